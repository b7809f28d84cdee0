#include "client/cli/study/study_files.h"

#include <algorithm>
#include <set>

#include "client/present/json_output.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace fs = std::filesystem;

namespace {

const std::set<std::string> kMeshes = {".obj", ".stl", ".ply", ".glb", ".gltf", ".dae", ".off"};

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

/// A contact set as far as it matters here.
struct SetHead {
  bool is_set = false;
  std::string object;  ///< empty: it does not say
};

SetHead headOf(const fs::path& path) {
  const json::Json document = json::Json::parse(readFile(path), nullptr, false);
  if (!document.is_object() || !document.contains("patches")) return {};
  const auto object = document.find("object");
  const bool is_named = object != document.end() && object->is_string();
  return {true, is_named ? object->get<std::string>() : ""};
}

/// The mesh of that name; of several the first by its ending. Empty if there is none.
std::string meshNamed(const std::string& name, const std::vector<fs::path>& files) {
  for (const fs::path& file : files)
    if (file.stem() == name && kMeshes.contains(extensionOf(file))) return file.string();
  return {};
}

/// The mesh with the longest name that begins `name`; empty if there is none.
std::string meshBeginning(const std::string& name, const std::vector<fs::path>& files) {
  std::string best;
  std::size_t longest = 0;
  for (const fs::path& file : files) {
    const std::string stem = file.stem().string();
    if (!kMeshes.contains(extensionOf(file)) || name.rfind(stem, 0) != 0) continue;
    if (stem.size() <= longest) continue;
    longest = stem.size();
    best = file.string();
  }
  return best;
}

}  // namespace

FoundGrasps findGrasps(const StudyFolders& folders) {
  const std::vector<fs::path> files = filesIn(folders.contacts, "--contacts-dir");
  const std::vector<fs::path> objects =
      folders.objects.empty() ? files : filesIn(folders.objects, "--object-dir");
  const bool with_maps = !folders.objects.empty() || !folders.object.empty();
  FoundGrasps found;
  for (const fs::path& file : files) {
    const bool is_set = extensionOf(file) == ".json";
    if (!is_set && !(with_maps && extensionOf(file) == ".ply")) continue;
    StudyGrasp grasp{file.stem().string(), file, folders.object};
    if (is_set) {
      const SetHead head = headOf(file);
      if (!head.is_set) {
        found.skipped.push_back(file);
        continue;
      }
      if (grasp.object.empty() && head.object.empty())
        rejectInput("{}: it does not say which object it lies on; --object names one",
                    quoted(file.string()));
      if (grasp.object.empty()) grasp.object = meshNamed(head.object, objects);
      if (grasp.object.empty()) grasp.object = head.object;
    } else if (grasp.object.empty()) {
      grasp.object = meshBeginning(grasp.label, objects);
      if (grasp.object.empty())
        rejectInput("{}: no object in {} has a name that begins its own", quoted(file.string()),
                    quoted(folders.objects.string()));
    }
    found.grasps.push_back(std::move(grasp));
  }
  if (found.grasps.empty())
    rejectInput("--contacts-dir {}: it holds no contact set (*.json){}",
                quoted(folders.contacts.string()),
                with_maps ? " and no contact map (*.ply)"
                          : "; contact maps (*.ply) count with --object or --object-dir");
  return found;
}

}  // namespace handgraft::client
