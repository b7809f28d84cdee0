#include "core/placement/hand_pose_guess.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Eigenvalues>

#include "core/base/error.h"
#include "core/geometry/tangent.h"
#include "core/optimize/objective.h"
#include "core/optimize/solver.h"

namespace handgraft::placement {
namespace {

using optimize::PointPair;
using optimize::PoseProblem;

constexpr double kDirectionArm = 0.01;  // m: how far along a direction its second pair sits
constexpr double kJointPrior = 1e-2;    // a joint at 1 rad from rest weighs as 1 mm of distance
constexpr double kDepthWeight = 5e4;    // 1/m^2, a pair: see DECISIONS
constexpr int kMostSamples = 200;       // of the skin
constexpr int kEvaluations = 150;       // a start: the pose need not be sharp

Pose turnedAbout(const Eigen::Vector3d& centre, const Eigen::Vector3d& axis, double angle) {
  Pose X = Pose::Identity();
  X.linear() = rotationFromVector(angle * axis);
  X.translation() = centre - X.linear() * centre;
  return X;
}

/// The direction along which the anchors' roots spread most: turning about it changes their
/// distances least, so the start from every side is worth a try.
std::pair<Eigen::Vector3d, Eigen::Vector3d> mainAxis(const PoseProblem& problem) {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const PointPair& pair : problem.pairs)
    centre += pair.p_W;
  centre /= static_cast<double>(problem.pairs.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const PointPair& pair : problem.pairs) {
    spread += (pair.p_W - centre) * (pair.p_W - centre).transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  return {centre, axes.eigenvectors().col(2).normalized()};
}

}  // namespace

Eigen::VectorXd curledPose(const hand::HandModel& model, double share) {
  Eigen::VectorXd q = model.restPose();
  for (int i = 0; i < model.dofCount(); ++i) {
    const double middle = 0.5 * (model.lower()[i] + model.upper()[i]);
    if (std::isfinite(middle)) q[i] += share * (middle - q[i]);
  }
  return q;
}

std::optional<Anchor> anchorAt(const hand::Skin& skin,
                               const transfer::PatchPlacement& placement) {
  const auto on_link = skin.project(placement.root_S);
  if (!on_link) return std::nullopt;
  Anchor anchor;
  anchor.link = on_link->link;
  anchor.p_L = on_link->p_L;
  anchor.n_L = on_link->n_L;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d axis_S =
        skin.directionInSkin(anchor.link, Eigen::Vector3d::Unit(axis));
    anchor.direction_L[axis] = axis_S.dot(placement.direction_S);
  }
  return anchor;
}

Anchor withObjectSide(Anchor anchor,
                      const contact::Patch& patch,
                      const geometry::TriangleMesh& object_O,
                      bool direction_is_known) {
  anchor.p_O = positionOf(object_O, patch.root);
  anchor.n_O = normalOf(object_O, patch.root);
  if (direction_is_known && patch.direction_O) {
    anchor.direction_O = tangentAt(object_O, patch.root, *patch.direction_O);
  }
  return anchor;
}

PoseProblem anchorProblem(std::shared_ptr<const hand::HandModel> model,
                          const std::vector<Anchor>& anchors,
                          const Pose& X_WO) {
  PoseProblem problem = optimize::makeProblem(std::move(model));
  for (int i = 0; i < std::ssize(anchors); ++i) {
    const Anchor& anchor = anchors[i];
    PointPair pair;
    pair.link = anchor.link;
    pair.p_L = anchor.p_L;
    pair.n_L = anchor.n_L;
    pair.p_W = X_WO * anchor.p_O;
    pair.n_W = X_WO.linear() * anchor.n_O;
    pair.patch = i;
    problem.pairs.push_back(pair);
    if (!anchor.direction_O) continue;
    pair.p_L += kDirectionArm * anchor.direction_L;
    pair.p_W += kDirectionArm * (X_WO.linear() * *anchor.direction_O);
    problem.pairs.push_back(pair);
  }
  problem.weights.prior = kJointPrior;
  problem.prior_weights = Eigen::VectorXd::Ones(problem.dofCount());
  problem.prior_weights.head<6>().setZero();
  return problem;
}

HandPoseGuesser::HandPoseGuesser(std::shared_ptr<const hand::HandModel> model,
                                 const hand::Skin& skin,
                                 std::shared_ptr<const geometry::Solid> object_O)
    : model_(std::move(model)), object_O_(std::move(object_O)) {
  const int vertices = skin.mesh().vertexCount();
  const int stride = std::max(1, vertices / kMostSamples);
  for (int v = 0; v < vertices; v += stride) {
    const auto on_link =
        skin.project(skin.mesh().vertex(v), skin.mesh().vertexNormals().col(v));
    if (on_link) samples_.push_back({on_link->link, on_link->p_L});
  }
}

double HandPoseGuesser::meanSquareDepth(const hand::HandPose& pose, const Pose& X_WO) const {
  if (samples_.empty()) return 0.0;
  hand::LinkPoses X_OL;
  hand::forwardKinematics(*model_, inverse(X_WO) * pose.X_WH, pose.q, X_OL);
  double sum = 0.0;
  for (const Sample& sample : samples_) {
    const double depth = std::max(0.0, -object_O_->grid().at(X_OL[sample.link] * sample.p_L));
    sum += depth * depth;
  }
  return sum / static_cast<double>(samples_.size());
}

double HandPoseGuesser::depthCharge(const hand::HandPose& pose,
                                    const Pose& X_WO,
                                    std::size_t pair_count) const {
  return kDepthWeight * static_cast<double>(pair_count) * meanSquareDepth(pose, X_WO);
}

std::vector<HandPoseGuess> HandPoseGuesser::place(const std::vector<Anchor>& anchors,
                                                  const Pose& X_WO,
                                                  int starts,
                                                  const Progress& progress) const {
  HANDGRAFT_REQUIRE(!anchors.empty());
  PoseProblem problem = anchorProblem(model_, anchors, X_WO);
  const auto [centre, axis] = mainAxis(problem);
  optimize::SolveOptions options;
  options.starts = 1;
  options.max_evaluations = kEvaluations;

  std::vector<HandPoseGuess> placements;
  for (int k = 0; k < starts; ++k) {
    progress.checkpoint();
    // Curls 0, 1/2, 1 in turn, each from the aligned side and from its opposite and quarters.
    const int quarters = k / 3;
    const double angle = 0.5 * std::numbers::pi * quarters;
    problem.start.q = curledPose(*model_, 0.5 * (k % 3));
    problem.start.X_WH =
        turnedAbout(centre, axis, angle) * optimize::alignRoot(problem, problem.start.q);
    const optimize::SolveReport report = optimize::solve(problem, options, progress);
    const double charge = depthCharge(report.pose, X_WO, problem.pairs.size());
    placements.push_back({report.pose, report.terms.objective + charge});
  }
  std::stable_sort(placements.begin(), placements.end(),
                   [](const HandPoseGuess& a, const HandPoseGuess& b) {
                     return a.score < b.score;
                   });
  return placements;
}

}  // namespace handgraft::placement
