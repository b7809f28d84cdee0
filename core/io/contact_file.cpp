#include "core/io/contact_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/contact/carry.h"
#include "core/io/ply_file.h"

namespace handgraft::io {
namespace {

using contact::ContactMap;
using contact::ContactSet;
using contact::Patch;
using geometry::SurfacePoint;
using nlohmann::json;

constexpr const char* kFormat = "handgraft-contacts/1";
constexpr std::uintmax_t kMostBytes = 64u << 20;  // a set of 1,000 patches takes about 1 MB
constexpr int kMostSegments = 10'000;

// === Contact maps

/// Names from comments that list `0=name 1=name`; what is no such pair is prose.
std::vector<std::string> segmentNamesIn(const std::vector<std::string>& comments) {
  std::vector<std::string> names;
  for (const std::string& comment : comments) {
    std::istringstream words(comment);
    for (std::string word; words >> word;) {
      const std::size_t sign = word.find('=');
      if (sign == 0 || sign == std::string::npos || sign > 5 || sign + 1 == word.size())
        continue;
      const std::string number = word.substr(0, sign);
      if (number.find_first_not_of("0123456789") != std::string::npos) continue;
      const std::size_t index = std::stoul(number);
      if (index >= kMostSegments) continue;
      if (index >= names.size()) names.resize(index + 1);
      names[index] = word.substr(sign + 1);
      while (!names[index].empty() &&
             (names[index].back() == ',' || names[index].back() == ';')) {
        names[index].pop_back();
      }
    }
  }
  return names;
}

/// Labels as the file has them; names are appended where it uses more than it names.
std::vector<int> labelsOf(const Eigen::VectorXd& column) {
  std::vector<int> labels(static_cast<std::size_t>(column.size()));
  for (Eigen::Index v = 0; v < column.size(); ++v) {
    const double label = column[v];
    if (!(label >= -1.0 && label < kMostSegments) || label != std::floor(label)) {
      rejectInput(
          "property 'link' of vertex {} is {}; permitted are whole numbers from -1 to {}", v,
          label, kMostSegments - 1);
    }
    labels[v] = static_cast<int>(label);
  }
  return labels;
}

ContactMap contactMapFrom(const PlyFile& ply) {
  for (const char* property : {"x", "y", "z", "contact"}) {
    if (ply.vertex.count(property) == 0) {
      rejectInput("no vertex property '{}', which a contact map needs", property);
    }
  }
  Eigen::Matrix3Xd vertices(3, ply.vertex_count);
  vertices.row(0) = ply.vertex.at("x").transpose();
  vertices.row(1) = ply.vertex.at("y").transpose();
  vertices.row(2) = ply.vertex.at("z").transpose();

  ContactMap map;
  map.mesh_O = geometry::TriangleMesh(std::move(vertices), ply.faces);
  map.value = ply.vertex.at("contact");
  if (const auto link = ply.vertex.find("link"); link != ply.vertex.end()) {
    map.label = labelsOf(link->second);
    map.segment_names = segmentNamesIn(ply.comments);
    const int most =
        map.label.empty() ? -1 : *std::max_element(map.label.begin(), map.label.end());
    if (!map.segment_names.empty() && most >= std::ssize(map.segment_names)) {
      map.segment_names.resize(static_cast<std::size_t>(most) + 1);
    }
  }
  validate(map);
  return map;
}

// === Contact sets: JSON to numbers, each with the field's name in its error

const json& fieldOf(const json& object, const char* name) {
  const auto field = object.find(name);
  if (field == object.end()) rejectInput("field '{}' is missing", name);
  return *field;
}

double numberFrom(const json& value, const char* name) {
  if (!value.is_number())
    rejectInput("field '{}' is {}; it must be a number", name, quoted(value.dump()));
  return value.get<double>();
}

int integerFrom(const json& value, const char* name) {
  constexpr int kMost = std::numeric_limits<int>::max();
  const bool fits = (value.is_number_unsigned() && value.get<std::uint64_t>() <= kMost);
  if (!fits)
    rejectInput("field '{}' is {}; it must be a whole number from 0", name,
                quoted(value.dump()));
  return value.get<int>();
}

std::string stringFrom(const json& value, const char* name) {
  if (!value.is_string())
    rejectInput("field '{}' is {}; it must be a string", name, quoted(value.dump()));
  return value.get<std::string>();
}

const json& arrayFrom(const json& value, const char* name) {
  if (!value.is_array()) rejectInput("field '{}' is no array", name);
  return value;
}

Eigen::Vector3d vectorFrom(const json& value, const char* name) {
  if (!value.is_array() || value.size() != 3) {
    rejectInput("field '{}' must be an array of 3 numbers", name);
  }
  return {numberFrom(value[0], name), numberFrom(value[1], name), numberFrom(value[2], name)};
}

// === Indices: the file's own to the mesh's and back

/// The mesh vertex of a file's vertex.
int meshVertexFrom(const json& value, const char* name, const MeshFile& object) {
  const int v = integerFrom(value, name);
  const int count = static_cast<int>(object.mesh_vertex.size());
  if (v >= count) {
    rejectInput("field '{}': vertex {} does not exist; the object has vertices 0 to {}", name,
                v, count - 1);
  }
  if (object.mesh_vertex[v] < 0) rejectInput("field '{}': no face uses vertex {}", name, v);
  return object.mesh_vertex[v];
}

/// Triangles of every face of the file, in their order; polygons have several.
class FaceIndex {
 public:
  explicit FaceIndex(const MeshFile& object) {
    for (std::size_t f = 0; f < object.file_face.size(); ++f) {
      triangles_.emplace_back(object.file_face[f], static_cast<int>(f));
    }
    std::sort(triangles_.begin(), triangles_.end());
  }

