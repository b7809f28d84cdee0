#include "server/messages/edit_messages.h"

#include <cmath>
#include <string>

#include "core/base/error.h"
#include "idl/fields.h"
#include "server/base/rejection.h"
#include "server/messages/convert.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kLongestName =
    256;  // bytes; models', joints' and patches' end there, too
constexpr std::uint32_t kMostSteps = 1'000'000;

const std::string& name(const std::string& text, const char* what) {
  if (text.size() > kLongestName) {
    rejectInput("{}: a name of {} bytes; at most {} are allowed", what, text.size(),
                kLongestName);
  }
  return text;
}

double finite(double value, const char* what) {
  if (!std::isfinite(value)) rejectInput("{}: {} is not finite", what, value);
  return value;
}

/// Infinity is no limit; what is no number is nothing.
double limit(double value, const char* what) {
  if (std::isnan(value)) rejectInput("{}: {} is no number", what, value);
  return value;
}

double notNegative(double value, const char* what) {
  if (!(value >= 0.0) || !std::isfinite(value)) {
    rejectInput("{}: {} must be finite and at least 0", what, value);
  }
  return value;
}

Eigen::Vector3d place(const std::array<double, 3>& p, const char* what) {
  return {finite(p[0], what), finite(p[1], what), finite(p[2], what)};
}

session::Side sideFrom(v1::PatchSide side) {
  switch (side) {
    case v1::SIDE_OBJECT:
      return session::Side::kObject;
    case v1::SIDE_HAND:
      return session::Side::kHand;
  }
  rejectInput("side: {} is neither object (0) nor hand (1)", static_cast<unsigned>(side));
}

session::PatchRootEdit rootFrom(const v1::PatchRootEdit& message) {
  for (const double weight : message.root().barycentric())
    finite(weight, "root's barycentric coordinate");
  return {name(message.patch(), "patch"), sideFrom(message.side()),
          surfacePointFrom(message.root())};
}

session::PriorEdit priorFrom(const v1::PriorEdit& message) {
  if (message.X_WH().size() > 1) {
    rejectInput("prior: {} poses; at most 1 is allowed", message.X_WH().size());
  }
  if (message.joints().size() != message.joint_positions().size()) {
    rejectInput("prior: {} joints but {} angles", message.joints().size(),
                message.joint_positions().size());
  }
  constexpr std::size_t kMostJoints = 512;
  if (message.joints().size() > kMostJoints) {
    rejectInput("prior: {} joints; at most {} are allowed", message.joints().size(),
                kMostJoints);
  }
  session::PriorEdit edit;
  if (!message.X_WH().empty()) edit.X_WH = poseFrom(message.X_WH().front(), "X_WH");
  for (const std::string& joint : message.joints())
    edit.joints.push_back(name(joint, "joint"));
  for (const double value : message.joint_positions())
    edit.q.push_back(finite(value, "angle of the prior"));
  return edit;
}

session::DragEdit dragFrom(const v1::DragEdit& message) {
  session::DragEdit edit;
  edit.link = name(message.link(), "link");
  edit.p_L = place(message.p_L_m(), "point to drag");
  edit.target_W = place(message.target_W_m(), "target of the drag");
  edit.weight = message.weight();
  const std::vector<double>& q = message.target_q_wxyz();
  if (q.empty()) return edit;
  if (q.size() != 4) {
    rejectInput("target_q_wxyz: {} numbers; a quaternion has 4, a free turn none", q.size());
  }
  edit.target_R_WL =
      poseFromQuaternion(Eigen::Vector3d::Zero(), {q[0], q[1], q[2], q[3]}, "target_q_wxyz")
          .linear();
  return edit;
}

optimize::PriorShares sharesFrom(const v1::PriorShares& message) {
  optimize::PriorShares shares;
  shares.root_rotation = notNegative(message.root_rotation(), "share of the root's rotation");
  shares.root_translation =
      notNegative(message.root_translation(), "share of the root's translation");
  shares.joints = notNegative(message.joints(), "share of the joints");
  shares.posture = notNegative(message.posture(), "share of the posture");
  return shares;
}

int steps(const v1::StepsEdit& message) {
  if (message.count() > kMostSteps) {
    rejectInput("count: {} is outside 0-{}", message.count(), kMostSteps);
  }
  return message.count() == 0 ? 1 : static_cast<int>(message.count());
}

