// Fewer frames of a motion: what they are of the whole, and the way back.
#include "core/manipulation/thinned_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace handgraft::manipulation {
namespace {

using testing::ElementsAre;

constexpr int kFrames = 14;

/// `a` all the time, with keys at 0, 4, 5 and 9; `b` in frames 7 and 8 alone.
Motion twoTracks() {
  Motion motion;
  motion.name = "two";
  for (int k = 0; k < kFrames; ++k) {
    motion.time_s.push_back(0.01 * k);
    motion.X_WO.push_back(Pose::Identity());
    motion.X_WO.back().translation().x() = k;
  }
  const auto track_of = [](const char* name, std::vector<int> frames, int end) {
    PatchTrack track;
    track.name = name;
    track.end = end;
    for (const int frame : frames) {
      track.keys.emplace_back();
      track.keys.back().frame = frame;
    }
    return track;
  };
  motion.tracks = {track_of("a", {0, 4, 5, 9}, kFrames), track_of("b", {7}, 9)};
  return motion;
}

transfer::PatchPlacement placedAt(int face) {
  transfer::PatchPlacement placement;
  placement.root_S.face = face;
  return placement;
}

std::vector<int> framesOf(const PatchTrack& track) {
  std::vector<int> frames;
  for (const PatchKey& key : track.keys)
    frames.push_back(key.frame);
  return frames;
}

TEST(ThinnedMotion, HasEachNthFrameWhatAppearsAndTheLast) {
  const ThinnedMotion thin = thinned(twoTracks(), 6);
  EXPECT_THAT(thin.frames, ElementsAre(0, 6, 7, 12, 13));
  EXPECT_EQ(thin.motion.frameCount(), 5);
  EXPECT_EQ(thin.motion.time_s[3], 0.12);
  EXPECT_EQ(thin.motion.X_WO[3].translation().x(), 12.0);
  ASSERT_EQ(thin.motion.tracks.size(), 2u);
  // Of the keys at 4 and 5 the latter holds at frame 6.
  EXPECT_THAT(framesOf(thin.motion.tracks[0]), ElementsAre(0, 1, 3));
  EXPECT_THAT(thin.keys[0], ElementsAre(0, 2, 3));
  EXPECT_EQ(thin.motion.tracks[0].end, 5);
  EXPECT_THAT(framesOf(thin.motion.tracks[1]), ElementsAre(2));
  EXPECT_EQ(thin.motion.tracks[1].end, 3);
}

TEST(ThinnedMotion, HasTheDemonstratorWhereItsFramesAre) {
  Motion motion = twoTracks();
  for (const int frame : {0, 4, 5, 9}) {
    motion.demonstrator.emplace_back().frame = frame;
    motion.demonstrator.back().X_OD.translation().x() = frame;
  }
  const ThinnedMotion thin = thinned(motion, 6);
  std::vector<int> frames;
  for (const DemonstratorKey& key : thin.motion.demonstrator)
    frames.push_back(key.frame);
  EXPECT_THAT(frames, ElementsAre(0, 1, 3));
  // Of the keys at 4 and 5 the latter is nearer to frame 6.
  EXPECT_EQ(thin.motion.demonstrator[1].X_OD.translation().x(), 5.0);
}

TEST(ThinnedMotion, OfEachFrameIsTheWhole) {
  const Motion motion = twoTracks();
  const ThinnedMotion thin = thinned(motion, 1);
  EXPECT_EQ(thin.motion.time_s, motion.time_s);
  EXPECT_TRUE(thin.hasAllKeys(motion));
  for (std::size_t t = 0; t < 2; ++t) {
    EXPECT_EQ(framesOf(thin.motion.tracks[t]), framesOf(motion.tracks[t]));
    EXPECT_EQ(thin.motion.tracks[t].end, motion.tracks[t].end);
  }
  EXPECT_FALSE(thinned(motion, 6).hasAllKeys(motion));
}

TEST(ThinnedMotion, OneFrameIsOneFrame) {
  Motion motion = twoTracks();
  motion.time_s.resize(1);
  motion.X_WO.resize(1);
  motion.tracks.resize(1);
  motion.tracks[0].keys.resize(1);
  motion.tracks[0].end = 1;
  const ThinnedMotion thin = thinned(motion, 6);
  EXPECT_THAT(thin.frames, ElementsAre(0));
  EXPECT_EQ(posesBetween(thin, {hand::HandPose()}, motion).size(), 1u);
}

TEST(ThinnedMotion, KeysThatWereLeftOutLieWhereTheNearestDoes) {
  Motion motion = twoTracks();
  ThinnedMotion thin = thinned(motion, 6);
  for (std::size_t i = 0; i < 3; ++i)
    thin.motion.tracks[0].keys[i].placement = placedAt(10 + static_cast<int>(i));
  motion.tracks[1].keys[0].placement = placedAt(3);
  takePlacements(thin, motion);
  std::vector<int> faces;
  for (const PatchKey& key : motion.tracks[0].keys)
    faces.push_back(key.placement->root_S.face);
  EXPECT_THAT(faces, ElementsAre(10, 11, 11, 12));
  EXPECT_EQ(motion.tracks[1].keys[0].placement->root_S.face, 3)
      << "it has none there: it stays";
}

TEST(ThinnedMotion, PosesBetweenGoByEvenSteps) {
  const Motion motion = twoTracks();
  const ThinnedMotion thin = thinned(motion, 6);
  std::vector<hand::HandPose> poses;
  for (const int frame : thin.frames) {
    hand::HandPose pose;
    pose.q = Eigen::VectorXd::Constant(1, 0.1 * frame);
    pose.X_WH.linear() = rotationFromVector({0.0, 0.0, 0.05 * frame});
    pose.X_WH.translation().x() = frame;
    poses.push_back(pose);
  }
  const std::vector<hand::HandPose> all = posesBetween(thin, poses, motion);
  ASSERT_EQ(all.size(), static_cast<std::size_t>(kFrames));
  for (int k = 0; k < kFrames; ++k) {
    const hand::HandPose& pose = all[static_cast<std::size_t>(k)];
    EXPECT_NEAR(pose.q[0], 0.1 * k, 1e-12);
    EXPECT_NEAR(pose.X_WH.translation().x(), k, 1e-12);
    EXPECT_NEAR(vectorFromRotation(pose.X_WH.linear()).z(), 0.05 * k, 1e-12);
  }
}

}  // namespace
}  // namespace handgraft::manipulation
