#include "tests/bench/motions/human_motions.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/demonstration/posed_hand_motion.h"
#include "core/hand/skin_cache.h"
#include "core/io/mesh_file.h"
#include "core/io/motion_import.h"
#include "core/optimize/diagnosis.h"
#include "core/optimize/solve_report.h"
#include "core/placement/solids.h"
#include "core/retargeting/motion_grasps.h"
#include "core/retargeting/motion_layer.h"
#include "core/retargeting/motion_places.h"
#include "core/retargeting/motion_solving.h"
#include "core/session/session.h"

#include "tests/bench/chain_pair.h"
#include "tests/bench/hand_import.h"
#include "tests/bench/motions/live_grasps.h"
#include "tests/bench/motions/live_motions.h"
#include "tests/bench/motions/mjcf_hand.h"
#include "tests/bench/retargeting/fingertips.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

namespace fs = std::filesystem;
using Poses = std::vector<hand::HandPose>;

/// A recorded human hand about an object.
struct HumanSequence {
  std::string name;
  std::shared_ptr<const geometry::TriangleMesh> object_O;
  std::vector<demonstration::PosedFrame> frames;
  manipulation::Motion motion;
};

struct RecordedHuman {
  const char* name;
  const char* object;
};

constexpr RecordedHuman kRecorded[] = {{"apple_pass_1", "apple"},
                                       {"waterbottle_pour_1", "waterbottle"}};

fs::path handSplines(const fs::path& folder, const std::string& name) {
  return folder / "trajectories" / ("MANO_" + name + "_hand.smexp");
}