session::ChoiceEdit choiceFrom(const v1::ChoiceEdit& message) {
  constexpr std::uint32_t kMostMinima = 8;
  if (message.rank() >= kMostMinima) {
    rejectInput("rank: {} is outside 0-{}", message.rank(), kMostMinima - 1);
  }
  session::ChoiceEdit edit;
  edit.rank = static_cast<int>(message.rank());
  return edit;
}

}  // namespace

session::Edit editFrom(const v1::EditBody& body) {
  switch (body._d()) {
    case v1::EDIT_OBJECT_POSE:
      if (body == v1::EditBody()) {
        rejectInput(
            "the edit says nothing: an EditBody needs one of its members, as X_WO, joint_limit "
            "or "
            "patch_root (idl/edits.idl)");
      }
      return session::ObjectPoseEdit{poseFrom(body.X_WO(), "X_WO")};
    case v1::EDIT_PATCH_WEIGHT:
      return session::PatchWeightEdit{name(body.patch_weight().patch(), "patch"),
                                      notNegative(body.patch_weight().weight(), "weight")};
    case v1::EDIT_PATCH_ROOT:
      return rootFrom(body.patch_root());
    case v1::EDIT_PATCH_DIRECTION:
      return session::PatchDirectionEdit{name(body.patch_direction().patch(), "patch"),
                                         sideFrom(body.patch_direction().side()),
                                         finite(body.patch_direction().angle_rad(), "angle")};
    case v1::EDIT_JOINT_LIMIT:
      return session::JointLimitEdit{name(body.joint_limit().joint(), "joint"),
                                     limit(body.joint_limit().lower(), "lower limit"),
                                     limit(body.joint_limit().upper(), "upper limit")};
    case v1::EDIT_JOINT_LOCK:
      return session::JointLockEdit{name(body.joint_lock().joint(), "joint"),
                                    body.joint_lock().locked()};
    case v1::EDIT_PRIOR:
      return priorFrom(body.prior());
    case v1::EDIT_WEIGHTS:
      return session::WeightsEdit{weightsFrom(body.weights())};
    case v1::EDIT_PATCH_ENABLED:
      return session::PatchEnabledEdit{name(body.patch_enabled().patch(), "patch"),
                                       body.patch_enabled().enabled()};
    case v1::EDIT_JOINT_SOFT:
      return session::JointSoftEdit{name(body.joint_soft().joint(), "joint"),
                                    finite(body.joint_soft().value(), "value"),
                                    notNegative(body.joint_soft().weight(), "weight")};
    case v1::EDIT_PRIOR_SHARES:
      return session::PriorSharesEdit{sharesFrom(body.prior_shares())};
    case v1::EDIT_SOLVING:
      return session::SolverSettingsEdit{solverSettingsFrom(body.solving())};
    case v1::EDIT_DRAG:
      return dragFrom(body.drag());
    case v1::EDIT_CHOICE:
      return choiceFrom(body.choice());
    case v1::EDIT_HAND:
      return session::HandEdit{name(body.swapped_model().name(), "hand")};
    case v1::EDIT_OBJECT:
      return session::ObjectEdit{name(body.swapped_model().name(), "object")};
    case v1::EDIT_UNDO:
      return session::UndoEdit{steps(body.steps())};
    case v1::EDIT_REDO:
      return session::RedoEdit{steps(body.steps())};
    case v1::EDIT_SNAPSHOT:
      return session::SnapshotEdit{name(body.snapshot().name(), "snapshot")};
    case v1::EDIT_RESTORE:
      return session::RestoreEdit{name(body.snapshot().name(), "snapshot")};
    case v1::EDIT_RELEASE:
      return session::ReleaseEdit{
          body.release().link().empty() ? "" : name(body.release().link(), "link")};
    case v1::EDIT_TAKE_BACK:
      return session::RemoveTimedEdit{static_cast<int>(body.take_back().index())};
    case v1::EDIT_PATCH_PLACE:
    case v1::EDIT_MOTION:
      reject(v1::ERROR_UNSUPPORTED, "this server does not know edits of kind {} yet",
             nameOf(body._d()));
  }
  rejectInput("edit kind {} does not exist", static_cast<unsigned>(body._d()));
}

}  // namespace handgraft::server
