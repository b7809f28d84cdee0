#pragma once

#include <memory>
#include <string>

#include "core/io/contact_file.h"
#include "core/session/session.h"

#include "tests/core/session/library_models.h"

namespace handgraft::test {

/// The built-in lemon in a whole hand, one of its patches so many times as heavy as the others.
struct UnevenLemon {
  io::MeshFile file = io::readMesh(libraryPath("objects/lemon.obj"));
  std::shared_ptr<const geometry::TriangleMesh> mesh =
      std::make_shared<const geometry::TriangleMesh>(file.mesh);
  contact::ContactSet contacts = io::readContactSet(libraryPath("contacts/lemon_6.json"), file);

  UnevenLemon(const std::string& heavy, double times) {
    for (contact::Patch& patch : contacts.patches)
      if (patch.name == heavy) patch.weight *= times;
  }

  [[nodiscard]] session::SessionModels models(const std::string& hand) const {
    return session::modelsOf(handOfLibrary(hand), mesh, contacts);
  }

  [[nodiscard]] session::Session open(const std::string& hand) const {
    return {models(hand), Pose::Identity(), {}};
  }
};

}  // namespace handgraft::test
