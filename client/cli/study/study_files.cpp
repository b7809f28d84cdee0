#include "client/cli/study/study_files.h"

#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "client/present/json_output.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace fs = std::filesystem;

namespace {

const std::set<std::string> mesh_extensions = {".obj",  ".stl", ".ply", ".glb",
                                               ".gltf", ".dae", ".off"};

std::string extensionOf(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return extension;
}

std::vector<fs::path> filesIn(const fs::path& folder, const char* option) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    rejectInput("{} {}: no such folder", option, quoted(folder.string()));
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.is_regular_file(error)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// A contact set or a motion as far as it matters here.
struct SetHead {
  bool is_set = false;
  bool is_motion = false;
  std::string object;      ///< empty: it does not say
  std::string is_neither;  ///< why, where it is none of both
};

std::string textIn(const json::Json& document, const char* key) {
  const auto value = document.find(key);
  return value != document.end() && value->is_string() ? value->get<std::string>() : "";
}

SetHead headOf(const fs::path& path) {
  SetHead head;
  json::Json document;
  try {
    document = json::Json::parse(readFile(path));
  } catch (const json::Json::exception& error) {
    head.is_neither = fmt::format("it is damaged, or no JSON: {}", error.what());
    return head;
  }
  head.is_neither = "no contact set and no motion";
  if (!document.is_object()) return head;
  const std::string format = textIn(document, "format");
  // Grasps have patches, too: where a file says its format, that counts.
  head.is_set =
      format.empty() ? document.contains("patches") : format.starts_with("handgraft-contacts/");
  head.is_motion =
      format.empty() ? document.contains("tracks") : format.starts_with("handgraft-motion/");
  if (!format.empty()) head.is_neither += fmt::format(" but {}", quoted(format));
  head.object = textIn(document, "object");
  return head;
}

/// The mesh of that name; of several the first by its ending. Empty if there is none.
std::string meshNamed(const std::string& name, const std::vector<fs::path>& files) {
  for (const fs::path& file : files)
    if (file.stem() == name && mesh_extensions.contains(extensionOf(file)))
      return file.string();
  return {};
}

/// The mesh with the longest name that begins `name`; empty if there is none.
std::string meshBeginning(const std::string& name, const std::vector<fs::path>& files) {
  std::string best;
  std::size_t longest = 0;
  for (const fs::path& file : files) {
    const std::string stem = file.stem().string();
    if (!mesh_extensions.contains(extensionOf(file)) || name.rfind(stem, 0) != 0) continue;
    if (stem.size() <= longest) continue;
    longest = stem.size();
    best = file.string();
  }
  return best;
}

/// Of a set or motion in a file: the mesh that it names, else what the server calls so.
std::string objectOf(const fs::path& file,
                     const SetHead& head,
                     const std::vector<fs::path>& objects) {
  if (head.object.empty())
    rejectInput("{}: it does not say which object it lies on; --object names one",
                quoted(file.string()));
  const std::string mesh = meshNamed(head.object, objects);
  return mesh.empty() ? head.object : mesh;
}

/// A JSON file of the folder: what it holds, or why it is left out.
void addSetOrMotion(const fs::path& file,
                    const StudyFolders& folders,
                    const std::vector<fs::path>& objects,
                    FoundGrasps& found) {
  const SetHead head = headOf(file);
  if (!head.is_set && !head.is_motion) {
    found.skipped.push_back({file, head.is_neither});
    return;
  }
  StudyGrasp grasp{file.stem().string(), file, folders.object};
  if (grasp.object.empty()) grasp.object = objectOf(file, head, objects);
  if (head.is_motion) grasp.motion = std::exchange(grasp.contacts, {}).string();
  found.grasps.push_back(std::move(grasp));
}

StudyGrasp graspOfMap(const fs::path& file,
                      const StudyFolders& folders,
                      const std::vector<fs::path>& objects) {
  StudyGrasp grasp{file.stem().string(), file, folders.object};
  if (grasp.object.empty()) grasp.object = meshBeginning(grasp.label, objects);
  if (grasp.object.empty())
    rejectInput("{}: no object in {} has a name that begins its own", quoted(file.string()),
                quoted(folders.objects.string()));
  return grasp;
}

/// `motion`: a model's name, or a path.
StudyGrasp graspOfMotion(const std::string& motion,
                         const StudyFolders& folders,
                         const std::vector<fs::path>& objects) {
  StudyGrasp grasp{motion, {}, folders.object, motion};
  if (!isPath(motion)) return grasp;
  const fs::path file = motion;
  const SetHead head = headOf(file);
  if (!head.is_motion)
    rejectInput("--motion {}: it is no motion (handgraft-motion/1)", quoted(motion));
  grasp.label = file.stem().string();
  if (grasp.object.empty()) grasp.object = objectOf(file, head, objects);
  return grasp;
}

}  // namespace

FoundGrasps findGrasps(const StudyFolders& folders) {
  const std::vector<fs::path> files = folders.contacts.empty()
                                          ? std::vector<fs::path>()
                                          : filesIn(folders.contacts, "--contacts-dir");
  const std::vector<fs::path> objects =
      folders.objects.empty() ? files : filesIn(folders.objects, "--object-dir");
  const bool with_maps = !folders.objects.empty() || !folders.object.empty();
  FoundGrasps found;
  for (const fs::path& file : files) {
    const std::string extension = extensionOf(file);
    if (extension == ".json")
      addSetOrMotion(file, folders, objects, found);
    else if (with_maps && extension == ".ply")
      found.grasps.push_back(graspOfMap(file, folders, objects));
  }
  for (const std::string& motion : folders.motions)
    found.grasps.push_back(graspOfMotion(motion, folders, objects));
  if (found.grasps.empty())
    rejectInput("--contacts-dir {}: it holds no contact set and no motion (*.json){}",
                quoted(folders.contacts.string()),
                with_maps ? " and no contact map (*.ply)"
                          : "; contact maps (*.ply) count with --object or --object-dir");
  return found;
}

}  // namespace handgraft::client
