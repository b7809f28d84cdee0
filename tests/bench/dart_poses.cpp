#include "tests/bench/dart_poses.h"

#include <algorithm>
#include <iostream>
#include <limits>
#include <map>
#include <random>
#include <string>

#include "core/hand/kinematics.h"

#include "tests/support/dart_hand.h"

namespace handgraft::bench {

namespace {

/// Every movable joint's value, followers included.
std::map<std::string, double> jointValues(const hand::HandModel& model,
                                          const Eigen::VectorXd& q) {
  std::map<std::string, double> values;
  for (int i = 0; i < model.dofCount(); ++i)
    values[model.dofJoint(i).name] = q[i];
  // Followers may follow followers, in any order.
  for (std::size_t known = 0; known != values.size();) {
    known = values.size();
    for (const hand::Joint& joint : model.joints()) {
      if (!joint.mimic || !values.contains(joint.mimic->source_joint)) continue;
      values[joint.name] =
          joint.mimic->multiplier * values[joint.mimic->source_joint] + joint.mimic->offset;
    }
  }
  return values;
}

/// DART writes a line for every link without a mass, which says nothing about poses.
dart::dynamics::SkeletonPtr quietly(const std::filesystem::path& urdf) {
  std::streambuf* words = std::cerr.rdbuf(nullptr);
  dart::dynamics::SkeletonPtr skeleton = test::dartHand(urdf);
  std::cerr.rdbuf(words);
  return skeleton;
}

}  // namespace

double largestPoseDifference(const std::filesystem::path& urdf,
                             const hand::HandModel& model,
                             int poses) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const dart::dynamics::SkeletonPtr skeleton = quietly(urdf);
  if (!skeleton) return kNone;
  auto* root = dynamic_cast<dart::dynamics::FreeJoint*>(skeleton->getRootJoint());
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  double worst = 0.0;
  for (int trial = 0; trial < poses; ++trial) {
    hand::HandPose pose;
    // DART nails a root called "world" to the world, instead of letting it float.
    if (root != nullptr) {
      pose.X_WH.linear() = rotationFromVector(
          Eigen::Vector3d(uniform(random), uniform(random), uniform(random)));
      pose.X_WH.translation() << uniform(random), uniform(random), uniform(random);
      root->setTransform(pose.X_WH);
    }
    pose.q.resize(model.dofCount());
    for (int i = 0; i < model.dofCount(); ++i)
      pose.q[i] = uniform(random);
    for (const auto& [name, value] : jointValues(model, pose.q)) {
      dart::dynamics::DegreeOfFreedom* dof = skeleton->getDof(name);
      if (dof == nullptr) return kNone;
      dof->setPosition(value);
    }
    const hand::LinkPoses X_WL = forwardKinematics(model, pose);
    for (int link = 0; link < model.linkCount(); ++link) {
      const auto* body =
          skeleton->getBodyNode(model.links()[static_cast<std::size_t>(link)].name);
      if (body == nullptr && link == 0 && root == nullptr) continue;  // the world itself
      if (body == nullptr) return kNone;
      worst = std::max(worst, (body->getWorldTransform().matrix() -
                               X_WL[static_cast<std::size_t>(link)].matrix())
                                  .cwiseAbs()
                                  .maxCoeff());
    }
  }
  return worst;
}

}  // namespace handgraft::bench
