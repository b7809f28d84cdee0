#include "core/retargeting/motion_solving.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "core/base/angle.h"
#include "core/base/error.h"
#include "core/geometry/surface_locator.h"
#include "core/optimize/diagnosis.h"
#include "core/retargeting/edited_motion.h"

namespace handgraft::retargeting {

namespace {

using manipulation::Motion;
using manipulation::MotionProblem;
using manipulation::PatchKey;
using manipulation::PatchTrack;

/// An outline about a recorded point, which stands for a region as large as a fingertip's.
contact::Patch diskAbout(const geometry::TriangleMesh& object_O,
                         const geometry::SurfaceLocator& locator,
                         const contact::Patch& point) {
  constexpr double kRadius = 0.005;  // m
  constexpr int kPoints = 12;
  contact::Patch disk = point;
  const Eigen::Vector3d p_O = positionOf(object_O, point.root);
  const Eigen::Vector3d n_O = normalOf(object_O, point.root);
  const Eigen::Vector3d x_O = n_O.unitOrthogonal();
  const Eigen::Vector3d y_O = n_O.cross(x_O);
  disk.interpolation_boundary.clear();
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kPoints;
    disk.interpolation_boundary.push_back(
        locator.nearest(p_O + kRadius * std::cos(angle) * x_O + kRadius * std::sin(angle) * y_O)
            .point);
  }
  return disk;
}

}  // namespace

MotionSolving motionSolving(bool causal) {
  MotionSolving solving;
  solving.causal = causal;
  if (!causal) return solving;
  solving.options.smoothness = manipulation::kCausalSmoothness;
  solving.options.fade.looks_ahead = false;
  return solving;
}

MotionProblem motionProblemOf(const session::Document& document,
                              const hand::Hand& hand,
                              const std::vector<double>& time_s,
                              const MotionSolving& solving) {
  MotionProblem problem = manipulation::makeMotionProblem(hand.model, time_s);
  for (std::size_t i = 0; i < document.joints.size(); ++i) {
    const session::DocumentJoint& joint = document.joints[i];
    const auto at = static_cast<Eigen::Index>(i);
    problem.lower[at] = joint.locked ? document.start.q[at] : joint.lower;
    problem.upper[at] = joint.locked ? document.start.q[at] : joint.upper;
  }
  problem.prior = document.prior.q;
  problem.weights = document.weights;
  problem.normal_form = document.solving.normal_form;
  if (solving.acceleration_limit > 0.0)
    problem.acceleration_limit.setConstant(solving.acceleration_limit);
  return problem;
}

std::vector<std::string> patchNames(const Motion& motion) {
  std::vector<std::string> names;
  std::set<std::string> known;
  for (const PatchTrack& track : motion.tracks)
    if (known.insert(track.name).second) names.push_back(track.name);
  return names;
}

bool isOfPoints(const Motion& motion) {
  return std::any_of(motion.tracks.begin(), motion.tracks.end(), [](const PatchTrack& track) {
    return std::any_of(track.keys.begin(), track.keys.end(), manipulation::isRecorded);
  });
}

contact::Patch patchOfGrasp(const PatchKey& key,
                            const geometry::TriangleMesh& object_O,
                            const geometry::SurfaceLocator& locator) {
  return isRecorded(key) ? diskAbout(object_O, locator, key.patch) : key.patch;
}

contact::ContactSet graspOf(const Motion& motion, const geometry::TriangleMesh& object_O) {
  contact::ContactSet grasp;
  grasp.name = motion.name;
  grasp.object = motion.object;
  grasp.side = motion.side;
  grasp.notes = motion.notes;
  const geometry::SurfaceLocator locator(object_O);
  std::set<std::string> known;
  for (const PatchTrack& track : motion.tracks) {
    if (!known.insert(track.name).second) continue;
    grasp.patches.push_back(patchOfGrasp(track.keys.front(), object_O, locator));
  }
  return grasp;
}

SolvedMotion solveMotion(const session::Document& document,
                         const hand::Hand& hand,
                         const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                         const Motion& motion,
                         MotionSolving solving,
                         int threads,
                         const Progress& progress) {
  EditedMotion edited(std::make_shared<const Motion>(motion), object_O);
  return *edited.solve(document, hand, solving, threads, progress);
}

MotionFits::MotionFits(const Motion& motion, const SolvedMotion& solved)
    : solved_(solved), frames_(solved.problem, solved.solving.options.fade) {
  const std::vector<std::string> names = patchNames(motion);
  for (const PatchTrack& track : motion.tracks) {
    patch_of_track_.push_back(
        static_cast<int>(std::find(names.begin(), names.end(), track.name) - names.begin()));
  }
}

std::vector<PatchFrameFit> MotionFits::at(int frame) const {
  const hand::HandPose& pose = solved_.trajectory.poses.at(static_cast<std::size_t>(frame));
  const optimize::PoseProblem single = frames_.at(frame, pose);
  const hand::LinkPoses X_OL = hand::forwardKinematics(*solved_.problem.model, pose);

  struct Normals {
    int count = 0;
    Eigen::Vector3d hand_O = Eigen::Vector3d::Zero();
    Eigen::Vector3d object_O = Eigen::Vector3d::Zero();
  };

  std::map<int, PatchFrameFit> fits;  // by the problem's track
  std::map<int, Normals> normals;     // likewise
  for (const manipulation::FrameProblems::Present& present : frames_.presentAt(frame)) {
    PatchFrameFit& fit = fits[present.track];
    fit.track = solved_.track_of[static_cast<std::size_t>(present.track)];
    fit.patch = patch_of_track_[static_cast<std::size_t>(fit.track)];
    fit.presence = present.presence;
  }
  for (const optimize::PointPair& pair : single.pairs) {
    if (pair.patch < 0) continue;  // a place that is held
    PatchFrameFit& fit = fits[pair.patch];
    if (pair.weight == 0.0) fit.presence = 0.0;  // it is switched off
    const Pose& X = X_OL[static_cast<std::size_t>(pair.link)];
    fit.mean_mm += 1e3 * (X * pair.p_L - pair.p_W).norm();
    ++fit.points;
    if (!pair.has_normals) continue;
    const Eigen::Vector3d n_O = X.linear() * pair.n_L;
    fit.normal_deg += inDegrees(angleBetween(n_O, -pair.n_W));
    Normals& sums = normals[pair.patch];
    ++sums.count;
    sums.hand_O += n_O;
    sums.object_O -= pair.n_W;
  }
  std::vector<PatchFrameFit> result;
  for (auto& [track, fit] : fits) {
    if (fit.points == 0) continue;
    fit.mean_mm /= fit.points;
    const Normals& sums = normals[track];
    if (sums.count > 0) fit.normal_deg /= sums.count;
    const double facing_deg = inDegrees(angleBetween(sums.hand_O, sums.object_O));
    fit.reached = optimize::isReached(fit.mean_mm, facing_deg);
    result.push_back(fit);
  }
  return result;
}

}  // namespace handgraft::retargeting
