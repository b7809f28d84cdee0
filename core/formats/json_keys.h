#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace handgraft::formats {

/// JSON as Python's `json.dump` writes it, too: NaN, which JSON does not know, is read as null,
/// so that whoever reads a field can name it. Errors: nlohmann::json::exception.
nlohmann::json parsedJson(std::string_view text);

/// What is wrong with an object's first key that is not `permitted`: a misspelt optional field
/// must not count as an absent one. Nothing if all are, or if `value` is no object.
std::optional<std::string> unknownKeyIn(const nlohmann::json& value,
                                        std::initializer_list<const char*> permitted);

/// What stands there, for messages: numbers and texts as they are written, "an array" or "an
/// object" else, which may be nested deeper than the stack.
std::string shown(const nlohmann::json& value);

/// A field that must be there. Errors: InvalidInput naming it, also if `value` is no object.
const nlohmann::json& memberOf(const nlohmann::json& value, const char* name);

/// Errors: InvalidInput, with `name` as the field's, if it is no finite number.
double finiteFrom(const nlohmann::json& value, const char* name);

}  // namespace handgraft::formats
