#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/hand/contact_site.h"
#include "core/hand/hand_model.h"
#include "core/hand/kinematics.h"
#include "core/hand/skin.h"

namespace handgraft::test {

/// A hand of a palm (facing +z) and three fingers of two joints, thumb against index and
/// middle, with balls of 10 mm as tips. Six joints: thumb_1, thumb_2, index_1, ... in rad.
struct SmallHand {
  std::shared_ptr<const hand::HandModel> model;
  std::shared_ptr<const hand::Skin> skin;
  std::vector<hand::ContactSite> sites;
};

namespace detail {

inline geometry::TriangleMesh movedUp(const geometry::TriangleMesh& mesh, double z) {
  return geometry::transformed(mesh, Eigen::Affine3d(Eigen::Translation3d(0, 0, z)));
}

inline hand::Joint hinge(const std::string& name,
                         const std::string& parent,
                         const std::string& child,
                         const Eigen::Vector3d& p_P,
                         double side) {
  hand::Joint joint;
  joint.name = name;
  joint.type = hand::JointType::kRevolute;
  joint.parent_link = parent;
  joint.child_link = child;
  joint.X_PJ.translation() = p_P;
  joint.axis_J = side * Eigen::Vector3d::UnitY();
  joint.lower = -0.5;
  joint.upper = 1.5;
  return joint;
}

}  // namespace detail

inline SmallHand makeSmallHand() {
  std::vector<hand::Link> links(1);
  std::vector<hand::Joint> joints;
  SmallHand small;
  links[0].name = "palm";
  links[0].visuals.push_back({geometry::makeBox({0.1, 0.06, 0.01}), "box"});
  const auto add_finger = [&](const std::string& name, double x, double y) {
    const double side = x < 0.0 ? 1.0 : -1.0;  // turns +z towards the hand's middle
    hand::Link lower{name + "_lower", {}, {}};
    lower.visuals.push_back(
        {detail::movedUp(geometry::makeCylinder(0.006, 0.03), 0.015), "cylinder"});
    hand::Link tip{name + "_tip", {}, {}};
    tip.visuals.push_back({detail::movedUp(geometry::makeSphere(0.01, 3), 0.02), "sphere"});
    links.push_back(lower);
    links.push_back(tip);
    joints.push_back(detail::hinge(name + "_1", "palm", lower.name, {x, y, 0.005}, side));
    joints.push_back(detail::hinge(name + "_2", lower.name, tip.name, {0, 0, 0.035}, side));
    hand::ContactSite site;
    site.name = name;
    site.link = tip.name;
    site.n_L = side * Eigen::Vector3d::UnitX();
    site.p_L = Eigen::Vector3d(0, 0, 0.02) + 0.01 * site.n_L;
    site.direction_L = -Eigen::Vector3d::UnitZ();
    small.sites.push_back(site);
  };
  add_finger("thumb", -0.04, 0.0);
  add_finger("index", 0.04, 0.015);
  add_finger("middle", 0.04, -0.015);
  small.model = std::make_shared<const hand::HandModel>("small", links, joints);

  const Eigen::VectorXd q = Eigen::VectorXd::Zero(6);
  hand::LinkPoses X_SL;
  hand::forwardKinematics(*small.model, Pose::Identity(), q, X_SL);
  std::vector<geometry::TriangleMesh> surfaces;
  for (int i = 0; i < small.model->linkCount(); ++i) {
    const hand::Link& link = small.model->links()[i];
    surfaces.push_back(
        geometry::transformed(link.visuals[0].mesh_L, Eigen::Affine3d(X_SL[i].matrix())));
  }
  small.skin =
      std::make_shared<const hand::Skin>(*small.model, geometry::merged(surfaces), q, 0.004);
  return small;
}

}  // namespace handgraft::test
