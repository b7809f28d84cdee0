#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/hand/kept_files.h"
#include "core/hand/skin.h"
#include "core/hand/skin_report.h"

namespace handgraft::hand {

/// 64 hexadecimal digits that name a skin by what it is made from: the links' surfaces at the
/// reference pose, the options, and the version of the method. Cost: some 20 ms.
std::string skinKey(const HandModel& model, const SkinOptions& options);

/// What is kept of a skin: its mesh, what its maker had to say, and the link of each face,
/// which takes longest to find of what a mesh needs to be a skin (empty: not known).
struct StoredSkin {
  geometry::TriangleMesh mesh_S;
  std::vector<std::string> notes;
  std::vector<int> face_links = {};
};

/// Bytes that hold a skin, its key and a checksum of all that.
std::string serialise(const StoredSkin& skin, const std::string& key);

/// The skin, or nothing if the file is damaged, of another key or version, or not closed.
/// Takes memory in proportion to the bytes given, whatever they announce.
std::optional<StoredSkin> deserialise(std::string_view file, const std::string& key);

/// Folders of skins that were made before, named by their keys: one that came with the program
/// and is only read, and one that is added to; either may be missing.
///
/// A damaged file is made anew. Its skins keep what is made of them beside their files
/// (kept_solid.h). Threads: const methods from any thread.
class SkinCache {
 public:
  /// Without a folder nothing is kept. `shipped` is looked into first.
  explicit SkinCache(std::optional<std::filesystem::path> folder = std::nullopt,
                     std::filesystem::path shipped = {});

  /// `handgraft/skins` in `$XDG_CACHE_HOME`, else in `$HOME/.cache` (XDG Base Directory
  /// Specification); no cache where neither is an absolute path.
  static SkinCache fromEnvironment(std::filesystem::path shipped = {});

  /// The skin from a folder, else from `buildSkin`, which is then kept. A folder that cannot
  /// be written costs the next caller time, nothing else. The
  /// report is as buildSkin fills it, without steps if the skin comes from a folder. Errors:
  /// as buildSkin.
  [[nodiscard]] Skin get(const HandModel& model,
                         const SkinOptions& options,
                         const Progress& progress,
                         SkinReport* report = nullptr) const;

  [[nodiscard]] const std::optional<std::filesystem::path>& folder() const {
    return files_->folder();
  }

 private:
  std::shared_ptr<const KeptFiles> files_;
};

}  // namespace handgraft::hand
