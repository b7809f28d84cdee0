// What a hand did after a demonstrator, kept to be exported.
#include "server/sessions/live_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/small_hand.h"

namespace handgraft::server {
namespace {

using retargeting::LiveFollower;
using testing::ElementsAre;
using testing::HasSubstr;

const std::vector<std::string> parts = {"thumb_tip", "palm_1", "index_tip"};

LiveFollower::Answer answerAt(double x, const std::vector<int>& touching) {
  LiveFollower::Answer answer;
  answer.pose.q = Eigen::VectorXd::Constant(6, x);
  answer.pose.X_WH.translation().x() = x;
  answer.depths.object_m = 1e-3 * x;
  for (const int part : touching) {
    LiveFollower::PartFit fit;
    fit.part = part;
    fit.distance_mm = x;
    fit.reached = part == 0;
    fit.on_object_W = Eigen::Vector3d(x, 0.0, part);
    answer.parts.push_back(fit);
  }
  return answer;
}

io::HandTrajectory of(std::shared_ptr<const hand::HandModel> model,
                      std::shared_ptr<const geometry::TriangleMesh> object_O = nullptr) {
  io::HandTrajectory both;
  both.hand = "small";
  both.model = std::move(model);
  both.object_O = std::move(object_O);
  return both;
}

TEST(LiveRun, HasWhatWasAnsweredAndWhatTouched) {
  const test::SmallHand small = test::makeSmallHand();
  LiveRun run;
  EXPECT_TRUE(run.isEmpty());
  EXPECT_THROW((void)run.trajectory(), BrokenContract);
  Pose X_WO = Pose::Identity();
  X_WO.translation().z() = 0.3;
  run.add(of(small.model), 2.0, X_WO, answerAt(0.1, {2}), parts);
  run.add(of(small.model), 2.5, X_WO, answerAt(0.2, {0, 2}), parts);
  const io::HandTrajectory kept = run.trajectory();
  EXPECT_THAT(kept.patch_names, ElementsAre("index_tip", "thumb_tip"));
  ASSERT_EQ(kept.frames.size(), 2u);
  EXPECT_EQ(kept.hand, "small");
  EXPECT_EQ(kept.frames[1].time_s, 2.5);
  EXPECT_EQ(kept.frames[1].pose_W.q[3], 0.2);
  EXPECT_EQ(kept.frames[1].X_WO.translation().z(), 0.3);
  EXPECT_EQ(kept.frames[1].depths.object_m, 2e-4);
  ASSERT_EQ(kept.frames[1].patches.size(), 2u);
  EXPECT_EQ(kept.frames[1].patches[0].patch, 1);
  EXPECT_TRUE(kept.frames[1].patches[0].reached);
  EXPECT_EQ(kept.frames[1].patches[1].p_W, Eigen::Vector3d(0.2, 0.0, 2.0));
  EXPECT_THAT(kept.notes, ElementsAre(HasSubstr("count from 2 s of the demonstrator's")));
}

TEST(LiveRun, ForgetsWhatIsOldestAndSaysSo) {
  const test::SmallHand small = test::makeSmallHand();
  LiveRun run;
  for (std::size_t k = 0; k < LiveRun::kMostFrames + 3; ++k)
    run.add(of(small.model), 0.01 * static_cast<double>(k), Pose::Identity(), answerAt(0.1, {}),
            parts);
  const io::HandTrajectory kept = run.trajectory();
  EXPECT_EQ(kept.frames.size(), LiveRun::kMostFrames);
  EXPECT_NEAR(kept.frames.front().time_s, 0.03, 1e-12);
  EXPECT_THAT(kept.notes, ElementsAre(HasSubstr("count from 0.03 s"),
                                      HasSubstr("3 before them are not kept")));
}

TEST(LiveRun, OfAnotherHandBeginsAnew) {
  LiveRun run;
  run.add(of(test::makeSmallHand().model), 0.0, Pose::Identity(), answerAt(0.1, {0}), parts);
  run.add(of(test::makeSmallHand().model), 0.1, Pose::Identity(), answerAt(0.2, {1}), parts);
  EXPECT_EQ(run.trajectory().frames.size(), 1u);
  EXPECT_THAT(run.trajectory().patch_names, ElementsAre("palm_1"));
}

TEST(LiveRun, AboutAnotherObjectOrEarlierBeginsAnew) {
  const test::SmallHand small = test::makeSmallHand();
  const auto ball =
      std::make_shared<const geometry::TriangleMesh>(geometry::makeSphere(0.03, 1));
  LiveRun run;
  run.add(of(small.model), 0.0, Pose::Identity(), answerAt(0.1, {0}), parts);
  run.add(of(small.model, ball), 0.1, Pose::Identity(), answerAt(0.2, {1}), parts);
  EXPECT_EQ(run.trajectory().frames.size(), 1u);
  EXPECT_EQ(run.trajectory().object_O, ball);
  run.add(of(small.model, ball), 0.2, Pose::Identity(), answerAt(0.2, {1}), parts);
  EXPECT_EQ(run.trajectory().frames.size(), 2u);
  run.add(of(small.model, ball), 0.15, Pose::Identity(), answerAt(0.2, {1}), parts);
  EXPECT_EQ(run.trajectory().frames.size(), 1u);
}

}  // namespace
}  // namespace handgraft::server
