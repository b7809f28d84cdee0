#include "core/placement/posture_finding.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "core/hand/finger_coordinates.h"
#include "core/hand/hand_location.h"
#include "core/hand/kinematics.h"
#include "core/hand/posture.h"
#include "core/hand/turned_parts.h"
#include "core/optimize/pose_solver.h"
#include "core/optimize/problem_options.h"

namespace handgraft::placement {

namespace {

using contact::PartDirection;
using Eigen::Vector3d;

constexpr double kPalmarWeight = 0.5;  // of a bone's
constexpr double kPalmWeight = 3.0;    // it carries all others

// A radian off the relaxed posture, of the bones' |difference|^2: chooses where they do not.
constexpr double kRelaxing = 0.01;

// A hand that can stand as the demonstrator's did is held to it more, as the fourth power of
// how near it comes: a hand's own grasp comes back, and others are as free as their build asks
// for.
constexpr double kUsualMisfit = 0.17;  // rad: a human hand of other proportions
constexpr double kMostSure = 64.0;

constexpr int kPostureStarts = 3;  // as good as eight
constexpr int kPostureEvaluations = 100;
constexpr double kLeastPromised = 1e-6;  // from one posture to the next: some 0.01 deg

/// Two directions that are to be one.
void align(int link,
           const Vector3d& d_L,
           const Vector3d& d_O,
           double weight,
           optimize::PoseProblem& problem) {
  if (!(d_L.norm() > 0.5) || !(d_O.norm() > 0.5)) return;
  optimize::PointPair pair;
  pair.link = link;
  pair.n_L = d_L.normalized();
  pair.n_W = -d_O.normalized();
  pair.weight = weight;
  problem.pairs.push_back(pair);
}

/// The angle that directions are off in `pose`, root mean square; rad.
double misfitOf(const optimize::PoseProblem& problem, const hand::HandPose& pose) {
  hand::LinkPoses X_WL;
  forwardKinematics(*problem.model, pose.X_WH, pose.q, X_WL);
  double sum = 0.0;
  for (const optimize::PointPair& pair : problem.pairs) {
    const Vector3d is_W = X_WL[static_cast<std::size_t>(pair.link)].linear() * pair.n_L;
    const double angle = std::atan2(is_W.cross(pair.n_W).norm(), -is_W.dot(pair.n_W));
    sum += angle * angle;
  }
  return std::sqrt(sum / static_cast<double>(problem.pairs.size()));
}

/// Directions alone: the root's place plays no part. Joints that they leave open stay near
/// `relaxed`.
optimize::PoseProblem postureProblem(const hand::Hand& hand,
                                     const std::vector<PartDirection>& posture,
                                     const Eigen::VectorXd& relaxed) {
  hand::LinkPoses X_SL;
  forwardKinematics(*hand.model, Pose::Identity(), hand.skin->qReference(), X_SL);
  std::map<std::string, hand::TurnedPart> parts;
  for (hand::TurnedPart& part : turnedParts(hand::coordinatesOf(hand)->anatomy()))
    parts[part.name] = std::move(part);
  optimize::PoseProblem problem = optimize::makeProblem(hand.model);
  problem.weights = {0.0, 1.0, kRelaxing};
  problem.normal_form = optimize::NormalForm::kSum;
  problem.start.q = relaxed;
  problem.prior.q = relaxed;
  problem.prior_weights = Eigen::VectorXd::Ones(problem.dofCount());
  problem.prior_weights.head<6>().setZero();
  for (int i = 3; i < 6; ++i)
    optimize::lock(i, problem);
  for (const PartDirection& was : posture) {
    const auto part = parts.find(was.part);
    if (part == parts.end()) continue;
    const double weight = was.part == hand::kPalmPart ? kPalmWeight : 1.0;
    const int link = part->second.link;
    const Eigen::Matrix3d R_LS = X_SL[static_cast<std::size_t>(link)].linear().transpose();
    align(link, R_LS * part->second.outward_S, was.outward_O, weight, problem);
    align(link, R_LS * part->second.palmar_S, was.palmar_O, kPalmarWeight * weight, problem);
  }
  return problem;
}

Eigen::VectorXd relaxedJoints(const hand::Hand& hand) {
  return hand::relaxedPosture(*hand.model, hand.skin->qReference());
}

}  // namespace

Posture postureFor(const hand::Hand& hand, const contact::ContactSet& contacts) {
  Posture posture;
  posture.q = relaxedJoints(hand);
  if (contacts.posture.empty()) return posture;
  const optimize::PoseProblem problem = postureProblem(hand, contacts.posture, posture.q);
  // Fewer leave the hand free to turn.
  if (problem.pairs.size() < 2) return posture;
  optimize::SolveOptions options;
  options.starts = kPostureStarts;
  options.max_evaluations = kPostureEvaluations;
  const optimize::SolveReport report =
      optimize::PoseSolver(problem).search(options, Progress());
  posture.q = report.pose.q;
  posture.R_OH = report.pose.X_WH.linear();
  const double fit = kUsualMisfit / std::max(misfitOf(problem, report.pose), 1e-6);
  posture.sureness = std::clamp(std::pow(fit, 4.0), 1.0, kMostSure);
  return posture;
}

Eigen::VectorXd jointsLike(const hand::Hand& hand,
                           const std::vector<PartDirection>& posture,
                           const Eigen::Matrix3d& R_OH,
                           const Eigen::VectorXd& start) {
  optimize::PoseProblem problem = postureProblem(hand, posture, relaxedJoints(hand));
  problem.start.X_WH.linear() = R_OH;
  problem.start.q = start.cwiseMax(problem.lower).cwiseMin(problem.upper);
  for (int i = 0; i < 3; ++i)
    optimize::lock(i, problem);
  optimize::SolveOptions options;
  options.starts = 1;
  options.max_evaluations = kPostureEvaluations;
  options.least_promise = kLeastPromised;
  return optimize::PoseSolver(problem).search(options, Progress()).pose.q;
}

}  // namespace handgraft::placement
