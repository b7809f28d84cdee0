#include "idl/json.h"

#include <array>
#include <charconv>
#include <cmath>
#include <type_traits>

#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "idl/check.h"

namespace handgraft::idl {

namespace {

constexpr std::uint64_t kMostExact = 1ULL << 53U;  // whole numbers that a double keeps
constexpr const char* kLabelKey = "kind";

template <class T>
const T& as(const void* value) {
  return *static_cast<const T*>(value);
}

bool isNothing(const Type& type) {
  return type.kind == Kind::kStruct && std::string_view(type.name) == "Nothing";
}

bool isBytes(const Type& type) {
  return type.element != nullptr && type.element->kind == Kind::kOctet;
}

// === To JSON

Json numberJson(double value) {
  if (std::isfinite(value)) return value;
  return std::isnan(value) ? "nan" : value > 0.0 ? "inf" : "-inf";
}

/// As few digits as say which float it is.
Json floatJson(float value) {
  if (!std::isfinite(value)) return numberJson(value);
  std::array<char, 64> text{};
  const char* end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  double shortest = value;
  std::from_chars(text.data(), end, shortest);
  return shortest;
}

Json wholeJson(std::uint64_t value) {
  return value <= kMostExact ? Json(value) : Json(std::to_string(value));
}

std::string hexOf(const Type& type, const void* bytes) {
  std::string text;
  const std::size_t size = type.size(bytes);
  const auto* octets =
      size == 0 ? nullptr
                : static_cast<const std::uint8_t*>(type.at(const_cast<void*>(bytes), 0));
  text.reserve(2 * size);
  constexpr const char* kDigits = "0123456789abcdef";
  for (std::size_t i = 0; i < size; ++i) {
    text += kDigits[octets[i] >> 4U];
    text += kDigits[octets[i] & 0xFU];
  }
  return text;
}

Json valueJson(const Type& type, const void* value) {
  switch (type.kind) {
    case Kind::kBoolean:
      return as<bool>(value);
    case Kind::kOctet:
      return as<std::uint8_t>(value);
    case Kind::kInt32:
      return as<std::int32_t>(value);
    case Kind::kUint32:
      return as<std::uint32_t>(value);
    case Kind::kInt64:
      return as<std::int64_t>(value);
    case Kind::kUint64:
      return wholeJson(as<std::uint64_t>(value));
    case Kind::kFloat:
      return floatJson(as<float>(value));
    case Kind::kDouble:
      return numberJson(as<double>(value));
    case Kind::kString:
      return as<std::string>(value);
    case Kind::kEnum:
      return nameOf(type, enumAt(value));
    case Kind::kStruct:
    case Kind::kUnion:
      return jsonOf(type, value);
    case Kind::kSequence:
    case Kind::kArray:
      break;
  }
  if (isBytes(type)) return hexOf(type, value);
  const std::size_t size = type.size(value);
  void* const values = const_cast<void*>(value);  // read alone
  if (type.isOptional())
    return size == 0 ? Json(nullptr) : valueJson(*type.element, type.at(values, 0));
  Json list = Json::array();
  for (std::size_t i = 0; i < size; ++i)
    list.push_back(valueJson(*type.element, type.at(values, i)));
  return list;
}

// === From JSON

/// What is there instead, for errors.
std::string shown(const Json& json) {
  return quoted(textOf(json));
}

[[noreturn]] void reject(const std::string& path, const Json& json, const std::string& wanted) {
  throw InvalidField(path.empty() ? "message" : path,
                     fmt::format("{} is no {}", shown(json), wanted));
}

template <class Number>
Number wholeFrom(const Json& json, const Field& field, const std::string& path) {
  Number number = 0;
  const bool is_text = json.is_string() && sizeof(Number) == 8;
  if (!json.is_number_integer() && !is_text) reject(path, json, "whole number");
  const std::string text = is_text ? json.get<std::string>() : json.dump();
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || rest != end) {
    constexpr auto kLeast = std::numeric_limits<Number>::min();
    constexpr auto kMost = std::numeric_limits<Number>::max();
    // Of those bounds the field's own where they are narrower.
    throw InvalidField(
        path,
        fmt::format("{} is outside {} to {}", text,
                    field.least > static_cast<double>(kLeast) ? fmt::to_string(field.least)
                                                              : fmt::to_string(kLeast),
                    field.most < static_cast<double>(kMost) ? fmt::to_string(field.most)
                                                            : fmt::to_string(kMost)));
  }
  checkNumber(static_cast<double>(number), field, path);
  return number;
}

double numberFrom(const Json& json, const Field& field, const std::string& path) {
  double value = 0.0;
  if (json.is_number()) {
    value = json.get<double>();
  } else if (json == "inf") {
    value = kInfinity;
  } else if (json == "-inf") {
    value = -kInfinity;
  } else if (json == "nan") {
    value = std::numeric_limits<double>::quiet_NaN();
  } else {
    reject(path, json, "number");
  }
  checkNumber(value, field, path);
  return value;
}

int digitFrom(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

void resizeTo(std::size_t size, const Type& type, void* values, const std::string& path) {
  if (type.kind == Kind::kArray) {
    if (size != type.bound) {
      throw InvalidField(path, fmt::format("{} entries; it has {}", size, type.bound));
    }
    return;
  }
  if (type.bound > 0 && size > type.bound) {
    throw InvalidField(path,
                       fmt::format("{} entries; at most {} are allowed", size, type.bound));
  }
  type.resize(values, size);
}

void readBytes(const Type& type, void* bytes, const Json& json, const std::string& path) {
  if (!json.is_string()) reject(path, json, "text of hexadecimal digits");
  const auto& text = json.get_ref<const std::string&>();
  if (text.size() % 2 != 0) reject(path, json, "whole number of bytes");
  resizeTo(text.size() / 2, type, bytes, path);
  for (std::size_t i = 0; i < text.size(); i += 2) {
    const int high = digitFrom(text[i]);
    const int low = digitFrom(text[i + 1]);
    if (high < 0 || low < 0) reject(path, json, "text of hexadecimal digits");
    *static_cast<std::uint8_t*>(type.at(bytes, i / 2)) =
        static_cast<std::uint8_t>(16 * high + low);
  }
}

void readValue(const Type& type,
               void* value,
               const Field& field,
               const Json& json,
               const std::string& path);

void readList(const Type& type,
              void* values,
              const Field& field,
              const Json& json,
              const std::string& path) {
  if (isBytes(type)) return readBytes(type, values, json, path);
  if (type.isOptional()) {
    type.resize(values, json.is_null() ? 0 : 1);
    if (!json.is_null()) readValue(*type.element, type.at(values, 0), field, json, path);
    return;
  }
  if (!json.is_array()) reject(path, json, "list");
  resizeTo(json.size(), type, values, path);
  for (std::size_t i = 0; i < json.size(); ++i) {
    readValue(*type.element, type.at(values, i), field, json[i],
              fmt::format("{}[{}]", path, i));
  }
}

void readValue(const Type& type,
               void* value,
               const Field& field,
               const Json& json,
               const std::string& path) {
  const auto whole = [&]<class Number>(Number& number) {
    number = wholeFrom<Number>(json, field, path);
  };
  switch (type.kind) {
    case Kind::kBoolean:
      if (!json.is_boolean()) reject(path, json, "true or false");
      *static_cast<bool*>(value) = json.get<bool>();
      return;
    case Kind::kOctet:
      return whole(*static_cast<std::uint8_t*>(value));
    case Kind::kInt32:
      return whole(*static_cast<std::int32_t*>(value));
    case Kind::kUint32:
      return whole(*static_cast<std::uint32_t*>(value));
    case Kind::kInt64:
      return whole(*static_cast<std::int64_t*>(value));
    case Kind::kUint64:
      return whole(*static_cast<std::uint64_t*>(value));
    case Kind::kFloat: {
      const double number = numberFrom(json, field, path);
      const auto rounded = static_cast<float>(number);
      if (std::isfinite(number) && !std::isfinite(rounded))
        reject(path, json, "number of single precision");
      *static_cast<float*>(value) = rounded;
      return;
    }
    case Kind::kDouble:
      *static_cast<double*>(value) = numberFrom(json, field, path);
      return;
    case Kind::kString:
      if (!json.is_string()) reject(path, json, "text");
      *static_cast<std::string*>(value) = json.get<std::string>();
      return;
    case Kind::kEnum: {
      const auto found =
          json.is_string() ? valueOf(type, json.get_ref<const std::string&>()) : std::nullopt;
      if (!found) {
        throw InvalidField(
            path, fmt::format("{} is none of {}", shown(json), fmt::join(namesOf(type), " ")));
      }
      std::memcpy(value, &*found, sizeof(*found));
      return;
    }
    case Kind::kStruct:
    case Kind::kUnion:
      return readJson(type, value, json, path);
    case Kind::kSequence:
    case Kind::kArray:
      return readList(type, value, field, json, path);
  }
}

[[noreturn]] void rejectKey(const std::string& path,
                            const std::string& key,
                            const std::vector<std::string>& known) {
  throw InvalidField(
      memberPath(path, quoted(key).substr(1, quoted(key).size() - 2).c_str()),
      fmt::format("there is no such field; there are {}", fmt::join(known, " ")));
}

void readUnion(const Type& type, void* message, const Json& json, const std::string& path) {
  const std::string label_path = memberPath(path, kLabelKey);
  const auto label = json.find(kLabelKey);
  if (label == json.end())
    throw InvalidField(label_path, fmt::format("it is not said; it is one of {}",
                                               fmt::join(namesOf(*type.discriminator), " ")));
  const auto value = label->is_string()
                         ? valueOf(*type.discriminator, label->get_ref<const std::string&>())
                         : std::nullopt;
  const Field* chosen = value ? chosenOf(type, *value) : nullptr;
  if (chosen == nullptr) {
    throw InvalidField(label_path, fmt::format("{} is none of {}", shown(*label),
                                               fmt::join(namesOf(*type.discriminator), " ")));
  }
  type.choose(message, *value);
  for (const auto& [key, one] : json.items()) {
    if (key == kLabelKey) continue;
    if (key != chosen->name) rejectKey(path, key, {kLabelKey, chosen->name});
    readValue(*chosen->type, chosen->in(message), *chosen, one, memberPath(path, chosen->name));
  }
}

}  // namespace

Json jsonOf(const Type& type, const void* message) {
  void* const fields = const_cast<void*>(message);  // read alone
  Json json = Json::object();
  if (type.kind == Kind::kUnion) {
    json[kLabelKey] = nameOf(*type.discriminator, type.label(message));
    const Field* chosen = chosenOf(type, type.label(message));
    if (chosen != nullptr && !isNothing(*chosen->type))
      json[chosen->name] = valueJson(*chosen->type, chosen->in(fields));
    return json;
  }
  for (const Field& field : type.fields)
    json[field.name] = valueJson(*field.type, field.in(fields));
  return json;
}

void readJson(const Type& type, void* message, const Json& json, const std::string& path) {
  if (!json.is_object()) reject(path, json, "object");
  if (type.kind == Kind::kUnion) return readUnion(type, message, json, path);
  for (const auto& [key, value] : json.items()) {
    const Field* field = fieldOf(type, key);
    if (field == nullptr) {
      std::vector<std::string> known;
      for (const Field& one : type.fields)
        known.emplace_back(one.name);
      rejectKey(path, key, known);
    }
    readValue(*field->type, field->in(message), *field, value, memberPath(path, field->name));
  }
}

void requireWhole(const Type& type, const Json& json, const std::string& path) {
  const auto require = [&](const Field& field) {
    const Type& of_field = *field.type;
    const std::string field_path = memberPath(path, field.name);
    const auto said = json.find(field.name);
    if (said == json.end()) {
      if (of_field.kind == Kind::kSequence) return;
      throw InvalidField(field_path, "it is not said");
    }
    const bool is_list = of_field.kind == Kind::kSequence || of_field.kind == Kind::kArray;
    const Type& inner = is_list ? *of_field.element : of_field;
    if (inner.kind != Kind::kStruct && inner.kind != Kind::kUnion) return;
    if (!said->is_array()) {
      if (!said->is_null()) requireWhole(inner, *said, field_path);
      return;
    }
    for (std::size_t i = 0; i < said->size(); ++i)
      requireWhole(inner, (*said)[i], fmt::format("{}[{}]", field_path, i));
  };
  if (type.kind != Kind::kUnion) {
    for (const Field& field : type.fields)
      require(field);
    return;
  }
  const auto label = valueOf(*type.discriminator, json.at(kLabelKey).get<std::string>());
  const Field* chosen = label ? chosenOf(type, *label) : nullptr;
  if (chosen != nullptr && !isNothing(*chosen->type)) require(*chosen);
}

void readJsonText(const Type& type, void* message, std::string_view text) {
  Json json;
  try {
    json = Json::parse(text);
  } catch (const Json::exception& e) {
    rejectInput("no JSON: {}", quoted(e.what()));
  }
  readJson(type, message, json, "");
}

std::string textOf(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

std::string jsonText(const Type& type, const void* message, int indent) {
  return textOf(jsonOf(type, message), indent);
}

}  // namespace handgraft::idl
