#include "tests/system/shared_skins.h"

#include <filesystem>

#include "tests/system/service.h"

namespace handgraft::test {

namespace fs = std::filesystem;

namespace {

constexpr const char* kVariable = "XDG_CACHE_HOME";

// Of this build of the server; what older ones left is removed.
fs::path folder() {
  const fs::path server = program("handgraft-server");
  const fs::path all = server.parent_path().parent_path() / "tests" / "skins";
  const std::string name =
      std::to_string(fs::last_write_time(server).time_since_epoch().count());
  std::error_code error;
  fs::create_directories(all / name, error);
  for (fs::directory_iterator other(all, error), end; !error && other != end;
       other.increment(error)) {
    std::error_code in_use;
    if (other->path().filename() != name) fs::remove_all(other->path(), in_use);
  }
  return all / name;
}

}  // namespace

SharedSkins::SharedSkins() : cache_(kVariable, folder()) {}

}  // namespace handgraft::test
