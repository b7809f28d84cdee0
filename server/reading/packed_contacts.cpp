#include "server/reading/packed_contacts.h"

#include <cmath>
#include <set>
#include <string>
#include <utility>

#include "core/io/mesh_file.h"
#include "server/reading/packed_parts.h"

namespace handgraft::server {

namespace {

bool isUnitOrZero(const Eigen::Vector3d& v) {
  return v.isZero() || std::abs(v.norm() - 1.0) < 1e-6;
}

void put(ByteWriter& out, const geometry::SurfacePoint& point) {
  out.number(point.face);
  out.numbers(point.barycentric.data(), 3);
}

geometry::SurfacePoint takeSurfacePoint(ByteReader& in) {
  geometry::SurfacePoint point;
  point.face = in.number<int>();
  in.numbers(point.barycentric.data(), 3);
  return point;
}

}  // namespace

void put(ByteWriter& out, hand::Chirality side) {
  out.number(static_cast<std::uint8_t>(side));
}

hand::Chirality takeSide(ByteReader& in) {
  return in.form() < 2 ? hand::Chirality::kUnknown : in.one(hand::Chirality::kLeft);
}

void put(ByteWriter& out, const contact::Patch& patch) {
  out.text(patch.name);
  put(out, patch.root);
  out.number(static_cast<std::uint8_t>(patch.direction_O.has_value()));
  if (patch.direction_O) out.numbers(patch.direction_O->data(), 3);
  put(out, patch.boundary);
  out.count(patch.interpolation_boundary.size());
  for (const geometry::SurfacePoint& point : patch.interpolation_boundary)
    put(out, point);
  out.number(patch.weight);
  out.number(static_cast<std::uint8_t>(patch.place.has_value()));
  if (!patch.place) return;
  out.text(patch.place->digit);
  out.text(patch.place->segment);
  out.number(static_cast<std::int32_t>(patch.place->segment_count));
  for (const double number : {patch.place->along, patch.place->around_rad, patch.place->across,
                              patch.place->from_tip})
    out.number(number);
}

/// All else is checked by contact::validate.
contact::Patch takePatch(ByteReader& in) {
  contact::Patch patch;
  patch.name = in.text();
  patch.root = takeSurfacePoint(in);
  if (in.flag()) patch.direction_O = in.point();
  patch.boundary = takeInts(in);
  patch.interpolation_boundary.resize(
      in.count(contact::kMostPoints, sizeof(int) + 3 * sizeof(double)));
  for (geometry::SurfacePoint& point : patch.interpolation_boundary)
    point = takeSurfacePoint(in);
  patch.weight = in.finite();
  if (!in.flag()) return patch;
  hand::HandLocation& place = patch.place.emplace();
  place.digit = in.text();
  place.segment = in.text();
  place.segment_count = in.number<std::int32_t>();
  place.along = in.finite();
  place.around_rad = in.finite();
  place.across = in.finite();
  place.from_tip = in.finite();
  return patch;
}

void put(ByteWriter& out, const std::vector<contact::PartDirection>& posture) {
  out.count(posture.size());
  for (const contact::PartDirection& part : posture) {
    out.text(part.part);
    out.numbers(part.outward_O.data(), 3);
    out.numbers(part.palmar_O.data(), 3);
  }
}

std::vector<contact::PartDirection> takePosture(ByteReader& in) {
  std::vector<contact::PartDirection> posture(
      in.count(contact::kMostParts, 6 * sizeof(double)));
  for (contact::PartDirection& part : posture) {
    part.part = in.text();
    in.numbers(part.outward_O.data(), 3);
    in.numbers(part.palmar_O.data(), 3);
    in.require(
        isUnitOrZero(part.outward_O) && !part.outward_O.isZero() && isUnitOrZero(part.palmar_O),
        "a posture's direction without unit length");
  }
  return posture;
}

void put(ByteWriter& out, const contact::ContactSet& set) {
  out.text(set.name);
  out.text(set.object);
  put(out, set.side);
  out.count(set.patches.size());
  for (const contact::Patch& patch : set.patches)
    put(out, patch);
  put(out, set.posture);
  put(out, set.notes);
}

contact::ContactSet takeContactSet(ByteReader& in, const geometry::TriangleMesh& mesh_O) {
  contact::ContactSet set;
  set.name = in.text();
  set.object = in.text();
  set.side = takeSide(in);
  set.patches.resize(in.count(contact::kMostPatches, 4 * kCountSize));
  in.require(!set.patches.empty(), "a contact set without patches");
  std::set<std::string> names;
  std::size_t points = 0;
  for (contact::Patch& patch : set.patches) {
    patch = takePatch(in);
    contact::validate(mesh_O, patch);
    points += patch.interpolation_boundary.size();
    in.require(points <= contact::kMostPoints, "too many points");
    in.require(names.insert(patch.name).second, "two patches of one name");
  }
  set.posture = takePosture(in);
  set.notes = takeTexts(in);
  return set;
}

void put(ByteWriter& out, const contact::ContactMap& map) {
  put(out, map.mesh_O);
  put(out, map.value);
  put(out, map.label);
  put(out, map.segment_names);
  put(out, map.segment_parts);
}

contact::ContactMap takeContactMap(ByteReader& in) {
  contact::ContactMap map;
  map.mesh_O = takeMesh(in);
  map.value = takeVector(in, io::kMostVertices);
  map.label = takeInts(in);
  map.segment_names = takeTexts(in);
  map.segment_parts = takeTexts(in);
  contact::validate(map);
  in.require(map.mesh_O.faceCount() > 0, "a map without faces");
  return map;
}

}  // namespace handgraft::server
