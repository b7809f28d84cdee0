#include "tests/fuzz/scratch_file.h"

#include <cstdio>
#include <cstdlib>

#include <unistd.h>

namespace handgraft::fuzz {

namespace {

namespace fs = std::filesystem;

class ScratchFolder {
 public:
  ScratchFolder()
      : path_(
            (fs::is_directory("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path()) /
            ("handgraft_fuzz_" + std::to_string(getpid()))) {
    fs::create_directories(path_);
  }

  ~ScratchFolder() {
    std::error_code error;
    fs::remove_all(path_, error);
  }

  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

fs::path scratchFile(const std::string& name, std::string_view bytes) {
  static const ScratchFolder scratch_folder;
  fs::path path = scratch_folder.path() / name;
  std::FILE* file = std::fopen(path.c_str(), "wb");
  const bool written =
      file != nullptr && std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  if (file == nullptr || std::fclose(file) != 0 || !written) {
    std::fprintf(stderr, "%s cannot be written\n", path.c_str());
    std::_Exit(1);
  }
  return path;
}

}  // namespace handgraft::fuzz
