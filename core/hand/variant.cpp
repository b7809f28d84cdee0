#include "core/hand/variant.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <Eigen/Geometry>

#include "core/base/error.h"
#include "core/hand/joint_numbers.h"

namespace handgraft::hand {

namespace {

/// A link shorter than this has no length to speak of: its joints meet in one place.
constexpr double kShortestLength = 1e-3;  // m
/// A last link with less of its way across its joint's axis lies along that.
constexpr double kAcross = 0.5;
/// Room for a follower's limit beyond what its source permits: the division by its multiplier
/// rounds.
constexpr double kRoundOff = 1e-12;

/// Middle of a link's surface, by area; nothing if it has no area.
std::optional<Eigen::Vector3d> middleOf(const Link& link) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double total = 0.0;
  for (const Shape& shape : link.surface()) {
    const geometry::TriangleMesh& mesh = shape.mesh_L;
    for (int f = 0; f < mesh.faceCount(); ++f) {
      const Eigen::Vector3i face = mesh.face(f);
      const Eigen::Vector3d a = mesh.vertex(face[0]);
      const Eigen::Vector3d b = mesh.vertex(face[1]);
      const Eigen::Vector3d c = mesh.vertex(face[2]);
      const double area = 0.5 * (b - a).cross(c - a).norm();
      sum += area * (a + b + c) / 3.0;
      total += area;
    }
  }
  if (!(total > 0.0)) return std::nullopt;
  return sum / total;
}

/// A hand while it is changed: all but the surfaces.
class Draft {
 public:
  explicit Draft(const HandModel& model)
      : model_(model),
        joints(model.joints()),
        lower(model.lower()),
        upper(model.upper()),
        stretch_L(static_cast<std::size_t>(model.linkCount()), Eigen::Matrix3d::Identity()),
        joint_scale(Eigen::VectorXd::Ones(model.dofCount())) {}

  void apply(const HandChange& change) {
    switch (change.property) {
      case HandProperty::kLower:
      case HandProperty::kUpper:
        return setLimit(change.target, change.property == HandProperty::kUpper, change.value);
      case HandProperty::kRange:
        return scaleRange(change.target, change.value);
      case HandProperty::kLength:
        return scaleLength(change.target, change.value);
      case HandProperty::kSize:
        return change.target.empty() ? scaleHand(change.value)
                                     : scaleLink(change.target, change.value);
    }
    rejectInput("property {} of a hand does not exist", static_cast<int>(change.property));
  }

  void checkLimits() const {
    for (int dof = 0; dof < model_.dofCount(); ++dof) {
      if (lower[dof] <= upper[dof]) continue;
      rejectInput(
          "joint {}: its lower limit {} is above its upper limit {}; permitted are lower "
          "limits "
          "from {} up to the upper one",
          quoted(model_.dofJoint(dof).name), lower[dof], upper[dof], -kLargestLimit);
    }
  }

 private:
  const HandModel& model_;

 public:
  std::vector<Joint> joints;
  Eigen::VectorXd lower;  ///< of the dofs, as they are to be
  Eigen::VectorXd upper;
  std::vector<bool> limit_set = std::vector<bool>(2 * lower.size(), false);
  std::vector<Eigen::Matrix3d> stretch_L;
  Eigen::VectorXd joint_scale;
  bool shape_changed = false;

 private:
  static void requireFactor(const std::string& what, double value) {
    if (!(value >= kSmallestFactor && value <= kLargestFactor))
      rejectInput("{}: factor {} is outside {} to {}", what, value, kSmallestFactor,
                  kLargestFactor);
  }

  void setLimit(const std::string& joint, bool is_upper, double value) {
    const int dof = model_.dofIndex(joint);
    if (!(std::abs(value) <= kLargestLimit))
      rejectInput("{} limit of joint {}: {} is outside {} to {}", is_upper ? "upper" : "lower",
                  quoted(joint), value, -kLargestLimit, kLargestLimit);
    (is_upper ? upper : lower)[dof] = value;
    limit_set[2 * static_cast<std::size_t>(dof) + (is_upper ? 1 : 0)] = true;
  }

  void scaleRange(const std::string& joint, double factor) {
    const int dof = model_.dofIndex(joint);
    requireFactor("range of joint " + quoted(joint), factor);
    if (!std::isfinite(lower[dof]) || !std::isfinite(upper[dof]))
      rejectInput("joint {} has no limits, so its range cannot be changed; set both first",
                  quoted(joint));
    if (factor == 1.0) return;
    const double rest = model_.restPose()[dof] * joint_scale[dof];
    setLimit(joint, false, rest + factor * (lower[dof] - rest));
    setLimit(joint, true, rest + factor * (upper[dof] - rest));
  }

