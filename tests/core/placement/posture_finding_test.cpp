#include "core/placement/posture_finding.h"

#include <gtest/gtest.h>

#include "core/hand/anatomy.h"
#include "core/hand/hand_location.h"
#include "core/hand/posture.h"

#include "tests/core/session/ball_grasp.h"
#include "tests/support/small_hand.h"

namespace handgraft::placement {
namespace {

/// The small hand, and a box that it holds in a pose of its own.
class PostureOfASmallHand : public testing::Test {
 protected:
  PostureOfASmallHand() {
    hand.model = small.model;
    hand.skin = small.skin;
    hand.sites = small.sites;
    pose.q = Eigen::VectorXd(6);
    pose.q << 0.1, 0.3, 0.2, 0.15, -0.1, 0.4;
    pose.X_WH.rotate(Eigen::AngleAxisd(1.0, Eigen::Vector3d(1.0, -2.0, 0.5).normalized()));
  }

  /// The set of a hand that touched in `pose_`, with nothing but its posture.
  [[nodiscard]] contact::ContactSet shown() const {
    contact::ContactSet set;
    hand::LinkPoses X_SL;
    forwardKinematics(*hand.model, Pose::Identity(), hand.skin->qReference(), X_SL);
    const hand::LinkPoses X_OL = forwardKinematics(*hand.model, pose);
    const hand::Anatomy anatomy = anatomyOf(*hand.model, X_SL, hand.sites);
    for (const hand::NamedDigit& digit : anatomy.digits) {
      for (const hand::Segment& segment : digit.segments) {
        const auto L = static_cast<std::size_t>(segment.links.back());
        const Eigen::Matrix3d R_OS = X_OL[L].linear() * X_SL[L].linear().transpose();
        set.posture.push_back({hand::partName(digit.name, segment.name),
                               R_OS * segment.boneInSkin(), R_OS * segment.palmar_S});
      }
    }
    const auto palm = static_cast<std::size_t>(anatomy.palm_links.front());
    const Eigen::Matrix3d R_OS = X_OL[palm].linear() * X_SL[palm].linear().transpose();
    if (anatomy.palm)
      set.posture.push_back(
          {hand::kPalmPart, R_OS * anatomy.palm->outward_S, R_OS * anatomy.palm->facing_S});
    return set;
  }

