// Bytes of a mesh file, all the way to log maps. The first byte says which format they claim
// to be in and what is asked of the mesh.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include <unistd.h>

#include "core/base/error.h"
#include "core/io/mesh_file.h"

#include "tests/fuzz/sane_geometry.h"

namespace {

namespace fs = std::filesystem;

// Beyond this, one log map of a hostile mesh takes a second under the sanitizers.
constexpr int kMostFaces = 1500;

/// A file of this process's own in memory, where the system has such a folder.
fs::path scratchFile(const char* extension) {
  static const fs::path kFolder =
      fs::is_directory("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path();
  return kFolder / ("handgraft_fuzz_" + std::to_string(getpid()) + extension);
}

void writeFile(const fs::path& path, const std::uint8_t* bytes, std::size_t size) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  const bool written = file != nullptr && std::fwrite(bytes, 1, size, file) == size;
  if (file == nullptr || std::fclose(file) != 0 || !written) {
    std::fprintf(stderr, "%s cannot be written\n", path.c_str());
    std::_Exit(1);
  }
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size < 2) return 0;
  constexpr const char* kExtensions[] = {".stl", ".obj", ".ply"};
  const fs::path path = scratchFile(kExtensions[bytes[0] % 3]);
  writeFile(path, bytes + 1, size - 1);
  try {
    const handgraft::io::MeshFile file = handgraft::io::readMesh(path);
    if (file.mesh.faceCount() <= kMostFaces) {
      handgraft::fuzz::exerciseGeometry(file.mesh, bytes[0] / 3U);
    }
  } catch (const handgraft::InvalidInput&) {
    // The answer that most bytes deserve.
  }
  fs::remove(path);
  return 0;
}
