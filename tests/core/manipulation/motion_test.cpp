#include "core/manipulation/motion.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/surface_locator.h"
#include "core/io/mesh_file.h"
#include "core/io/motion_file.h"
#include "core/io/motion_import.h"

#include "tests/support/shared_data.h"

namespace handgraft::manipulation {
namespace {

using testing::HasSubstr;

const geometry::TriangleMesh& ball() {
  static const geometry::TriangleMesh mesh = geometry::makeSphere(0.05, 3);
  return mesh;
}

PatchKey keyAt(int frame, const Eigen::Vector3d& towards) {
  static const geometry::SurfaceLocator locator(ball());
  PatchKey key;
  key.frame = frame;
  key.patch.name = "index";
  key.patch.root = locator.nearest(0.05 * towards.normalized()).point;
  key.patch.direction_O = Eigen::Vector3d::UnitZ();
  for (const Eigen::Vector3d& aside :
       {Eigen::Vector3d(0, 0.1, 0), Eigen::Vector3d(0, -0.1, 0.1), Eigen::Vector3d(0, 0, -0.2)})
    key.patch.interpolation_boundary.push_back(
        locator.nearest(0.05 * (towards.normalized() + aside)).point);
  key.patch.place = hand::HandLocation{"index", "distal", 3, 0.5, 0.1, 0.5, 0.2};
  return key;
}

Motion slide() {
  Motion motion;
  motion.name = "slide";
  motion.object = "ball";
  for (int k = 0; k < 10; ++k) {
    motion.time_s.push_back(0.01 * k);
    Pose X = Pose::Identity();
    X.linear() = rotationFromVector({0, 0, 0.02 * k});
    X.translation().x() = 0.003 * k;
    motion.X_WO.push_back(X);
  }
  PatchTrack track;
  track.name = "index";
  track.end = 8;
  track.keys = {keyAt(1, Eigen::Vector3d::UnitX()), keyAt(4, {1.0, 0.2, 0.0})};
  motion.tracks.push_back(track);
  return motion;
}

/// The message of what `validate` throws; empty if it does not.
std::string faultOf(const Motion& motion) {
  try {
    validate(ball(), motion);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

TEST(Motion, AKeyHoldsUntilTheNext) {
  const Motion motion = slide();
  EXPECT_EQ(motion.tracks[0].keyAt(3).frame, 1);
  EXPECT_EQ(motion.tracks[0].keyAt(4).frame, 4);
  EXPECT_EQ(motion.tracks[0].keyAt(7).frame, 4);
  EXPECT_THROW(static_cast<void>(motion.tracks[0].keyAt(8)), BrokenContract);
}

/// The demonstrator's hand at frames 0, 4 and 8, turned by a quarter from the first to the
/// second, and where it is.
Motion shownSlide() {
  Motion motion = slide();
  for (const int frame : {0, 4, 8}) {
    DemonstratorKey key;
    key.frame = frame;
    const Eigen::Matrix3d R = rotationFromVector(Eigen::Vector3d::UnitZ() *
                                                 (frame > 0 ? 0.5 * std::numbers::pi : 0.0));
    key.X_OD.linear() = R;
    key.X_OD.translation().x() = 0.01 * frame;
    key.posture = {{"palm", R * Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()},
                   {"thumb_distal", R * Eigen::Vector3d::UnitY(), Eigen::Vector3d::Zero()}};
    motion.demonstrator.push_back(key);
  }
  return motion;
}

TEST(Motion, BetweenTwoKeysTheDemonstratorIsInBetween) {
  const Motion motion = shownSlide();
  const Pose half = demonstratorPoseAt(motion, 2);
  EXPECT_NEAR(half.translation().x(), 0.02, 1e-12);
  const Eigen::Vector3d diagonal = Eigen::Vector3d(1.0, 1.0, 0.0).normalized();
  EXPECT_TRUE(half.linear().col(0).isApprox(diagonal, 1e-12));
  EXPECT_NEAR(demonstratorPoseAt(motion, 4).translation().x(), 0.04, 1e-12);
  EXPECT_NEAR(demonstratorPoseAt(motion, 9).translation().x(), 0.08, 1e-12) << "the last";
  EXPECT_EQ(demonstratorNear(motion, 5).frame, 4);
  EXPECT_EQ(demonstratorNear(motion, 9).frame, 8);
  EXPECT_THROW((void)demonstratorPoseAt(slide(), 0), BrokenContract);
  EXPECT_THROW((void)demonstratorNear(slide(), 0), BrokenContract);
}

TEST(Motion, ADemonstratorIsDueEach40Milliseconds) {
  Motion motion = shownSlide();
  motion.demonstrator.resize(1);
  EXPECT_FALSE(isDemonstratorDue(motion, 3));
  EXPECT_TRUE(isDemonstratorDue(motion, 4)) << "0.01 s a frame";
  motion.demonstrator.clear();
  EXPECT_TRUE(isDemonstratorDue(motion, 0));
}

TEST(Motion, NamesWhatIsWrongOfItsDemonstrator) {
  EXPECT_EQ(faultOf(shownSlide()), "");
  Motion motion = shownSlide();
  motion.demonstrator[1].frame = 0;
  EXPECT_THAT(faultOf(motion), HasSubstr("demonstrator: key at frame 0; permitted are 1 to 9"));
  motion = shownSlide();
  motion.demonstrator[2].frame = 10;
  EXPECT_THAT(faultOf(motion), HasSubstr("demonstrator: key at frame 10"));
  motion = shownSlide();
  motion.demonstrator[1].X_OD.translation().y() = std::numeric_limits<double>::infinity();
  EXPECT_THAT(faultOf(motion),
              HasSubstr("demonstrator, frame 4: the hand's pose is not finite"));
  motion = shownSlide();
  motion.demonstrator[1].X_OD.linear() *= 2.0;
  EXPECT_THAT(faultOf(motion), HasSubstr("is no rotation and translation"));
  motion = shownSlide();
  motion.demonstrator[1].posture[1].outward_O *= 0.5;
  EXPECT_THAT(faultOf(motion), HasSubstr("direction of part 'thumb_distal'"));
  motion = shownSlide();
  motion.demonstrator[1].posture.resize(contact::kMostParts + 1,
                                        motion.demonstrator[1].posture[0]);
  EXPECT_THAT(faultOf(motion), HasSubstr("a posture of 1001 parts; permitted are 1000"));
}

TEST(Motion, NamesWhatIsWrong) {
  EXPECT_EQ(faultOf(slide()), "");
  Motion motion = slide();
  motion.time_s[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(faultOf(motion), HasSubstr("frame 3: time is nan"));
  motion = slide();
  motion.time_s[5] = motion.time_s[4];
  EXPECT_THAT(faultOf(motion), HasSubstr("frame 5: time 0.04 s does not lie behind"));
  motion = slide();
  motion.X_WO[2].translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(faultOf(motion), HasSubstr("frame 2: the object's pose is not finite"));
  motion = slide();
  motion.X_WO[2].linear() *= 1.1;
  EXPECT_THAT(faultOf(motion), HasSubstr("frame 2: the object's pose is no rotation"));
  motion = slide();
  motion.tracks[0].end = 11;
  EXPECT_THAT(faultOf(motion), HasSubstr("track 0 ('index'): ends at frame 11"));
  motion = slide();
  motion.tracks[0].keys[1].frame = 1;
  EXPECT_THAT(faultOf(motion), HasSubstr("key at frame 1; permitted are 2 to 9"));
  motion = slide();
  motion.tracks[0].keys[0].patch.root.face = 100000;
  EXPECT_THAT(faultOf(motion), HasSubstr("key at frame 1: root"));
  motion = slide();
  motion.tracks[0].keys[0].hand_points.resize(1);
  EXPECT_THAT(faultOf(motion), HasSubstr("has 1 points on the hand"));
  motion = slide();
  motion.time_s.clear();
  EXPECT_THAT(faultOf(motion), HasSubstr("0 frames"));
}

TEST(Motion, TellsThatItsObjectJumps) {
  Motion motion = slide();
  EXPECT_EQ(remarksOn(motion).size(), 1u);  // frames without contact
  motion.X_WO[6].translation().y() += 1.0;
  EXPECT_THAT(remarksOn(motion)[0], HasSubstr("jumps 2 times, first to frame 6"));
}

TEST(Motion, TellsTimesInMilliseconds) {
  Motion motion = slide();
  for (double& time_s : motion.time_s)
    time_s *= 1e3;
  EXPECT_THAT(remarksOn(motion)[0], HasSubstr("are these milliseconds?"));
}

TEST(Motion, TracksOfPointsKeepNamesThatSessionsKnow) {
  Motion motion = slide();
  PatchTrack& track = motion.tracks[0];
  track.name = "fingertip";
  nameByParts(motion);
  EXPECT_EQ(track.name, "fingertip") << "an area, of a site that the hand may have";
  for (PatchKey& key : track.keys) {
    key.patch.interpolation_boundary.resize(1);
    key.hand_points = {{"ff_tip", {}}};
  }
  nameByParts(motion);
  EXPECT_EQ(track.name, "fingertip") << "it has a place";
  track.name = "ff_tip";
  nameByParts(motion);
  EXPECT_EQ(track.name, "index_distal");
  EXPECT_EQ(track.keys[1].patch.name, "index_distal");
  track.name = "fingertip";
  track.keys[0].patch.place.reset();
  nameByParts(motion);
  EXPECT_EQ(track.name, "c1");
}

TEST(MotionFile, ComesBackAsItWent) {
  Motion motion = slide();
  motion.tracks[0].keys[1].hand_points.assign(3, {"index3", {0.01, 0.02, 0.03}});
  motion.tracks[0].keys[1].patch.weight = 2.0;
  motion.notes = {"made by hand"};
  motion.side = hand::Chirality::kLeft;
  const Motion back = io::motionFromText(io::motionText(motion, ball()), ball());
  EXPECT_EQ(back.name, motion.name);
  EXPECT_EQ(back.time_s, motion.time_s);
  EXPECT_EQ(back.notes, motion.notes);
  EXPECT_EQ(back.side, motion.side);
  ASSERT_EQ(back.X_WO.size(), motion.X_WO.size());
  for (std::size_t k = 0; k < back.X_WO.size(); ++k)
    EXPECT_TRUE(back.X_WO[k].isApprox(motion.X_WO[k], 1e-12)) << k;
  ASSERT_EQ(back.tracks.size(), 1u);
  EXPECT_EQ(back.tracks[0].end, 8);
  ASSERT_EQ(back.tracks[0].keys.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const PatchKey& was = motion.tracks[0].keys[i];
    const PatchKey& is = back.tracks[0].keys[i];
    EXPECT_EQ(is.frame, was.frame);
    EXPECT_EQ(is.patch.place, was.patch.place);
    EXPECT_EQ(is.patch.weight, was.patch.weight);
    EXPECT_EQ(is.hand_points.size(), was.hand_points.size());
    for (std::size_t j = 0; j < 3; ++j) {
      EXPECT_LT((positionOf(ball(), is.patch.interpolation_boundary[j]) -
                 positionOf(ball(), was.patch.interpolation_boundary[j]))
                    .norm(),
                1e-12);
    }
  }
}

TEST(MotionFile, TheDemonstratorComesBack) {
  const Motion motion = shownSlide();
  const Motion back = io::motionFromText(io::motionText(motion, ball()), ball());
  ASSERT_EQ(back.demonstrator.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const DemonstratorKey& was = motion.demonstrator[i];
    const DemonstratorKey& is = back.demonstrator[i];
    EXPECT_EQ(is.frame, was.frame);
    EXPECT_TRUE(is.X_OD.isApprox(was.X_OD, 1e-12));
    ASSERT_EQ(is.posture.size(), was.posture.size());
    for (std::size_t j = 0; j < is.posture.size(); ++j) {
      EXPECT_EQ(is.posture[j].part, was.posture[j].part);
      EXPECT_TRUE(is.posture[j].outward_O.isApprox(was.posture[j].outward_O, 1e-12));
      EXPECT_TRUE((is.posture[j].palmar_O - was.posture[j].palmar_O).isZero(1e-12));
    }
  }
}

TEST(MotionFile, NamesTheFieldThatIsWrong) {
  const std::string text = io::motionText(slide(), ball());
  const auto fault_with = [&](const std::string& what, const std::string& instead) {
    std::string broken = text;
    const std::size_t at = broken.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    broken.replace(at, what.size(), instead);
    try {
      io::motionFromText(broken, ball());
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(fault_with("handgraft-motion/1", "handgraft-motion/9"), HasSubstr("'format'"));
  EXPECT_THAT(fault_with("\"end\":8", "\"end\":-8"), HasSubstr("track 0: field 'end' is '-8'"));
  EXPECT_THAT(fault_with("\"end\":8", "\"stop\":8"), HasSubstr("stop"));
  EXPECT_THAT(fault_with("\"time_s\":[0.0", "\"time_s\":[null"),
              HasSubstr("'time_s' has 'null'"));
  EXPECT_THAT(fault_with("\"root\":[", "\"root\":[1e3,"), HasSubstr("field 'root' must be"));
  EXPECT_THAT(fault_with("\"name\":\"slide\"", "\"demonstrator\":[{\"frame\":1}]"),
              HasSubstr("demonstrator, key 0: field 'hand_pose' is missing"));
  EXPECT_THAT(fault_with("\"name\":\"slide\"",
                         "\"demonstrator\":[{\"frame\":1,\"hand_pose\":[0,0,0,1,0,0,0],"
                         "\"posture\":[{\"part\":\"palm\",\"outward\":[0,0,0]}]}]"),
              HasSubstr("demonstrator, key 0: field 'outward' has no length"));
  EXPECT_THAT(fault_with("{", "["), HasSubstr("parse error"));
}

TEST(SplineTrajectory, IsAStraightLineWhereItsControlsAre) {
  // Greville abscissae of the knots 0 0 0 0 1 2 2 2 2: the spline of a line is the line.
  io::SplineTrajectory line;
  line.controls.resize(5, 1);
  line.controls.col(0) << 0.0, 1.0 / 3.0, 1.0, 5.0 / 3.0, 2.0;
  for (const double share : {0.0, 0.1, 0.49, 0.5, 0.77, 1.0})
    EXPECT_NEAR(line.at(share)[0], 2.0 * share, 1e-14) << share;
}

TEST(Keyframes, AreReadAndRejectedByLine) {
  const auto path = test::scratchDirectory() / "keys.csv";
  const auto write = [&](const std::string& text) {
    std::ofstream(path) << text;
  };
  write("time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0.1,1,0,0,0\n0.5,0.2,0,0.1,0,0,0,1\n");
  const auto poses = io::readKeyframes(path);
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[1].X_WO.translation().x(), 0.2);
  EXPECT_NEAR(poses[1].X_WO.linear()(0, 0), -1.0, 1e-15);
  write("time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0.1,1,0,0,0\n-1,0.2,0,0.1,0,0,0,1\n");
  try {
    io::readKeyframes(path);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("line 3: time -1 s"));
  }
}

TEST(ContactSequence, ReadsARecordedOne) {
  HANDGRAFT_NEEDS_SHARED_DATA("contacts/grab_sequences");
  const auto folder = test::sharedData("contacts/grab_sequences");
  const io::MeshFile apple = io::readMesh(test::sharedData("objects/grab/apple.obj"));
  const Motion motion =
      io::readContactSequence(folder / "allegro_apple_pass_1.json", apple.mesh,
                              folder / "trajectories/apple_pass_1_object.smexp");
  EXPECT_EQ(motion.frameCount(), 703);
  EXPECT_NEAR(motion.duration(), 702.0 / 120.0, 1e-12);
  EXPECT_GT(motion.tracks.size(), 17u);
  EXPECT_TRUE(motion.notes.empty());
  // It is lifted by some 20 cm or more, not by 20 m.
  double way = 0.0;
  for (const Pose& X : motion.X_WO)
    way = std::max(way, (X.translation() - motion.X_WO[0].translation()).norm());
  EXPECT_GT(way, 0.1);
  EXPECT_LT(way, 3.0);
}

TEST(StrideOf, IsAllOfItWhereThatIsShorter) {
  for (const double rate_hz : {24.0, 30.0, 60.0, 120.0, 1000.0}) {
    std::vector<double> time_s(50);
    for (std::size_t k = 0; k < time_s.size(); ++k)
      time_s[k] = static_cast<double>(k) / rate_hz;
    EXPECT_EQ(strideOf(time_s, 1e9), 49) << rate_hz;
    EXPECT_EQ(strideOf(time_s, 0.0), 1) << rate_hz;
    EXPECT_EQ(strideOf(time_s, 3.0 / rate_hz), 3) << rate_hz;
  }
}

}  // namespace
}  // namespace handgraft::manipulation
