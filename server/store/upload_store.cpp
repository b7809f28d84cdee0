#include "server/store/upload_store.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <system_error>
#include <vector>

#include <fmt/format.h>

#include "core/base/content_hash.h"
#include "core/base/error.h"
#include "server/base/rejection.h"

namespace handgraft::server {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLongestUri = 1024;
constexpr std::size_t kLargestChunk = 524288;  // the bound in models.idl

/// Readers of meshes tell formats apart by the name's end: keep it if it is harmless.
std::string safeExtension(const std::string& uri) {
  constexpr std::size_t kLongest = 5;
  const std::size_t dot = uri.find_last_of('.');
  if (dot == std::string::npos) return "";
  const std::string end = uri.substr(dot + 1);
  const bool harmless =
      !end.empty() && end.size() <= kLongest && std::all_of(end.begin(), end.end(), [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0;
      });
  return harmless ? "." + end : "";
}

}  // namespace

// === UploadedFiles

UploadedFiles::UploadedFiles(fs::path folder) : folder_(std::move(folder)) {
  fs::create_directory(folder_);
}

UploadedFiles::~UploadedFiles() {
  std::error_code error;  // a temporary folder that stays is no reason to fail
  fs::remove_all(folder_, error);
}

const fs::path& UploadedFiles::file(const std::string& uri) const {
  const auto found = files_.find(uri);
  if (found == files_.end())
    rejectInput("{}: this file was not uploaded", handgraft::quoted(uri));
  return found->second;
}

std::string UploadedFiles::inClientsWords(std::string message) const {
  for (const auto& [uri, path] : files_) {
    const std::string ours = path.string();
    const std::string theirs = handgraft::quoted(uri).substr(1);
    for (std::size_t at = message.find(ours); at != std::string::npos;
         at = message.find(ours, at + theirs.size() - 1)) {
      message.replace(at, ours.size(), theirs.substr(0, theirs.size() - 1));
    }
  }
  return message;
}

std::string UploadedFiles::contentHash() const {
  ContentHash hash;
  std::vector<char> buffer(1 << 16);
  for (const auto& [uri, path] : files_) {
    hash.addText(uri);
    std::ifstream in(path, std::ios::binary);
    std::uint64_t size = 0;
    while (in.read(buffer.data(), static_cast<std::streamsize>(buffer.size())) ||
           in.gcount() > 0) {
      hash.add({buffer.data(), static_cast<std::size_t>(in.gcount())});
      size += static_cast<std::uint64_t>(in.gcount());
    }
    hash.addNumber(size);
  }
  return hash.finish();
}

// === UploadStore

void UploadStore::put(const ClientId& client, const v1::PutFileRequest& chunk) {
  if (chunk.uri().empty() || chunk.uri().size() > kLongestUri) {
    rejectInput("uri {}: its length {} is outside 1-{}", handgraft::quoted(chunk.uri()),
                chunk.uri().size(), kLongestUri);
  }
  if (chunk.bytes().size() > kLargestChunk) {
    rejectInput("file {}: a chunk of {} bytes; at most {} are allowed",
                handgraft::quoted(chunk.uri()), chunk.bytes().size(), kLargestChunk);
  }
  const std::lock_guard lock(mutex_);
  dropIdleLocked();
  const Key key{client, chunk.upload_id()};
  Upload& upload = uploadFor(key);
  upload.touched = std::chrono::steady_clock::now();
  File& file = beginFile(key, upload, chunk);
  if (chunk.total_bytes() != file.total || chunk.offset() != file.received ||
      chunk.bytes().size() > file.total - file.received) {
    rejectInput("file {}: {} bytes at offset {} of {} do not continue the {} of {} there are",
                handgraft::quoted(chunk.uri()), chunk.bytes().size(), chunk.offset(),
                chunk.total_bytes(), file.received, file.total);
  }
  if (chunk.bytes().empty() && file.total > file.received) {
    rejectInput("file {}: an empty chunk at offset {} of {}", handgraft::quoted(chunk.uri()),
                chunk.offset(), file.total);
  }
  makeRoom(key, chunk.bytes().size(), chunk.uri());
  const fs::path path = upload.files->file(chunk.uri());
  std::ofstream out(path, std::ios::binary | std::ios::app);
  out.write(reinterpret_cast<const char*>(chunk.bytes().data()),
            static_cast<std::streamsize>(chunk.bytes().size()));
  out.close();
  if (!out) {
    // Of a chunk that comes again nothing may be there.
    std::error_code ignored;
    fs::resize_file(path, file.received, ignored);
    reject(v1::ERROR_OVERLOADED, "the server has no room left for uploads");
  }
  file.received += chunk.bytes().size();
  upload.received += chunk.bytes().size();
}

std::uint64_t UploadStore::held() const {
  std::uint64_t sum = 0;
  for (const auto& [key, upload] : uploads_)
    sum += upload.received + kFileCost * upload.progress.size();
  return sum;
}

