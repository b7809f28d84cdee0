#include "core/contact/finger_assignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/base/error.h"
#include "core/contact/region.h"
#include "core/contact/threshold.h"

namespace handgraft::contact {
namespace {

constexpr int kPartCount = 6;
constexpr int kBonesOfFinger = 3;
constexpr double kSmallestShare = 0.15;
/// Sine between a bone and the normal below which its tangent is mostly noise: 20 degrees.
constexpr double kSteepest = 0.34;

struct Bone {
  int part;
  int proximal;  ///< joint
  int distal;
};

std::array<Bone, 20> bones() {
  std::array<Bone, 20> all{};
  std::size_t next = 0;
  for (int finger = 0; finger < kPalm; ++finger) {
    const int base = 1 + 4 * finger;
    all[next++] = {kPalm, 0, base};
    for (int i = 0; i < kBonesOfFinger; ++i)
      all[next++] = {finger, base + i, base + i + 1};
  }
  return all;
}

constexpr const char* kSegments[] = {"proximal", "middle", "distal"};

/// A finger's first joint.
int baseOf(int finger) {
  return 1 + 4 * finger;
}

/// Of the five digits three each, then the palm.
std::vector<std::string> segmentNames() {
  std::vector<std::string> names;
  for (int finger = 0; finger < kPalm; ++finger)
    for (const char* segment : kSegments)
      names.push_back(hand::partName(kHandParts[finger], segment));
  names.emplace_back(kHandParts[kPalm]);
  return names;
}

double distanceToBone(const Eigen::Vector3d& p,
                      const Eigen::Vector3d& a,
                      const Eigen::Vector3d& b) {
  const Eigen::Vector3d d = b - a;
  const double length2 = d.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(d) / length2, 0.0, 1.0) : 0.0;
  return (a + t * d - p).norm();
}

/// The bone of a finger that is nearest, from its base.
int nearestSegment(const HandJoints& joints, const Eigen::Vector3d& p_O, int finger) {
  int best = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kBonesOfFinger; ++i) {
    const int joint = baseOf(finger) + i;
    const double distance =
        distanceToBone(p_O, joints.p_O.col(joint), joints.p_O.col(joint + 1));
    if (distance >= nearest) continue;
    nearest = distance;
    best = i;
  }
  return best;
}

using Accepted = std::array<bool, kPartCount>;

int nearestPart(const HandJoints& joints,
                const Eigen::Vector3d& p_O,
                const Accepted& accepted) {
  int best = -1;
  double nearest = std::numeric_limits<double>::infinity();
  for (int part = 0; part < kPartCount; ++part) {
    if (!accepted[static_cast<std::size_t>(part)]) continue;
    const double distance = nearestBone(joints, p_O, part).distance_m;
    if (distance >= nearest) continue;
    nearest = distance;
    best = part;
  }
  return best;
}

