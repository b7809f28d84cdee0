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

}  // namespace

NearestBone nearestBone(const HandJoints& joints,
                        const Eigen::Vector3d& p_O,
                        std::optional<int> part) {
  static const std::array<Bone, 20> kBones = bones();
  NearestBone nearest;
  nearest.distance_m = std::numeric_limits<double>::infinity();
  for (const Bone& bone : kBones) {
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
  map.segment_names.assign(std::begin(kHandParts), std::end(kHandParts));
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
  for (const Region& region : connectedRegions(mesh, marked)) {
    std::vector<int> vertices;
    for (const int f : region) {
      for (const int v : mesh.face(f))
        vertices.push_back(v);
    }
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());

    std::array<double, kPartCount> area{};
    double whole = 0.0;
    for (const int v : vertices) {
      area[static_cast<std::size_t>(map.label[v])] += areas[v];
      whole += areas[v];
    }
    Accepted accepted{};
    for (std::size_t part = 0; part < area.size(); ++part) {
      accepted[part] =
          area[part] > 0.0 && area[part] >= std::max(minimum_area_m2, kSmallestShare * whole);
    }
    // Nobody has enough of a speck: it goes to whoever has most of it.
    if (std::none_of(accepted.begin(), accepted.end(), [](bool is) {
          return is;
        }))
      accepted[static_cast<std::size_t>(std::max_element(area.begin(), area.end()) -
                                        area.begin())] = true;
    for (const int v : vertices) {
      if (!accepted[static_cast<std::size_t>(map.label[v])])
        map.label[v] = nearestPart(joints, mesh.vertex(v), accepted);
    }
  }
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