void UploadStore::makeRoom(const Key& key, std::uint64_t bytes, const std::string& uri) {
  const auto now = std::chrono::steady_clock::now();
  while (true) {
    const std::uint64_t all = held();
    if (bytes <= limits_.bytes && all <= limits_.bytes - bytes) return;
    auto longest = uploads_.end();
    for (auto at = uploads_.begin(); at != uploads_.end(); ++at) {
      if (at->first == key || now - at->second.touched < limits_.idle_in_need) continue;
      if (longest == uploads_.end() || at->second.touched < longest->second.touched)
        longest = at;
    }
    if (longest == uploads_.end()) {
      reject(v1::ERROR_OVERLOADED,
             "file {}: all clients together are uploading {} bytes; try later",
             handgraft::quoted(uri), all);
    }
    uploads_.erase(longest);
  }
}

UploadStore::Upload& UploadStore::uploadFor(const Key& key) {
  const auto found = uploads_.find(key);
  if (found != uploads_.end()) return found->second;
  const auto mine = std::count_if(uploads_.begin(), uploads_.end(), [&](const auto& one) {
    return one.first.first == key.first;
  });
  if (static_cast<std::size_t>(mine) >= limits_.uploads_per_client) {
    reject(v1::ERROR_OVERLOADED, "{} uploads are unfinished; load or wait before another one",
           mine);
  }
  Upload& upload = uploads_[key];
  upload.files =
      std::make_shared<UploadedFiles>(folder_.path() / fmt::format("{}", next_folder_++));
  return upload;
}

UploadStore::File& UploadStore::beginFile(const Key& key,
                                          Upload& upload,
                                          const v1::PutFileRequest& chunk) {
  const auto found = upload.progress.find(chunk.uri());
  const bool again = chunk.offset() == 0 && found != upload.progress.end();
  if (found != upload.progress.end() && !again) return found->second;
  if (chunk.offset() != 0) {
    reject(v1::ERROR_UPLOAD_GONE,
           "file {}: a chunk at offset {} of a file that is not begun here",
           handgraft::quoted(chunk.uri()), chunk.offset());
  }

  // What is announced counts for its own client, so that a limit shows at a file's first chunk;
  // for all together counts what has come: a promise costs nothing, and must hold nobody up.
  const std::uint64_t given_back = again ? found->second.total : 0;
  const std::uint64_t mine = reservedBy(key.first) - given_back;
  if (chunk.total_bytes() > limits_.bytes_per_client ||
      mine > limits_.bytes_per_client - chunk.total_bytes()) {
    reject(v1::ERROR_OVERLOADED,
           "file {}: {} bytes besides {} unfinished; a client may upload {} at once",
           handgraft::quoted(chunk.uri()), chunk.total_bytes(), mine, limits_.bytes_per_client);
  }
  makeRoom(key, kFileCost, chunk.uri());
  if (!again && upload.progress.size() >= limits_.files_per_upload) {
    reject(v1::ERROR_OVERLOADED, "file {}: an upload may have {} files",
           handgraft::quoted(chunk.uri()), limits_.files_per_upload);
  }

  const fs::path path =
      again ? upload.files->file(chunk.uri())
            : upload.files->folder_ /
                  fmt::format("{}{}", upload.progress.size(), safeExtension(chunk.uri()));
  const std::ofstream made(path, std::ios::binary | std::ios::trunc);
  upload.files->files_[chunk.uri()] = path;
  upload.reserved += chunk.total_bytes() - given_back;
  if (again) upload.received -= found->second.received;
  File& file = upload.progress[chunk.uri()];
  file = {chunk.uri(), chunk.total_bytes(), 0};
  return file;
}

std::shared_ptr<const UploadedFiles> UploadStore::finish(const ClientId& client,
                                                         std::uint64_t upload_id) {
  const std::lock_guard lock(mutex_);
  const auto found = uploads_.find({client, upload_id});
  if (found == uploads_.end())
    reject(v1::ERROR_UPLOAD_GONE, "upload {}: no file of it is here", upload_id);
  for (const auto& [uri, file] : found->second.progress) {
    if (file.received == file.total) continue;
    rejectInput("file {}: {} of {} bytes were sent", handgraft::quoted(uri), file.received,
                file.total);
  }
  std::shared_ptr<const UploadedFiles> files = found->second.files;
  uploads_.erase(found);
  return files;
}

std::uint64_t UploadStore::bytes() const {
  const std::lock_guard lock(mutex_);
  std::uint64_t sum = 0;
  for (const auto& [key, upload] : uploads_)
    sum += upload.received;
  return sum;
}

void UploadStore::drop(const ClientId& client) {
  const std::lock_guard lock(mutex_);
  std::erase_if(uploads_, [&](const auto& one) {
    return one.first.first == client;
  });
}

void UploadStore::dropIdle() {
  const std::lock_guard lock(mutex_);
  dropIdleLocked();
}

void UploadStore::dropIdleLocked() {
  const auto now = std::chrono::steady_clock::now();
  std::erase_if(uploads_, [&](const auto& one) {
    return now - one.second.touched > limits_.idle;
  });
}

std::uint64_t UploadStore::reservedBy(const ClientId& client) const {
  std::uint64_t sum = 0;
  for (const auto& [key, upload] : uploads_) {
    if (key.first == client) sum += upload.reserved;
  }
  return sum;
}

}  // namespace handgraft::server
