#pragma once

#include <filesystem>

#include "server/store/model_store.h"

namespace handgraft::server {

/// Reads a library folder into the store, replacing what has the same name:
/// `hands/NAME/{NAME.urdf,sites.yaml}`, `objects/NAME.{obj,stl,ply,glb,gltf,dae}`,
/// `contacts/NAME.{json,ply}`. A contact set that does not say which object it lies on belongs
/// to the object with the longest name that begins its own (`lemon_6`: `lemon`).
///
/// A model that cannot be read is left out, with a warning in the log: one bad file must not
/// keep a server from starting. Errors: InvalidInput if the folder does not exist. Returns how
/// many were left out.
int readLibrary(const std::filesystem::path& folder, ModelStore& store);

/// The library that comes with the program: beside the executable (`../share/handgraft/models`)
/// if it is installed, else in the source tree it was built from.
std::filesystem::path builtInLibrary();

/// Likewise the skins of its hands, made when the program was built; the folder may be missing.
std::filesystem::path builtInSkins();

/// Makes the skins of the built-in hands, and what their solids take long to find, as far as
/// they are not in `folder` yet. Errors: InvalidInput if a hand cannot be read. Cost: some
/// seconds a hand.
void makeSkins(const std::filesystem::path& folder);

}  // namespace handgraft::server
