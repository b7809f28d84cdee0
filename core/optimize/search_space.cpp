#include "core/optimize/search_space.h"

#include <algorithm>
#include <limits>

namespace handgraft::optimize {

namespace {

/// Which dofs of the hand share a chain: their entry of the Hessian may differ from zero.
std::vector<std::vector<char>> couplings(const MomentTree& tree, int joint_dofs) {
  std::vector<std::vector<char>> coupled(
      static_cast<std::size_t>(joint_dofs),
      std::vector<char>(static_cast<std::size_t>(joint_dofs), 0));
  for (const TreeJoint& joint : tree.joints) {
    for (int body = joint.parent_body; body > 0;) {
      const TreeJoint& before = tree.joints[static_cast<std::size_t>(body - 1)];
      const auto a = static_cast<std::size_t>(joint.dof);
      const auto b = static_cast<std::size_t>(before.dof);
      coupled[a][b] = coupled[b][a] = 1;
      body = before.parent_body;
    }
  }
  return coupled;
}

}  // namespace

SearchSpace makeSearchSpace(const PoseProblem& problem, const MomentTree& tree) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const int dofs = problem.dofCount();
  Eigen::VectorXd lower = Eigen::VectorXd::Constant(dofs, -kInfinity);
  Eigen::VectorXd upper = Eigen::VectorXd::Constant(dofs, kInfinity);
  lower.segment<3>(3) = problem.root_lower;
  upper.segment<3>(3) = problem.root_upper;
  lower.tail(dofs - 6) = problem.lower;
  upper.tail(dofs - 6) = problem.upper;
  const auto is_free = [&](int dof) {
    const bool locked =
        !problem.locked.empty() && problem.locked[static_cast<std::size_t>(dof)];
    return !locked && lower[dof] < upper[dof];
  };

  // === Joints that move pairs, tips first; those that move none; the root
  std::vector<int> order;
  std::vector<char> listed(static_cast<std::size_t>(dofs), 0);
  const auto list = [&](int dof) {
    if (listed[static_cast<std::size_t>(dof)] != 0 || !is_free(dof)) return;
    listed[static_cast<std::size_t>(dof)] = 1;
    order.push_back(dof);
  };
  for (auto joint = tree.joints.rbegin(); joint != tree.joints.rend(); ++joint)
    list(6 + joint->dof);
  const std::size_t moving = order.size();
  for (int dof = 6; dof < dofs; ++dof)
    list(dof);
  const std::size_t joints = order.size();
  for (int dof = 0; dof < 6; ++dof)
    list(dof);

  SearchSpace space;
  space.dofs = std::move(order);
  space.lower = lower(space.dofs);
  space.upper = upper(space.dofs);
  const auto coupled = couplings(tree, dofs - 6);
  for (std::size_t i = 0; i < space.dofs.size(); ++i) {
    std::size_t first = i < joints ? i : 0;
    for (std::size_t j = 0; i < moving && j < i; ++j) {
      const auto a = static_cast<std::size_t>(space.dofs[i] - 6);
      const auto b = static_cast<std::size_t>(space.dofs[j] - 6);
      if (coupled[a][b] == 0) continue;
      first = j;
      break;
    }
    space.first.push_back(static_cast<int>(first));
  }
  const auto rotations = std::count_if(space.dofs.begin(), space.dofs.end(), [](int dof) {
    return dof < 3;
  });
  space.rotation_partly_locked = rotations == 1 || rotations == 2;
  return space;
}

}  // namespace handgraft::optimize