  void scaleLength(const std::string& link, double factor) {
    const int index = model_.linkIndex(link);
    requireFactor("length of link " + quoted(link), factor);
    const auto direction = directionOf(index);
    if (!direction) {
      std::string names;
      for (int i = 0; i < model_.linkCount(); ++i)
        if (directionOf(i))
          names += (names.empty() ? "" : ", ") +
                   quoted(model_.links()[static_cast<std::size_t>(i)].name);
      rejectInput(
          "link {} has no length: its next joints lie at its own, and so does its surface; "
          "links "
          "with a length are {}",
          quoted(link), names.empty() ? "none" : names);
    }
    stretch(index,
            Eigen::Matrix3d::Identity() + (factor - 1.0) * *direction * direction->transpose(),
            factor);
  }

  void scaleLink(const std::string& link, double factor) {
    const int index = model_.linkIndex(link);
    requireFactor("size of link " + quoted(link), factor);
    stretch(index, factor * Eigen::Matrix3d::Identity(), factor);
  }

  void scaleHand(double factor) {
    requireFactor("size of the hand", factor);
    if (factor == 1.0) return;
    for (int link = 0; link < model_.linkCount(); ++link)
      stretch(link, factor * Eigen::Matrix3d::Identity(), factor);
    // A slider's travel is a length of the hand, too; what turns is not.
    const auto scale_of = [&](const std::string& name) {
      for (const Joint& joint : joints)
        if (joint.name == name) return joint.type == JointType::kPrismatic ? factor : 1.0;
      return 1.0;
    };
    for (Joint& joint : joints) {
      const double scale = joint.type == JointType::kPrismatic ? factor : 1.0;
      for (const JointNumber& number : kJointNumbers)
        if (number.scales_with_slider) joint.*number.value *= scale;
      if (!joint.mimic) continue;
      joint.mimic->multiplier *= scale / scale_of(joint.mimic->source_joint);
      joint.mimic->offset *= scale;
    }
    for (int dof = 0; dof < model_.dofCount(); ++dof) {
      if (model_.dofJoint(dof).type != JointType::kPrismatic) continue;
      lower[dof] *= factor;
      upper[dof] *= factor;
      joint_scale[dof] *= factor;
    }
  }

  /// Stretches a link about its own joint; the next joints keep their directions.
  void stretch(int link, const Eigen::Matrix3d& B, double factor) {
    if (factor == 1.0) return;
    Eigen::Matrix3d& A = stretch_L[static_cast<std::size_t>(link)];
    A = B * A;
    for (Joint& joint : joints)
      if (joint.parent_link == model_.links()[static_cast<std::size_t>(link)].name)
        joint.X_PJ.translation() = B * joint.X_PJ.translation();
    shape_changed = true;
  }

  [[nodiscard]] bool isLast(const std::string& link) const {
    return std::none_of(joints.begin(), joints.end(), [&](const Joint& joint) {
      if (joint.parent_link != link) return false;
      return joint.type != JointType::kFixed || !isLast(joint.child_link);
    });
  }

  /// The moving joint that a link hangs by, itself or through fixed ones: its axis in L.
  [[nodiscard]] std::optional<std::pair<JointType, Eigen::Vector3d>> ownJoint(
      std::string link) const {
    Eigen::Matrix3d R_LB = Eigen::Matrix3d::Identity();  // B: the link that is looked at
    while (true) {
      const auto own = std::find_if(joints.begin(), joints.end(), [&](const Joint& joint) {
        return joint.child_link == link;
      });
      if (own == joints.end()) return std::nullopt;
      if (own->type != JointType::kFixed)
        return std::pair(own->type, Eigen::Vector3d(R_LB * own->axis_J.normalized()));
      R_LB = R_LB * own->X_PJ.linear().transpose();
      link = own->parent_link;
    }
  }

  /// Of a last link the finger's own direction: its surface may lie beside its joint, and what
  /// stretches from joint to middle then tilts its faces. A jaw slides across itself, and a
  /// finger that bends does so about an axis across itself: what leads along the axis is beside
  /// it. A link that turns about itself, or slides out along itself, keeps its way.
  [[nodiscard]] Eigen::Vector3d alongFinger(const Link& link,
                                            const Eigen::Vector3d& way_L) const {
    const auto own = isLast(link.name) ? ownJoint(link.name) : std::nullopt;
    if (!own) return way_L;
    const Eigen::Vector3d across_L = way_L - own->second.dot(way_L) * own->second;
    return across_L.norm() < kAcross * way_L.norm() ? way_L : across_L;
  }

