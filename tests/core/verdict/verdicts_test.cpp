// What a solution says in words, on a ball that three fingers hold.

#include "core/verdict/verdicts.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/contact_file.h"

#include "tests/core/session/ball_grasp.h"
#include "tests/core/session/library_models.h"

namespace handgraft::verdict {
namespace {

using optimize::Verdict;
using testing::HasSubstr;

Verdicts solvedAndJudged(session::Session& session) {
  const optimize::SolveReport report = session.optimize({}, Progress());
  FitCheck check;
  return verdictsOf(session, *session.solvedProblem(), report,
                    check.of(session, *session.solvedProblem()));
}

/// The middle of the ball's face that lies farthest in a direction.
geometry::SurfacePoint facePointTowards(const geometry::TriangleMesh& ball,
                                        const Eigen::Vector3d& direction) {
  geometry::SurfacePoint farthest{0, Eigen::Vector3d::Constant(1.0 / 3.0)};
  for (int face = 0; face < ball.faceCount(); ++face) {
    const geometry::SurfacePoint middle{face, Eigen::Vector3d::Constant(1.0 / 3.0)};
    if (positionOf(ball, middle).dot(direction) > positionOf(ball, farthest).dot(direction))
      farthest = middle;
  }
  return farthest;
}

TEST(Verdicts, AllReachedIsSaidInOneLine) {
  const test::BallGrasp grasp;
  session::Session session = grasp.open();
  const Verdicts verdicts = solvedAndJudged(session);
  EXPECT_EQ(verdicts.line, "3 of 3 patches reached");
  EXPECT_FALSE(verdicts.too_large);
  ASSERT_EQ(verdicts.texts.size(), 3U);
  EXPECT_THAT(verdicts.texts[0], HasSubstr("mm off on average"));
  EXPECT_THAT(verdicts.texts[0],
              HasSubstr(fmt::format("mean normals {:.0f} degrees apart",
                                    verdicts.diagnosis.patches[0].facing_deg)));
}

TEST(Verdicts, SayThatTheOtherHandTouchedWhereHardlyAnythingFits) {
  const io::MeshFile file = io::readMesh(test::libraryPath("objects/box.obj"));
  const auto box = std::make_shared<const geometry::TriangleMesh>(file.mesh);
  contact::ContactSet contacts =
      io::readContactSet(test::libraryPath("contacts/box_5.json"), file);
  const auto says_so = HasSubstr("a left hand touched, and this is a right one");
  contacts.side = hand::Chirality::kLeft;
  session::Session session(test::handOfLibrary("human20"), box, contacts, Pose::Identity(), {});
  EXPECT_THAT(solvedAndJudged(session).line, Not(says_so)) << "all is reached";
  const auto shut = [](session::Session& one) {
    const hand::HandModel& model = *one.hand().model;
    for (int dof = 0; dof < model.dofCount(); ++dof)
      one.apply(session::JointLimitEdit{model.dofJoint(dof).name, model.upper()[dof] - 0.01,
                                        model.upper()[dof]});
  };
  shut(session);
  EXPECT_THAT(solvedAndJudged(session).line, says_so);
  contacts.side = hand::Chirality::kRight;
  session::Session right(test::handOfLibrary("human20"), box, contacts, Pose::Identity(), {});
  shut(right);
  EXPECT_THAT(solvedAndJudged(right).line, Not(HasSubstr("hand touched")));
  // Of patches without fingers' names nothing tells the side.
  contacts.side = hand::Chirality::kUnknown;
  for (std::size_t i = 0; i < contacts.patches.size(); ++i) {
    contacts.patches[i].name = fmt::format("c{}", i);
    contacts.patches[i].place.reset();
  }
  session::Session untold(test::handOfLibrary("human20"), box, contacts, Pose::Identity(), {});
  const auto asks = HasSubstr("which hand touched is not known: if it was a left one");
  EXPECT_THAT(solvedAndJudged(untold).line, Not(asks)) << "all is reached";
  shut(untold);
  EXPECT_THAT(solvedAndJudged(untold).line, asks);
}

TEST(Verdicts, NameTheLimitsThatKeepAFingerOpen) {
  const test::BallGrasp grasp;
  session::Session session = grasp.open();
  for (const char* joint : {"index_1", "index_2", "thumb_1", "thumb_2", "middle_1", "middle_2"})
    session.apply(session::JointLimitEdit{joint, -0.5, -0.3});
  const Verdicts verdicts = solvedAndJudged(session);
  EXPECT_THAT(verdicts.line, Not(HasSubstr("3 of 3")));
  ASSERT_FALSE(verdicts.diagnosis.sensitivities.empty());
  const std::string limit = nameOf(*session.hand().model, verdicts.diagnosis.sensitivities[0]);
  EXPECT_THAT(limit, HasSubstr(" upper"));
  EXPECT_THAT(
      verdicts.texts,
      testing::Contains(testing::ContainsRegex(" upper by [0-9.]+ deg: [0-9.]+ mm nearer")));
  for (const optimize::LimitSensitivity& one : verdicts.diagnosis.sensitivities) {
    EXPECT_GT(one.gain, 0.0);
    EXPECT_NEAR(one.limit, -0.3, 1e-12);
  }
}

// Somebody's own hold is no fault of the other patches.
TEST(Verdicts, NameWhatIsHeldWhereThatKeepsAPatchAway) {
  const test::BallGrasp grasp;
  session::Session session = grasp.open();
  solvedAndJudged(session);
  session::DragEdit drag;
  drag.link = "thumb_tip";
  drag.target_W = Eigen::Vector3d(0.1, 0.0, 0.0);
  session.apply(drag);
  const Verdicts held = solvedAndJudged(session);
  ASSERT_EQ(held.diagnosis.patches[0].verdict, Verdict::kOutOfReach);
  EXPECT_THAT(held.texts[0], HasSubstr("what is held at thumb_tip keeps it away"));
}

// Nor is what is held in its place to blame where two patches want the same finger elsewhere.
TEST(Verdicts, BlameNoHoldThatKeepsNothingAway) {
  const test::BallGrasp grasp;
  session::Session session = grasp.open();
  const hand::HandPose pose = session.optimize({}, Progress()).pose;
  session::DragEdit drag;  // to where it is
  drag.link = "middle_tip";
  const int link = session.hand().model->linkIndex("middle_tip");
  drag.target_W =
      hand::forwardKinematics(*session.hand().model, pose)[static_cast<std::size_t>(link)]
          .translation();
  session.apply(drag);
  for (const std::string& text : solvedAndJudged(session).texts)
    EXPECT_THAT(text, Not(HasSubstr("held")));
}

TEST(Verdicts, ASwitchedOffPatchIsNotCounted) {
  const test::BallGrasp grasp;
  session::Session session = grasp.open();
  session.apply(session::PatchWeightEdit{"middle", 0.0});
  const Verdicts verdicts = solvedAndJudged(session);
  EXPECT_THAT(verdicts.line, HasSubstr("of 2 patches"));
}

TEST(Verdicts, TellThatNothingHoldsWhatIsPressedFromOneSide) {
  const test::BallGrasp grasp;
  session::Session session = grasp.open();
  EXPECT_THAT(solvedAndJudged(session).line, Not(HasSubstr("one side")));
  EXPECT_FALSE(solvedAndJudged(session).one_sided);
  // The thumb stands against the two fingers.
  session.apply(session::PatchWeightEdit{"thumb", 0.0});
  EXPECT_THAT(solvedAndJudged(session).line,
              HasSubstr("2 of 2 patches reached; what is reached presses to one side"));
  EXPECT_TRUE(solvedAndJudged(session).one_sided);
  session.apply(session::PatchWeightEdit{"middle", 0.0});
  EXPECT_THAT(solvedAndJudged(session).line, Not(HasSubstr("one side"))) << "a touch";
}

TEST(Verdicts, APatchWithoutAPointOnTheHandIsNotReachedAndNamed) {
  const test::BallGrasp grasp;
  session::Session session = grasp.open();
  // Seen from the ball's other side the patch lies farther away than the finger is long.
  const geometry::TriangleMesh& ball = *grasp.ball;
  const geometry::SurfacePoint root = grasp.contacts.patches[2].root;
  const geometry::SurfacePoint opposite = facePointTowards(ball, -positionOf(ball, root));
  session.apply(session::PatchRootEdit{"middle", session::Side::kObject, opposite});
  const Verdicts verdicts = solvedAndJudged(session);
  EXPECT_THAT(verdicts.line,
              HasSubstr(" of 3 patches reached; middle has no point on the hand"));
  EXPECT_EQ(verdicts.diagnosis.patches.size(), 2U);
  session.apply(session::PatchEnabledEdit{"middle", false});
  EXPECT_THAT(solvedAndJudged(session).line, Not(HasSubstr("middle")));
}

TEST(Verdicts, TellOfHowFewPointsAPatchIsReached) {
  test::BallGrasp grasp;
  std::vector<geometry::SurfacePoint>& points =
      grasp.contacts.patches[2].interpolation_boundary;
  const Eigen::Vector3d away = -positionOf(*grasp.ball, points[0]).normalized();
  for (std::size_t i = 4; i < points.size(); ++i)
    points[i] = facePointTowards(*grasp.ball, away);
  session::Session session = grasp.open();
  const Verdicts verdicts = solvedAndJudged(session);
  EXPECT_THAT(verdicts.line, testing::ContainsRegex(
                                 "; middle: only [1-5] of its 25 points lies? on the hand"));
  EXPECT_THAT(verdicts.texts.at(2), HasSubstr("only "));
  EXPECT_THAT(verdicts.texts.at(1), Not(HasSubstr("only ")));
}

TEST(Verdicts, TellThatARootLiesOutsideOfItsBoundary) {
  const test::BallGrasp grasp;
  session::Session session = grasp.open();
  // The patch's radius is 7 mm.
  const Eigen::Vector3d root = positionOf(*grasp.ball, grasp.contacts.patches[2].root);
  session.apply(session::PatchRootEdit{
      "middle", session::Side::kObject,
      facePointTowards(*grasp.ball, root + Eigen::Vector3d(0.0, 0.0, -0.015))});
  const Verdicts verdicts = solvedAndJudged(session);
  EXPECT_THAT(verdicts.line, HasSubstr("; middle: its root lies outside of its boundary"));
}

TEST(Verdicts, PromiseOfASolveWhatAPatchLeftOutWouldBring) {
  const test::BallGrasp grasp;
  session::Session session = grasp.open();
  // Too far round the ball for its finger, and heavy: it turns the hand away from the others.
  session.apply(
      session::PatchRootEdit{"middle", session::Side::kObject,
                             facePointTowards(*grasp.ball, Eigen::Vector3d(0.5, -1.0, -0.5))});
  session.apply(session::PatchWeightEdit{"middle", 1e3});
  EXPECT_THAT(solvedAndJudged(session).line,
              HasSubstr("; solved without middle 2 of 2 would be"));
}

TEST(Verdicts, TellWhatIsKnownOfSizesBeforeASearch) {
  const test::BallGrasp grasp;
  session::Session session = grasp.open();
  session.transferPatches(Progress());
  FitFindings findings;
  EXPECT_EQ(lineOf(session, findings), "");
  findings.clearances.push_back({1, 0.0011});
  findings.spans.push_back({0, 2, 0.06, 0.04});
  EXPECT_TRUE(findings.tooLarge());
  EXPECT_TRUE(findings.tooSmall());
  EXPECT_EQ(lineOf(session, findings),
            "too large for index (by 1.1 mm); too small for thumb and middle: 60 mm apart, the "
            "hand's places at most 40");
}

TEST(Verdicts, WhatTheHandHasNoPlaceForIsCounted) {
  test::BallGrasp grasp;
  grasp.contacts.patches.push_back(grasp.contacts.patches.back());
  grasp.contacts.patches.back().name = "little";
  session::Session session = grasp.open();
  EXPECT_EQ(solvedAndJudged(session).line, "3 of 3 patches reached; 1 more dropped");
}

TEST(Verdicts, APatchWithoutClearanceIsNotReachedWhateverThePoseSays) {
  const test::BallGrasp grasp;
  session::Session session = grasp.open();
  const optimize::SolveReport report = session.optimize({}, Progress());
  FitFindings findings;
  findings.clearances.push_back({1, 0.0011});
  const Verdicts verdicts = verdictsOf(session, *session.solvedProblem(), report, findings);
  EXPECT_EQ(verdicts.diagnosis.patches.at(1).verdict, Verdict::kNoClearance);
  EXPECT_EQ(verdicts.diagnosis.patches[1].missing_clearance_m, 0.0011);
  EXPECT_EQ(verdicts.diagnosis.patches[0].missing_clearance_m, 0.0);
  EXPECT_NEAR(verdicts.diagnosis.patches[1].miss_mm, 1.1, 1e-9);
  EXPECT_THAT(verdicts.texts[1], HasSubstr("too thick by at least 1.1 mm"));
  EXPECT_EQ(verdicts.line, "2 of 3 patches reached; too large for index (by 1.1 mm)");
  EXPECT_TRUE(verdicts.too_large);
}

TEST(FitCheck, FindsABallTooLargeOnlyWhenTheHandCannotOpen) {
  const test::BallGrasp grasp;
  session::Session session = grasp.open();
  session.transferPatches(Progress());
  FitCheck check;
  EXPECT_TRUE(check.of(session, session.problem()).spans.empty());
  for (const char* joint : {"index_1", "index_2", "thumb_1", "thumb_2", "middle_1", "middle_2"})
    session.apply(session::JointLimitEdit{joint, 1.1, 1.2});
  session.transferPatches(Progress());
  const FitFindings findings = check.of(session, session.problem());
  EXPECT_FALSE(findings.spans.empty());
  EXPECT_TRUE(findings.tooSmall());
}

TEST(FitCheck, StandsWhereTheObjectIsMoved) {
  const test::BallGrasp grasp;
  session::Session session = grasp.open();
  for (const char* joint : {"index_1", "index_2", "thumb_1", "thumb_2", "middle_1", "middle_2"})
    session.apply(session::JointLimitEdit{joint, 1.1, 1.2});
  session.transferPatches(Progress());
  FitCheck kept;
  const std::size_t before = kept.of(session, session.problem()).spans.size();
  Pose X_WO = Pose::Identity();
  X_WO.translation() = Eigen::Vector3d(0.3, -0.2, 0.1);
  session.apply(session::ObjectPoseEdit{X_WO});
  session.transferPatches(Progress());
  EXPECT_EQ(kept.of(session, session.problem()).spans.size(), before);
  FitCheck fresh;
  EXPECT_EQ(fresh.of(session, session.problem()).spans.size(), before);
}

}  // namespace
}  // namespace handgraft::verdict
