#include "client/present/output_file.h"

#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/base/error.h"

namespace handgraft::client {

namespace fs = std::filesystem;

namespace {

constexpr int kMostLinks = 40;  // as many as Linux follows

// Where writing leads, and how.
struct Target {
  fs::path path;  // what links lead to
  bool exists = false;
  bool replaceable = false;  // by a file that is written beside it first
  fs::perms permissions = fs::perms::none;
};

fs::path folderOf(const fs::path& path) {
  return fs::absolute(path).parent_path();
}

// Links to a file that is not there yet are followed, too.
fs::path behindLinks(fs::path path) {
  std::error_code error;
  fs::path whole = fs::canonical(path, error);
  if (!error) return whole;
  for (int i = 0; i < kMostLinks && fs::is_symlink(path, error); ++i) {
    const fs::path next = fs::read_symlink(path, error);
    if (error) break;
    path = folderOf(path) / next;
  }
  return fs::weakly_canonical(fs::absolute(path), error);
}

// Throws unless a file of this name may be written. `label` starts the message.
Target targetOf(const fs::path& path, const std::string& label) {
  if (path.empty()) rejectInput("{}: the file's name is empty", label);
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  Target target;
  target.exists = fs::exists(status);
  if (fs::is_directory(status)) rejectInput("{}: that is a folder", label);
  if (!target.exists && status.type() != fs::file_type::not_found) {
    rejectInput("{}: cannot be written ({})", label, error.message());
  }
  // Names of open pipes and the like lead nowhere that a path could say: they stay as they are.
  const bool ordinary = !target.exists || fs::is_regular_file(status);
  target.path = ordinary ? behindLinks(path) : path;
  if (target.path.empty()) rejectInput("{}: cannot be written", label);
  const fs::path folder = folderOf(target.path);
  if (!target.exists && !fs::is_directory(folder, error)) {
    rejectInput("{}: there is no folder {}", label, quoted(folder.string()));
  }
  if (target.exists) {
    // The superuser may write what nobody is meant to change.
    constexpr fs::perms kAnyWrite =
        fs::perms::owner_write | fs::perms::group_write | fs::perms::others_write;
    if ((status.permissions() & kAnyWrite) == fs::perms::none) {
      rejectInput("{}: cannot be written (the file is read-only)", label);
    }
    if (access(path.c_str(), W_OK) != 0) {
      rejectInput("{}: cannot be written ({})", label, std::generic_category().message(errno));
    }
    target.permissions = status.permissions();
  }
  const bool open_folder = access(folder.c_str(), W_OK) == 0;
  if (!target.exists && !open_folder) {
    rejectInput("{}: cannot be written ({})", label, std::generic_category().message(errno));
  }
  target.replaceable = ordinary && open_folder && fs::is_directory(folder, error);
  return target;
}

// Zero, or why not (an errno).
int writeAll(const fs::path& path, int flags, std::string_view bytes) {
  const int file = open(path.c_str(), O_WRONLY | O_CLOEXEC | flags, 0666);
  if (file < 0) return errno;
  int reason = 0;
  while (!bytes.empty() && reason == 0) {
    const ssize_t count = write(file, bytes.data(), bytes.size());
    if (count >= 0) {
      bytes.remove_prefix(static_cast<std::size_t>(count));
    } else if (errno != EINTR) {
      reason = errno;
    }
  }
  if (close(file) != 0 && reason == 0) reason = errno;
  return reason;
}

int replace(const Target& target, std::string_view bytes) {
  fs::path partial = target.path;
  partial += "." + std::to_string(getpid()) + ".part";
  int reason = writeAll(partial, O_CREAT | O_TRUNC | O_NOFOLLOW, bytes);
  std::error_code error;
  if (reason == 0 && target.exists) fs::permissions(partial, target.permissions, error);
  if (reason == 0 && !error) fs::rename(partial, target.path, error);
  if (error) reason = error.value();
  if (reason != 0) fs::remove(partial, error);
  return reason;
}

}  // namespace

void requireWritable(const NamedFile& file) {
  targetOf(file.path, file.option + " " + quoted(file.path.string()));
}

void requireDistinct(const std::vector<NamedFile>& files) {
  for (std::size_t i = 0; i < files.size(); ++i) {
    for (std::size_t k = i + 1; k < files.size(); ++k) {
      std::error_code error;
      const bool same = fs::equivalent(files[i].path, files[k].path, error) ||
                        behindLinks(files[i].path) == behindLinks(files[k].path);
      if (!same) continue;
      rejectInput("{} and {} name one file, {}", files[i].option, files[k].option,
                  quoted(files[k].path.string()));
    }
  }
}

void requireSafe(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs) {
  std::vector<NamedFile> files;
  for (const NamedFile& file : outputs) {
    if (file.path.empty()) continue;
    requireWritable(file);
    for (const NamedFile& input : inputs)
      requireDistinct({file, input});
    files.push_back(file);
  }
  requireDistinct(files);
}

void writeFile(const fs::path& path, std::string_view bytes) {
  const std::string label = quoted(path.string());
  const Target target = targetOf(path, label);
  const int reason = target.replaceable ? replace(target, bytes)
                                        : writeAll(target.path, O_TRUNC | O_NOCTTY, bytes);
  if (reason != 0)
    rejectInput("{}: cannot be written ({})", label, std::generic_category().message(reason));
}

void OutputFiles::write(const std::function<void()>& writing) {
  try {
    writing();
  } catch (const InvalidInput& error) {
    errors_ += (errors_.empty() ? "" : "; ") + std::string(error.what());
  }
}

void OutputFiles::requireWritten() const {
  if (!errors_.empty()) throw InvalidInput(errors_);
}

}  // namespace handgraft::client