  /// Which way a link runs from its own joint, a unit vector in L; nothing for one without
  /// length.
  [[nodiscard]] std::optional<Eigen::Vector3d> directionOf(int link) const {
    const Link& one = model_.links()[static_cast<std::size_t>(link)];
    Eigen::Vector3d way = Eigen::Vector3d::Zero();
    int count = 0;
    for (const Joint& joint : joints) {
      if (joint.parent_link != one.name) continue;
      way += joint.X_PJ.translation();
      ++count;
    }
    if (count > 0) way /= count;
    if (way.norm() < kShortestLength) {
      const auto middle = middleOf(one);
      way = middle ? Eigen::Vector3d(stretch_L[static_cast<std::size_t>(link)] * *middle)
                   : Eigen::Vector3d::Zero();
    }
    if (way.norm() < kShortestLength) return std::nullopt;
    return alongFinger(one, way).normalized();
  }
};

Joint& jointNamed(std::vector<Joint>& joints, const std::string& name) {
  const auto found = std::find_if(joints.begin(), joints.end(), [&](const Joint& joint) {
    return joint.name == name;
  });
  HANDGRAFT_REQUIRE(found != joints.end());
  return *found;
}

/// Widens the limits of the joints that follow `source` to where they are with it at `value`.
void leaveRoom(const HandModel& coupled,
               int dof,
               const std::string& source,
               double value,
               std::vector<Joint>& joints) {
  for (const HandModel::Node& node : coupled.nodes()) {
    if (node.dof != dof || node.joint_name == source) continue;
    Joint& follower = jointNamed(joints, node.joint_name);
    const double followed = node.multiplier * value + node.offset;
    const double room = kRoundOff * (1.0 + std::abs(followed));
    follower.lower = std::min(follower.lower, followed - room);
    follower.upper = std::max(follower.upper, followed + room);
  }
}

/// The joints with the limits that were set, and followers that leave them their range.
std::vector<Joint> jointsWithLimits(const HandModel& model, const Draft& draft) {
  std::vector<Joint> joints = draft.joints;
  // What follows what, and how far, also where sliders were scaled.
  std::vector<Link> bare;
  for (const Link& link : model.links())
    bare.push_back({link.name, {}, {}});
  const HandModel coupled(model.name(), std::move(bare), draft.joints);
  for (int dof = 0; dof < model.dofCount(); ++dof) {
    for (const bool is_upper : {false, true}) {
      if (!draft.limit_set[2 * static_cast<std::size_t>(dof) + (is_upper ? 1 : 0)]) continue;
      const double value = (is_upper ? draft.upper : draft.lower)[dof];
      Joint& source = jointNamed(joints, model.dofJoint(dof).name);
      (is_upper ? source.upper : source.lower) = value;
      leaveRoom(coupled, dof, source.name, value, joints);
    }
  }
  return joints;
}

std::vector<Shape> stretched(std::vector<Shape> shapes, const Eigen::Matrix3d& A) {
  if (A == Eigen::Matrix3d::Identity()) return shapes;
  for (Shape& shape : shapes)
    shape.mesh_L = geometry::transformed(shape.mesh_L, Eigen::Affine3d(A));
  return shapes;
}

}  // namespace

std::string nameOf(HandProperty property) {
  switch (property) {
    case HandProperty::kLower:
      return "lower";
    case HandProperty::kUpper:
      return "upper";
    case HandProperty::kRange:
      return "range";
    case HandProperty::kLength:
      return "length";
    case HandProperty::kSize:
      return "size";
  }
  throw BrokenContract("a property of hands that does not exist");
}

bool changesShape(HandProperty property) {
  return property == HandProperty::kLength || property == HandProperty::kSize;
}

void validate(const HandModel& model, const HandChange& change) {
  Draft(model).apply(change);
}

HandVariant makeVariant(const HandModel& model,
                        const std::string& name,
                        const std::vector<HandChange>& changes,
                        VariantSurfaces surfaces) {
  Draft draft(model);
  for (const HandChange& change : changes)
    draft.apply(change);
  draft.checkLimits();

  std::vector<Link> links;
  for (std::size_t i = 0; i < model.links().size(); ++i) {
    const Link& link = model.links()[i];
    if (surfaces == VariantSurfaces::kLeftOut) {
      links.push_back({link.name, {}, {}});
    } else {
      links.push_back({link.name, stretched(link.visuals, draft.stretch_L[i]),
                       stretched(link.collisions, draft.stretch_L[i])});
    }
  }
  HandVariant variant{HandModel(name, std::move(links), jointsWithLimits(model, draft))
                          .asMirror(model.isMirror()),
                      std::move(draft.stretch_L), std::move(draft.joint_scale),
                      draft.shape_changed};
  variant.model = variant.model.withRestPose(poseOfVariant(variant, model.restPose()));
  return variant;
}

Eigen::VectorXd poseOfVariant(const HandVariant& variant, const Eigen::VectorXd& q) {
  HANDGRAFT_REQUIRE(q.size() == variant.model.dofCount());
  return q.cwiseProduct(variant.joint_scale)
      .cwiseMax(variant.model.lower())
      .cwiseMin(variant.model.upper());
}

std::vector<ContactSite> sitesOfVariant(const HandVariant& variant,
                                        const std::vector<ContactSite>& sites) {
  std::vector<ContactSite> moved = sites;
  for (ContactSite& site : moved) {
    const Eigen::Matrix3d& A =
        variant.stretch_L[static_cast<std::size_t>(variant.model.linkIndex(site.link))];
    if (A == Eigen::Matrix3d::Identity()) continue;
    site.p_L = A * site.p_L;
    // Normals go by the inverse transpose, which keeps them at right angles to directions.
    site.n_L = (A.inverse().transpose() * site.n_L).normalized();
    site.direction_L = (A * site.direction_L).normalized();
  }
  return moved;
}

}  // namespace handgraft::hand
