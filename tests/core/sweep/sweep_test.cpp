#include "core/sweep/sweep.h"

#include <atomic>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/hand/skin_bending.h"
#include "core/optimize/avoidance.h"
#include "core/verdict/verdicts.h"

#include "tests/core/session/ball_grasp.h"

namespace handgraft::sweep {
namespace {

using hand::HandProperty;
using test::BallGrasp;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::vector<SweepGrasp> twoGrasps() {
  const BallGrasp three;
  const BallGrasp open({"thumb", "index", "middle"}, true);
  return {{three.ball, three.contacts}, {open.ball, open.contacts}};
}

std::vector<SweepRow> sweepOf(const std::vector<SweepAxis>& axes, int threads = 1) {
  SweepOptions options;
  options.threads = threads;
  return sweep(BallGrasp().hand(), twoGrasps(), axes, options, Progress()).rows;
}

void expectSame(const SweepRow& a, const SweepRow& b) {
  EXPECT_EQ(a.grasp, b.grasp);
  EXPECT_EQ(a.values, b.values);
  EXPECT_EQ(a.error, b.error);
  EXPECT_EQ(a.terms.objective, b.terms.objective);
  EXPECT_EQ(a.mean_mm, b.mean_mm);
  EXPECT_EQ(a.q, b.q);
  EXPECT_EQ(a.joints_at_limit, b.joints_at_limit);
}

TEST(Sweep, OfNothingIsTheHandAsItIs) {
  const std::vector<SweepRow> rows = sweepOf({});
  ASSERT_EQ(rows.size(), 2u);
  session::Session session = BallGrasp().open();
  const optimize::SolveReport report = session.optimize({}, Progress());
  EXPECT_EQ(rows[0].error, "");
  EXPECT_NEAR(rows[0].terms.objective, report.terms.objective, 1e-6 * report.terms.objective);
  EXPECT_EQ(rows[0].patch_count, 3);
  EXPECT_EQ(rows[0].reached_count, 3);
  EXPECT_EQ(rows[0].point_count, 75);
}

// Also where depth costs nothing; a hand that is kept out is hardly inside.
TEST(Sweep, TellsHowDeepEachAnswerIs) {
  SweepOptions options;
  const SweepRow kept_out =
      sweep(BallGrasp().hand(), twoGrasps(), {}, options, Progress()).rows.front();
  options.solving.avoid_penetration = false;
  const SweepRow row =
      sweep(BallGrasp().hand(), twoGrasps(), {}, options, Progress()).rows.front();
  session::Session session = BallGrasp().open();
  const optimize::SolveReport report =
      session.solve(options.solving, session::SolveRun(), Progress()).report;
  const quality::Penetration told = verdict::penetrationOf(session, report.pose, Progress());
  ASSERT_GT(told.max_depth_m, 5e-4);
  EXPECT_NEAR(row.depths.object_m, told.max_depth_m, 1e-5);
  EXPECT_NEAR(row.depths.self_m, told.self_depth_m, 1e-5);
  EXPECT_LT(kept_out.depths.object_m, 0.5 * row.depths.object_m);
}

TEST(Sweep, RunsTheFirstAxisSlowestAndGraspsFastest) {
  const std::vector<SweepRow> rows =
      sweepOf({{HandProperty::kUpper, "thumb_1", {0.2, 0.8}},
               {HandProperty::kLower, "index_1", {-0.4, -0.1, 0}}});
  ASSERT_EQ(rows.size(), 12u);
  EXPECT_EQ(rows[0].values, (std::vector<double>{0.2, -0.4}));
  EXPECT_EQ(rows[1].grasp, 1);
  EXPECT_EQ(rows[2].values, (std::vector<double>{0.2, -0.1}));
  EXPECT_EQ(rows[11].values, (std::vector<double>{0.8, 0}));
  for (const SweepRow& row : rows) {
    EXPECT_EQ(row.error, "");
    EXPECT_LE(row.q[0], row.values[0] + 1e-9);
    EXPECT_GE(row.q[2], row.values[1] - 1e-9);
  }
}

// No start is taken from another row, so none depends on which rows there are.
TEST(Sweep, ARowAloneIsThatOfTheWholeSweep) {
  const std::vector<double> limits = {0.0, 0.1, 0.3, 1.5};
  const std::vector<double> lengths = {0.8, 1.0, 1.3};
  const std::vector<SweepRow> all = sweepOf({{HandProperty::kLength, "index_lower", lengths},
                                             {HandProperty::kUpper, "thumb_1", limits}});
  for (std::size_t length = 0; length < lengths.size(); ++length) {
    for (std::size_t limit = 0; limit < limits.size(); limit += 3) {
      const std::vector<SweepRow> alone =
          sweepOf({{HandProperty::kLength, "index_lower", {lengths[length]}},
                   {HandProperty::kUpper, "thumb_1", {limits[limit]}}});
      ASSERT_EQ(alone.size(), 2u);
      expectSame(alone[0], all[2 * (length * limits.size() + limit)]);
      expectSame(alone[1], all[2 * (length * limits.size() + limit) + 1]);
    }
  }
}

TEST(Sweep, GivesTheSameBytesOnTwoThreads) {
  const std::vector<SweepAxis> axes = {{HandProperty::kSize, "", {0.9, 1.0, 1.2}},
                                       {HandProperty::kRange, "thumb_2", {0.3, 1.0}}};
  const std::vector<SweepRow> one = sweepOf(axes, 1);
  const std::vector<SweepRow> two = sweepOf(axes, 2);
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i)
    expectSame(one[i], two[i]);
}

/// Limits of three joints that halve the room that `q` uses.
std::vector<session::JointLimitEdit> tighter(const hand::HandModel& model,
                                             const Eigen::VectorXd& q) {
  std::vector<session::JointLimitEdit> edits;
  for (const char* joint : {"thumb_1", "thumb_2", "index_2"}) {
    const int dof = model.dofIndex(joint);
    const double half = 0.5 * q[dof];
    edits.push_back({joint, half < 0.0 ? half : model.lower()[dof],
                     half > 0.0 ? half : model.upper()[dof]});
  }
  return edits;
}

void expectOthersMoved(const hand::HandModel& model,
                       const std::vector<session::JointLimitEdit>& edits,
                       const Eigen::VectorXd& q_free,
                       const Eigen::VectorXd& q_tight) {
  for (const session::JointLimitEdit& edit : edits) {
    const double q = q_tight[model.dofIndex(edit.joint)];
    EXPECT_GE(q, edit.lower - 1e-9) << edit.joint;
    EXPECT_LE(q, edit.upper + 1e-9) << edit.joint;
  }
  for (const char* other : {"index_1", "middle_1", "middle_2"}) {
    const int dof = model.dofIndex(other);
    EXPECT_GT(std::abs(q_tight[dof] - q_free[dof]), 1e-3) << other;
  }
}

TEST(Sweep, TighterLimitsOfThreeJointsMoveOthers) {
  const hand::Hand hand = BallGrasp().hand();
  const SweepRow free = sweepOf({})[0];
  const std::vector<session::JointLimitEdit> edits = tighter(*hand.model, free.q);
  std::vector<SweepAxis> axes;
  for (const session::JointLimitEdit& edit : edits) {
    axes.push_back({HandProperty::kLower, edit.joint, {edit.lower}});
    axes.push_back({HandProperty::kUpper, edit.joint, {edit.upper}});
  }
  const SweepRow tight = sweepOf(axes)[0];
  ASSERT_EQ(tight.error, "");
  EXPECT_FALSE(tight.joints_at_limit.empty());
  expectOthersMoved(*hand.model, edits, free.q, tight.q);
  EXPECT_GT(tight.terms.objective, free.terms.objective);
}

TEST(Sweep, ASessionsTighterLimitsMoveOtherJointsAsWell) {
  session::Session session = BallGrasp().open();
  const optimize::SolveReport free = session.optimize({}, Progress());
  const hand::HandModel& model = *session.hand().model;
  const std::vector<session::JointLimitEdit> edits = tighter(model, free.pose.q);
  for (const session::JointLimitEdit& edit : edits)
    session.apply(edit);
  const optimize::SolveReport tight = session.optimize({}, Progress());
  expectOthersMoved(model, edits, free.pose.q, tight.pose.q);
}

TEST(Sweep, WiderLimitsAreNeverWorse) {
  std::vector<double> limits;
  for (int i = 0; i <= 8; ++i)
    limits.push_back(-0.4 + 0.1 * i);
  const std::vector<SweepRow> rows = sweepOf({{HandProperty::kUpper, "thumb_1", limits}});
  for (std::size_t i = 2; i < rows.size(); ++i) {
    EXPECT_LE(rows[i].terms.objective, rows[i - 2].terms.objective * (1.0 + 1e-6)) << i;
  }
  EXPECT_GT(rows.front().terms.objective, 1.002 * rows[rows.size() - 2].terms.objective)
      << "the limit would not matter";
}

/// What a session answers that is opened on a hand with this change.
session::Solution solutionOn(const hand::Hand& original,
                             const SweepGrasp& grasp,
                             const hand::HandChange& change) {
  const hand::HandVariant variant =
      hand::makeVariant(*original.model, original.model->name(), {change});
  hand::Hand hand = original;
  hand.model = std::make_shared<const hand::HandModel>(variant.model);
  hand.skin = hand::SkinBending(original.model, original.skin).bent(variant);
  hand.skin_maps = nullptr;
  hand.sites = hand::sitesOfVariant(variant, original.sites);
  session::Session session(hand, grasp.object_O, grasp.contacts, Pose::Identity(), {});
  return session.solve({}, session::SolveRun(), Progress());
}

// Places that are kept from the hand as it is may be bad ones for another: a row lacks no more
// than a session opened on it, and costs a hundredth more at most.
TEST(Sweep, NoRowIsWorseThanASessionOnSuchAHand) {
  hand::Hand hand = BallGrasp().hand();
  hand.sites_are_found = true;  // so that places may slide
  const std::vector<SweepGrasp> grasps = twoGrasps();
  const std::vector<SweepAxis> axes = {{HandProperty::kUpper, "thumb_1", {-0.4, -0.2}},
                                       {HandProperty::kUpper, "index_2", {0.1, 0.5}},
                                       {HandProperty::kLength, "index_lower", {0.5, 0.7, 1.6}},
                                       {HandProperty::kSize, "", {0.7, 1.4}}};
  for (const SweepAxis& axis : axes) {
    for (const SweepRow& row : sweep(hand, grasps, {axis}, {}, Progress()).rows) {
      ASSERT_EQ(row.error, "");
      const session::Solution anew =
          solutionOn(hand, grasps[static_cast<std::size_t>(row.grasp)],
                     {axis.property, axis.target, row.values[0]});
      EXPECT_EQ(row.patch_count, 3);
      EXPECT_GT(row.point_count, 60);
      EXPECT_GT(row.mean_mm, 0.0);
      const auto lacking = session::worthOf(anew).first;
      ASSERT_LE(row.patch_count - row.reached_count, lacking)
          << axis.target << " " << row.values[0];
      if (row.patch_count - row.reached_count < lacking) continue;
      EXPECT_LE(row.terms.objective, 1.01 * anew.report.terms.objective)
          << axis.target << " " << row.values[0];
    }
  }
}

// Contacts of a hand and an object that are both twice as large fit as well, at twice the
// scale.
TEST(Sweep, AHandAndAnObjectOfTwiceTheSizeFitAlike) {
  const BallGrasp grasp;
  BallGrasp large;
  large.ball = std::make_shared<const geometry::TriangleMesh>(
      geometry::transformed(*grasp.ball, Eigen::Affine3d(Eigen::Scaling(2.0))));
  SweepOptions options;
  options.weights.normal = 0.0;
  options.weights.prior = 0.0;
  const SweepRow small =
      sweep(grasp.hand(), {{grasp.ball, grasp.contacts}}, {}, options, Progress()).rows[0];
  const SweepRow twice = sweep(grasp.hand(), {{large.ball, large.contacts}},
                               {{HandProperty::kSize, "", {2.0}}}, options, Progress())
                             .rows[0];
  ASSERT_EQ(twice.error, "");
  EXPECT_EQ(twice.point_count, small.point_count);
  // But for the margin that they are kept apart by, which does not grow with them.
  const double margin_mm = 1e3 * optimize::Avoidance().margin_m;
  EXPECT_NEAR(twice.mean_mm, 2.0 * small.mean_mm, 0.02 * small.mean_mm + margin_mm);
}

TEST(Sweep, LimitsThatCrossAreTheRowsOwnError) {
  const std::vector<SweepRow> rows = sweepOf({{HandProperty::kLower, "thumb_1", {-0.5, 1.0}},
                                              {HandProperty::kUpper, "thumb_1", {0.5, 1.4}}});
  ASSERT_EQ(rows.size(), 8u);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool crosses = rows[i].values[0] > rows[i].values[1];
    EXPECT_EQ(rows[i].error.empty(), !crosses) << rows[i].error;
    if (crosses) {
      EXPECT_THAT(rows[i].error, AllOf(HasSubstr("'thumb_1'"), HasSubstr("0.5")));
    }
  }
}

