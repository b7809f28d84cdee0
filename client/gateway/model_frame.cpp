#include "client/gateway/model_frame.h"

#include <bit>
#include <cstring>
#include <type_traits>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "idl/json.h"

namespace handgraft::client::gateway {

namespace {

static_assert(std::endian::native == std::endian::little, "arrays are sent as they lie");

constexpr std::size_t kAlignment = 4;

/// Arrays one after the other, and where each of them is.
class Arrays {
 public:
  template <class T>
  void add(const std::string& name, std::vector<T>& values) {
    static_assert(sizeof(T) == kAlignment);
    const char* type = std::is_floating_point_v<T> ? "f32"
                       : std::is_signed_v<T>       ? "i32"
                                                   : "u32";
    list_.push_back(
        {{"name", name}, {"type", type}, {"at", bytes_.size()}, {"count", values.size()}});
    if (!values.empty()) {
      const std::size_t at = bytes_.size();
      bytes_.resize(at + values.size() * sizeof(T));
      std::memcpy(bytes_.data() + at, values.data(), values.size() * sizeof(T));
    }
    values = {};
  }

  void add(const std::string& name, v1::Mesh& mesh) {
    add(name + "/vertices", mesh.vertices_m());
    add(name + "/triangles", mesh.triangles());
  }

  [[nodiscard]] const idl::Json& list() const { return list_; }

  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  idl::Json list_ = idl::Json::array();
  std::string bytes_;
};

/// Takes the meshes out of the description, and leaves out what only editing of files needs.
void takeMeshes(v1::ModelDescription& description, Arrays& arrays) {
  if (description._d() == v1::MODEL_HAND) {
    v1::HandDescription& hand = description.hand();
    for (std::size_t i = 0; i < hand.links().size(); ++i)
      arrays.add("links/" + std::to_string(i), hand.links()[i].surface_L());
    arrays.add("skin", hand.skin_S());
    arrays.add("skin/links", hand.skin_face_links());
    hand.sites_file().clear();
  } else if (description._d() == v1::MODEL_OBJECT) {
    arrays.add("mesh", description.object().mesh_O());
  } else if (description._d() == v1::MODEL_CONTACTS) {
    for (v1::MapInfo& map : description.contacts().contact_map()) {
      arrays.add("map", map.mesh_O());
      arrays.add("map/values", map.value());
    }
    description.contacts().file().clear();
  } else {
    description.motion().file().clear();
  }
}

void append(std::string& frame, std::uint32_t number) {
  for (unsigned shift = 0; shift < 32U; shift += 8U)
    frame += static_cast<char>((number >> shift) & 0xFFU);
}

}  // namespace

std::string modelFrame(std::uint32_t request, v1::ModelDescription description) {
  Arrays arrays;
  takeMeshes(description, arrays);
  const std::string text =
      idl::textOf({{"description", idl::jsonOf(description)}, {"arrays", arrays.list()}});
  std::string frame;
  frame.reserve(3 * kAlignment + text.size() + arrays.bytes().size());
  append(frame, request);
  append(frame, static_cast<std::uint32_t>(text.size()));
  frame += text;
  frame.append((kAlignment - frame.size() % kAlignment) % kAlignment, ' ');
  return frame + arrays.bytes();
}

}  // namespace handgraft::client::gateway
