#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "core/base/scratch_folder.h"
#include "idl/models.h"

namespace handgraft::server {

struct UploadLimits {
  std::uint64_t bytes = 1ull << 30;               ///< of all clients, as they have come
  std::uint64_t bytes_per_client = 256ull << 20;  ///< as announced
  std::size_t files_per_upload = 2000;
  std::size_t uploads_per_client = 16;
  std::chrono::seconds idle{600};  ///< an upload that nothing was added to is dropped
  /// Likewise, the longest idle one first, where another client's would find no room.
  std::chrono::seconds idle_in_need{10};
};

/// The files of one finished upload; they are deleted with this.
///
/// A client's names never become paths: every file lies in one private folder under a name of
/// ours.
class UploadedFiles {
 public:
  explicit UploadedFiles(std::filesystem::path folder);
  ~UploadedFiles();
  UploadedFiles(const UploadedFiles&) = delete;
  UploadedFiles& operator=(const UploadedFiles&) = delete;

  /// The file sent for a URI. Errors: InvalidInput naming it if there is none.
  [[nodiscard]] const std::filesystem::path& file(const std::string& uri) const;

  [[nodiscard]] bool has(const std::string& uri) const { return files_.count(uri) != 0; }

  /// All of them, by URI.
  [[nodiscard]] const std::map<std::string, std::filesystem::path>& all() const {
    return files_;
  }

  /// A message with our file names replaced by the client's URIs.
  [[nodiscard]] std::string inClientsWords(std::string message) const;

  /// ContentHash of all names and contents; equal for equal files in whatever order they came.
  [[nodiscard]] std::string contentHash() const;

 private:
  friend class UploadStore;
  std::filesystem::path folder_;
  std::map<std::string, std::filesystem::path> files_;
};

/// Files that clients send in chunks, until a model is made of them.
///
/// Threads: all methods from any thread; chunks of one upload one after another.
class UploadStore {
 public:
  using ClientId = std::array<std::uint8_t, 16>;

  /// Makes a private folder under the system's temporary one. Errors: std::filesystem_error.
  explicit UploadStore(UploadLimits limits = {}) : limits_(limits) {}

  UploadStore(const UploadStore&) = delete;
  UploadStore& operator=(const UploadStore&) = delete;

  /// Adds a chunk. Errors: InvalidInput for a chunk out of order or beyond the file's size, an
  /// empty or overlong URI; Rejection (ERROR_OVERLOADED) beyond the limits. After an error the
  /// file must be sent again from offset 0.
  void put(const ClientId& client, const v1::PutFileRequest& chunk);

  /// Hands the upload over. Errors: InvalidInput if there is none of that number, or a file of
  /// it is not complete.
  std::shared_ptr<const UploadedFiles> finish(const ClientId& client, std::uint64_t upload_id);

  /// Gives back what a client that is gone had begun to send.
  void drop(const ClientId& client);

  /// Gives back what nothing was added to for so long. To be called now and then.
  void dropIdle();

  /// What a file counts as beyond its bytes: empty ones take room, too.
  static constexpr std::uint64_t kFileCost = 4096;

  /// Bytes that have come of all unfinished uploads.
  [[nodiscard]] std::uint64_t bytes() const;

 private:
  struct File {
    std::string uri;
    std::uint64_t total = 0;
    std::uint64_t received = 0;
  };

  struct Upload {
    std::shared_ptr<UploadedFiles> files;
    std::map<std::string, File> progress;
    std::uint64_t reserved = 0;  ///< bytes announced
    std::uint64_t received = 0;  ///< bytes that have come
    std::chrono::steady_clock::time_point touched;
  };

  using Key = std::pair<ClientId, std::uint64_t>;

  void dropIdleLocked();
  Upload& uploadFor(const Key& key);
  File& beginFile(const Key& key, Upload& upload, const v1::PutFileRequest& chunk);
  [[nodiscard]] std::uint64_t reservedBy(const ClientId& client) const;
  [[nodiscard]] std::uint64_t held() const;
  /// Errors: Rejection if so many bytes find no room beside those of all clients, after what
  /// was idle has gone.
  void makeRoom(const Key& key, std::uint64_t bytes, const std::string& uri);

  UploadLimits limits_;
  ScratchFolder folder_{"handgraft-server"};
  mutable std::mutex mutex_;
  std::map<Key, Upload> uploads_;
  std::uint64_t next_folder_ = 0;
};

}  // namespace handgraft::server
