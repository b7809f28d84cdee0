#include "idl/check.h"

#include <cmath>

#include <fmt/ranges.h>

namespace handgraft::idl {

namespace {

template <class T>
const T& as(const void* value) {
  return *static_cast<const T*>(value);
}

/// Numbers without a range and text are never wrong.
bool mayBeWrong(const Type& type, const Field& field) {
  switch (type.kind) {
    case Kind::kBoolean:
    case Kind::kString:
      return false;
    case Kind::kOctet:
    case Kind::kInt32:
    case Kind::kUint32:
    case Kind::kInt64:
    case Kind::kUint64:
      return field.least > -kInfinity || field.most < kInfinity;
    default:
      return true;
  }
}

void checkValue(const Type& type,
                const void* value,
                const Field& field,
                const std::string& path) {
  switch (type.kind) {
    case Kind::kBoolean:
    case Kind::kString:
      return;
    case Kind::kOctet:
      return checkNumber(as<std::uint8_t>(value), field, path);
    case Kind::kInt32:
      return checkNumber(as<std::int32_t>(value), field, path);
    case Kind::kUint32:
      return checkNumber(as<std::uint32_t>(value), field, path);
    case Kind::kInt64:
      return checkNumber(static_cast<double>(as<std::int64_t>(value)), field, path);
    case Kind::kUint64:
      return checkNumber(static_cast<double>(as<std::uint64_t>(value)), field, path);
    case Kind::kFloat:
      return checkNumber(as<float>(value), field, path);
    case Kind::kDouble:
      return checkNumber(as<double>(value), field, path);
    case Kind::kEnum: {
      const std::uint32_t number = enumAt(value);
      for (const Enumerator& one : type.names)
        if (one.value == number) return;
      throw InvalidField(
          path, fmt::format("{} is none of {}", number, fmt::join(namesOf(type), " ")));
    }
    case Kind::kStruct:
    case Kind::kUnion:
      return check(type, value, path);
    case Kind::kSequence:
    case Kind::kArray: {
      const std::size_t size = type.size(value);
      if (type.bound > 0 && size > type.bound)
        throw InvalidField(path,
                           fmt::format("{} entries; at most {} are allowed", size, type.bound));
      if (!mayBeWrong(*type.element, field)) return;
      for (std::size_t i = 0; i < size; ++i) {
        checkValue(*type.element, type.at(const_cast<void*>(value), i), field,
                   fmt::format("{}[{}]", path, i));
      }
      return;
    }
  }
}

}  // namespace

void checkNumber(double value, const Field& field, const std::string& path) {
  const bool is_bounded = std::isfinite(field.least) && std::isfinite(field.most);
  if (std::isnan(value) && !(is_bounded && !field.nan)) {
    if (!field.nan) throw InvalidField(path, "nan is no number");
  } else if (std::isinf(value)) {
    if (!field.infinite) throw InvalidField(path, fmt::format("{} is not finite", value));
  } else if (!(value >= field.least && value <= field.most)) {
    throw InvalidField(path,
                       fmt::format("{} is outside {} to {}", value, field.least, field.most));
  }
}

std::string memberPath(const std::string& path, const char* name) {
  return path.empty() ? name : path + "." + name;
}

void check(const Type& type, const void* message, const std::string& path) {
  void* const fields = const_cast<void*>(message);  // its fields are read alone
  if (type.kind == Kind::kUnion) {
    const std::uint32_t label = type.label(message);
    const Field* chosen = chosenOf(type, label);
    if (chosen == nullptr) {
      throw InvalidField(
          memberPath(path, "kind"),
          fmt::format("{} is none of {}", label, fmt::join(namesOf(*type.discriminator), " ")));
    }
    return checkValue(*chosen->type, chosen->in(fields), *chosen,
                      memberPath(path, chosen->name));
  }
  for (const Field& field : type.fields) {
    if (!mayBeWrong(*field.type, field)) continue;
    checkValue(*field.type, field.in(fields), field, memberPath(path, field.name));
  }
}

}  // namespace handgraft::idl
