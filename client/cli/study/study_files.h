#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "client/link/model_files.h"

/// The grasps and motions of a study, found in folders.
namespace handgraft::client {

/// One file of contacts, or a motion, and the object it lies on.
struct StudyGrasp {
  std::string label;               ///< the file's name without its ending, or the model's
  std::filesystem::path contacts;  ///< a contact set (JSON) or map (PLY); empty: a motion
  std::string object;              ///< a model's name, or the path of a mesh
  std::string motion = {};         ///< a model's name, or a path; empty: a grasp
  std::string patch = {};          ///< of a motion, that alone; empty: all of them

  [[nodiscard]] bool isMotion() const { return !motion.empty(); }
};

/// Where to look.
struct StudyFolders {
  std::filesystem::path contacts;         ///< empty: there are motions alone
  std::filesystem::path objects;          ///< empty: beside the contacts
  std::string object;                     ///< of all of them; empty: each file's own
  std::vector<std::string> motions = {};  ///< models' names, or paths, beside the folder's
};

/// A JSON file that is left out.
struct SkippedFile {
  std::filesystem::path path;
  std::string reason;  ///< what it is instead, or what is wrong with it
};

struct FoundGrasps {
  std::vector<StudyGrasp> grasps;
  std::vector<SkippedFile> skipped;
};

/// All contact sets and motions of the folder, in the order of their names, then `motions`. The
/// object of a motion that is a model's name is left to the server. A set's or motion's object
/// is the one that it names: a mesh of that name among the objects, else what the server calls
/// so. Contact maps count where `objects` or `object` says what they lie on: the object whose
/// name begins the map's. Errors: InvalidInput for folders that are none, a folder without
/// contacts or motions, a file that is no motion, and one that does not say what it lies on,
/// naming it.
FoundGrasps findGrasps(const StudyFolders& folders);

}  // namespace handgraft::client
