#pragma once

#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/contact/contact_set.h"

namespace handgraft::io {

/// How a hand's parts are turned, as files of contacts and of motions have it: a list of
/// { "part": ..., "outward": [x, y, z], "palmar": [x, y, z] }. Errors: InvalidInput naming the
/// field; directions may have any length but none.
std::vector<contact::PartDirection> postureFrom(const nlohmann::json& value);

nlohmann::json postureJson(const std::vector<contact::PartDirection>& posture);

}  // namespace handgraft::io
