#pragma once

#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "core/demonstration/posed_hand_contacts.h"

#include "tests/support/small_hand.h"

namespace handgraft::demonstration {

/// The small hand at rest about a box that its fingertips press 1 mm into: thumb on the box's
/// side at -x, index and middle on that at x, the palm below at -z; the box stands askew.
class SmallHandAboutABox : public testing::Test {
 protected:
  SmallHandAboutABox() {
    X_WO_.translate(Eigen::Vector3d(0.3, -0.2, 0.1));
    X_WO_.rotate(Eigen::AngleAxisd(1.0, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()));
    pose.q = Eigen::VectorXd::Zero(6);
    pose.X_WH = X_WO_ * Eigen::Translation3d(0.0, 0.0, -0.06);  // tips at the box's middle
  }

  [[nodiscard]] hand::Hand hand() const {
    hand::Hand hand;
    hand.model = small.model;
    hand.skin = small.skin;
    hand.sites = small.sites;
    return hand;
  }

  [[nodiscard]] PosedContacts contacts(double reach_m = 0.010) const {
    contact::PoseContactOptions options;
    options.reach_m = reach_m;
    contact::SegmentationOptions segmentation;
    segmentation.outline_share = 0.0;  // patches end at the threshold
    return contactsOfPosedHand(hand(), pose, box_O_, X_WO_, options, segmentation, Progress());
  }

  [[nodiscard]] const contact::Patch& patchOf(const PosedContacts& contacts,
                                              const std::string& name) const {
    for (const contact::Patch& patch : contacts.set.patches)
      if (patch.name == name) return patch;
    throw std::runtime_error("no patch " + name);
  }

  test::SmallHand small = test::makeSmallHand();
  geometry::TriangleMesh box_O_ = geometry::makeBox({0.062, 0.08, 0.06});
  Pose X_WO_ = Pose::Identity();
  hand::HandPose pose;
};

}  // namespace handgraft::demonstration