  const test::SmallHand small = test::makeSmallHand();
  hand::Hand hand;
  hand::HandPose pose;
};

TEST_F(PostureOfASmallHand, OfAHandLikeItIsTheSame) {
  const contact::ContactSet set = shown();
  ASSERT_EQ(set.posture.size(), 7u);
  const Posture posture = postureFor(hand, set);
  ASSERT_TRUE(posture.R_OH.has_value());
  // The pull to the relaxed posture moves it a little.
  EXPECT_LT((posture.q - pose.q).lpNorm<Eigen::Infinity>(), 0.02);
  EXPECT_LT((*posture.R_OH - pose.X_WH.linear()).norm(), 0.02);
}

TEST_F(PostureOfASmallHand, TurnsWithTheObject) {
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(2.0, Eigen::Vector3d(0.3, 0.1, -1.0).normalized()).toRotationMatrix();
  const Posture before = postureFor(hand, shown());
  pose.X_WH.linear() = R * pose.X_WH.linear();
  const Posture after = postureFor(hand, shown());
  EXPECT_LT((after.q - before.q).norm(), 1e-4);
  EXPECT_LT((*after.R_OH - R * *before.R_OH).norm(), 1e-4);
}

TEST_F(PostureOfASmallHand, LeavesOtherDigitsRelaxed) {
  contact::ContactSet set = shown();
  std::erase_if(set.posture, [](const contact::PartDirection& part) {
    return part.part.starts_with("middle");
  });
  const Posture posture = postureFor(hand, set);
  const Eigen::VectorXd relaxed = hand::relaxedPosture(*hand.model, hand.skin->qReference());
  EXPECT_NEAR(posture.q[0], pose.q[0], 0.02);
  EXPECT_NEAR(posture.q[4], relaxed[4], 1e-6);
  EXPECT_NEAR(posture.q[5], relaxed[5], 1e-6);
}

TEST_F(PostureOfASmallHand, IsSurerTheNearerTheHandComes) {
  contact::ContactSet set = shown();
  EXPECT_EQ(postureFor(hand, set).sureness, 64.0);
  EXPECT_EQ(postureFor(hand, {}).sureness, 1.0);
  // Bones that no joint of this hand can follow: each to the other side.
  const auto bent_by = [&](double angle) {
    contact::ContactSet bent = set;
    for (std::size_t i = 0; i < bent.posture.size(); ++i) {
      contact::PartDirection& part = bent.posture[i];
      const Eigen::AngleAxisd turn((i % 2 == 0 ? 1.0 : -1.0) * angle, part.palmar_O);
      part.outward_O = turn * part.outward_O;
    }
    return postureFor(hand, bent).sureness;
  };
  const double nearer = bent_by(0.15);
  EXPECT_GT(nearer, 1.0);
  EXPECT_LT(nearer, 8.0);
  EXPECT_EQ(bent_by(0.6), 1.0);
}

TEST_F(PostureOfASmallHand, JointsFollowItFromOneToTheNext) {
  const Eigen::Matrix3d R_OH = pose.X_WH.linear();
  Eigen::VectorXd like = hand::relaxedPosture(*hand.model, hand.skin->qReference());
  for (int i = 0; i < 5; ++i) {
    pose.q[0] += 0.05;
    pose.q[4] -= 0.04;
    like = jointsLike(hand, shown().posture, R_OH, like);
    EXPECT_LT((like - pose.q).lpNorm<Eigen::Infinity>(), 0.02) << i;
  }
  // A hand that is turned otherwise makes up for it by its joints alone, as far as it can.
  const Eigen::VectorXd turned =
      jointsLike(hand, shown().posture, R_OH * rotationFromVector({0.0, 0.1, 0.0}), like);
  EXPECT_GT((turned - like).lpNorm<Eigen::Infinity>(), 0.03);
}

TEST_F(PostureOfASmallHand, IsRelaxedWhereNobodyKnows) {
  const Posture posture = postureFor(hand, {});
  EXPECT_EQ(posture.q, hand::relaxedPosture(*hand.model, hand.skin->qReference()));
  EXPECT_FALSE(posture.R_OH.has_value());
}

// === In a session

/// Where a first solve leaves the middle finger that no patch is for.
Eigen::Vector2d spareFinger(double share, const std::vector<contact::PartDirection>& shown) {
  test::BallGrasp grasp({"thumb", "index"});
  grasp.contacts.posture = shown;
  session::Session session = grasp.open();
  session::PriorSharesEdit shares;
  shares.shares.posture = share;
  session.apply(shares);
  session::SolverSettings solving;
  solving.avoid_penetration = false;
  return session.solve(solving, {}, Progress()).report.pose.q.segment<2>(4);
}

TEST(PostureInASession, DecidesWhatContactsLeaveOpen) {
  const test::SmallHand small = test::makeSmallHand();
  const Eigen::VectorXd relaxed = hand::relaxedPosture(*small.model, small.skin->qReference());
  EXPECT_LT((spareFinger(50.0, {}) - relaxed.segment<2>(4)).norm(), 1e-3);
  EXPECT_LT(spareFinger(0.0, {}).norm(), 1e-3) << "at rest";
}

TEST(PostureInASession, IsTakenFromAPosedHandThroughAndThrough) {
  // Closed by 0.5 rad and 0.2: the bones of the other fingers are those of the zero pose.
  std::vector<contact::PartDirection> shown;
  for (const char* digit : {"thumb", "index"})
    for (const char* segment : {"_proximal", "_distal"})
      shown.push_back(
          {std::string(digit) + segment, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::Zero()});
  const auto turned = [](double angle) {
    return Eigen::Vector3d(-std::sin(angle), 0.0, std::cos(angle));
  };
  shown.push_back({"middle_proximal", turned(0.5), Eigen::Vector3d::Zero()});
  shown.push_back({"middle_distal", turned(0.7), Eigen::Vector3d::Zero()});
  EXPECT_LT((spareFinger(50.0, shown) - Eigen::Vector2d(0.5, 0.2)).norm(), 0.1);
}

}  // namespace
}  // namespace handgraft::placement
