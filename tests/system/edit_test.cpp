#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/system/live_session.h"

namespace handgraft::test {
namespace {

v1::EditBody jointLimit(const std::string& joint, double lower_rad, double upper_rad) {
  v1::JointLimitEdit edit;
  edit.joint(joint);
  edit.lower(lower_rad);
  edit.upper(upper_rad);
  v1::EditBody body;
  body.joint_limit(edit);
  return body;
}

v1::EditBody objectPose(double z_m) {
  v1::Pose X_WO;
  X_WO.p_m({0.0, 0.0, z_m});
  X_WO.q_wxyz({1.0, 0.0, 0.0, 0.0});
  v1::EditBody body;
  body.X_WO(X_WO);
  return body;
}

class Edits : public testing::Test {
 protected:
  Service service;
  LiveSession session{service, "barrett8", "lemon", "lemon_6"};
};

TEST_F(Edits, AreAnsweredByARevisionAndAFreshSolution) {
  const v1::PoseSolution before = session.optimize();
  // Move the busiest joint's limit below where the solve left it.
  const auto& q = before.joint_positions();
  const std::size_t busiest =
      static_cast<std::size_t>(std::max_element(q.begin(), q.end()) - q.begin());
  const double upper = 0.5 * q[busiest];
  ASSERT_GT(upper, 0.05) << "the grasp bends no joint";

  const v1::EditReply reply =
      session.edit(jointLimit(session.opened().joint_names()[busiest], 0.0, upper));
  const auto after = session.solution([&](const v1::PoseSolution& solution) {
    return solution.is_final() && solution.revision() == reply.revision();
  });

  EXPECT_EQ(reply.error(), v1::ErrorCode::ERROR_NONE) << reply.message();
  EXPECT_EQ(reply.revision(), before.revision() + 1);
  ASSERT_TRUE(after.has_value());
  EXPECT_LE(after->joint_positions()[busiest], upper + 1e-12);
}

TEST_F(Edits, MovingTheObjectMovesTheHandWithIt) {
  session.optimize();
  const v1::EditReply reply = session.edit(objectPose(0.5));
  const auto after = session.solution([&](const v1::PoseSolution& solution) {
    return solution.is_final() && solution.revision() == reply.revision();
  });
  ASSERT_TRUE(after.has_value());
  EXPECT_EQ(after->X_WO().p_m()[2], 0.5);
  EXPECT_NEAR(after->X_WH().p_m()[2], 0.5, 0.3) << "the hand did not follow";
}

TEST_F(Edits, ThatAreWrongAreRefusedAndChangeNothing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const v1::EditReply unknown = session.edit(jointLimit("no_such_joint", 0.0, 1.0));
  const v1::EditReply not_a_number = session.edit(objectPose(nan));
  const v1::EditReply stale = session.edit(objectPose(0.1), 41);

  EXPECT_NE(unknown.error(), v1::ErrorCode::ERROR_NONE);
  EXPECT_NE(unknown.message().find("no_such_joint"), std::string::npos) << unknown.message();
  EXPECT_EQ(not_a_number.error(), v1::ErrorCode::ERROR_INVALID_INPUT);
  EXPECT_EQ(stale.error(), v1::ErrorCode::ERROR_CONFLICT) << stale.message();
  EXPECT_EQ(session.edit(objectPose(0.1)).revision(), 1u) << "a refused edit counted";
}

TEST_F(Edits, OfAClosedSessionAreRefused) {
  session.close();
  const v1::EditReply reply = session.edit(objectPose(0.1));
  EXPECT_EQ(reply.error(), v1::ErrorCode::ERROR_NOT_FOUND) << reply.message();
}

}  // namespace
}  // namespace handgraft::test
