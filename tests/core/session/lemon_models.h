#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "core/hand/skin_cache.h"
#include "core/io/contact_file.h"
#include "core/io/sites_file.h"
#include "core/io/urdf_file.h"

#include "tests/core/session/named_models.h"
#include "tests/support/shared_data.h"

namespace handgraft::test {

/// Of the built-in library.
inline std::filesystem::path modelPath(const std::string& relative) {
  return sourceDirectory() / "server/models" / relative;
}

/// A hand on the built-in lemon, with its six patches, and others to swap to.
inline session::SessionModels lemonModels(const hand::Hand& hand) {
  const io::MeshFile file = io::readMesh(modelPath("objects/lemon.obj"));
  return withOthers(hand, std::make_shared<const geometry::TriangleMesh>(file.mesh),
                    io::readContactSet(modelPath("contacts/lemon_6.json"), file));
}

/// A hand of a file with its own sites, or with those that are found.
inline hand::Hand handOf(const std::filesystem::path& urdf,
                         const std::filesystem::path& sites) {
  hand::Hand hand;
  hand.model = std::make_shared<const hand::HandModel>(io::readUrdf(urdf).model);
  hand.skin = std::make_shared<const hand::Skin>(
      hand::SkinCache::fromEnvironment().get(*hand.model, {}, Progress()));
  hand.sites_are_found = sites.empty();
  hand.sites = sites.empty() ? findContactSites(*hand.model, *hand.skin)
                             : io::readSites(sites, *hand.model);
  return hand;
}

}  // namespace handgraft::test
