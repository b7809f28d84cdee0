#pragma once

#include <initializer_list>
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

namespace handgraft::io {

/// What is wrong with an object's first key that is not `permitted`: a misspelt optional field
/// must not count as an absent one. Nothing if all are, or if `value` is no object.
std::optional<std::string> unknownKeyIn(const nlohmann::json& value,
                                        std::initializer_list<const char*> permitted);

}  // namespace handgraft::io
