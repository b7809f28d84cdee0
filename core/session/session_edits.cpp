// What each edit checks and changes. Every function checks all before it changes anything.
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/geometry/tangent.h"
#include "core/session/hand_placement.h"
#include "core/session/open_directions.h"
#include "core/session/session.h"

namespace handgraft::session {
namespace {

constexpr double kLargestJointValue = 1e3;  // rad or m
constexpr double kLargestTurn = 1e3;        // rad
constexpr double kLargestLambda = 1e12;
constexpr double kRotationTolerance = 1e-6;
constexpr double kBoundTolerance = 1e-9;  // solver and optimiser agree on it

void requireFinitePose(const Pose& X, const char* what) {
  const Eigen::Matrix3d R = X.linear();
  if (!X.matrix().allFinite()) rejectInput("{} is not finite", what);
  if (!(R.transpose() * R).isIdentity(kRotationTolerance) || !(R.determinant() > 0.0)) {
    rejectInput("{} is no rigid motion: its rotation's determinant is {:.6g}, it must be 1",
                what, R.determinant());
  }
}

void requireWithin(double value, double least, double most, const std::string& what) {
  if (!(value >= least && value <= most)) {
    rejectInput("{} is {}; permitted are {} to {}", what, value, least, most);
  }
}

}  // namespace

void Session::apply(const Edit& edit) {
  std::visit(
      [this](const auto& one) {
        applyOne(one);
      },
      edit);
  ++revision_;
}

SessionPatch& Session::patchNamed(const std::string& name) {
  std::vector<std::string> names;
  for (SessionPatch& item : patches_) {
    if (item.patch.name == name) return item;
    names.push_back(item.patch.name);
  }
  rejectInput("there is no patch {}; there are {}", quoted(name), fmt::join(names, ", "));
}

void Session::applyOne(const ObjectPoseEdit& edit) {
  requireFinitePose(edit.X_WO, "the object's pose");
  X_WO_ = edit.X_WO;
}

void Session::applyOne(const PatchWeightEdit& edit) {
  SessionPatch& item = patchNamed(edit.patch);
  requireWithin(edit.weight, 0.0, contact::kLargestWeight,
                "weight of patch " + quoted(edit.patch));
  item.patch.weight = edit.weight;
  for (transfer::Correspondence& pair : item.transferred.correspondences) {
    pair.weight = edit.weight;
  }
}

void Session::applyOne(const PatchRootEdit& edit) {
  SessionPatch& item = patchNamed(edit.patch);
  const std::string what = "root of patch " + quoted(edit.patch);
  if (edit.side == Side::kObject) {
    validate(*object_O_, edit.root, what.c_str());
    if (item.direction_is_open) {
      item.patch.direction_O.reset();
    } else {
      item.patch.direction_O =
          tangentCarried(*object_O_, item.patch.root, edit.root, *item.patch.direction_O);
    }
    item.patch.root = edit.root;
  } else {
    const geometry::TriangleMesh& skin = hand_.skin->mesh();
    validate(skin, edit.root, what.c_str());
    item.placement =
        item.placement ? movedTo(skin, *item.placement, edit.root)
                       : transfer::Placement{
                             edit.root, tangentAt(skin, edit.root, -positionOf(skin, edit.root))
                                            .value_or(anyTangentAt(skin, edit.root))};
    item.dropped.clear();
    item.root_is_open = false;
  }
  item.up_to_date = false;
}

void Session::applyOne(const PatchDirectionEdit& edit) {
  requireWithin(edit.angle_rad, -kLargestTurn, kLargestTurn,
                "angle of patch " + quoted(edit.patch));
  if (const SessionPatch& item = patchNamed(edit.patch); !item.placement) {
    rejectInput("patch {} is dropped: {}", quoted(edit.patch), item.dropped);
  } else if (edit.side == Side::kObject && !item.patch.direction_O) {
    findOpenDirections(Progress());
  }
  SessionPatch& item = patchNamed(edit.patch);  // the search above may move the patches
  if (edit.side == Side::kObject) {
    item.patch.direction_O =
        tangentTurned(*object_O_, item.patch.root, *item.patch.direction_O, edit.angle_rad);
    item.direction_is_open = false;
  } else {
    item.placement = turned(hand_.skin->mesh(), *item.placement, edit.angle_rad);
    item.root_is_open = false;
  }
  item.up_to_date = false;
}

void Session::applyOne(const JointLimitEdit& edit) {
  const int dof = hand_.model->dofIndex(edit.joint);
  const std::string joint = "of joint " + quoted(edit.joint);
  requireWithin(edit.lower, -kLargestJointValue, kLargestJointValue, "lower limit " + joint);
  requireWithin(edit.upper, -kLargestJointValue, kLargestJointValue, "upper limit " + joint);
  if (edit.lower > edit.upper) {
    rejectInput("lower limit {} {} is above its upper limit {}", edit.lower, joint, edit.upper);
  }
  lower_[dof] = edit.lower;
  upper_[dof] = edit.upper;
}

void Session::applyOne(const JointLockEdit& edit) {
  const int dof = hand_.model->dofIndex(edit.joint);
  locked_[static_cast<std::size_t>(6 + dof)] = edit.locked;
}

void Session::applyOne(const PriorEdit& edit) {
  if (edit.X_WH) requireFinitePose(*edit.X_WH, "the hand's pose");
  if (edit.joints.size() != edit.q.size()) {
    rejectInput("{} joints with {} values; one value per joint is needed", edit.joints.size(),
                edit.q.size());
  }
  hand::HandPose pose = start_;
  if (edit.X_WH) pose.X_WH = *edit.X_WH;
  std::vector<int> seen;
  for (std::size_t i = 0; i < edit.joints.size(); ++i) {
    const int dof = hand_.model->dofIndex(edit.joints[i]);
    if (std::find(seen.begin(), seen.end(), dof) != seen.end()) {
      rejectInput("joint {} is named twice", quoted(edit.joints[i]));
    }
    seen.push_back(dof);
    requireWithin(edit.q[i], std::max(lower_[dof] - kBoundTolerance, -kLargestJointValue),
                  std::min(upper_[dof] + kBoundTolerance, kLargestJointValue),
                  "joint " + quoted(edit.joints[i]));
    pose.q[dof] = edit.q[i];
  }
  start_ = pose;
  prior_ = pose;
  start_is_known_ = true;
}

void Session::applyOne(const WeightsEdit& edit) {
  requireWithin(edit.weights.distance, 0.0, kLargestLambda, "weight of the distance");
  requireWithin(edit.weights.normal, 0.0, kLargestLambda, "weight of the normals");
  requireWithin(edit.weights.prior, 0.0, kLargestLambda, "weight of the prior");
  weights_ = edit.weights;
}

}  // namespace handgraft::session
