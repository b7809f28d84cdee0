#include "tests/support/shared_data.h"

#include <cstdlib>
#include <stdexcept>

#include <unistd.h>

namespace handgraft::test {

namespace fs = std::filesystem;

fs::path sourceDirectory() {
  return HANDGRAFT_SOURCE_DIR;
}

fs::path sharedData(const std::string& relative) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): tests read the environment, nobody writes it.
  const char* set = std::getenv("HANDGRAFT_SHARED_DATA");
  const fs::path root =
      set != nullptr ? fs::path(set) : sourceDirectory().parent_path() / "shared" / "data";
  return root / relative;
}

fs::path scratchDirectory() {
  struct Folder {
    fs::path path;

    Folder() {
      std::string pattern = (fs::temp_directory_path() / "handgraft_test_XXXXXX").string();
      if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("mkdtemp failed");
      path = pattern;
    }

    ~Folder() {
      std::error_code error;
      fs::remove_all(path, error);
    }
  };

  static const Folder data_folder;
  return data_folder.path;
}

}  // namespace handgraft::test
