#include "idl/fields.h"

#include <algorithm>

#include <fmt/ranges.h>

#include "core/base/error.h"

namespace handgraft::idl {

const char* nameOf(const Type& type, std::uint32_t value) {
  const auto found = std::ranges::find(type.names, value, &Enumerator::value);
  return found == type.names.end() ? "unknown" : found->name;
}

std::optional<std::uint32_t> valueOf(const Type& type, std::string_view name) {
  const auto found = std::ranges::find(type.names, name, &Enumerator::name);
  return found == type.names.end() ? std::nullopt : std::optional(found->value);
}

std::vector<std::string> namesOf(const Type& type) {
  std::vector<std::string> names;
  for (const Enumerator& one : type.names)
    names.emplace_back(one.name);
  return names;
}

std::uint32_t requireValue(const Type& type, std::string_view name, std::string_view what) {
  if (name.empty()) return type.names.front().value;
  if (const auto value = valueOf(type, name)) return *value;
  rejectInput("{} {}: it must be one of {}", what, quoted(std::string(name)),
              fmt::join(namesOf(type), " "));
}

const Field* fieldOf(const Type& type, std::string_view name) {
  const auto found = std::ranges::find(type.fields, name, &Field::name);
  return found == type.fields.end() ? nullptr : &*found;
}

const Field* chosenOf(const Type& type, std::uint32_t label) {
  const auto found = std::ranges::find_if(type.fields, [label](const Field& field) {
    return std::ranges::find(field.labels, label) != field.labels.end();
  });
  return found == type.fields.end() ? nullptr : &*found;
}

}  // namespace handgraft::idl
