// Bytes of a mesh file, all the way to log maps. The first byte says which format they claim
// to be in and what is asked of the mesh.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/io/mesh_file.h"

#include "tests/fuzz/sane_geometry.h"
#include "tests/fuzz/scratch_file.h"

namespace {

// Beyond this, one log map of a hostile mesh takes a second under the sanitizers.
constexpr int kMostFaces = 1500;

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size < 2) return 0;
  constexpr const char* kExtensions[] = {".stl", ".obj", ".ply"};
  const std::string_view text(reinterpret_cast<const char*>(bytes) + 1, size - 1);
  const std::filesystem::path path =
      handgraft::fuzz::scratchFile(std::string("mesh") + kExtensions[bytes[0] % 3], text);
  try {
    const handgraft::io::MeshFile file = handgraft::io::readMesh(path);
    if (file.mesh.faceCount() <= kMostFaces) {
      handgraft::fuzz::exerciseGeometry(file.mesh, bytes[0] / 3U);
    }
  } catch (const handgraft::InvalidInput&) {
    // The answer that most bytes deserve.
  }
  return 0;
}
