#include <bit>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "core/base/error.h"
#include "core/io/file_bytes.h"
#include "core/io/file_mesh.h"
#include "core/io/mesh_file.h"

namespace handgraft::io {

namespace {

constexpr std::size_t kHeaderBytes = 84;  // 80 of text, the number of facets
constexpr std::size_t kFacetBytes = 50;   // normal, three corners, two bytes of attributes

void addFacet(FileMesh& mesh, const std::string& file) {
  const auto first = static_cast<int>(mesh.vertices.size()) - 3;
  if (first + 3 > kMostVertices)
    rejectInput("{}: has more than {} vertices", file, kMostVertices);
  mesh.file_face.push_back(static_cast<int>(mesh.triangles.size()));
  mesh.triangles.push_back({first, first + 1, first + 2});
}

std::uint32_t facetCount(std::string_view bytes) {
  static_assert(std::endian::native == std::endian::little, "STL is little-endian");
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kHeaderBytes - sizeof(count), sizeof(count));
  return count;
}

FileMesh readBinary(std::string_view bytes, const std::string& file) {
  if (bytes.size() < kHeaderBytes) {
    rejectInput("{}: STL is truncated, it has {} bytes and its header alone needs {}", file,
                bytes.size(), kHeaderBytes);
  }
  const std::uint64_t count = facetCount(bytes);
  if (kHeaderBytes + count * kFacetBytes > bytes.size()) {
    rejectInput("{}: STL claims {} facets ({} bytes), it has {} bytes (truncated?)", file,
                count, kHeaderBytes + count * kFacetBytes, bytes.size());
  }
  FileMesh mesh;
  for (std::uint64_t f = 0; f < count; ++f) {
    float corners[9];
    std::memcpy(corners, bytes.data() + kHeaderBytes + f * kFacetBytes + 3 * sizeof(float),
                sizeof(corners));
    for (int c = 0; c < 9; c += 3) {
      mesh.vertices.emplace_back(corners[c], corners[c + 1], corners[c + 2]);
    }
    addFacet(mesh, file);
  }
  return mesh;
}

FileMesh readText(std::string_view bytes, const std::string& file) {
  std::size_t cursor = 0;
  const auto next_word = [&]() {
    constexpr std::string_view kBlank = " \t\r\n\v\f";
    const std::size_t begin = bytes.find_first_not_of(kBlank, cursor);
    if (begin == std::string_view::npos) return std::string_view();
    cursor = std::min(bytes.find_first_of(kBlank, begin), bytes.size());
    return bytes.substr(begin, cursor - begin);
  };
  FileMesh mesh;
  std::size_t facet_begin = 0;
  bool ended = false;
  for (std::string_view word = next_word(); !word.empty(); word = next_word()) {
    if (word == "vertex") {
      Eigen::Vector3d p;
      for (int axis = 0; axis < 3; ++axis) {
        const std::string_view number = next_word();
        bool is_number = false;
        p[axis] = numberFrom(number, is_number);
        if (!is_number) {
          rejectInput("{}: vertex {} has {} where a coordinate is needed (truncated?)", file,
                      mesh.vertices.size(), quoted(std::string(number)));
        }
      }
      mesh.vertices.push_back(p);
    } else if (word == "endfacet") {
      if (mesh.vertices.size() - facet_begin != 3) {
        rejectInput("{}: facet {} has {} vertices, it needs 3", file, mesh.triangles.size(),
                    mesh.vertices.size() - facet_begin);
      }
      addFacet(mesh, file);
      facet_begin = mesh.vertices.size();
    }
    ended = word == "endsolid" || (ended && word != "solid");
  }
  if (!ended || facet_begin != mesh.vertices.size()) {
    rejectInput("{}: STL is truncated, it must end with 'endsolid'", file);
  }
  return mesh;
}

/// Binary headers may begin with "solid", too; then the size decides.
bool isText(std::string_view bytes) {
  if (bytes.substr(0, 5) != "solid") return false;
  if (bytes.size() < kHeaderBytes) return true;
  if (kHeaderBytes + std::uint64_t{facetCount(bytes)} * kFacetBytes == bytes.size())
    return false;
  const std::string_view start = bytes.substr(0, 1024);
  return start.find('\0') == std::string_view::npos;
}

}  // namespace

FileMesh readStl(const std::filesystem::path& path) {
  const std::string bytes = readFileBytes(path);
  const std::string file = handgraft::quoted(path.string());
  return isText(bytes) ? readText(bytes, file) : readBinary(bytes, file);
}

}  // namespace handgraft::io