  /// The mesh face that is the `triangle`-th of a file's face.
  [[nodiscard]] int meshFace(int file_face, int triangle) const {
    const auto first =
        std::lower_bound(triangles_.begin(), triangles_.end(), std::pair(file_face, 0));
    const auto at =
        std::distance(first, triangles_.end()) > triangle ? first + triangle : triangles_.end();
    if (at == triangles_.end() || at->first != file_face) {
      rejectInput(
          "face {} (triangle {}) does not exist or has no area; the object's last is {}",
          file_face, triangle, triangles_.empty() ? -1 : triangles_.back().first);
    }
    return at->second;
  }

  /// Which triangle of its file's face a mesh face is.
  [[nodiscard]] int triangleOf(int file_face, int mesh_face) const {
    const auto first =
        std::lower_bound(triangles_.begin(), triangles_.end(), std::pair(file_face, 0));
    return static_cast<int>(
        std::lower_bound(first, triangles_.end(), std::pair(file_face, mesh_face)) - first);
  }

 private:
  std::vector<std::pair<int, int>> triangles_;  ///< (file face, mesh face), sorted
};

/// An object's mesh with the ways between its indices and its file's.
struct IndexedObject {
  const MeshFile& file;
  FaceIndex faces{file};
};

SurfacePoint surfacePointFrom(const json& value,
                              const char* name,
                              const IndexedObject& object) {
  if (!value.is_object()) rejectInput("field '{}' is no object", name);
  if (const auto vertex = value.find("vertex"); vertex != value.end()) {
    return geometry::surfacePointAtVertex(object.file.mesh,
                                          meshVertexFrom(*vertex, name, object.file));
  }
  const int triangle =
      value.contains("triangle") ? integerFrom(value["triangle"], "triangle") : 0;
  SurfacePoint point;
  point.face = object.faces.meshFace(integerFrom(fieldOf(value, "face"), "face"), triangle);
  point.barycentric = vectorFrom(fieldOf(value, "barycentric"), "barycentric");
  geometry::validate(object.file.mesh, point, name);
  return point;
}

json surfacePointJson(const SurfacePoint& point, const IndexedObject& object) {
  const int v = geometry::vertexAt(object.file.mesh, point);
  if (v >= 0) return {{"vertex", object.file.file_vertex[v]}};
  const Eigen::Vector3d& b = point.barycentric;
  const int file_face = object.file.file_face[point.face];
  json value = {{"face", file_face}, {"barycentric", {b[0], b[1], b[2]}}};
  const int triangle = object.faces.triangleOf(file_face, point.face);
  if (triangle > 0) value["triangle"] = triangle;
  return value;
}

// === Contact sets: patches

Patch patchFrom(const json& value, const IndexedObject& object) {
  Patch patch;
  patch.name = stringFrom(fieldOf(value, "name"), "name");
  patch.root = surfacePointFrom(fieldOf(value, "root"), "root", object);
  if (const auto direction = value.find("direction"); direction != value.end()) {
    patch.direction_O = vectorFrom(*direction, "direction");
  }
  if (const auto weight = value.find("weight"); weight != value.end()) {
    patch.weight = numberFrom(*weight, "weight");
  }
  for (const json& vertex : arrayFrom(fieldOf(value, "boundary"), "boundary")) {
    patch.boundary.push_back(meshVertexFrom(vertex, "boundary", object.file));
  }
  if (const auto points = value.find("interpolation_boundary"); points != value.end()) {
    for (const json& point : arrayFrom(*points, "interpolation_boundary")) {
      patch.interpolation_boundary.push_back(
          surfacePointFrom(point, "interpolation_boundary", object));
    }
  } else {
    const auto count = value.find("interpolation_count");
    patch.interpolation_boundary =
        contact::sampleLoop(object.file.mesh, patch.boundary,
                            count == value.end() ? contact::kDefaultInterpolationCount
                                                 : integerFrom(*count, "interpolation_count"));
  }
  return patch;
}

/// The patch's own name for messages, if it has one.
std::string labelOf(const json& patch, std::size_t index) {
  if (patch.is_object() && patch.contains("name") && patch["name"].is_string()) {
    return "patch " + quoted(patch["name"].get<std::string>());
  }
  return fmt::format("patch {}", index);
}

ContactSet contactSetFrom(const json& root, const MeshFile& object_file) {
  const IndexedObject object{object_file};
  if (!root.is_object()) rejectInput("the file holds no JSON object");
  const std::string format = stringFrom(fieldOf(root, "format"), "format");
  if (format != kFormat) rejectInput("format is {}; expected '{}'", quoted(format), kFormat);

  ContactSet set;
  set.name = stringFrom(fieldOf(root, "name"), "name");
  if (root.contains("object")) set.object = stringFrom(root["object"], "object");
  const json& patches = arrayFrom(fieldOf(root, "patches"), "patches");
  if (patches.empty()) rejectInput("field 'patches' is empty; at least one patch is needed");
  for (std::size_t i = 0; i < patches.size(); ++i) {
    try {
      if (!patches[i].is_object()) rejectInput("it is no JSON object");
      set.patches.push_back(patchFrom(patches[i], object));
    } catch (const InvalidInput& error) {
      rejectInput("{}: {}", labelOf(patches[i], i), error.what());
    }
    validate(object.file.mesh, set.patches.back());
  }
  if (root.contains("notes")) {
    for (const json& text : arrayFrom(root["notes"], "notes")) {
      set.notes.push_back(stringFrom(text, "notes"));
    }
  }
  return set;
}

std::string textOf(const std::filesystem::path& path) {
  std::error_code fault;
  const std::uintmax_t size = std::filesystem::file_size(path, fault);
  if (fault) rejectInput("cannot be read: {}", fault.message());
  if (size > kMostBytes) rejectInput("{} bytes; permitted are {}", size, kMostBytes);
  std::ifstream file(path, std::ios::binary);
  std::string text(static_cast<std::size_t>(size), '\0');
  if (!file.read(text.data(), static_cast<std::streamsize>(size))) {
    rejectInput("cannot be read");
  }
  return text;
}

/// Runs `read` so that its errors begin with the file's name.
template <class Read>
auto namingFile(const std::filesystem::path& path, const Read& read) {
  try {
    return read();
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", path.string(), error.what());
  } catch (const json::exception& error) {
    rejectInput("{}: no valid JSON: {}", path.string(), quoted(error.what()));
  }
}

bool startsLikePly(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  char start[3] = {};
  return file.read(start, 3) && std::string(start, 3) == "ply";
}

bool sameMesh(const geometry::TriangleMesh& a, const geometry::TriangleMesh& b) {
  return a.vertexCount() == b.vertexCount() && a.faceCount() == b.faceCount() &&
         a.faces() == b.faces() && a.vertices() == b.vertices();
}

}  // namespace

ContactMap readContactMap(const std::filesystem::path& path) {
  const PlyFile ply = readPly(path);
  return namingFile(path, [&] {
    return contactMapFrom(ply);
  });
}

ContactSet readContactSet(const std::filesystem::path& path, const MeshFile& object) {
  return namingFile(path, [&] {
    return contactSetFrom(json::parse(textOf(path)), object);
  });
}

std::string objectNameIn(const std::filesystem::path& path) {
  if (startsLikePly(path)) return "";
  return namingFile(path, [&]() -> std::string {
    const json root = json::parse(textOf(path));
    if (!root.is_object() || !root.contains("object")) return "";
    return stringFrom(root["object"], "object");
  });
}

void writeContactSet(const std::filesystem::path& path,
                     const ContactSet& set,
                     const MeshFile& object_file) {
  const IndexedObject object{object_file};
  json patches = json::array();
  for (const Patch& patch : set.patches) {
    validate(object_file.mesh, patch);
    json item = {{"name", patch.name}, {"root", surfacePointJson(patch.root, object)}};
    if (patch.direction_O) {
      const Eigen::Vector3d& d = *patch.direction_O;
      item["direction"] = {d.x(), d.y(), d.z()};
    }
    item["boundary"] = json::array();
    for (const int v : patch.boundary)
      item["boundary"].push_back(object_file.file_vertex[v]);
    for (const SurfacePoint& point : patch.interpolation_boundary) {
      item["interpolation_boundary"].push_back(surfacePointJson(point, object));
    }
    item["weight"] = patch.weight;
    patches.push_back(std::move(item));
  }
  json root = {{"format", kFormat}, {"name", set.name}, {"patches", std::move(patches)}};
  if (!set.object.empty()) root["object"] = set.object;
  if (!set.notes.empty()) root["notes"] = set.notes;

  std::ofstream file(path, std::ios::binary);
  // Names may hold any bytes; what is no UTF-8 is replaced rather than refused.
  file << root.dump(1, ' ', false, json::error_handler_t::replace) << '\n';
  if (!file.flush()) rejectInput("{}: cannot be written", path.string());
}

ContactSet readContacts(const std::filesystem::path& path,
                        const MeshFile& object,
                        const contact::SegmentationOptions& options) {
  if (!startsLikePly(path)) return readContactSet(path, object);
  const ContactMap map = readContactMap(path);
  return namingFile(path, [&] {
    ContactSet set = segment(map, options);
    set.name = path.stem().string();
    return sameMesh(map.mesh_O, object.mesh) ? set : carry(set, map.mesh_O, object.mesh);
  });
}

}  // namespace handgraft::io