/// Hinges of ball joints, R = Rx Ry Rz, of what splines give as R = Rz Ry Rx.
Eigen::VectorXd hingesOf(const Eigen::VectorXd& spline) {
  Eigen::VectorXd q(spline.size() - 6);
  for (Eigen::Index i = 0; i < q.size(); i += 3) {
    const Eigen::Vector3d angles = spline.segment<3>(6 + i);
    const Eigen::Matrix3d R = (Eigen::AngleAxisd(angles.z(), Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(angles.y(), Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(angles.x(), Eigen::Vector3d::UnitX()))
                                  .toRotationMatrix();
    q[i] = std::atan2(-R(1, 2), R(2, 2));
    q[i + 1] = std::asin(std::clamp(R(0, 2), -1.0, 1.0));
    q[i + 2] = std::atan2(-R(0, 1), R(0, 0));
  }
  return q;
}

/// Of all that is recorded, and rest.
Eigen::Matrix2Xd rangesRecorded(const fs::path& folder) {
  constexpr int kLooked = 200;
  Eigen::Matrix2Xd ranges(2, 0);
  for (const RecordedHuman& one : kRecorded) {
    const io::SplineTrajectory splines =
        io::readSplineTrajectory(handSplines(folder, one.name));
    for (int i = 0; i <= kLooked; ++i) {
      const Eigen::VectorXd q = hingesOf(splines.at(static_cast<double>(i) / kLooked));
      if (ranges.cols() == 0) ranges = Eigen::Matrix2Xd::Zero(2, q.size());
      ranges.row(0) = ranges.row(0).cwiseMin(q.transpose());
      ranges.row(1) = ranges.row(1).cwiseMax(q.transpose());
    }
  }
  return ranges;
}

hand::Hand readHuman(const fs::path& folder, const fs::path& cache) {
  hand::Hand hand;
  hand.model = std::make_shared<const hand::HandModel>(
      readManoMjcf(folder / "hands", rangesRecorded(folder)));
  hand.skin = std::make_shared<const hand::Skin>(
      hand::SkinCache(cache).get(*hand.model, hand::SkinOptions(), Progress()));
  hand.sites = findContactSites(*hand.model, *hand.skin);
  hand.sites_are_found = true;
  return hand;
}

/// How far the recording's own points are off where its splines put them, mm.
double recordedResidual(const fs::path& folder,
                        const hand::Hand& human,
                        const HumanSequence& sequence) {
  const manipulation::Motion points =
      io::readContactSequence(folder / ("MANO_" + sequence.name + ".json"), *sequence.object_O,
                              folder / "trajectories" / (sequence.name + "_object.smexp"));
  double sum = 0.0;
  double count = 0.0;
  for (const manipulation::PatchTrack& track : points.tracks) {
    for (int k = track.begin(); k < track.end; ++k) {
      const demonstration::PosedFrame& frame = sequence.frames[static_cast<std::size_t>(k)];
      const hand::LinkPoses X_WL = hand::forwardKinematics(*human.model, frame.pose);
      const manipulation::PatchKey& key = track.keyAt(k);
      for (std::size_t i = 0; i < key.hand_points.size(); ++i) {
        const auto link =
            static_cast<std::size_t>(human.model->linkIndex(key.hand_points[i].link));
        const Eigen::Vector3d p_O = inverse(frame.X_WO) * (X_WL[link] * key.hand_points[i].p_L);
        sum +=
            1e3 *
            (p_O - positionOf(*sequence.object_O, key.patch.interpolation_boundary[i])).norm();
        count += 1.0;
      }
    }
  }
  return sum / std::max(count, 1.0);
}

HumanSequence readSequence(const fs::path& data,
                           const hand::Hand& human,
                           const std::string& name,
                           const std::string& object) {
  const fs::path folder = data / "contacts/grab_sequences";
  HumanSequence sequence;
  sequence.name = name;
  sequence.object_O = std::make_shared<const geometry::TriangleMesh>(
      io::readMesh(data / "objects/grab" / (object + ".obj")).mesh);
  const io::SplineTrajectory of_hand = io::readSplineTrajectory(handSplines(folder, name));
  const io::SplineTrajectory of_object =
      io::readSplineTrajectory(folder / "trajectories" / (name + "_object.smexp"));
  const manipulation::Motion points =
      io::readContactSequence(folder / ("MANO_" + name + ".json"), *sequence.object_O,
                              folder / "trajectories" / (name + "_object.smexp"));
  const int last = points.frameCount() - 1;
  for (int k = 0; k <= last; ++k) {
    const Eigen::VectorXd x = of_hand.at(static_cast<double>(k) / last);
    demonstration::PosedFrame frame;
    frame.time_s = points.time_s[static_cast<std::size_t>(k)];
    frame.X_WO = points.X_WO[static_cast<std::size_t>(k)];
    frame.pose.X_WH = io::poseFromSpline(x);
    frame.pose.q = hingesOf(x);  // in the order of the bodies
    HANDGRAFT_REQUIRE(frame.pose.q.size() == human.model->dofCount());
    sequence.frames.push_back(std::move(frame));
  }
  sequence.motion = demonstration::motionOfPosedHand(human, sequence.frames, *sequence.object_O,
                                                     {}, Progress());
  sequence.motion.name = name;
  std::size_t cuts = 0;
  for (const manipulation::PatchTrack& track : sequence.motion.tracks)
    cuts += track.keys.size();
  std::printf(
      "%s: %d frames, %zu areas from begin to end, cut %zu times; the recording's own "
      "points are %.1f mm off\n",
      name.c_str(), last + 1, sequence.motion.tracks.size(), cuts,
      recordedResidual(folder, human, sequence));
  for (const std::string& note : sequence.motion.notes)
    std::printf("%s: %s\n", name.c_str(), note.c_str());
  return sequence;
}

/// Between the mean normals of both sides of a patch, mean over the points of all patches that
/// are there, as `retargeting` measures single grasps, deg.
double facingOf(const manipulation::MotionProblem& problem, const Poses& poses) {
  const manipulation::FrameProblems frames(problem, {0.0, true});
  double sum = 0.0;
  double points = 0.0;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const optimize::PoseProblem single = frames.at(static_cast<int>(k), poses[k]);
    if (single.pairs.empty()) continue;
    optimize::SolveReport report;
    report.pose = poses[k];
    report.patches = optimize::fitPatches(single, poses[k]);
    const std::vector<double> facing = optimize::facingAngles(single, report);
    for (std::size_t i = 0; i < facing.size(); ++i) {
      sum += report.patches[i].point_count * facing[i];
      points += report.patches[i].point_count;
    }
  }
  return sum / std::max(points, 1.0);
}

void printRow(const HumanSequence& sequence,
              const hand::Hand& hand,
              const manipulation::MotionProblem& problem,
              const std::string& way,
              const Poses& poses,
              double ms) {
  const manipulation::FrameFit fit =
      manipulation::meanFit(manipulation::fitFrames(problem, poses));
  const manipulation::Smoothness smoothness = manipulation::measureSmoothness(problem, poses);
  double deepest = 0.0;
  int past = 0;
  for (const hand::HandPose& pose : poses) {
    const double depth =
        placement::deepestOf(hand.model, hand.skin, sequence.object_O, pose, Progress());
    deepest = std::max(deepest, depth);
    past += depth > 2e-3 ? 1 : 0;
  }
  std::printf("| %s | %s | %s | %.2f | %.1f | %.2f | %d | %.0f | %.3f | %.2f |\n",
              sequence.name.c_str(), hand.model->name().c_str(), way.c_str(), fit.mean_mm,
              facingOf(problem, poses), 1e3 * deepest, past, smoothness.rms_jerk,
              smoothness.max_step, ms);
  std::fflush(stdout);
}

/// The problem with patches slid on the hand to where `poses` show them, as ours were to where
/// our poses do.
manipulation::MotionProblem shownBy(const Poses& poses,
                                    const HumanSequence& sequence,
                                    const session::Document& document,
                                    const hand::Hand& hand,
                                    manipulation::MotionProblem problem) {
  constexpr int kSlides = 8;
  manipulation::Motion motion = sequence.motion;
  const retargeting::MotionPlaces places(document, hand, *sequence.object_O, motion);
  places.deal(motion);
  for (int i = 0; i < kSlides && places.slide(poses, motion); ++i) {
  }
  const retargeting::MotionLayer layer(document, hand, *sequence.object_O, motion);
  problem.tracks = layer.lay(motion, Progress()).tracks;
  return problem;
}

/// Poses in O, each from the one before.
template <class Solve>
Poses fromFrameToFrame(const HumanSequence& sequence,
                       const hand::Hand& human,
                       const Fingertips& fingertips,
                       const Solve& solve) {
  Poses poses;
  for (const demonstration::PosedFrame& frame : sequence.frames) {
    hand::HandPose pose_O = frame.pose;
    pose_O.X_WH = inverse(frame.X_WO) * frame.pose.X_WH;
    poses.push_back(solve(posed(*human.model, fingertips, pose_O),
                          poses.empty() ? nullptr : &poses.back()));
  }
  return poses;
}

void follow(const HumanSequence& sequence,
            const hand::Hand& human,
            const Fingertips& human_tips,
            const hand::Hand& hand,
            bool with_baselines) {
  const session::Session session(
      retargeting::modelsOfMotion(hand, sequence.object_O, sequence.motion), Pose::Identity(),
      {});
  const double count = sequence.motion.frameCount();
  const double begin = threadMilliseconds();
  const retargeting::SolvedMotion solved =
      retargeting::solveMotion(session.document(), hand, sequence.object_O, sequence.motion,
                               retargeting::motionSolving(false), 1, Progress());
  const double ms = (threadMilliseconds() - begin) / count;
  for (const std::string& note : solved.notes)
    std::printf("%s: %s\n", hand.model->name().c_str(), note.c_str());
  printRow(sequence, hand, solved.problem, "contacts", solved.trajectory.poses, ms);
  if (!with_baselines) return;
  const Fingertips tips = fingertipsOf(hand);
  const auto baseline = [&](const std::string& way, const auto& solve) {
    const double before = threadMilliseconds();
    const Poses poses = fromFrameToFrame(sequence, human, human_tips, solve);
    const double ms_frame = (threadMilliseconds() - before) / count;
    printRow(sequence, hand, solved.problem, way, poses, ms_frame);
    printRow(sequence, hand, shownBy(poses, sequence, session.document(), hand, solved.problem),
             way + ", places as it shows them", poses, ms_frame);
  };
  baseline("fingertips", [&](const FingertipPose& target, const hand::HandPose* before) {
    return fingertipKinematics(hand, tips, target, before);
  });
  baseline("DexPilot", [&](const FingertipPose& target, const hand::HandPose* before) {
    return dexPilot(hand, tips, target, before);
  });
}

std::vector<fs::path> usualHands(const fs::path& data,
                                 const fs::path& library,
                                 HumanWays ways) {
  std::vector<fs::path> urdfs = {data / "hands/allegro_right/allegro_hand_right.urdf",
                                 data / "hands/shadow_right/shadow_hand_right.urdf"};
  if (ways == HumanWays::kLive)
    for (const char* urdf : {"hands/barrett_bhand/bhand_model.urdf",
                             "hands/human_hand_graspit20/human_hand_graspit20.urdf",
                             "hands/mia_hand_right/mia_hand_description/urdf/mia_hand.urdf"})
      urdfs.push_back(data / urdf);
  if (!library.empty()) urdfs.push_back(library / "hands/human20/human20.urdf");
  return urdfs;
}

}  // namespace

