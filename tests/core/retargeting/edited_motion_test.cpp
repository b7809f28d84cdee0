#include "core/retargeting/edited_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/hand/kinematics.h"
#include "core/session/session.h"
#include "core/session/timed_edit.h"

#include "tests/core/session/ball_grasp.h"

namespace handgraft::retargeting {
namespace {

using testing::HasSubstr;

constexpr int kFrames = 240;
constexpr double kRate = 60.0;

/// A ball held by three fingers for four seconds.
manipulation::Motion held(const test::BallGrasp& grasp) {
  manipulation::Motion motion;
  motion.name = "hold";
  motion.object = "ball";
  for (int k = 0; k < kFrames; ++k) {
    motion.time_s.push_back(k / kRate);
    motion.X_WO.push_back(Pose::Identity());
  }
  for (const contact::Patch& patch : grasp.contacts.patches) {
    manipulation::PatchTrack track;
    track.name = patch.name;
    track.end = kFrames;
    track.keys.resize(1);
    track.keys[0].patch = patch;
    motion.tracks.push_back(track);
  }
  return motion;
}

class MotionBenchTest : public testing::Test {
 protected:
  std::shared_ptr<const SolvedMotion> solve(const session::Document& document,
                                            const EditedMotion::OnStretch& told = {},
                                            bool causal = false) {
    return bench.solve(document, grasp.hand(), motionSolving(causal), 1, Progress(), told);
  }

  session::Document with(const session::Document& document,
                         double time_s,
                         double falloff_s,
                         session::TimedChange change) {
    const hand::Hand hand = grasp.hand();
    session::Models models;
    models.hand = &hand;
    models.object_O = grasp.ball;
    session::Document edited = document;
    session::addTimed({{time_s, falloff_s}, std::move(change)}, models, edited);
    return edited;
  }

