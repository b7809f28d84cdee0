#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/hand/skin.h"
#include "core/hand/skin_report.h"

namespace handgraft::hand {

/// 64 hexadecimal digits that name a skin by what it is made from: the links' surfaces at the
/// reference pose, the options, and the version of the method. Cost: some 20 ms.
std::string skinKey(const HandModel& model, const SkinOptions& options);

/// What is kept of a skin: its mesh, and what its maker had to say.
struct StoredSkin {
  geometry::TriangleMesh mesh_S;
  std::vector<std::string> notes;
};

/// Bytes that hold a skin, its key and a checksum of all that.
std::string serialise(const StoredSkin& skin, const std::string& key);

/// The skin, or nothing if the bytes are damaged, of another key or version, or not closed.
/// Takes memory in proportion to the bytes given, whatever they announce.
std::optional<StoredSkin> deserialise(std::string_view bytes, const std::string& key);

/// A folder of skins that were made before, named by their keys; or none.
///
/// A damaged file is made anew. Several processes may share a folder: files appear whole.
/// Threads: const methods from any thread.
class SkinCache {
 public:
  /// Without a folder nothing is kept.
  explicit SkinCache(std::optional<std::filesystem::path> folder = std::nullopt);

  /// `handgraft/skins` in `$XDG_CACHE_HOME`, else in `$HOME/.cache` (XDG Base Directory
  /// Specification); no cache where neither is an absolute path.
  static SkinCache fromEnvironment();

  /// The skin from the folder, else from `buildSkin`, which is then kept. A folder that cannot
  /// be written costs the next caller time, nothing else. The
  /// report is as buildSkin fills it, without steps if the skin comes from the folder. Errors:
  /// as buildSkin.
  [[nodiscard]] Skin get(const HandModel& model,
                         const SkinOptions& options,
                         const Progress& progress,
                         SkinReport* report = nullptr) const;

  [[nodiscard]] const std::optional<std::filesystem::path>& folder() const { return folder_; }

 private:
  std::optional<std::filesystem::path> folder_;
};

}  // namespace handgraft::hand
