// Writes what contact_file.cpp reads.
#include <algorithm>
#include <fstream>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/io/contact_file.h"
#include "core/io/indexed_object.h"
#include "core/io/posture_json.h"

namespace handgraft::io {
namespace {

using contact::ContactSet;
using contact::Patch;
using geometry::SurfacePoint;
using nlohmann::json;

json surfacePointJson(const SurfacePoint& point, const IndexedObject& object) {
  const int v = geometry::vertexAt(object.file().mesh, point);
  if (v >= 0) return {{"vertex", object.file().file_vertex[v]}};
  const Eigen::Vector3d b = object.swappedIfTurned(point.face, point.barycentric);
  const int file_face = object.file().file_face[point.face];
  json value = {{"face", file_face}, {"barycentric", {b[0], b[1], b[2]}}};
  const int triangle = object.triangleOf(point.face);
  if (triangle > 0) value["triangle"] = triangle;
  return value;
}

json placeJson(const hand::HandLocation& place) {
  json value = {
      {"digit", place.digit}, {"along", place.along}, {"around_rad", place.around_rad}};
  if (place.digit == hand::kPalmPart) {
    value["across"] = place.across;
    return value;
  }
  value["segment"] = place.segment;
  if (place.segment_count > 0) value["segments"] = place.segment_count;
  if (place.from_tip >= 0.0) value["from_tip"] = place.from_tip;
  return value;
}

}  // namespace

std::string contactSetText(const ContactSet& set, const MeshFile& object_file) {
  if (object_file.cloud_O.cols() > 0) {
    rejectInput(
        "contacts on a point cloud's surface have no indices in its file to be written by");
  }
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
    if (patch.place) item["place"] = placeJson(*patch.place);
    patches.push_back(std::move(item));
  }
  const bool has_places = std::any_of(set.patches.begin(), set.patches.end(), [](auto& patch) {
    return patch.place.has_value();
  });
  const bool has_side = set.side != hand::Chirality::kUnknown;
  const bool is_second = has_places || has_side || !set.posture.empty();
  json root = {{"format", is_second ? kContactsFormatWithPlaces : kContactsFormat},
               {"name", set.name},
               {"patches", std::move(patches)}};
  if (!set.object.empty()) root["object"] = set.object;
  if (has_side) root["side"] = nameOf(set.side);
  if (!set.posture.empty()) root["posture"] = postureJson(set.posture);
  if (!set.notes.empty()) root["notes"] = set.notes;
  // Names may hold any bytes; what is no UTF-8 is replaced rather than refused.
  return root.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

void writeContactSet(const std::filesystem::path& path,
                     const ContactSet& set,
                     const MeshFile& object) {
  std::string text;
  try {
    text = contactSetText(set, object);
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", path.string(), error.what());
  }
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) rejectInput("{}: cannot be written", path.string());
}

}  // namespace handgraft::io
