#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "core/base/pose.h"
#include "core/geometry/surface_point.h"
#include "core/hand/kinematics.h"
#include "core/optimize/pose_problem.h"
#include "core/optimize/problem_options.h"
#include "core/session/solver_settings.h"

namespace handgraft::session {

// === What a user may change (idl/edits.idl says the same on the wire). Each kind has the name
// by which files spell it, and lists its fields once: bytes, files and texts are made of both.
enum class Side { kObject, kHand };

struct ObjectPoseEdit {
  Pose X_WO;

  static constexpr std::string_view kKind = "object_pose";

  static void fields(auto& edit, auto&& visit) { visit("X_WO", edit.X_WO); }
};

struct PatchWeightEdit {
  std::string patch;
  double weight = 0.0;

  static constexpr std::string_view kKind = "patch_weight";

  static void fields(auto& edit, auto&& visit) {
    visit("patch", edit.patch);
    visit("weight", edit.weight);
  }
};

struct PatchEnabledEdit {
  std::string patch;
  bool enabled = false;

  static constexpr std::string_view kKind = "patch_enabled";

  static void fields(auto& edit, auto&& visit) {
    visit("patch", edit.patch);
    visit("enabled", edit.enabled);
  }
};

struct PatchRootEdit {
  std::string patch;
  Side side = Side::kObject;
  geometry::SurfacePoint root;

  static constexpr std::string_view kKind = "patch_root";

  static void fields(auto& edit, auto&& visit) {
    visit("patch", edit.patch);
    visit("side", edit.side);
    visit("root", edit.root);
  }
};

struct PatchDirectionEdit {
  std::string patch;
  Side side = Side::kObject;
  double angle_rad = 0.0;  ///< about the outward normal, counter-clockwise

  static constexpr std::string_view kKind = "patch_direction";

  static void fields(auto& edit, auto&& visit) {
    visit("patch", edit.patch);
    visit("side", edit.side);
    visit("angle_rad", edit.angle_rad);
  }
};

struct JointLimitEdit {
  std::string joint;
  double lower = 0.0;
  double upper = 0.0;

  static constexpr std::string_view kKind = "joint_limit";

  static void fields(auto& edit, auto&& visit) {
    visit("joint", edit.joint);
    visit("lower", edit.lower);
    visit("upper", edit.upper);
  }
};

// A locked joint stays where the start has it, which `value` moves.
struct JointLockEdit {
  std::string joint;
  bool locked = false;
  /// Where it is held in a motion: who applies the edit fills it in from the motion's answer,
  /// so that its log needs none.
  std::optional<double> value{};

  static constexpr std::string_view kKind = "joint_lock";

  static void fields(auto& edit, auto&& visit) {
    visit("joint", edit.joint);
    visit("locked", edit.locked);
    visit("value", edit.value);
  }
};

// Holds a joint near a value: the prior moves there and weighs `weight` times as much. Weight 0
// lets it go.
struct JointSoftEdit {
  std::string joint;
  double value = 0.0;
  double weight = 0.0;

  static constexpr std::string_view kKind = "joint_soft";

  static void fields(auto& edit, auto&& visit) {
    visit("joint", edit.joint);
    visit("value", edit.value);
    visit("weight", edit.weight);
  }
};

// Sets the prior and the start; what is not named stays as it was.
struct PriorEdit {
  std::optional<Pose> X_WH;
  std::vector<std::string> joints;
  std::vector<double> q;

  static constexpr std::string_view kKind = "prior";

  static void fields(auto& edit, auto&& visit) {
    visit("X_WH", edit.X_WH);
    visit("joints", edit.joints);
    visit("q", edit.q);
  }
};

struct PriorSharesEdit {
  optimize::PriorShares shares;

  static constexpr std::string_view kKind = "prior_shares";

  static void fields(auto& edit, auto&& visit) { visit("shares", edit.shares); }
};

struct WeightsEdit {
  optimize::Weights weights;

  static constexpr std::string_view kKind = "weights";

  static void fields(auto& edit, auto&& visit) { visit("weights", edit.weights); }
};

struct SolverSettingsEdit {
  SolverSettings solving;

  static constexpr std::string_view kKind = "solving";

  static void fields(auto& edit, auto&& visit) { visit("solving", edit.solving); }
};

// Moves a point of a link to a place, the other contacts held softly; the pose becomes prior
// and start. With a rotation, the link's frame is turned to it as well. The place is held from
// then on, as a contact of its own in place of an earlier one of that link, until it is let go.
struct DragEdit {
  std::string link;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
  Eigen::Vector3d target_W = Eigen::Vector3d::Zero();
  std::optional<Eigen::Matrix3d> target_R_WL{};
  /// How firmly: 1 is twenty times as firm as all patches together. 0: not at all, so that the
  /// next search may take it back.
  double weight = 1.0;

  static constexpr std::string_view kKind = "drag";

  static void fields(auto& edit, auto&& visit) {
    visit("link", edit.link);
    visit("p_L", edit.p_L);
    visit("target_W", edit.target_W);
    visit("target_R_WL", edit.target_R_WL);
    visit("weight", edit.weight);
  }
};

// Lets go what was dragged.
struct ReleaseEdit {
  std::string link;  ///< empty: all

