#pragma once

#include <filesystem>
#include <string>

namespace handgraft {

/// A private folder under the system's temporary one, for as long as this lives. Those of its
/// kind that a program left which was killed are removed first: each is locked by its owner,
/// and a lock ends with the process. Of this user's alone.
class ScratchFolder {
 public:
  /// `kind` begins its name: "handgraft-server". Errors: std::filesystem_error.
  explicit ScratchFolder(const std::string& kind);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  int lock_ = -1;
};

}  // namespace handgraft
