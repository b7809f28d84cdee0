#include "client/link/file_fence.h"

#include <algorithm>
#include <array>
#include <cctype>

#include <fmt/format.h>

#include "core/base/error.h"

namespace handgraft::client {

namespace fs = std::filesystem;

namespace {

using Types = std::vector<std::string>;

const Types& typesOf(FileFence::Kind kind) {
  static const Types mesh_types = {".stl", ".obj", ".ply", ".gltf", ".glb", ".dae"};
  static const Types buffer_types = {".bin"};
  static const Types site_types = {".yaml"};
  static const Types pose_types = {".srdf"};
  switch (kind) {
    case FileFence::Kind::kMesh:
      return mesh_types;
    case FileFence::Kind::kBuffer:
      return buffer_types;
    case FileFence::Kind::kSites:
      return site_types;
    case FileFence::Kind::kPoses:
      break;
  }
  return pose_types;
}

std::string typeOf(const fs::path& file) {
  std::string type = file.extension().string();
  std::transform(type.begin(), type.end(), type.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return type;
}

/// What the path leads to, links and dots resolved; as it is where there is nothing.
fs::path resolved(const fs::path& path) {
  std::error_code error;
  fs::path real = fs::canonical(path, error);
  return error ? fs::absolute(path).lexically_normal() : real;
}

bool isBelow(const fs::path& file, const fs::path& folder) {
  if (folder.empty() || folder == folder.root_path()) return false;
  const auto [end, rest] =
      std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  return (end == folder.end() || (end->empty() && std::next(end) == folder.end())) &&
         rest != file.end();
}

/// The folder that belongs to a model: `hand/` of `hand/urdf/hand.urdf`.
fs::path ownFolder(const fs::path& model) {
  static constexpr std::array<const char*, 6> kInner = {"urdf",   "xacro",  "robot",
                                                        "robots", "models", "description"};
  const fs::path folder = resolved(fs::absolute(model).parent_path());
  const bool is_inner = std::any_of(kInner.begin(), kInner.end(), [&](const char* name) {
    return folder.filename() == name;
  });
  return is_inner ? folder.parent_path() : folder;
}

}  // namespace

FileFence::FileFence(const fs::path& model, const PackageMap& packages) {
  const fs::path real = resolved(model);
  if (typeOf(real) != typeOf(model)) {
    rejectInput("{}: it leads to {}, which is of another type", quoted(model.string()),
                quoted(real.string()));
  }
  folders_.push_back(ownFolder(model));
  for (const auto& [name, folder] : packages)
    folders_.push_back(resolved(folder));
  for (const auto& [name, folder] : amentPackages())
    workspace_.push_back(fs::absolute(folder).lexically_normal());
}

FileFence FileFence::around(const fs::path& folder) {
  FileFence fence;
  fence.folders_.push_back(resolved(folder));
  fence.closed_ = true;
  return fence;
}

void FileFence::require(const std::string& what, const fs::path& file, Kind kind) const {
  const fs::path real = resolved(file);
  const Types& types = typesOf(kind);
  if (std::find(types.begin(), types.end(), typeOf(real)) == types.end()) {
    rejectInput("{}: {} is not sent: a model takes files of the types {} along", quoted(what),
                quoted(real.string()), fmt::join(types, " "));
  }
  if (isInside(real, file)) return;
  if (closed_) rejectInput("{}: it leads out of the files that were given", quoted(what));
  rejectInput(
      "{}: {} is not sent: it lies outside {}, and no package that was named holds it; "
      "--package NAME=DIR names one",
      quoted(what), quoted(real.string()), quoted(folders_.front().string()));
}

bool FileFence::isInside(const fs::path& file, const fs::path& found_as) const {
  const auto holds = [](const std::vector<fs::path>& folders, const fs::path& path) {
    return std::any_of(folders.begin(), folders.end(), [&](const fs::path& folder) {
      return isBelow(path, folder);
    });
  };
  if (holds(folders_, file)) return true;
  if (closed_) return false;
  if (holds(workspace_, fs::absolute(found_as).lexically_normal())) return true;
  // A package of a checkout, beside the model's or above it.
  std::error_code error;
  for (fs::path folder = file.parent_path(); folder.has_relative_path();
       folder = folder.parent_path()) {
    if (fs::is_regular_file(folder / "package.xml", error) &&
        isBelow(folders_.front(), folder.parent_path()))
      return true;
  }
  return false;
}

}  // namespace handgraft::client
