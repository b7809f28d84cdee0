#include "core/optimize/finalists.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/base/pose.h"

namespace handgraft::optimize {

namespace {

// So far apart two poses lie close.
constexpr double kAngle = 0.2;    // rad
constexpr double kLength = 0.02;  // m

/// The last body that carries all with point pairs.
int carrierOf(const MomentTree& tree) {
  if (tree.moments.empty()) return 0;
  const auto parent_of = [&tree](int body) {
    return tree.joints[static_cast<std::size_t>(body - 1)].parent_body;
  };
  int carrier = tree.moments.front().body;
  for (const BodyMoments& moments : tree.moments) {
    // Parents have lower numbers.
    for (int body = moments.body; body != carrier;)
      (body > carrier ? body : carrier) = parent_of(std::max(body, carrier));
  }
  return carrier;
}

}  // namespace

std::vector<int> Finalists::choose(const std::vector<LocalResult>& results,
                                   int explored,
                                   int most) {
  std::vector<int> order(static_cast<std::size_t>(explored));
  std::iota(order.begin(), order.end(), 0);
  const auto result_of = [&results](int start) -> const LocalResult& {
    return results[static_cast<std::size_t>(start)];
  };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return result_of(a).terms.objective < result_of(b).terms.objective;
  });
  std::vector<int> now;
  for (const int start : order) {
    if (static_cast<int>(chosen_.size()) >= most) break;
    const auto is_itself = [start](const Finalist& other) {
      return other.start == start;
    };
    if (std::any_of(chosen_.begin(), chosen_.end(), is_itself)) continue;
    const hand::HandPose& pose = result_of(start).pose;
    const auto known = std::find_if(chosen_.begin(), chosen_.end(), [&](const Finalist& other) {
      return liesClose(model_, pose, other.explored);
    });
    if (known != chosen_.end()) {
      if (start >= explored_) ++known->alike;  // the others were counted in their round
      continue;
    }
    chosen_.push_back({start, pose});
    now.push_back(start);
  }
  explored_ = explored;
  return now;
}

std::vector<hand::HandPose> Finalists::best(const std::vector<LocalResult>& results,
                                            std::size_t most) const {
  std::vector<const LocalResult*> ranked;
  for (const Finalist& finalist : chosen_)
    ranked.push_back(&results[static_cast<std::size_t>(finalist.start)]);
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto* a, const auto* b) {
    return a->terms.objective < b->terms.objective;
  });
  std::vector<hand::HandPose> poses;
  for (std::size_t i = 0; i < std::min(most, ranked.size()); ++i)
    poses.push_back(ranked[i]->pose);
  return poses;
}

bool Finalists::agree(const std::vector<LocalResult>& results) const {
  constexpr double kSame = 1e-3;  // share of the objective, as minima.h has it
  constexpr int kEnough = 3;
  const auto objective_of = [&results](const Finalist& finalist) {
    return results[static_cast<std::size_t>(finalist.start)].terms.objective;
  };
  double best = std::numeric_limits<double>::infinity();
  for (const Finalist& finalist : chosen_)
    best = std::min(best, objective_of(finalist));
  int agreeing = 0;
  int alike = 0;
  for (const Finalist& finalist : chosen_) {
    if (objective_of(finalist) > (1.0 + kSame) * best) continue;
    ++agreeing;
    alike += finalist.alike;
  }
  return agreeing >= kEnough || 2 * alike >= explored_;
}

bool liesClose(const hand::HandModel& model, const hand::HandPose& a, const hand::HandPose& b) {
  if ((a.X_WH.translation() - b.X_WH.translation()).norm() > kLength) return false;
  for (int j = 0; j < model.dofCount(); ++j) {
    const bool slides = model.dofJoint(j).type == hand::JointType::kPrismatic;
    if (std::abs(a.q[j] - b.q[j]) > (slides ? kLength : kAngle)) return false;
  }
  const Eigen::Matrix3d turn = a.X_WH.linear().transpose() * b.X_WH.linear();
  return vectorFromRotation(turn).norm() <= kAngle;
}

bool liesCloseBehindTheWrist(const MomentTree& tree,
                             const hand::HandPose& a,
                             const hand::HandPose& b) {
  const int carrier = carrierOf(tree);
  std::vector<BodyPlace> at_a(static_cast<std::size_t>(tree.bodyCount()));
  std::vector<BodyPlace> at_b(at_a.size());
  placeBodies(tree, a.X_WH.linear(), a.q, at_a);
  placeBodies(tree, b.X_WH.linear(), b.q, at_b);
  const BodyPlace& in_a = at_a[static_cast<std::size_t>(carrier)];
  const BodyPlace& in_b = at_b[static_cast<std::size_t>(carrier)];
  const Eigen::Vector3d way = b.X_WH.translation() - a.X_WH.translation();
  if ((way + in_b.p_HB_W - in_a.p_HB_W).norm() > kLength) return false;
  if (vectorFromRotation(in_a.R_WB.transpose() * in_b.R_WB).norm() > kAngle) return false;
  std::vector<char> is_behind(at_a.size(), 0);
  is_behind[static_cast<std::size_t>(carrier)] = 1;
  for (std::size_t j = 0; j < tree.joints.size(); ++j) {
    const TreeJoint& joint = tree.joints[j];
    if (is_behind[static_cast<std::size_t>(joint.parent_body)] == 0) continue;
    is_behind[j + 1] = 1;
    const bool slides = joint.type == hand::JointType::kPrismatic;
    if (std::abs(a.q[joint.dof] - b.q[joint.dof]) > (slides ? kLength : kAngle)) return false;
  }
  return true;
}

}  // namespace handgraft::optimize
