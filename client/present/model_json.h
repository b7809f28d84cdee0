#pragma once

#include <string>

#include "idl/models.h"

/// Models described for programs; as json_output.h. `skin` of a hand is null where its
/// description does not tell.
namespace handgraft::client::json {

std::string description(const v1::ModelDescription& description, int indent = 2);

/// A hand's skin alone: `hand`, and as `skin` what `description` has.
std::string skin(const std::string& hand, const v1::SkinReport& report, int indent = 2);

}  // namespace handgraft::client::json
