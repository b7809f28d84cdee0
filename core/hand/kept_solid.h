#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/progress.h"
#include "core/hand/hand_model.h"
#include "core/hand/hand_solid.h"
#include "core/hand/skin.h"

namespace handgraft::hand {

/// 64 hexadecimal digits that name a hand's solid by what it is made from: the skin, the links'
/// own surfaces, how links hang on each other, and the version of the method. Cost: some 10 ms.
std::string solidKey(const HandModel& model, const Skin& skin);

/// Bytes that hold what was found, its key and a checksum.
std::string serialise(const SolidFindings& findings, const std::string& key);

/// What was found of so many links, or nothing if the bytes are damaged or of another key or
/// version. Takes memory in proportion to the bytes given, whatever they announce.
std::optional<SolidFindings> deserialiseFindings(std::string_view bytes,
                                                 const std::string& key);

/// The hand's solid. What it takes long to find is read where the skin is kept (Skin::keptIn),
/// or kept there. The same solid to the bit either way. Errors: as HandSolid's constructor.
std::shared_ptr<const HandSolid> keptSolid(const HandModel& model,
                                           const Skin& skin,
                                           const Progress& progress);

}  // namespace handgraft::hand
