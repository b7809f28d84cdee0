#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

/// Files that commands write, checked before long work and written so that nothing is lost.
namespace handgraft::client {

/// A file that an option names.
struct NamedFile {
  std::string option;  ///< `--out`
  std::filesystem::path path;
};

/// Checks that a file of this name may be written: there is a folder for it, and what has the
/// name already is no folder and may be changed. Writes nothing.
/// Errors: InvalidInput, naming the option, the path and the reason.
void requireWritable(const NamedFile& file);

/// Errors: InvalidInput if two of them are one file, also by way of links, naming both options.
void requireDistinct(const std::vector<NamedFile>& files);

/// Checks everything that a command will write: each file may be written, they are distinct,
/// and none of them is one of `inputs`. Outputs without a path do not count. Errors:
/// InvalidInput as above.
void requireSafe(const std::vector<NamedFile>& outputs, const std::vector<NamedFile>& inputs);

/// Writes all bytes. An ordinary file is replaced only when all of them are written, and keeps
/// its permissions; links are followed. A device, a pipe, or a file in a folder where nothing
/// may be added is written straight into.
/// Errors: InvalidInput, naming the path and the reason.
void writeFile(const std::filesystem::path& path, std::string_view bytes);

/// Several files of one command: those that can be written are, whatever becomes of the others.
class OutputFiles {
 public:
  /// Calls `writing`, and keeps its InvalidInput for later; other errors pass.
  void write(const std::function<void()>& writing);

  /// Once all else is done. Errors: InvalidInput with what was kept, if anything was.
  void requireWritten() const;

 private:
  std::string errors_;
};

}  // namespace handgraft::client