std::vector<int> regionVertices(const geometry::TriangleMesh& mesh, const Region& region) {
  std::vector<int> vertices;
  for (const int f : region) {
    for (const int v : mesh.face(f))
      vertices.push_back(v);
  }
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

/// The parts that have enough of a region to touch it.
Accepted acceptedOf(const std::array<double, kPartCount>& area, double least) {
  Accepted accepted{};
  for (std::size_t part = 0; part < area.size(); ++part)
    accepted[part] = area[part] > 0.0 && area[part] >= least;
  // Nobody has enough of a speck: it goes to whoever has most of it.
  if (std::none_of(accepted.begin(), accepted.end(), [](bool is) {
        return is;
      }))
    accepted[static_cast<std::size_t>(std::max_element(area.begin(), area.end()) -
                                      area.begin())] = true;
  return accepted;
}

/// Vertices of a region whose part has little of it go to the nearest of those with more.
void leaveToLargestParts(const Region& region,
                         const Eigen::VectorXd& areas,
                         const HandJoints& joints,
                         double minimum_area_m2,
                         ContactMap& map) {
  const std::vector<int> vertices = regionVertices(map.mesh_O, region);
  std::array<double, kPartCount> area{};
  double whole = 0.0;
  for (const int v : vertices) {
    area[static_cast<std::size_t>(map.label[v])] += areas[v];
    whole += areas[v];
  }
  const Accepted accepted = acceptedOf(area, std::max(minimum_area_m2, kSmallestShare * whole));
  for (const int v : vertices) {
    if (!accepted[static_cast<std::size_t>(map.label[v])])
      map.label[v] = nearestPart(joints, map.mesh_O.vertex(v), accepted);
  }
}

// === Places

/// The palm: from the wrist up, from the index across; fingers bend to where it faces.
struct PalmAxes {
  Eigen::Vector3d knuckles_O;  ///< their middle
  Eigen::Vector3d across_O;    ///< as long as the palm is wide
  Eigen::Vector3d up_O;
  Eigen::Vector3d facing_O;
  Eigen::Vector3d thumb_side_O;
};

PalmAxes palmAxesOf(const HandJoints& joints) {
  const auto joint = [&](int i) -> Eigen::Vector3d {
    return joints.p_O.col(i);
  };
  const Eigen::Vector3d knuckles = 0.5 * (joint(baseOf(1)) + joint(baseOf(4)));
  const Eigen::Vector3d across_O = joint(baseOf(4)) - joint(baseOf(1));
  const Eigen::Vector3d up_O = (knuckles - joint(0)).stableNormalized();
  Eigen::Vector3d facing_O = up_O.cross(across_O).stableNormalized();
  double bent = 0.0;
  for (int finger = 1; finger < kPalm; ++finger)
    bent += (joint(baseOf(finger) + 3) - joint(baseOf(finger))).dot(facing_O);
  if (bent < 0.0) facing_O = -facing_O;
  const Eigen::Vector3d thumb_side_O =
      -(across_O - across_O.dot(up_O) * up_O).stableNormalized();
  return {knuckles, across_O, up_O, facing_O, thumb_side_O};
}

std::optional<hand::HandLocation> placeOnPalm(const HandJoints& joints,
                                              const PalmAxes& palm,
                                              hand::HandLocation place,
                                              const Eigen::Vector3d& p_O,
                                              const Eigen::Vector3d& looks_O) {
  const double height = (palm.knuckles_O - joints.p_O.col(0)).norm();
  const double width = palm.across_O.norm();
  if (!(height > 0.0) || !(width > 0.0)) return std::nullopt;
  const Eigen::Vector3d index_O = joints.p_O.col(baseOf(1));
  place.along = (palm.knuckles_O - p_O).dot(palm.up_O) / height;
  place.across = (p_O - index_O).dot(-palm.thumb_side_O) / width;
  place.around_rad = std::atan2(looks_O.dot(palm.thumb_side_O), looks_O.dot(palm.facing_O));
  return place;
}

/// The way the inside of a digit's bone, from `from` along `u`, looks, not made a unit: a
/// finger's as the palm does, turned with the bone; a thumb's to the fingers.
Eigen::Vector3d palmarSideOf(const HandJoints& joints,
                             const PalmAxes& palm,
                             int finger,
                             const Eigen::Vector3d& from,
                             const Eigen::Vector3d& u) {
  Eigen::Vector3d palmar_O =
      palm.facing_O.dot(palm.up_O.cross(palm.thumb_side_O)) * u.cross(palm.thumb_side_O);
  if (finger == 0) {
    palmar_O = Eigen::Vector3d::Zero();
    for (int other = 1; other < kPalm; ++other)
      palmar_O += 0.25 * (joints.p_O.col(baseOf(other) + 1) - from);
  }
  palmar_O -= palmar_O.dot(u) * u;
  return palmar_O;
}

std::optional<hand::HandLocation> placeOnDigit(const HandJoints& joints,
                                               const PalmAxes& palm,
                                               hand::HandLocation place,
                                               const Eigen::Vector3d& p_O,
                                               const Eigen::Vector3d& looks_O) {
  const auto joint = [&](int i) -> Eigen::Vector3d {
    return joints.p_O.col(i);
  };
  const auto* at = std::find(std::begin(kHandParts), std::end(kHandParts), place.digit);
  if (at == std::end(kHandParts)) return std::nullopt;
  const int finger = static_cast<int>(at - std::begin(kHandParts));
  const auto* segment = std::find(std::begin(kSegments), std::end(kSegments), place.segment);
  const int index = static_cast<int>(segment - std::begin(kSegments));
  const Eigen::Vector3d from = joint(baseOf(finger) + index);
  const Eigen::Vector3d bone = joint(baseOf(finger) + index + 1) - from;
  const double length = bone.norm();
  if (!(length > 0.0)) return std::nullopt;
  const Eigen::Vector3d u = bone / length;
  place.segment_count = kBonesOfFinger;
  place.along = std::clamp((p_O - from).dot(u) / length, 0.0, 1.0);

  Eigen::Vector3d palmar_O = palmarSideOf(joints, palm, finger, from, u);
  if (palmar_O.norm() < 1e-9) return place;
  palmar_O.normalize();
  // As hand/finger_coordinates: a right hand's is the bone cross the palmar side.
  Eigen::Vector3d thumbward_O = u.cross(palmar_O);
  if (palm.up_O.cross(palm.facing_O).dot(palm.thumb_side_O) < 0.0) thumbward_O = -thumbward_O;
  place.around_rad = std::atan2(looks_O.dot(thumbward_O), looks_O.dot(palmar_O));
  double to_tip = (1.0 - place.along) * length;
  double whole = 0.0;
  for (int k = 0; k < kBonesOfFinger; ++k) {
    const double one = (joint(baseOf(finger) + k + 1) - joint(baseOf(finger) + k)).norm();
    whole += one;
    if (k > index) to_tip += one;
  }
  place.from_tip = to_tip / whole;
  return place;
}

}  // namespace

