#include "core/io/contact_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/contact/reproject.h"
#include "core/formats/json_keys.h"
#include "core/formats/zip_file.h"
#include "core/io/demonstration_file.h"
#include "core/io/file_bytes.h"
#include "core/io/indexed_object.h"
#include "core/io/object_file.h"
#include "core/io/posture_json.h"

namespace handgraft::io {
namespace {

using contact::ContactMap;
using contact::ContactSet;
using contact::Patch;
using geometry::SurfacePoint;
using nlohmann::json;

constexpr std::uintmax_t kMostBytes = 32u << 20;  // a set of 1,000 patches takes about 4 MB
constexpr std::size_t kLongestName = 256;

// === Contact sets: JSON to numbers, each with the field's name in its error

const json& fieldOf(const json& object, const char* name) {
  const auto field = object.find(name);
  if (field == object.end()) rejectInput("field '{}' is missing", name);
  return *field;
}

double doubleFrom(const json& value, const char* name) {
  if (!value.is_number())
    rejectInput("field '{}' is {}; it must be a number", name, formats::shown(value));
  return value.get<double>();
}

int integerFrom(const json& value, const char* name) {
  constexpr int kMost = std::numeric_limits<int>::max();
  const bool fits = (value.is_number_unsigned() && value.get<std::uint64_t>() <= kMost);
  if (!fits)
    rejectInput("field '{}' is {}; it must be a whole number from 0", name,
                formats::shown(value));
  return value.get<int>();
}

std::string stringFrom(const json& value, const char* name) {
  if (!value.is_string())
    rejectInput("field '{}' is {}; it must be a string", name, formats::shown(value));
  return value.get<std::string>();
}

std::string nameFrom(const json& value, const char* field) {
  std::string name = stringFrom(value, field);
  if (name.size() > kLongestName) {
    rejectInput("field '{}' has {} bytes; permitted are {}", field, name.size(), kLongestName);
  }
  return name;
}

const json& arrayFrom(const json& value, const char* name) {
  if (!value.is_array()) rejectInput("field '{}' is no array", name);
  return value;
}

Eigen::Vector3d vectorFrom(const json& value, const char* name) {
  if (!value.is_array() || value.size() != 3) {
    rejectInput("field '{}' must be an array of 3 numbers", name);
  }
  return {doubleFrom(value[0], name), doubleFrom(value[1], name), doubleFrom(value[2], name)};
}

void requireKnownKeys(const json& object, std::initializer_list<const char*> permitted) {
  if (const auto fault = formats::unknownKeyIn(object, permitted)) rejectInput("{}", *fault);
}

// === Places, by the file's own indices

/// A point of an object that is given as points.
Eigen::Vector3d cloudPointFrom(const json& value, const char* name, const MeshFile& object) {
  const int v = integerFrom(value, name);
  if (v >= object.cloud_O.cols()) {
    rejectInput("field '{}': point {} does not exist; the object has points 0 to {}", name, v,
                object.cloud_O.cols() - 1);
  }
  return object.cloud_O.col(v);
}

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

/// `count` places at equal arc length along the closed polygon of points, laid onto the
/// surface.
std::vector<SurfacePoint> sampleCloudLoop(const std::vector<Eigen::Vector3d>& loop,
                                          int count,
                                          const IndexedObject& object) {
  constexpr const char* kName = "boundary";
  if (loop.size() < 3)
    rejectInput("field 'boundary' has {} points; at least 3 are needed", loop.size());
  if (count < contact::kFewestInterpolationPoints ||
      count > contact::kMostInterpolationPoints) {
    rejectInput("field 'interpolation_count' is {}; permitted are {} to {}", count,
                contact::kFewestInterpolationPoints, contact::kMostInterpolationPoints);
  }
  std::vector<double> along{0.0};
  for (std::size_t i = 0; i < loop.size(); ++i)
    along.push_back(along.back() + (loop[(i + 1) % loop.size()] - loop[i]).norm());
  if (!(along.back() > 0.0)) rejectInput("field 'boundary' has no length");
  std::vector<SurfacePoint> places;
  std::size_t at = 0;
  for (int k = 0; k < count; ++k) {
    const double s = along.back() * k / count;
    while (at + 1 < loop.size() && along[at + 1] <= s)
      ++at;
    const double length = along[at + 1] - along[at];
    const double t = length > 0.0 ? (s - along[at]) / length : 0.0;
    places.push_back(
        object.nearest((1.0 - t) * loop[at] + t * loop[(at + 1) % loop.size()], kName));
  }
  return places;
}

SurfacePoint surfacePointFrom(const json& value,
                              const char* name,
                              const IndexedObject& object) {
  if (!value.is_object()) rejectInput("field '{}' is no object", name);
  if (const auto fault =
          formats::unknownKeyIn(value, {"vertex", "face", "triangle", "barycentric"}))
    rejectInput("field '{}': {}", name, *fault);
  if (object.isCloud()) {
    const auto vertex = value.find("vertex");
    if (vertex == value.end())
      rejectInput(
          "field '{}': the object is given as points, places on it are named by 'vertex'",
          name);
    return object.nearest(cloudPointFrom(*vertex, name, object.file()), name);
  }
  if (const auto vertex = value.find("vertex"); vertex != value.end()) {
    return geometry::surfacePointAtVertex(object.file().mesh,
                                          meshVertexFrom(*vertex, name, object.file()));
  }
  const int triangle =
      value.contains("triangle") ? integerFrom(value["triangle"], "triangle") : 0;
  SurfacePoint point;
  point.face = object.meshFace(integerFrom(fieldOf(value, "face"), "face"), triangle);
  point.barycentric = object.swappedIfTurned(
      point.face, vectorFrom(fieldOf(value, "barycentric"), "barycentric"));
  geometry::validate(object.file().mesh, point, name);
  return point;
}

// === Contact sets: patches

/// Larger than any place beside a bone or a palm.
constexpr double kFarthestPlace = 100.0;

double placeNumberFrom(const json& value, const char* field, double otherwise) {
  const auto found = value.find(field);
  if (found == value.end()) return otherwise;
  const double number = doubleFrom(*found, field);
  if (!(std::abs(number) <= kFarthestPlace))
    rejectInput("field '{}' is {}; permitted are {} to {}", field, number, -kFarthestPlace,
                kFarthestPlace);
  return number;
}

hand::HandLocation placeFrom(const json& value) {
  if (!value.is_object()) rejectInput("field 'place' is no object");
  requireKnownKeys(
      value, {"digit", "segment", "segments", "along", "around_rad", "across", "from_tip"});
  hand::HandLocation place;
  place.digit = nameFrom(fieldOf(value, "digit"), "digit");
  if (value.contains("segment")) place.segment = nameFrom(value["segment"], "segment");
  if (value.contains("segments")) {
    constexpr int kMostSegments = 100;
    place.segment_count = integerFrom(value["segments"], "segments");
    if (place.segment_count < 0 || place.segment_count > kMostSegments)
      rejectInput("field 'segments' is {}; permitted are 0 to {}", place.segment_count,
                  kMostSegments);
  }
  place.along = placeNumberFrom(value, "along", place.along);
  place.around_rad = placeNumberFrom(value, "around_rad", place.around_rad);
  place.across = placeNumberFrom(value, "across", place.across);
  place.from_tip = placeNumberFrom(value, "from_tip", place.from_tip);
  return place;
}

Patch patchFrom(const json& value, const IndexedObject& object, bool may_have_place) {
  requireKnownKeys(value, {"name", "root", "direction", "boundary", "interpolation_count",
                           "interpolation_boundary", "weight", "place"});
  if (!may_have_place && value.contains("place"))
    rejectInput("field 'place' needs format '{}'", kContactsFormatWithPlaces);
  Patch patch;
  patch.name = nameFrom(fieldOf(value, "name"), "name");
  patch.root = surfacePointFrom(fieldOf(value, "root"), "root", object);
  if (const auto direction = value.find("direction"); direction != value.end()) {
    patch.direction_O = vectorFrom(*direction, "direction");
  }
  if (const auto weight = value.find("weight"); weight != value.end()) {
    patch.weight = doubleFrom(*weight, "weight");
  }
  if (const auto place = value.find("place"); place != value.end())
    patch.place = placeFrom(*place);
  std::vector<Eigen::Vector3d> cloud_loop;
  for (const json& vertex : arrayFrom(fieldOf(value, "boundary"), "boundary")) {
    if (object.isCloud()) {
      cloud_loop.push_back(cloudPointFrom(vertex, "boundary", object.file()));
      continue;
    }
    patch.boundary.push_back(meshVertexFrom(vertex, "boundary", object.file()));
  }
  if (const auto points = value.find("interpolation_boundary"); points != value.end()) {
    for (const json& point : arrayFrom(*points, "interpolation_boundary")) {
      patch.interpolation_boundary.push_back(
          surfacePointFrom(point, "interpolation_boundary", object));
    }
  } else {
    const auto field = value.find("interpolation_count");
    const int count = field == value.end() ? contact::kDefaultInterpolationCount
                                           : integerFrom(*field, "interpolation_count");
    patch.interpolation_boundary =
        object.isCloud() ? sampleCloudLoop(cloud_loop, count, object)
                         : contact::sampleLoop(object.file().mesh, patch.boundary, count);
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
  if (root.is_array()) {
    rejectInput(
        "the file holds a list of {} entries; a contact set is an object with 'format': '{}' "
        "and 'patches', each with a root and a boundary; points without areas are none: "
        "a PLY of the object with contact at each vertex, 0 to 1, is a contact map",
        root.size(), kContactsFormat);
  }
  if (!root.is_object()) rejectInput("the file holds no JSON object");
  const std::string format = stringFrom(fieldOf(root, "format"), "format");
  if (format != kContactsFormat && format != kContactsFormatWithPlaces) {
    rejectInput("format is {}; expected '{}' or '{}'", quoted(format), kContactsFormat,
                kContactsFormatWithPlaces);
  }
  requireKnownKeys(root, {"format", "name", "object", "side", "patches", "posture", "notes"});
  for (const char* field : {"posture", "side"})
    if (format == kContactsFormat && root.contains(field))
      rejectInput("field '{}' needs format '{}'", field, kContactsFormatWithPlaces);

  ContactSet set;
  set.name = nameFrom(fieldOf(root, "name"), "name");
  if (root.contains("object")) set.object = nameFrom(root["object"], "object");
  if (root.contains("side"))
    set.side = hand::sideNamed(stringFrom(root["side"], "side"), "side");
  const json& patches = arrayFrom(fieldOf(root, "patches"), "patches");
  if (patches.empty()) rejectInput("field 'patches' is empty; at least one patch is needed");
  if (patches.size() > contact::kMostPatches) {
    rejectInput("field 'patches' has {} entries; permitted are {}", patches.size(),
                contact::kMostPatches);
  }
  std::map<std::string, std::size_t> index_of;
  std::size_t point_count = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    try {
      if (!patches[i].is_object()) rejectInput("it is no JSON object");
      set.patches.push_back(patchFrom(patches[i], object, format == kContactsFormatWithPlaces));
    } catch (const InvalidInput& error) {
      rejectInput("{}: {}", labelOf(patches[i], i), error.what());
    }
    validate(object.file().mesh, set.patches.back());
    point_count += set.patches.back().interpolation_boundary.size();
    if (point_count > contact::kMostPoints) {
      rejectInput("patches 0 to {} have {} interpolation points; permitted are {} in a set", i,
                  point_count, contact::kMostPoints);
    }
    const auto [known, is_new] = index_of.emplace(set.patches.back().name, i);
    if (!is_new) {
      rejectInput("patches {} and {} are both called {}; names must differ", known->second, i,
                  quoted(known->first));
    }
  }
  if (root.contains("posture")) set.posture = postureFrom(root["posture"]);
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

/// The touching segments that the header's list, if there is one, does not name.
std::vector<std::string> notesOnUnlistedLinks(const ContactMap& map, double threshold) {
  std::vector<std::string> notes;
  if (map.segment_names.empty()) return notes;
  std::map<int, int> vertices_of;
  for (std::size_t v = 0; v < map.label.size(); ++v) {
    const int link = map.label[v];
    const bool touches = link >= 0 && map.value[static_cast<Eigen::Index>(v)] > threshold;
    if (touches && map.segment_names[link].empty()) ++vertices_of[link];
  }
  for (const auto& [link, count] : vertices_of) {
    notes.push_back(
        fmt::format("link {} of {} touching vertices is not in the header's list of segments",
                    link, count));
  }
  return notes;
}

bool sameMesh(const geometry::TriangleMesh& a, const geometry::TriangleMesh& b) {
  return a.vertexCount() == b.vertexCount() && a.faceCount() == b.faceCount() &&
         a.faces() == b.faces() && a.vertices() == b.vertices();
}

/// A set's. Whoever gives a mesh has forgotten its picture, not written JSON badly.
json setIn(const std::filesystem::path& path) {
  constexpr std::array<const char*, 5> kMeshes{".glb", ".gltf", ".obj", ".stl", ".dae"};
  if (std::find(kMeshes.begin(), kMeshes.end(), endingOf(path)) != kMeshes.end()) {
    rejectInput(
        "a mesh alone tells no contacts: its picture does (--picture FILE --colors SCALE), "
        "a PLY with a value at each vertex, "
        "an OBJ with colours at its vertices (--colors SCALE), or a set of patches as JSON");
  }
  return formats::parsedJson(textOf(path));
}

}  // namespace

ContactSet readContactSet(const std::filesystem::path& path, const MeshFile& object) {
  return namingFile(path, [&] {
    return contactSetFrom(setIn(path), object);
  });
}

std::string objectNameIn(const std::filesystem::path& path) {
  if (isContactMap(path)) return "";
  if (formats::isZip(readFileBytes(path))) return objectOfNpz(path);  // a demonstration
  return namingFile(path, [&]() -> std::string {
    const json root = setIn(path);
    if (!root.is_object() || !root.contains("object")) return "";
    return nameFrom(root["object"], "object");
  });
}

ContactSet contactsFromMap(const ContactMap& map,
                           const MeshFile& object,
                           const contact::SegmentationOptions& options) {
  // Points alone have no regions: the object's own surface, or one laid through them, has.
  const ContactMap on_mesh = onFaces(map, object);
  ContactSet set = segment(on_mesh, options);
  const std::vector<std::string> unlisted =
      notesOnUnlistedLinks(map, thresholdOf(on_mesh, options));
  set.notes.insert(set.notes.begin(), unlisted.begin(), unlisted.end());
  if (sameMesh(on_mesh.mesh_O, object.mesh)) return set;
  ContactSet carried = reproject(set, on_mesh.mesh_O, object.mesh);
  if (auto note = contact::noteOnOtherShape(on_mesh.mesh_O, object.mesh))
    carried.notes.push_back(std::move(*note));
  return carried;
}

ContactSet readContacts(const std::filesystem::path& path,
                        const MeshFile& object,
                        const contact::SegmentationOptions& options,
                        const ContactMapSource& source) {
  if (!isContactMap(path, source)) return readContactSet(path, object);
  const ContactMap map = readContactMap(path, source);
  return namingFile(path, [&] {
    ContactSet set = contactsFromMap(map, object, options);
    set.name = path.stem().string();
    return set;
  });
}

}  // namespace handgraft::io
