#include "core/optimize/drag.h"

#include <algorithm>
#include <functional>
#include <map>
#include <vector>

#include "core/base/error.h"
#include "core/optimize/local_search.h"

namespace handgraft::optimize {
namespace {

// What moves whom: the target outweighs everything (1 m of hold bends it by 0.1 mm); a radian
// of a joint costs as much as 1 cm of a patch; the root is a hundred times as stiff as the
// joints that would do the same, so that it comes last.
constexpr double kTarget = 1e7;     // 1/m^2, of the dragged point
constexpr double kHold = 1e2;       // 1/m^2, of all points of one patch together
constexpr double kJoint = 1e-2;     // 1/rad^2, or 1/m^2 of sliding joints times 100
constexpr double kRootShift = 1e3;  // 1/m^2
constexpr double kRootTurn = 10.0;  // 1/rad^2

constexpr double kReachedPoint = 1e-4;  // m
constexpr double kReachedTurn = 1e-3;   // rad
constexpr double kTurnArm = 0.05;       // m; a turn by 1 rad weighs as a miss by as much
constexpr double kFarthest = 10.0;      // m
constexpr int kEvaluations = 100;       // a solve

/// Which degrees of freedom belong to the finger of a link.
struct Finger {
  bool carries_fingers = false;  ///< the link is no finger's: several spring from it
  std::vector<char> links;       ///< flags: of the finger
  std::vector<char> dofs;        ///< flags: that move the finger and nothing else
};

/// Flags: links beyond which several moving branches lie, or which these leave.
std::vector<char> branchedLinks(const hand::HandModel& model) {
  const auto count = static_cast<std::size_t>(model.linkCount());
  // How many moving branches leave each link, what is fixed to it included.
  std::vector<int> branches(count, 0);
  for (auto node = model.nodes().rbegin(); node != model.nodes().rend(); ++node) {
    const auto parent = static_cast<std::size_t>(node->parent_link);
    branches[parent] += node->dof >= 0 ? 1 : branches[static_cast<std::size_t>(node->link)];
  }
  // What lies beyond a link branches if any link there does.
  std::vector<char> branched(count, 0);
  for (auto node = model.nodes().rbegin(); node != model.nodes().rend(); ++node) {
    const auto child = static_cast<std::size_t>(node->link);
    if (branches[child] > 1) branched[child] = 1;
    if (branched[child] != 0) branched[static_cast<std::size_t>(node->parent_link)] = 1;
  }
  if (branches[0] > 1) branched[0] = 1;
  return branched;
}

/// Flags: `base` and all that hangs on it.
std::vector<char> linksFrom(const hand::HandModel& model, int base) {
  std::vector<char> links(static_cast<std::size_t>(model.linkCount()), 0);
  links[static_cast<std::size_t>(base)] = 1;
  for (const hand::HandModel::Node& node : model.nodes()) {
    if (links[static_cast<std::size_t>(node.parent_link)] != 0)
      links[static_cast<std::size_t>(node.link)] = 1;
  }
  return links;
}

/// Flags: degrees of freedom that move some of `links`, and no others.
std::vector<char> dofsWithin(const hand::HandModel& model, const std::vector<char>& links) {
  std::vector<char> dofs(static_cast<std::size_t>(model.dofCount()), 0);
  for (const hand::HandModel::Node& node : model.nodes()) {
    if (node.dof < 0) continue;
    if (links[static_cast<std::size_t>(node.link)] != 0)
      dofs[static_cast<std::size_t>(node.dof)] = 1;
  }
  for (const hand::HandModel::Node& node : model.nodes()) {
    if (node.dof < 0) continue;
    // A joint that others outside follow would move them, too.
    if (links[static_cast<std::size_t>(node.link)] == 0)
      dofs[static_cast<std::size_t>(node.dof)] = 0;
  }
  return dofs;
}

Finger fingerOf(const hand::HandModel& model, int link) {
  const std::vector<char> branched = branchedLinks(model);
  Finger finger;
  finger.links.assign(static_cast<std::size_t>(model.linkCount()), 0);
  finger.dofs.assign(static_cast<std::size_t>(model.dofCount()), 0);
  if (link == 0 || branched[static_cast<std::size_t>(link)] != 0) {
    finger.carries_fingers = true;
    return finger;
  }
  // Up to the last link beyond which nothing branches.
  int base = link;
  for (int next = link; next != 0;) {
    next = model.nodes()[static_cast<std::size_t>(next - 1)].parent_link;
    if (branched[static_cast<std::size_t>(next)] != 0) break;
    base = next;
  }
  // A finger that is all there is has the root for its base.
  finger.links = linksFrom(model, base);
  finger.dofs = dofsWithin(model, finger.links);
  // Without any it is fixed to the root.
  finger.carries_fingers = std::none_of(finger.dofs.begin(), finger.dofs.end(), [](char flag) {
    return flag != 0;
  });
  return finger;
}

PointPair pairAt(int link,
                 const Eigen::Vector3d& p_L,
                 const Eigen::Vector3d& p_W,
                 double weight) {
  PointPair pair;
  pair.link = link;
  pair.p_L = p_L;
  pair.p_W = p_W;
  pair.n_L = Eigen::Vector3d::UnitX();
  pair.n_W = Eigen::Vector3d::UnitX();
  pair.has_normals = false;
  pair.weight = weight;
  return pair;
}

/// The points of other fingers' patches, where the start has them.
void addHolds(const PoseProblem& source, const Finger& finger, PoseProblem& problem) {
  const hand::LinkPoses X_WL = forwardKinematics(*source.model, source.start);
  const auto is_held = [&](const PointPair& pair) {
    return pair.weight > 0.0 && finger.links[static_cast<std::size_t>(pair.link)] == 0;
  };
  std::map<int, int> counts;
  for (const PointPair& pair : source.pairs) {
    if (is_held(pair)) ++counts[pair.patch];
  }
  for (const PointPair& pair : source.pairs) {
    if (!is_held(pair)) continue;
    problem.pairs.push_back(pairAt(pair.link, pair.p_L,
                                   X_WL[static_cast<std::size_t>(pair.link)] * pair.p_L,
                                   kHold / counts[pair.patch]));
  }
}

/// A problem that keeps the hand where it is, and has no points yet.
PoseProblem stillProblem(const PoseProblem& source) {
  PoseProblem problem = makeProblem(source.model);
  problem.start = source.start;
  problem.start.q = source.start.q.cwiseMax(source.lower).cwiseMin(source.upper);
  problem.prior = problem.start;
  problem.lower = source.lower;
  problem.upper = source.upper;
  problem.root_lower = source.root_lower;
  problem.root_upper = source.root_upper;
  problem.locked = source.locked;
  problem.locked.resize(static_cast<std::size_t>(problem.dofCount()), false);
  problem.weights = {1.0, 0.0, 1.0};
  problem.prior_weights = Eigen::VectorXd::Constant(problem.dofCount(), kJoint);
  problem.prior_weights.head<3>().setConstant(kRootTurn);
  problem.prior_weights.segment<3>(3).setConstant(kRootShift);
  for (int dof = 0; dof < source.model->dofCount(); ++dof) {
    if (source.model->dofJoint(dof).type == hand::JointType::kPrismatic)
      problem.prior_weights[6 + dof] = 100.0 * kJoint;
  }
  return problem;
}

hand::HandPose solved(const PoseProblem& problem, const Progress& progress, int& evaluations) {
  const PreparedProblem prepared(problem);
  LocalSearch search(prepared);
  const LocalSearch::Observer nobody;
  const std::function<void()> keep_going = [&] {
    progress.checkpoint();
  };
  search.attend(nobody, keep_going);
  LocalResult result = search.begin(problem.start);
  search.advance(Solver::kLm, kEvaluations, result);
  evaluations += result.evaluations;
  return result.pose;
}

void measure(const PoseProblem& problem, const DragTarget& target, DragResult& result) {
  const Pose X_WL =
      forwardKinematics(*problem.model, result.pose)[static_cast<std::size_t>(target.link)];
  result.short_m = (X_WL * target.p_L - target.target_W).norm();
  result.short_rad =
      target.R_WL ? vectorFromRotation(X_WL.linear().transpose() * *target.R_WL).norm() : 0.0;
}

bool reached(const DragResult& result) {
  return result.short_m <= kReachedPoint && result.short_rad <= kReachedTurn;
}

/// The whole hand, the root no farther than the options allow.
hand::HandPose movedAsAWhole(PoseProblem problem,
                             bool bounded,
                             const DragOptions& options,
                             const Progress& progress,
                             int& evaluations) {
  const Pose X_WH = problem.start.X_WH;
  if (bounded) {
    const Eigen::Vector3d p = X_WH.translation();
    const Eigen::Vector3d travel = Eigen::Vector3d::Constant(options.root_travel_m);
    problem.root_lower = problem.root_lower.cwiseMax((p - travel).eval()).cwiseMin(p);
    problem.root_upper = problem.root_upper.cwiseMin((p + travel).eval()).cwiseMax(p);
  }
  hand::HandPose pose = solved(problem, progress, evaluations);
  const Eigen::Vector3d turn_W =
      vectorFromRotation(pose.X_WH.linear() * X_WH.linear().transpose());
  if (!bounded || turn_W.norm() <= options.root_turn) return pose;
  // Turned as far as it may in the direction that it wanted to; the rest without turning.
  problem.start = pose;
  problem.start.X_WH.linear() =
      rotationFromVector(turn_W.normalized() * options.root_turn) * X_WH.linear();
  for (std::size_t axis = 0; axis < 3; ++axis)
    problem.locked[axis] = true;
  return solved(problem, progress, evaluations);
}

}  // namespace

std::vector<PointPair> pairsOf(const DragTarget& target, double weight) {
  if (!target.R_WL) return {pairAt(target.link, target.p_L, target.target_W, weight)};
  // Opposite points about the place: their mean is the place, their spread the rotation.
  std::vector<PointPair> pairs;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double arm : {-kTurnArm, kTurnArm}) {
      const Eigen::Vector3d offset = arm * Eigen::Vector3d::Unit(axis);
      pairs.push_back(pairAt(target.link, target.p_L + offset,
                             target.target_W + *target.R_WL * offset, weight / 6.0));
    }
  }
  return pairs;
}

