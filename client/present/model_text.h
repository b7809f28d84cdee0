#pragma once

#include <string>

#include "idl/models.h"

/// Models described for people; as text_output.h.
namespace handgraft::client::text {

/// Of a hand also what its skin is like, where the description tells.
std::string description(const v1::ModelDescription& description);

/// Joints with limits and rest, mimic joints, poses, sites, skin, notes.
std::string hand(const v1::HandDescription& hand);

/// The steps that made the skin, its measures, and in a last line whether it is sound.
std::string skin(const v1::SkinReport& report);

/// Patches and notes.
std::string contacts(const v1::ContactsDescription& set);

}  // namespace handgraft::client::text
