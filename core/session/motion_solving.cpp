#include "core/session/motion_solving.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <thread>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/surface_locator.h"
#include "core/hand/finger_coordinates.h"
#include "core/manipulation/causal_solver.h"
#include "core/manipulation/lay_patches.h"
#include "core/manipulation/lay_points.h"
#include "core/manipulation/offline_solver.h"
#include "core/optimize/diagnosis.h"
#include "core/session/solids.h"

namespace handgraft::session {

namespace {

using manipulation::LaidMotion;
using manipulation::Motion;
using manipulation::MotionProblem;
using manipulation::PatchKey;
using manipulation::PatchTrack;

/// An outline about a recorded point, which stands for a region as large as a fingertip's.
contact::Patch diskAbout(const geometry::TriangleMesh& object_O,
                         const geometry::SurfaceLocator& locator,
                         const contact::Patch& point) {
  constexpr double kRadius_m = 0.005;
  constexpr int kPoints = 12;
  contact::Patch disk = point;
  const Eigen::Vector3d p_O = positionOf(object_O, point.root);
  const Eigen::Vector3d n_O = normalOf(object_O, point.root);
  const Eigen::Vector3d x_O = n_O.unitOrthogonal();
  const Eigen::Vector3d y_O = n_O.cross(x_O);
  disk.interpolation_boundary.clear();
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kPoints;
    disk.interpolation_boundary.push_back(locator
                                              .nearest(p_O + kRadius_m * std::cos(angle) * x_O +
                                                       kRadius_m * std::sin(angle) * y_O)
                                              .point);
  }
  return disk;
}

bool isRecorded(const PatchKey& key) {
  return key.patch.interpolation_boundary.size() <
         static_cast<std::size_t>(contact::kFewestInterpolationPoints);
}

/// Every point of the motion says where it lies on links that this hand has.
bool liesOnLinksOf(const hand::HandModel& model, const Motion& motion) {
  for (const PatchTrack& track : motion.tracks)
    for (const PatchKey& key : track.keys)
      for (const manipulation::HandPoint& point : key.hand_points)
        if (model.maybeLinkIndex(point.link)) return true;
  return false;
}

LaidMotion laidOnHand(const Document& document,
                      const Hand& hand,
                      const geometry::TriangleMesh& object_O,
                      const Motion& motion,
                      const Progress& progress) {
  LaidMotion laid;
  if (liesOnLinksOf(*hand.model, motion)) {
    laid.tracks = layPoints(motion, object_O, *hand.model);
    for (std::size_t t = 0; t < motion.tracks.size(); ++t) {
      const auto& keys = motion.tracks[t].keys;
      const bool is_laid = std::any_of(keys.begin(), keys.end(), [&](const PatchKey& key) {
        return std::any_of(key.hand_points.begin(), key.hand_points.end(),
                           [&](const manipulation::HandPoint& point) {
                             return hand.model->maybeLinkIndex(point.link).has_value();
                           });
      });
      if (is_laid) laid.track_of.push_back(static_cast<int>(t));
    }
    HANDGRAFT_REQUIRE(laid.track_of.size() == laid.tracks.size());
    return laid;
  }
  const hand::FingerCoordinates coordinates(*hand.model, *hand.skin, hand.sites);
  const bool has_points =
      std::any_of(motion.tracks.begin(), motion.tracks.end(), [](const PatchTrack& track) {
        return isRecorded(track.keys.front());
      });
  if (has_points) {
    return layPointsByPlace(motion, object_O, *hand.model, *hand.skin, coordinates, progress);
  }
  return layPatches(motion, transfer::borrowedSurfaces(object_O, *hand.skin), *hand.model,
                    hand.sites, coordinates, document.transfer, progress);
}

/// The document's switches and weights, which it has by the patches' names.
void weigh(const Document& document,
           const Motion& motion,
           const contact::ContactSet& grasp,
           const std::vector<int>& track_of,
           std::vector<manipulation::PairTrack>& tracks) {
  const std::vector<std::string> names = patchNames(motion);
  std::map<std::string, double> factors;
  for (std::size_t i = 0; i < names.size() && i < document.patches.size(); ++i) {
    const double own = grasp.patches[i].weight;
    const double given = document.patches[i].effectiveWeight();
    factors[names[i]] = own > 0.0 ? given / own : given;
  }
  bool any = false;
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    const auto found = factors.find(motion.tracks[static_cast<std::size_t>(track_of[t])].name);
    const double factor = found == factors.end() ? 1.0 : found->second;
    any = any || factor > 0.0;
    if (factor == 1.0) continue;
    for (manipulation::PairSpan& span : tracks[t].spans)
      for (optimize::PointPair& pair : span.pairs)
        pair.weight *= factor;
  }
  if (!any) rejectInput("all patches of motion {} are switched off", quoted(motion.name));
}

