#include "client/gateway/given_files.h"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <sstream>
#include <system_error>

#include "client/link/client.h"
#include "core/base/error.h"

namespace handgraft::client::gateway {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLongestPart = 255;  // bytes of a file's name, on the systems there are

[[noreturn]] void refuseRoom(const std::string& why) {
  throw Refused(v1::ERROR_OVERLOADED, why);
}

void replaceAll(std::string& text, const std::string& what, const std::string& with) {
  for (std::size_t at = text.find(what); at != std::string::npos;
       at = text.find(what, at + with.size())) {
    text.replace(at, what.size(), with);
  }
}

}  // namespace

// === Files that belong together

ModelFiles FileGroup::model(v1::ModelKind kind,
                            const std::string& main,
                            const std::string& object,
                            const std::string& units) const {
  if (files_.count(main) == 0) {
    rejectInput("{}: it is not among the files that were given", quoted(main));
  }
  const fs::path path = folder_ / main;
  try {
    switch (kind) {
      case v1::MODEL_HAND: {
        HandReading reading;
        reading.within = folder_;
        reading.packages = packagesWithin(folder_, path);
        return handFiles(path, reading, units);
      }
      case v1::MODEL_OBJECT:
        return objectFiles(path, units, folder_);
      case v1::MODEL_CONTACTS: {
        ContactReading reading;
        reading.within = folder_;
        return contactFiles(path, object, reading, units);
      }
      default:
        break;
    }
  } catch (const InvalidInput& error) {
    throw InvalidInput(inPagesWords(error.what()));
  }
  rejectInput("kind: pages load hands, objects and contacts");
}

std::string FileGroup::inPagesWords(std::string message) const {
  replaceAll(message, folder_.string() + "/", "");
  replaceAll(message, folder_.string(), ".");
  return message;
}

// === Those of all pages

void GivenFiles::requirePath(const std::string& path) const {
  const auto refuse = [&](const char* why) {
    rejectInput("{}: {}; files are called by paths such as hand/meshes/palm.stl", quoted(path),
                why);
  };
  if (path.empty() || path.size() > limits_.path_bytes) refuse("its name is empty or too long");
  if (path.find('\0') != std::string::npos || path.find('\\') != std::string::npos)
    refuse("its name has a character that names may not have");
  if (path.front() == '/' || path.back() == '/') refuse("it is no file of the folder");
  std::size_t parts = 0;
  std::istringstream stream(path);
  for (std::string part; std::getline(stream, part, '/');) {
    if (part.empty() || part == "." || part == "..") refuse("it leads out of its folder");
    if (part.size() > kLongestPart) refuse("a part of its name is too long");
    if (++parts > limits_.path_parts) refuse("it lies too deep");
  }
}

void GivenFiles::requireRoom(PageId page, const FileGroup& group, const Chunk& chunk) const {
  if (group.files_.size() >= limits_.files_per_group) {
    refuseRoom(fmt::format("{}: too many files; {} may be given at once", quoted(chunk.path),
                           limits_.files_per_group));
  }
  std::uint64_t all = 0;
  std::uint64_t its = 0;
  for (const auto& [key, other] : groups_) {
    all += other->bytes_;
    if (key.first == page) its += other->bytes_;
  }
  if (chunk.total_bytes > limits_.bytes_per_page - std::min(its, limits_.bytes_per_page)) {
    refuseRoom(fmt::format("{}: {} bytes with {} before it; a page may give up to {}",
                           quoted(chunk.path), chunk.total_bytes, its, limits_.bytes_per_page));
  }
  if (chunk.total_bytes > limits_.bytes - std::min(all, limits_.bytes)) {
    refuseRoom(fmt::format("{}: other pages give files, too; try again in a while",
                           quoted(chunk.path)));
  }
}

FileGroup& GivenFiles::groupFor(PageId page, std::uint64_t number) {
  const auto found = groups_.find({page, number});
  if (found != groups_.end()) return *found->second;
  const auto its = std::count_if(groups_.begin(), groups_.end(), [&](const auto& one) {
    return one.first.first == page;
  });
  if (static_cast<std::size_t>(its) >= limits_.groups_per_page) {
    refuseRoom(
        fmt::format("a page keeps at most {} folders of files", limits_.groups_per_page));
  }
  return *groups_.emplace(std::pair(page, number), std::make_shared<FileGroup>()).first->second;
}

void GivenFiles::put(PageId page, const Chunk& chunk) {
  requirePath(chunk.path);
  FileGroup& group = groupFor(page, chunk.group);
  const fs::path path = group.folder_ / chunk.path;
  auto found = group.files_.find(chunk.path);
  if (found == group.files_.end()) {
    requireRoom(page, group, chunk);
    std::error_code error;
    fs::create_directories(path.parent_path(), error);
    if (error || fs::exists(path)) {
      rejectInput("{}: a file and a folder of that name were given", quoted(chunk.path));
    }
    found = group.files_.emplace(chunk.path, FileGroup::File{chunk.total_bytes, 0}).first;
    group.bytes_ += chunk.total_bytes;
  }
  FileGroup::File& file = found->second;
  if (chunk.offset != file.received || chunk.total_bytes != file.total ||
      chunk.bytes.size() > file.total - file.received) {
    rejectInput("{}: bytes {} to {} of {} do not follow the {} that came before",
                quoted(chunk.path), chunk.offset, chunk.offset + chunk.bytes.size(),
                chunk.total_bytes, file.received);
  }
  std::ofstream out(path, std::ios::binary | std::ios::app);
  out.write(chunk.bytes.data(), static_cast<std::streamsize>(chunk.bytes.size()));
  out.close();
  if (!out) {
    // Of a chunk that comes again nothing may be there.
    std::error_code ignored;
    fs::resize_file(path, file.received, ignored);
    rejectInput("{}: it cannot be kept: no room", quoted(chunk.path));
  }
  file.received += chunk.bytes.size();
}

std::shared_ptr<const FileGroup> GivenFiles::find(PageId page, std::uint64_t group) const {
  const auto found = groups_.find({page, group});
  if (found == groups_.end()) rejectInput("files {}: there are none of that number", group);
  for (const auto& [path, file] : found->second->files_) {
    if (file.received < file.total) {
      rejectInput("{}: {} of its {} bytes came", quoted(path), file.received, file.total);
    }
  }
  return found->second;
}

void GivenFiles::drop(PageId page, std::uint64_t group) {
  groups_.erase({page, group});
}

void GivenFiles::drop(PageId page) {
  groups_.erase(groups_.lower_bound({page, 0}), groups_.lower_bound({page + 1, 0}));
}

}  // namespace handgraft::client::gateway