NearestBone nearestBone(const HandJoints& joints,
                        const Eigen::Vector3d& p_O,
                        std::optional<int> part) {
  static const std::array<Bone, 20> known_bones = bones();
  NearestBone nearest;
  nearest.distance_m = std::numeric_limits<double>::infinity();
  for (const Bone& bone : known_bones) {
    if (part && bone.part != *part) continue;
    const Eigen::Vector3d a = joints.p_O.col(bone.distal);
    const Eigen::Vector3d d = joints.p_O.col(bone.proximal) - a;
    const double length2 = d.squaredNorm();
    const double t = length2 > 0.0 ? std::clamp((p_O - a).dot(d) / length2, 0.0, 1.0) : 0.0;
    const double distance = (a + t * d - p_O).norm();
    if (distance >= nearest.distance_m) continue;
    nearest = {bone.part, distance, d.stableNormalized()};
  }
  return nearest;
}

void validate(const HandJoints& joints) {
  for (int i = 0; i < joints.p_O.cols(); ++i) {
    if (!joints.p_O.col(i).allFinite())
      rejectInput("hand joints: joint {} is not finite; 21 places are needed", i);
  }
  if ((joints.p_O.colwise() - joints.p_O.col(0)).cwiseAbs().maxCoeff() == 0.0)
    rejectInput("hand joints: all 21 are in one place");
}

void assignFingers(ContactMap& map,
                   const std::vector<char>& touches,
                   const HandJoints& joints,
                   double minimum_area_m2) {
  validate(joints);
  const geometry::TriangleMesh& mesh = map.mesh_O;
  HANDGRAFT_REQUIRE(std::ssize(touches) == mesh.vertexCount());
  map.segment_names = segmentNames();
  map.segment_parts.clear();
  map.label.assign(touches.size(), -1);
  Accepted all{};
  all.fill(true);
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    if (touches[v] != 0) map.label[v] = nearestPart(joints, mesh.vertex(v), all);
  }

  const Eigen::VectorXd areas = vertexAreas(mesh);
  std::vector<char> marked(static_cast<std::size_t>(mesh.faceCount()));
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    marked[f] = touches[face[0]] + touches[face[1]] + touches[face[2]] == 3 ? 1 : 0;
  }
  for (const Region& region : connectedRegions(mesh, marked))
    leaveToLargestParts(region, areas, joints, minimum_area_m2, map);

  // === From parts to their segments
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    int& label = map.label[static_cast<std::size_t>(v)];
    if (label < 0) continue;
    label = label == kPalm
                ? kPalm * kBonesOfFinger
                : label * kBonesOfFinger + nearestSegment(joints, mesh.vertex(v), label);
  }
}

std::optional<hand::HandLocation> placeByJoints(const HandJoints& joints,
                                                const std::string& part,
                                                const Eigen::Vector3d& p_O,
                                                const Eigen::Vector3d& n_O) {
  const auto place = hand::placeNamed(part);
  if (!place) return std::nullopt;
  const Eigen::Vector3d looks_O = -n_O;  // contact is face to face
  const PalmAxes palm = palmAxesOf(joints);
  if (place->digit == hand::kPalmPart) return placeOnPalm(joints, palm, *place, p_O, looks_O);
  return placeOnDigit(joints, palm, *place, p_O, looks_O);
}

std::optional<Eigen::Vector3d> directionTowardsWrist(const HandJoints& joints,
                                                     const std::string& part,
                                                     const Eigen::Vector3d& p_O,
                                                     const Eigen::Vector3d& n_O) {
  const auto* at = std::find(std::begin(kHandParts), std::end(kHandParts), part);
  const int index = static_cast<int>(at - std::begin(kHandParts));
  const auto nearest = nearestBone(
      joints, p_O, at != std::end(kHandParts) ? std::optional(index) : std::nullopt);
  const Eigen::Vector3d to_wrist = (joints.p_O.col(0) - p_O).stableNormalized();
  for (const Eigen::Vector3d& d : {nearest.towards_wrist_O, to_wrist}) {
    const Eigen::Vector3d tangent = d - d.dot(n_O) * n_O;
    if (tangent.norm() > kSteepest) return tangent.normalized();
  }
  return std::nullopt;
}

}  // namespace handgraft::contact
