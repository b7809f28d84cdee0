#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "idl/contract.h"

/// What every message of the contract consists of: tables, made of the IDL by make_fields.py.
/// Whatever goes through them (JSON, checks, other languages) cannot forget a field.
/// HANDGRAFT_EACH_MESSAGE(Do) lists the names of all structs and unions.
namespace handgraft::idl {

enum class Kind {
  kBoolean,  ///< bool
  kOctet,    ///< std::uint8_t, and so on
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat,
  kDouble,
  kString,    ///< std::string
  kEnum,      ///< 32 bits
  kStruct,    ///< fastddsgen's class of that name
  kUnion,     ///< the same
  kSequence,  ///< std::vector
  kArray,     ///< std::array
};

struct Type;

struct Enumerator {
  const char* name;  ///< as people and JSON spell it: "out_of_reach"
  std::uint32_t value;
};

/// A member of a struct or a union.
struct Field {
  const char* name;
  const Type* type;
  /// Where it lies in a message; of a union: while it is the chosen one.
  void* (*in)(void* message);
  double least;  ///< of a number; of each, in a sequence
  double most;
  bool infinite;  ///< it may be so
  bool nan;
  std::span<const std::uint32_t> labels;  ///< that choose it, in a union
};

struct Type {
  Kind kind;
  const char* name;                    ///< as in the IDL; "" of sequences and arrays
  std::span<const Field> fields = {};  ///< of structs and unions
  std::span<const Enumerator> names = {};
  const Type* element = nullptr;  ///< of sequences and arrays
  std::size_t bound = 0;          ///< of them; 0: none
  std::size_t (*size)(const void* values) = nullptr;
  void (*resize)(void* values, std::size_t size) = nullptr;  ///< of sequences
  void* (*at)(void* values, std::size_t index) = nullptr;
  const Type* discriminator = nullptr;  ///< of unions: an enum
  std::uint32_t (*label)(const void* message) = nullptr;
  void (*choose)(void* message, std::uint32_t label) = nullptr;  ///< its member is a new one

  /// An optional value is a sequence of at most one.
  [[nodiscard]] bool isOptional() const { return kind == Kind::kSequence && bound == 1; }
};

/// Where a value of an enum lies in a message, as a number.
inline std::uint32_t enumAt(const void* value) {
  std::uint32_t number = 0;
  std::memcpy(&number, value, sizeof(number));
  return number;
}

/// The table of a message or an enum: `typeOf<v1::Pose>()`.
template <class Message>
const Type& typeOf() {
  return typeFor(static_cast<const Message*>(nullptr));
}

/// As people and JSON spell it; "unknown" of a value that is none, which the wire may bring.
const char* nameOf(const Type& type, std::uint32_t value);
std::optional<std::uint32_t> valueOf(const Type& type, std::string_view name);
/// All names of an enum, in order.
std::vector<std::string> namesOf(const Type& type);
/// As valueOf; the first enumerator of an empty name. Errors: InvalidInput: `what`, the name,
/// all names.
std::uint32_t requireValue(const Type& type, std::string_view name, std::string_view what);
/// Null where a struct or a union has no such field.
const Field* fieldOf(const Type& type, std::string_view name);
/// The field that a union's label chooses; null for a label that is none.
const Field* chosenOf(const Type& type, std::uint32_t label);

// === What make_fields.py builds tables of

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

inline constexpr Type kBooleanType = {Kind::kBoolean, "boolean"};
inline constexpr Type kOctetType = {Kind::kOctet, "octet"};
inline constexpr Type kInt32Type = {Kind::kInt32, "long"};
inline constexpr Type kUint32Type = {Kind::kUint32, "unsigned long"};
inline constexpr Type kInt64Type = {Kind::kInt64, "long long"};
inline constexpr Type kUint64Type = {Kind::kUint64, "unsigned long long"};
inline constexpr Type kFloatType = {Kind::kFloat, "float"};
inline constexpr Type kDoubleType = {Kind::kDouble, "double"};
inline constexpr Type kStringType = {Kind::kString, "string"};

template <class Values>
constexpr Type arrayOf(const Type& element, std::size_t count) {
  Type type = {Kind::kArray, ""};
  type.element = &element;
  type.bound = count;
  type.size = [](const void* values) {
    return static_cast<const Values*>(values)->size();
  };
  type.at = [](void* values, std::size_t index) -> void* {
    return &(*static_cast<Values*>(values))[index];
  };
  return type;
}

template <class Values>
constexpr Type sequenceOf(const Type& element, std::size_t bound) {
  Type type = arrayOf<Values>(element, bound);
  type.kind = Kind::kSequence;
  type.resize = [](void* values, std::size_t size) {
    static_cast<Values*>(values)->resize(size);
  };
  return type;
}

}  // namespace handgraft::idl

namespace handgraft::v1 {

/// "put_file", "converged", "hand": what an enumerator is called in logs, messages, JSON.
template <class Enum>
requires std::is_enum_v<Enum>

const char* nameOf(Enum value) {
  return idl::nameOf(idl::typeOf<Enum>(), value);
}

/// The enumerator of that name, if there is one.
template <class Enum>
std::optional<Enum> enumeratorOf(std::string_view name) {
  const auto value = idl::valueOf(idl::typeOf<Enum>(), name);
  return value ? std::optional(static_cast<Enum>(*value)) : std::nullopt;
}

/// The enumerator of that name; the first one, which stands for the default, of an empty name.
/// Errors: InvalidInput: `what`, the name, and all that there are.
template <class Enum>
Enum enumeratorFrom(std::string_view name, std::string_view what) {
  return static_cast<Enum>(idl::requireValue(idl::typeOf<Enum>(), name, what));
}

}  // namespace handgraft::v1