void runHumanMotions(const fs::path& data,
                     const fs::path& library,
                     const fs::path& cache,
                     HumanWays ways,
                     const fs::path& folder,
                     const fs::path& pictures) {
  const hand::Hand human = readHuman(data / "contacts/grab_sequences", cache);
  const Fingertips tips = fingertipsOf(human);
  std::vector<hand::Hand> hands;
  for (const fs::path& urdf :
       folder.empty() ? usualHands(data, library, ways) : urdfsIn({folder.string()}))
    hands.push_back(readHand(urdf, cache));
  std::vector<HumanSequence> sequences;
  for (const RecordedHuman& one : kRecorded)
    sequences.push_back(readSequence(data, human, one.name, one.object));
  if (ways != HumanWays::kLive) {
    std::printf(
        "| sequence | hand | way | mean mm | normals deg | deepest mm | frames past 2 mm | "
        "jerk | largest step rad | ms a frame |\n|---|---|---|---|---|---|---|---|---|---|\n");
    for (const HumanSequence& sequence : sequences)
      for (const hand::Hand& hand : hands)
        follow(sequence, human, tips, hand, ways == HumanWays::kAll);
  }
  printLiveHeading();
  for (const HumanSequence& sequence : sequences)
    for (const hand::Hand& hand : hands) {
      LiveFigures figures;
      followLive(retargeting::graspOf(sequence.motion, *sequence.object_O), sequence.frames,
                 sequence.object_O, human, hand, figures);
      printLiveRow(sequence.name, hand, figures);
    }
  if (ways == HumanWays::kLive) runLiveGrasps(data, cache, hands, pictures);
}

}  // namespace handgraft::bench
