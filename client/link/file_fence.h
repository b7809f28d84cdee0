#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/resource_uri.h"

namespace handgraft::client {

/// Which files go along with a model because the model, not the user, names them. A file from
/// strangers may name any file of this machine, and what is uploaded crosses the network.
///
/// Permitted are files of the kinds that a model consists of which lie, symbolic links
/// resolved, below the model's own folder or below a package: one that the user named, one of
/// the installed workspace, or a folder with a `package.xml` above the model or beside that.
/// The own
/// folder is the one above where the model lies in `urdf/` and the like.
class FileFence {
 public:
  enum class Kind { kMesh, kBuffer, kSites, kPoses };

  /// Of the model that the user named. Errors: InvalidInput if it is a symbolic link to a file
  /// of another type.
  FileFence(const std::filesystem::path& model, const PackageMap& packages);

  /// Files that lie in that folder alone: those of strangers, gathered there.
  static FileFence around(const std::filesystem::path& folder);

  /// Errors: InvalidInput, naming `what`, the file and where it may lie.
  void require(const std::string& what, const std::filesystem::path& file, Kind kind) const;

 private:
  FileFence() = default;

  [[nodiscard]] bool isInside(const std::filesystem::path& file,
                              const std::filesystem::path& found_as) const;

  std::vector<std::filesystem::path> folders_;
  std::vector<std::filesystem::path> workspace_;  ///< as found: its links are the user's own
  bool closed_ = false;                           ///< no package of the neighbourhood counts
};

}  // namespace handgraft::client
