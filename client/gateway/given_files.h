#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "client/gateway/web_server.h"
#include "client/link/model_files.h"
#include "core/base/scratch_folder.h"

namespace handgraft::client::gateway {

struct GivenLimits {
  std::uint64_t bytes_per_page = 256ULL << 20U;  ///< as announced; the server takes no more
  std::uint64_t bytes = 512ULL << 20U;           ///< of all pages
  std::size_t files_per_group = 2000;
  std::size_t groups_per_page = 8;
  std::size_t path_bytes = 1024;
  std::size_t path_parts = 32;
};

/// Files that belong together, as a page gave them: a private folder that goes with this.
class FileGroup {
 public:
  /// Errors: std::filesystem_error.
  FileGroup() = default;
  FileGroup(const FileGroup&) = delete;
  FileGroup& operator=(const FileGroup&) = delete;

  /// What the server is to be sent of them, by the rules that hold for every client
  /// (client/link/model_files.h), and nothing from elsewhere. `object` is what contacts lie on.
  /// Errors: InvalidInput, in words of the page's own paths.
  [[nodiscard]] ModelFiles model(v1::ModelKind kind,
                                 const std::string& main,
                                 const std::string& object,
                                 const std::string& units) const;

  /// A message without the place of our folder.
  [[nodiscard]] std::string inPagesWords(std::string message) const;

 private:
  friend class GivenFiles;

  struct File {
    std::uint64_t total = 0;
    std::uint64_t received = 0;
  };

  ScratchFolder scratch_{"handgraft_page"};
  std::filesystem::path folder_ = scratch_.path();
  std::map<std::string, File> files_;
  std::uint64_t bytes_ = 0;  ///< announced
};

/// Files that pages give, chunk by chunk, until their models are loaded.
///
/// What pages call them become paths below a folder of ours: parts that lead elsewhere are
/// refused, and nothing but plain files is ever made there.
/// Threads: one at a time.
class GivenFiles {
 public:
  explicit GivenFiles(GivenLimits limits = {}) : limits_(limits) {}

  struct Chunk {
    std::uint64_t group = 0;  ///< the page's number for it
    std::string path;         ///< within it: "hand/meshes/palm.stl"
    std::uint64_t total_bytes = 0;
    std::uint64_t offset = 0;
    std::string_view bytes;
  };

  /// Errors: InvalidInput for a path that is none, a chunk out of order or beyond the file's
  /// size; Refused (ERROR_OVERLOADED) beyond the limits.
  void put(PageId page, const Chunk& chunk);

  /// Errors: InvalidInput if there is none, or a file of it is not complete.
  [[nodiscard]] std::shared_ptr<const FileGroup> find(PageId page, std::uint64_t group) const;

  void drop(PageId page, std::uint64_t group);
  /// All of the page's.
  void drop(PageId page);

 private:
  FileGroup& groupFor(PageId page, std::uint64_t number);
  void requirePath(const std::string& path) const;
  void requireRoom(PageId page, const FileGroup& group, const Chunk& chunk) const;

  const GivenLimits limits_;
  std::map<std::pair<PageId, std::uint64_t>, std::shared_ptr<FileGroup>> groups_;
};

}  // namespace handgraft::client::gateway
