#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "core/hand/hand.h"
#include "core/hand/skin_cache.h"
#include "core/io/sites_file.h"
#include "core/io/urdf_file.h"

#include "tests/support/shared_data.h"

namespace handgraft::test {

/// A file of the built-in library.
inline std::filesystem::path libraryPath(const std::string& relative) {
  return sourceDirectory() / "server/models" / relative;
}

/// One of its hands, with its real skin.
inline hand::Hand handOfLibrary(const std::string& name) {
  hand::Hand hand;
  hand.model = std::make_shared<const hand::HandModel>(
      io::readUrdf(libraryPath("hands/" + name + "/" + name + ".urdf")).model);
  hand.skin = std::make_shared<const hand::Skin>(
      hand::SkinCache::fromEnvironment().get(*hand.model, {}, Progress()));
  hand.sites = io::readSites(libraryPath("hands/" + name + "/sites.yaml"), *hand.model);
  return hand;
}

}  // namespace handgraft::test