  const test::BallGrasp grasp;
  EditedMotion bench{std::make_shared<const manipulation::Motion>(held(grasp)), grasp.ball};
  const session::Document first = grasp.open().document();
};

bool same(const hand::HandPose& a, const hand::HandPose& b) {
  return a.q == b.q && a.X_WH.matrix() == b.X_WH.matrix();
}

TEST_F(MotionBenchTest, AnEditAtATimeChangesTheFramesAboutItAlone) {
  const auto before = solve(first);
  session::JointLockEdit lock{"index_1", true};
  const int dof = grasp.hand().model->dofIndex("index_1");
  lock.value = before->trajectory.poses[120].q[dof] + 0.05;
  std::vector<FrameRange> told;
  const auto after =
      solve(with(first, 2.0, 0.2, lock), [&](const SolvedMotion&, FrameRange range) {
        told.push_back(range);
      });
  ASSERT_EQ(told.size(), 1u);
  EXPECT_GT(told[0].first, 70);
  EXPECT_LT(told[0].end, 170);
  EXPECT_EQ(after->trajectory.poses[120].q[dof], *lock.value);
  for (int k = 0; k < kFrames; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const bool is_told = k >= told[0].first && k < told[0].end;
    EXPECT_TRUE(is_told || same(before->trajectory.poses[at], after->trajectory.poses[at]))
        << k;
  }
}

TEST_F(MotionBenchTest, UndoneAndDoneAgainItIsTheSameToTheByte) {
  const auto before = solve(first);
  const session::Document edited =
      with(first, 1.0, 0.3, session::PatchWeightEdit{"index", 20.0});
  const auto after = solve(edited);
  session::Document heavier = first;
  heavier.patches[0].weight = 3.0;
  const auto other = solve(heavier);
  EXPECT_FALSE(same(before->trajectory.poses[60], other->trajectory.poses[60]));
  for (std::size_t k = 0; k < kFrames; ++k) {
    EXPECT_TRUE(same(solve(first)->trajectory.poses[k], before->trajectory.poses[k]));
    EXPECT_TRUE(same(solve(edited)->trajectory.poses[k], after->trajectory.poses[k]));
  }
}

TEST_F(MotionBenchTest, EditsAtTimesFollowFromTheFirstAnswerAndFromThemselves) {
  static_cast<void>(solve(first));
  const session::Document one = with(first, 0.5, 0.2, session::PatchWeightEdit{"index", 20.0});
  const session::Document two = with(one, 3.0, 0.2, session::PatchEnabledEdit{"thumb", false});
  static_cast<void>(solve(one));
  const auto step_by_step = solve(two);
  EditedMotion fresh(std::make_shared<const manipulation::Motion>(held(grasp)), grasp.ball);
  const auto at_once = fresh.solve(two, grasp.hand(), motionSolving(false), 2, Progress());
  for (std::size_t k = 0; k < kFrames; ++k) {
    EXPECT_TRUE(same(step_by_step->trajectory.poses[k], at_once->trajectory.poses[k])) << k;
    EXPECT_EQ(step_by_step->depths[k], at_once->depths[k]) << k;
  }
}

TEST_F(MotionBenchTest, ADragMovesItsPlaceAndThoseNextToIt) {
  const auto before = solve(first);
  const hand::HandModel& model = *grasp.hand().model;
  const int link = model.linkIndex("index_tip");
  const auto place_in = [&](const SolvedMotion& solved, int k) -> Eigen::Vector3d {
    return hand::forwardKinematics(
               model, solved.trajectory
                          .poses[static_cast<std::size_t>(k)])[static_cast<std::size_t>(link)] *
           Eigen::Vector3d::Zero();
  };
  const Eigen::Vector3d there = place_in(*before, 120);
  session::DragEdit drag;
  drag.link = "index_tip";
  // Away from the ball, where nothing is in the way.
  drag.target_W = there + 0.01 * there.normalized();
  const session::DragPath way =
      session::dragWayOf(drag, {2.0, 0.3}, held(grasp).time_s, drag.target_W, [&](int k) {
        return place_in(*before, k);
      });
  const auto after = solve(with(first, 2.0, 0.3, way));
  EXPECT_LT((place_in(*after, 120) - drag.target_W).norm(), 0.002);
  const double half = (place_in(*after, 129) - place_in(*before, 129)).norm();
  EXPECT_GT(half, 0.002);
  EXPECT_LT(half, 0.008);
  EXPECT_EQ(place_in(*after, 20), place_in(*before, 20));
}

TEST_F(MotionBenchTest, ARootOnTheObjectGoesThereAndBack) {
  const auto before = solve(first);
  const contact::Patch& patch = grasp.contacts.patches[1];
  // A point of its own outline: some millimetres from the root.
  const geometry::SurfacePoint root = patch.interpolation_boundary[0];
  const auto after = solve(
      with(first, 2.0, 0.3, session::PatchRootEdit{patch.name, session::Side::kObject, root}));
  const manipulation::FrameProblems frames(after->problem, after->solving.options.fade);
  const auto middle_at = [&](int k) -> Eigen::Vector3d {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (const optimize::PointPair& pair :
         frames.at(k, after->trajectory.poses[static_cast<std::size_t>(k)]).pairs) {
      if (pair.patch != 1) continue;
      sum += pair.p_W;
      ++count;
    }
    return sum / count;
  };
  const Eigen::Vector3d way =
      positionOf(*grasp.ball, root) - positionOf(*grasp.ball, patch.root);
  EXPECT_LT((middle_at(120) - middle_at(10) - way).norm(), 0.4 * way.norm());
  EXPECT_LT((middle_at(10) - middle_at(230)).norm(), 1e-12);
  EXPECT_FALSE(same(before->trajectory.poses[120], after->trajectory.poses[120]));
  EXPECT_TRUE(same(before->trajectory.poses[10], after->trajectory.poses[10]));
}

TEST_F(MotionBenchTest, ARootAtATimeLeadsFromWhereItWasPutThroughout) {
  const contact::Patch& patch = grasp.contacts.patches[1];
  session::Document throughout = first;
  throughout.patches[1].root_O = patch.interpolation_boundary[0];
  const auto before = solve(throughout);
  // Back to where it came from, at one time.
  const auto after =
      solve(with(throughout, 2.0, 0.3,
                 session::PatchRootEdit{patch.name, session::Side::kObject, patch.root}));
  const auto roots_apart = [&](const SolvedMotion& a, int k, const SolvedMotion& b, int l) {
    const auto middle = [](const SolvedMotion& solved, int frame) -> Eigen::Vector3d {
      const manipulation::FrameProblems frames(solved.problem, solved.solving.options.fade);
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      int count = 0;
      for (const optimize::PointPair& pair :
           frames.at(frame, solved.trajectory.poses[static_cast<std::size_t>(frame)]).pairs) {
        if (pair.patch != 1) continue;
        sum += pair.p_W;
        ++count;
      }
      return sum / count;
    };
    return (middle(a, k) - middle(b, l)).norm();
  };
  const double way = roots_apart(*solve(first), 120, *before, 120);
  EXPECT_GT(way, 0.001);
  EXPECT_LT(roots_apart(*after, 120, *solve(first), 120), 0.4 * way) << "there it is back";
  EXPECT_LT(roots_apart(*after, 10, *before, 10), 1e-12) << "elsewhere it stays";
  // Twelve shares of the way, the longest of which is a fifth of it: nowhere a jump.
  for (int k = 95; k < 145; ++k)
    EXPECT_LT(roots_apart(*after, k, *after, k + 1), 0.3 * way) << k;
}

TEST_F(MotionBenchTest, AnUndoneEditOfAllLeavesNothingToThoseAtTimes) {
  session::Document moved = first;
  moved.patches[1].root_O = grasp.contacts.patches[1].interpolation_boundary[0];
  session::Document off = first;
  off.patches[1].enabled = false;
  const session::Document edited =
      with(off, 2.0, 0.3, session::PatchEnabledEdit{"index", true});
  static_cast<void>(solve(first));
  static_cast<void>(solve(off));
  static_cast<void>(solve(moved));
  const auto after = solve(edited);
  EditedMotion fresh(std::make_shared<const manipulation::Motion>(held(grasp)), grasp.ball);
  static_cast<void>(fresh.solve(first, grasp.hand(), motionSolving(false), 1, Progress()));
  const auto straight = fresh.solve(edited, grasp.hand(), motionSolving(false), 1, Progress());
  for (std::size_t k = 0; k < kFrames; ++k)
    EXPECT_TRUE(same(after->trajectory.poses[k], straight->trajectory.poses[k])) << k;
}

TEST_F(MotionBenchTest, ASoftValueAtATimeComesAsTheOneThroughoutGoes) {
  session::Document soft = first;
  const auto dof = static_cast<std::size_t>(grasp.hand().model->dofIndex("index_1"));
  soft.joints[dof].soft_weight = 4.0;
  soft.joints[dof].soft_value = 0.2;
  const auto solved = solve(with(soft, 2.0, 0.3, session::JointSoftEdit{"index_1", 0.6, 8.0}));
  for (const auto& [frame, own] : solved->problem.own) {
    ASSERT_GT(own.soft_weights.size(), dof);
    EXPECT_GE(own.soft_weights[dof], 4.0 - 1e-12) << frame;
    EXPECT_GE(own.soft_values[dof], 0.2 - 1e-12) << frame;
  }
  EXPECT_EQ(solved->problem.own.at(120).soft_weights[dof], 8.0);
  EXPECT_EQ(solved->problem.own.at(120).soft_values[dof], 0.6);
}

TEST_F(MotionBenchTest, CausalMotionsAreFollowedAnewFromTheEditOn) {
  const auto before = solve(first, {}, true);
  const auto after =
      solve(with(first, 2.0, 0.2, session::PatchWeightEdit{"index", 50.0}), {}, true);
  EXPECT_TRUE(same(before->trajectory.poses[100], after->trajectory.poses[100]));
  EXPECT_FALSE(same(before->trajectory.poses[121], after->trajectory.poses[121]));
}

TEST_F(MotionBenchTest, AnEditOfTheSameAtTheSameTimeTakesTheOthersPlace) {
  session::Document edited = with(first, 1.0, 0.3, session::PatchWeightEdit{"index", 20.0});
  edited = with(edited, 1.0, 0.1, session::PatchWeightEdit{"index", 2.0});
  edited =
      with(edited, 1.0, 0.1, session::PatchDirectionEdit{"index", session::Side::kObject, 0.2});
  edited =
      with(edited, 1.0, 0.1, session::PatchDirectionEdit{"index", session::Side::kObject, 0.3});
  ASSERT_EQ(edited.timed.size(), 2u);
  EXPECT_EQ(std::get<session::PatchWeightEdit>(edited.timed[0].change).weight, 2.0);
  EXPECT_NEAR(std::get<session::PatchDirectionEdit>(edited.timed[1].change).angle_rad, 0.5,
              1e-12);
}

TEST_F(MotionBenchTest, NamesWhatIsWrong) {
  const auto fault = [&](double time_s, double falloff_s,
                         session::TimedChange change) -> std::string {
    try {
      (void)with(first, time_s, falloff_s, std::move(change));
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(fault(1.0, -1.0, session::PatchWeightEdit{"index", 1.0}), HasSubstr("falloff"));
  EXPECT_THAT(fault(1.0, 0.0, session::PatchWeightEdit{"toe", 1.0}), HasSubstr("toe"));
  EXPECT_THAT(fault(1.0, 0.0, session::PatchWeightEdit{"index", -1.0}), HasSubstr("-1"));
  EXPECT_THAT(fault(1.0, 0.0, session::JointLimitEdit{"index_1", 1.0, 0.5}),
              HasSubstr("above"));
  EXPECT_THAT(fault(1.0, 0.0, session::JointLockEdit{"index_1", true}), HasSubstr("answer"));
  EXPECT_THAT(fault(1.0, 0.0, session::ReleaseEdit{"index_tip"}), HasSubstr("not held"));
}

TEST(TimedEdit, FadesWithoutABend) {
  const session::TimedEdit edit{{2.0, 0.5}, session::PatchWeightEdit{"index", 1.0}};
  EXPECT_EQ(session::influenceOf(edit, 2.0), 1.0);
  EXPECT_NEAR(session::influenceOf(edit, 1.75), 0.5, 1e-12);
  EXPECT_EQ(session::influenceOf(edit, 1.5), 0.0);
  const std::vector<double> time_s = {0.0, 0.1, 0.2, 0.3};
  const session::TimedEdit one{{0.13, 0.0}, session::PatchWeightEdit{"index", 1.0}};
  EXPECT_THAT(session::influencesOf(one, time_s), testing::ElementsAre(testing::Pair(1, 1.0)));
}

}  // namespace
}  // namespace handgraft::retargeting