TEST(Sweep, AGraspThatCannotBeSolvedLeavesTheOthersAlone) {
  std::vector<SweepGrasp> grasps = twoGrasps();
  for (contact::Patch& patch : grasps[0].contacts.patches)
    patch.name = "heel";
  grasps[0].contacts.patches.resize(1);
  const std::vector<SweepRow> rows =
      sweep(BallGrasp().hand(), grasps, {{HandProperty::kUpper, "thumb_1", {0.2, 0.8}}}, {},
            Progress())
          .rows;
  EXPECT_THAT(rows[0].error, HasSubstr("heel"));
  EXPECT_THAT(rows[2].error, HasSubstr("heel"));
  EXPECT_EQ(rows[1].error, "");
  EXPECT_EQ(rows[3].error, "");
}

TEST(Sweep, NamesWhatIsWrongBeforeItBegins) {
  const auto refusal = [](const std::vector<SweepAxis>& axes) {
    try {
      (void)sweepOf(axes);
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string("no refusal");
  };
  EXPECT_THAT(refusal({{HandProperty::kUpper, "elbow", {1.0}}}), HasSubstr("'elbow'"));
  EXPECT_THAT(refusal({{HandProperty::kUpper, "thumb_1", {}}}), HasSubstr("no values"));
  EXPECT_THAT(refusal({{HandProperty::kSize, "", {20.0}}}), HasSubstr("0.1 to 10"));
  EXPECT_THAT(refusal({{HandProperty::kUpper, "thumb_1", {1.0}},
                       {HandProperty::kUpper, "thumb_1", {1.0}}}),
              HasSubstr("'thumb_1.upper' is varied twice"));
  EXPECT_THAT(refusal({{HandProperty::kUpper, "thumb_1", std::vector<double>(300, 1.0)},
                       {HandProperty::kUpper, "thumb_2", std::vector<double>(300, 1.0)}}),
              AllOf(HasSubstr("180000 rows"), HasSubstr("100000")));
  EXPECT_THROW((void)sweep(BallGrasp().hand(), {}, {}, {}, Progress()), InvalidInput);
}

TEST(Sweep, KeepsItsRowsOutOfTheObject) {
  SweepOptions options;
  ASSERT_TRUE(options.solving.avoids());
  const auto rows =
      sweep(BallGrasp().hand(), twoGrasps(),
            {{HandProperty::kUpper, "thumb_1", {1.0}}, {HandProperty::kSize, "", {1.0, 1.2}}},
            options, Progress())
          .rows;
  options.solving.avoid_penetration = false;
  for (const SweepRow& row : rows) {
    EXPECT_EQ(row.error, "");
    // As if a place of a square centimetre lay half a millimetre deep.
    EXPECT_LT(row.terms.penetration, 10.0 * 5e-4 * 5e-4);
  }
  for (const SweepRow& row :
       sweep(BallGrasp().hand(), twoGrasps(), {}, options, Progress()).rows)
    EXPECT_EQ(row.terms.penetration, 0.0) << "nobody looked";
}

TEST(Sweep, StopsOnWish) {
  std::atomic<int> told{0};
  Progress* stopping = nullptr;
  Progress progress([&](std::string_view, double) {
    if (++told == 3) stopping->cancel();
  });
  stopping = &progress;
  EXPECT_THROW((void)sweep(BallGrasp().hand(), twoGrasps(),
                           {{HandProperty::kUpper, "thumb_1", std::vector<double>(50, 1.0)}},
                           {}, progress),
               Cancelled);
  EXPECT_LT(told, 20);
}

}  // namespace
}  // namespace handgraft::sweep