  static constexpr std::string_view kKind = "release";

  static void fields(auto& edit, auto&& visit) { visit("link", edit.link); }
};

// One of the minima that the last committed solution ranked becomes prior and start. The pose
// is filled in by the session that applies the edit, so that its log needs no solution.
struct ChoiceEdit {
  int rank = 0;  ///< 0: the best
  std::optional<hand::HandPose> pose;

  static constexpr std::string_view kKind = "choice";

  static void fields(auto& edit, auto&& visit) {
    visit("rank", edit.rank);
    visit("pose", edit.pose);
  }
};

// Another hand; places, limits and values that still fit are kept.
struct HandEdit {
  std::string name;

  static constexpr std::string_view kKind = "hand";

  static void fields(auto& edit, auto&& visit) { visit("name", edit.name); }
};

// Another object; patches that lie on it, too, are carried along.
struct ObjectEdit {
  std::string name;

  static constexpr std::string_view kKind = "object";

  static void fields(auto& edit, auto&& visit) { visit("name", edit.name); }
};

// === About one time of a motion

/// Where an edit applies: fully at `time_s`, fading to nothing `falloff_s` away from it.
struct EditTime {
  double time_s = 0.0;     ///< of the motion's own times
  double falloff_s = 0.0;  ///< 0: one frame
};

// A place of a link that goes a way of its own for some frames, as a drag at a time left it.
struct DragPath {
  std::string link;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
  double weight = 1.0;  ///< as DragEdit's; fades as the edit does
  int first_frame = 0;
  std::vector<Eigen::Vector3d> targets_O{};  ///< of each frame from the first on

  static constexpr std::string_view kKind = "drag_way";

  static void fields(auto& edit, auto&& visit) {
    visit("link", edit.link);
    visit("p_L", edit.p_L);
    visit("weight", edit.weight);
    visit("first_frame", edit.first_frame);
    visit("targets_O", edit.targets_O);
  }
};

/// What may be edited at a time.
using TimedChange = std::variant<PatchWeightEdit,
                                 PatchEnabledEdit,
                                 PatchRootEdit,
                                 PatchDirectionEdit,
                                 JointLimitEdit,
                                 JointLockEdit,
                                 JointSoftEdit,
                                 DragPath,
                                 ReleaseEdit>;

// An edit of a motion about one time; the grasp that stands for the motion stays as it is.
struct TimedEdit {
  EditTime when;
  TimedChange change;

  static constexpr std::string_view kKind = "timed";

  static void fields(auto& edit, auto&& visit) {
    visit("time_s", edit.when.time_s);
    visit("falloff_s", edit.when.falloff_s);
    visit("change", edit.change);
  }
};

// Takes one edit at a time back, whatever was edited since.
struct RemoveTimedEdit {
  int index = 0;  ///< of those of the document

  static constexpr std::string_view kKind = "take_back";

  static void fields(auto& edit, auto&& visit) { visit("index", edit.index); }
};

// === What moves through the history
struct UndoEdit {
  int count = 1;

  static constexpr std::string_view kKind = "undo";

  static void fields(auto& edit, auto&& visit) { visit("count", edit.count); }
};

struct RedoEdit {
  int count = 1;

  static constexpr std::string_view kKind = "redo";

  static void fields(auto& edit, auto&& visit) { visit("count", edit.count); }
};

struct SnapshotEdit {
  std::string name;  ///< one of that name is replaced

  static constexpr std::string_view kKind = "snapshot";

  static void fields(auto& edit, auto&& visit) { visit("name", edit.name); }
};

struct RestoreEdit {
  std::string name;

  static constexpr std::string_view kKind = "restore";

  static void fields(auto& edit, auto&& visit) { visit("name", edit.name); }
};

using Edit = std::variant<ObjectPoseEdit,
                          PatchWeightEdit,
                          PatchRootEdit,
                          PatchDirectionEdit,
                          JointLimitEdit,
                          JointLockEdit,
                          PriorEdit,
                          WeightsEdit,
                          PatchEnabledEdit,
                          JointSoftEdit,
                          PriorSharesEdit,
                          SolverSettingsEdit,
                          DragEdit,
                          ChoiceEdit,
                          HandEdit,
                          ObjectEdit,
                          UndoEdit,
                          RedoEdit,
                          SnapshotEdit,
                          RestoreEdit,
                          ReleaseEdit,
                          TimedEdit,
                          RemoveTimedEdit>;

/// One line for people, without numbers that say little: "limit thumb_mcp 0 to 0.6 rad", "drag
/// middle_tip". What it quotes is on one line and cut short.
std::string describe(const Edit& edit);

/// The same with the units of a joint's values, as this hand has it: "limit thumb_mcp 0 to 0.6
/// rad".
std::string describe(const Edit& edit, const hand::HandModel& model);

/// What is edited at a time, without the time.
std::string describe(const TimedChange& change);
std::string describe(const TimedChange& change, const hand::HandModel& model);

}  // namespace handgraft::session
