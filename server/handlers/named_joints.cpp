#include "server/handlers/named_joints.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/error.h"
#include "core/hand/floating_base.h"

namespace handgraft::server {

namespace {

constexpr double kLimitTolerance = 1e-6;  // rad or m; what files round away

bool follows(const hand::HandModel& model, const std::string& joint) {
  return std::any_of(model.joints().begin(), model.joints().end(), [&](const hand::Joint& one) {
    return one.name == joint && one.mimic.has_value();
  });
}

}  // namespace

NamedJoints::NamedJoints(const StoredHand& hand,
                         const std::vector<std::string>& joints,
                         Followers followers)
    : hand_(hand), names_(joints) {
  const hand::HandModel& model = hand.hand->model();
  std::vector<std::string> root_joints;
  if (hand.floating_base) root_joints = hand.floating_base->dofNames();
  std::set<std::string> known;
  for (const std::string& joint : joints) {
    if (!known.insert(joint).second)
      rejectInput("joint {} is named twice", handgraft::quoted(joint));
    Dof& dof = dofs_.emplace_back();
    const auto at = std::find(root_joints.begin(), root_joints.end(), joint);
    if (at != root_joints.end()) {
      dof.of_root = static_cast<int>(at - root_joints.begin());
      of_root_ = joint;
    } else if (followers == Followers::kRefused || !follows(model, joint)) {
      dof.of_hand = model.dofIndex(joint);
    }
  }
}

std::vector<std::string> NamedJoints::missing() const {
  std::vector<std::string> names = hand_.hand->model().dofNames();
  std::erase_if(names, [&](const std::string& name) {
    return std::find(names_.begin(), names_.end(), name) != names_.end();
  });
  return names;
}

hand::HandPose NamedJoints::poseAt(const Eigen::Ref<const Eigen::VectorXd>& values,
                                   const Eigen::VectorXd& start,
                                   const Pose& X_WH,
                                   bool root_is_given) const {
  if (tellRoot() && root_is_given) {
    rejectInput("the pose of the hand's root is given twice: by X_WH and by joint {}",
                handgraft::quoted(of_root_));
  }
  hand::HandPose pose;
  pose.q = start;
  Eigen::VectorXd q_root;
  if (hand_.floating_base) q_root = hand_.floating_base->restPose();
  for (std::size_t i = 0; i < dofs_.size(); ++i) {
    const double value = values[static_cast<Eigen::Index>(i)];
    if (!std::isfinite(value))
      rejectInput("joint {}: {} is not finite", handgraft::quoted(names_[i]), value);
    if (dofs_[i].of_root != kNone) q_root[dofs_[i].of_root] = value;
    if (dofs_[i].of_hand != kNone) pose.q[dofs_[i].of_hand] = value;
  }
  pose.X_WH = tellRoot() ? hand::carriedPose(*hand_.floating_base, q_root) : X_WH;
  return pose;
}

std::vector<std::string> beyondLimits(const hand::HandModel& model,
                                      const std::vector<hand::HandPose>& poses) {
  struct Beyond {
    int dof = 0;
    double by = 0.0;
    double value = 0.0;
  };

  std::vector<Beyond> found;
  for (int dof = 0; dof < model.dofCount(); ++dof) {
    Beyond one{dof, kLimitTolerance, 0.0};
    for (const hand::HandPose& pose : poses) {
      const double q = pose.q[dof];
      const double by = std::max(model.lower()[dof] - q, q - model.upper()[dof]);
      if (by > one.by) one = {dof, by, q};
    }
    if (one.by > kLimitTolerance) found.push_back(one);
  }
  if (found.empty()) return {};
  // One line, however many there are: a person's joints are often beyond a model's.
  std::stable_sort(found.begin(), found.end(), [](const Beyond& a, const Beyond& b) {
    return a.by > b.by;
  });
  const auto name_of = [&](const Beyond& one) {
    return handgraft::quoted(model.dofJoint(one.dof).name);
  };
  const Beyond& most = found.front();
  // No joint of a hand goes round more than once.
  const bool is_turns = model.dofJoint(most.dof).type != hand::JointType::kPrismatic &&
                        std::abs(most.value) > 2.0 * std::numbers::pi;
  std::string note =
      fmt::format("joint {}: {:.4g} is beyond its limits {:.4g} to {:.4g}; taken as it is{}",
                  name_of(most), most.value, model.lower()[most.dof], model.upper()[most.dof],
                  is_turns ? "; angles are radians, not degrees" : "");
  std::vector<std::string> others;
  for (std::size_t i = 1; i < found.size(); ++i)
    others.push_back(name_of(found[i]));
  if (!others.empty()) note += fmt::format("; so are {}", fmt::join(others, ", "));
  return {note};
}

}  // namespace handgraft::server
