#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "client/link/model_files.h"

/// The grasps of a study, found in folders.
namespace handgraft::client {

/// One file of contacts, and the object it lies on.
struct StudyGrasp {
  std::string label;               ///< the contacts' file name without its ending
  std::filesystem::path contacts;  ///< a contact set (JSON) or map (PLY)
  std::string object;              ///< a model's name, or the path of a mesh
};

/// Where to look.
struct StudyFolders {
  std::filesystem::path contacts;
  std::filesystem::path objects;  ///< empty: beside the contacts
  std::string object;             ///< of all contacts; empty: each file's own
};

struct FoundGrasps {
  std::vector<StudyGrasp> grasps;
  std::vector<std::filesystem::path> skipped;  ///< JSON files that hold no patches
};

/// All contact sets of the folder, in the order of their names. A set's object is the one that
/// it names: a mesh of that name among the objects, else what the server calls so. Contact maps
/// count where `objects` or `object` says what they lie on: the object whose name begins the
/// map's.
/// Errors: InvalidInput for folders that are none, a folder without contacts, and a file that
/// does not say what it lies on, naming it.
FoundGrasps findGrasps(const StudyFolders& folders);

}  // namespace handgraft::client
