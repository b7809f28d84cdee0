#include "tests/bench/live/random_edits.h"

#include <array>
#include <cmath>

namespace handgraft::bench {

namespace {

constexpr double kReach = 0.005;  // m, of a root that moves

std::array<double, 3> centre(const v1::Mesh& mesh, std::size_t face) {
  std::array<double, 3> p{};
  for (std::size_t corner = 0; corner < 3; ++corner) {
    const std::size_t v = mesh.triangles()[3 * face + corner];
    for (std::size_t axis = 0; axis < 3; ++axis)
      p[axis] += static_cast<double>(mesh.vertices_m()[3 * v + axis]) / 3.0;
  }
  return p;
}

std::vector<long> facesNear(const v1::Mesh& mesh, long face) {
  const auto root = centre(mesh, static_cast<std::size_t>(face));
  std::vector<long> near;
  for (std::size_t f = 0; f < mesh.triangles().size() / 3; ++f) {
    const auto p = centre(mesh, f);
    if (std::hypot(p[0] - root[0], p[1] - root[1], p[2] - root[2]) < kReach)
      near.push_back(static_cast<long>(f));
  }
  return near;
}

}  // namespace

RandomEdits::RandomEdits(unsigned seed,
                         const std::vector<v1::PatchReport>& placed,
                         const v1::ContactsDescription& contacts,
                         const v1::Mesh& object_O,
                         const v1::Mesh& skin_S,
                         const std::vector<v1::JointInfo>& joints)
    : random_(seed), joints_(joints), locked_(joints.size(), 0) {
  for (const v1::PatchReport& report : placed) {
    if (!report.placed()) continue;
    Patch patch;
    patch.name = report.name();
    patch.near_S = facesNear(skin_S, report.root_S().face());
    for (const v1::PatchInfo& info : contacts.patches()) {
      if (info.name() == report.name()) patch.near_O = facesNear(object_O, info.root().face());
    }
    patches_.push_back(patch);
  }
}

double RandomEdits::uniform(double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random_);
}

v1::SurfacePoint RandomEdits::placeIn(const std::vector<long>& faces) {
  v1::SurfacePoint place;
  place.face(static_cast<std::int32_t>(
      faces.at(std::uniform_int_distribution<std::size_t>(0, faces.size() - 1)(random_))));
  place.barycentric({0.25, 0.25, 0.5});
  return place;
}

v1::EditBody RandomEdits::next() {
  const Patch& patch =
      patches_[std::uniform_int_distribution<std::size_t>(0, patches_.size() - 1)(random_)];
  const auto index = std::uniform_int_distribution<std::size_t>(0, joints_.size() - 1)(random_);
  const v1::JointInfo& joint = joints_[index];
  v1::EditBody body;
  switch (std::uniform_int_distribution<int>(0, 8)(random_)) {
    case 0:
    case 1: {
      v1::PatchRootEdit edit;
      edit.patch(patch.name);
      edit.side(v1::SIDE_HAND);
      edit.root(placeIn(patch.near_S));
      body.patch_root(edit);
      kind_ = "root on the hand";
      break;
    }
    case 2: {
      v1::PatchRootEdit edit;
      edit.patch(patch.name);
      edit.side(v1::SIDE_OBJECT);
      edit.root(placeIn(patch.near_O));
      body.patch_root(edit);
      kind_ = "root on the object";
      break;
    }
    case 3: {
      v1::PatchDirectionEdit edit;
      edit.patch(patch.name);
      edit.side(v1::SIDE_HAND);
      edit.angle_rad(uniform(-0.3, 0.3));
      body.patch_direction(edit);
      kind_ = "direction";
      break;
    }
    case 4: {
      v1::PatchWeightEdit edit;
      edit.patch(patch.name);
      edit.weight(uniform(0.2, 2.0));
      body.patch_weight(edit);
      kind_ = "weight";
      break;
    }
    case 5: {
      v1::JointLimitEdit edit;
      edit.joint(joint.name());
      const double middle = 0.5 * (joint.lower() + joint.upper());
      const double half = 0.5 * (joint.upper() - joint.lower());
      edit.lower(middle - uniform(0.6, 1.0) * half);
      edit.upper(middle + uniform(0.6, 1.0) * half);
      body.joint_limit(edit);
      kind_ = "limit";
      break;
    }
    case 6: {
      v1::JointLockEdit edit;
      edit.joint(joint.name());
      locked_[index] = 1 - locked_[index];
      edit.locked(locked_[index] != 0);
      body.joint_lock(edit);
      kind_ = "lock";
      break;
    }
    case 7: {
      v1::Pose X_WO;
      X_WO.p_m({uniform(-0.01, 0.01), uniform(-0.01, 0.01), uniform(-0.01, 0.01)});
      const double half_turn = uniform(-0.05, 0.05);
      X_WO.q_wxyz({std::cos(half_turn), 0.0, 0.0, std::sin(half_turn)});
      body.X_WO(X_WO);
      kind_ = "object";
      break;
    }
    default: {
      v1::PriorEdit edit;
      edit.joints({joint.name()});
      edit.joint_positions(
          {joint.lower() + uniform(0.3, 0.7) * (joint.upper() - joint.lower())});
      body.prior(edit);
      kind_ = "prior";
      break;
    }
  }
  return body;
}

}  // namespace handgraft::bench