DragResult drag(const PoseProblem& problem,
                const DragTarget& target,
                const DragOptions& options,
                const Progress& progress) {
  validate(problem);
  HANDGRAFT_REQUIRE(target.link >= 0 && target.link < problem.model->linkCount());
  if (!target.p_L.allFinite() || !target.target_W.allFinite() ||
      (target.R_WL && !target.R_WL->allFinite())) {
    rejectInput("drag: its point and its target must be finite");
  }
  const double distance = std::max(target.p_L.norm(), target.target_W.norm());
  if (distance > kFarthest) {
    rejectInput("drag: {:.6g} m from the origin; permitted are {} m", distance, kFarthest);
  }
  DragResult result;
  PoseProblem still = stillProblem(problem);
  result.pose = still.start;
  measure(problem, target, result);
  if (boundsContradict(problem)) return result;
  const Finger finger = fingerOf(*problem.model, target.link);
  for (const PointPair& pair : pairsOf(target, kTarget))
    still.pairs.push_back(pair);

  // === The finger alone
  if (!finger.carries_fingers) {
    PoseProblem alone = still;
    for (std::size_t dof = 0; dof < 6; ++dof)
      alone.locked[dof] = true;
    for (std::size_t dof = 0; dof < finger.dofs.size(); ++dof)
      alone.locked[6 + dof] = alone.locked[6 + dof] || finger.dofs[dof] == 0;
    result.pose = solved(alone, progress, result.evaluations);
    measure(problem, target, result);
    if (reached(result)) return result;
  }

  // === The whole hand, from there
  addHolds(problem, finger, still);
  still.start.q = result.pose.q;
  DragResult whole = result;
  whole.pose =
      movedAsAWhole(still, !finger.carries_fingers, options, progress, whole.evaluations);
  whole.root_moved = true;
  measure(problem, target, whole);
  if (finger.carries_fingers ||
      whole.short_m + kTurnArm * whole.short_rad < result.short_m + kTurnArm * result.short_rad)
    return whole;
  result.evaluations = whole.evaluations;
  return result;
}

}  // namespace handgraft::optimize