/// Frames are independent: each thread takes every so-manyth.
std::vector<double> depthsOf(const SolvedMotion& solved,
                             const Hand& hand,
                             const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                             int threads,
                             const Progress& progress) {
  const std::vector<hand::HandPose>& poses = solved.trajectory.poses;
  std::vector<double> depths(poses.size(), 0.0);
  makeSolids(hand, object_O, progress);
  const auto step = static_cast<std::size_t>(std::max(1, threads));
  std::vector<std::exception_ptr> errors(step);
  const auto measure = [&](std::size_t first) {
    try {
      for (std::size_t k = first; k < poses.size(); k += step) {
        progress.checkpoint();
        if (first == 0) {
          progress.report("measuring depths",
                          static_cast<double>(k) / static_cast<double>(poses.size()));
        }
        depths[k] = penetrationOf(hand.model, hand.skin, object_O, Pose::Identity(), poses[k],
                                  {}, Progress())
                        .max_depth_m;
      }
    } catch (...) {
      errors[first] = std::current_exception();
    }
  };
  std::vector<std::thread> others;
  for (std::size_t i = 1; i < step; ++i)
    others.emplace_back(measure, i);
  measure(0);
  for (std::thread& other : others)
    other.join();
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
  return depths;
}

double inDegrees(double rad) {
  return rad * 180.0 / std::numbers::pi;
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

MotionProblem motionProblemOf(const Document& document,
                              const Hand& hand,
                              const std::vector<double>& time_s,
                              const MotionSolving& solving) {
  MotionProblem problem = manipulation::makeMotionProblem(hand.model, time_s);
  for (std::size_t i = 0; i < document.joints.size(); ++i) {
    const DocumentJoint& joint = document.joints[i];
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

contact::ContactSet graspOf(const Motion& motion, const geometry::TriangleMesh& object_O) {
  contact::ContactSet grasp;
  grasp.name = motion.name;
  grasp.object = motion.object;
  grasp.notes = motion.notes;
  const geometry::SurfaceLocator locator(object_O);
  std::set<std::string> known;
  std::map<std::string, int> counts;
  for (const PatchTrack& track : motion.tracks) {
    if (!known.insert(track.name).second) continue;
    const PatchKey& key = track.keys.front();
    contact::Patch patch =
        isRecorded(key) ? diskAbout(object_O, locator, key.patch) : key.patch;
    if (isRecorded(key)) {
      patch.name = patch.place ? hand::partName(patch.place->digit, patch.place->segment)
                               : fmt::format("c{}", grasp.patches.size() + 1);
      if (const int count = ++counts[patch.name]; count > 1)
        patch.name += fmt::format("_{}", count);
    }
    grasp.patches.push_back(std::move(patch));
  }
  return grasp;
}

SolvedMotion solveMotion(const Document& document,
                         const Hand& hand,
                         const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                         const Motion& motion,
                         MotionSolving solving,
                         int threads,
                         const Progress& progress) {
  SolvedMotion solved;
  solving.options.threads = threads;
  solved.problem = motionProblemOf(document, hand, motion.time_s, solving);
  LaidMotion laid = laidOnHand(document, hand, *object_O, motion, progress);
  weigh(document, motion, graspOf(motion, *object_O), laid.track_of, laid.tracks);
  solved.problem.tracks = std::move(laid.tracks);
  solved.track_of = std::move(laid.track_of);
  solved.notes = remarksOn(motion);
  solved.notes.insert(solved.notes.end(), laid.notes.begin(), laid.notes.end());
  if (document.solving.avoids()) {
    solved.problem.avoidance =
        avoidanceOf(hand.model, hand.skin, object_O, Pose::Identity(), progress);
  }
  solved.trajectory =
      solving.causal ? manipulation::solveCausal(solved.problem, solving.options, progress)
                     : manipulation::solveOffline(solved.problem, solving.options, progress);
  solved.notes.insert(solved.notes.end(), solved.trajectory.notes.begin(),
                      solved.trajectory.notes.end());
  solved.solving = solving;
  solved.depth_m = depthsOf(solved, hand, object_O, threads, progress);
  return solved;
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
  std::map<int, PatchFrameFit> fits;  // by the problem's track
  std::map<int, int> normals;
  for (const manipulation::FrameProblems::Present& present : frames_.presentAt(frame)) {
    PatchFrameFit& fit = fits[present.track];
    fit.track = solved_.track_of[static_cast<std::size_t>(present.track)];
    fit.patch = patch_of_track_[static_cast<std::size_t>(fit.track)];
    fit.presence = present.presence;
  }
  for (const optimize::PointPair& pair : single.pairs) {
    PatchFrameFit& fit = fits[pair.patch];
    const Pose& X = X_OL[static_cast<std::size_t>(pair.link)];
    fit.mean_mm += 1e3 * (X * pair.p_L - pair.p_W).norm();
    ++fit.points;
    if (!pair.has_normals) continue;
    const double cosine = -(X.linear() * pair.n_L).dot(pair.n_W);
    fit.normal_deg += inDegrees(std::acos(std::clamp(cosine, -1.0, 1.0)));
    ++normals[pair.patch];
  }
  const optimize::DiagnosisOptions reached;
  std::vector<PatchFrameFit> result;
  for (auto& [track, fit] : fits) {
    if (fit.points == 0) continue;
    fit.mean_mm /= fit.points;
    if (normals[track] > 0) fit.normal_deg /= normals[track];
    fit.reached = fit.mean_mm <= reached.reached_mm && fit.normal_deg <= reached.facing_deg;
    result.push_back(fit);
  }
  return result;
}

}  // namespace handgraft::session
