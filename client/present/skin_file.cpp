#include "client/present/skin_file.h"

#include <bit>
#include <cstdint>
#include <cstring>

#include "core/base/error.h"

namespace handgraft::client {

namespace {

static_assert(std::endian::native == std::endian::little, "the header says little endian");

template <class Number>
void append(std::string& bytes, Number number) {
  char raw[sizeof number];
  std::memcpy(raw, &number, sizeof number);
  bytes.append(raw, sizeof number);
}

}  // namespace

std::string skinPly(const v1::HandDescription& hand) {
  const v1::Mesh& skin = hand.skin_S();
  const std::size_t vertex_count = skin.vertices_m().size() / 3;
  const std::size_t face_count = skin.triangles().size() / 3;
  if (hand.skin_face_links().size() != face_count) {
    throw TransportError(fmt::format("the server named the links of {} faces; the skin has {}",
                                     hand.skin_face_links().size(), face_count));
  }
  std::string links;
  for (std::size_t i = 0; i < hand.links().size(); ++i) {
    const std::string name = quoted(hand.links()[i].name());
    links += fmt::format(" {}={}", i, name.substr(1, name.size() - 2));
  }
  std::string ply = fmt::format(
      "ply\nformat binary_little_endian 1.0\n"
      "comment skin of {}, metres, in the frame of its root\n"
      "comment links{}\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "element face {}\nproperty list uchar uint vertex_indices\nproperty int link\n"
      "end_header\n",
      quoted(hand.name()), links, vertex_count, face_count);
  for (std::size_t i = 0; i < 3 * vertex_count; ++i)
    append(ply, skin.vertices_m()[i]);
  for (std::size_t f = 0; f < face_count; ++f) {
    append(ply, std::uint8_t{3});
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t vertex = skin.triangles()[3 * f + k];
      if (vertex >= vertex_count) {
        throw TransportError(
            fmt::format("face {} of the skin names vertex {} of {}", f, vertex, vertex_count));
      }
      append(ply, vertex);
    }
    append(ply, static_cast<std::int32_t>(hand.skin_face_links()[f]));
  }
  return ply;
}

}  // namespace handgraft::client
