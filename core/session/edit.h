#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "core/base/pose.h"
#include "core/geometry/surface_point.h"
#include "core/hand/kinematics.h"
#include "core/optimize/pose_problem.h"
#include "core/optimize/problem_options.h"
#include "core/session/solving.h"

namespace handgraft::session {

// === What a user may change (idl/edits.idl says the same on the wire)
enum class Side { kObject, kHand };

struct ObjectPoseEdit {
  Pose X_WO;
};

struct PatchWeightEdit {
  std::string patch;
  double weight;
};

struct PatchEnabledEdit {
  std::string patch;
  bool enabled;
};

struct PatchRootEdit {
  std::string patch;
  Side side;
  geometry::SurfacePoint root;
};

struct PatchDirectionEdit {
  std::string patch;
  Side side;
  double angle_rad;  ///< about the outward normal, counter-clockwise
};

struct JointLimitEdit {
  std::string joint;
  double lower;
  double upper;
};

// A locked joint stays where the start has it.
struct JointLockEdit {
  std::string joint;
  bool locked;
  /// Of an edit at a time: where it is held. Who applies the edit fills it in from the motion's
  /// answer, so that its log needs none.
  std::optional<double> value{};
};

// Holds a joint near a value: the prior moves there and weighs `weight` times as much. Weight 0
// lets it go.
struct JointSoftEdit {
  std::string joint;
  double value;
  double weight;
};

// Sets the prior and the start; what is not named stays as it was.
struct PriorEdit {
  std::optional<Pose> X_WH;
  std::vector<std::string> joints;
  std::vector<double> q;
};

struct PriorSharesEdit {
  optimize::PriorShares shares;
};

struct WeightsEdit {
  optimize::Weights weights;
};

struct SolvingEdit {
  Solving solving;
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
};

// Lets go what was dragged.
struct ReleaseEdit {
  std::string link;  ///< empty: all
};

// One of the minima that the last committed solution ranked becomes prior and start. The pose
// is filled in by the session that applies the edit, so that its log needs no solution.
struct ChoiceEdit {
  int rank = 0;  ///< 0: the best
  std::optional<hand::HandPose> pose;
};

// Another hand; places, limits and values that still fit are kept.
struct HandEdit {
  std::string name;
};

// Another object; patches that lie on it, too, are carried along.
struct ObjectEdit {
  std::string name;
};

// === About one time of a motion

/// Where an edit applies: fully at `time_s`, fading to nothing `falloff_s` away from it.
struct EditTime {
  double time_s = 0.0;     ///< of the motion's own times
  double falloff_s = 0.0;  ///< 0: one frame
};

// A place of a link that goes a way of its own for some frames, as a drag at a time left it.
struct DragWay {
  std::string link;
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
  double weight = 1.0;  ///< as DragEdit's; fades as the edit does
  int first_frame = 0;
  std::vector<Eigen::Vector3d> targets_O{};  ///< of each frame from the first on
};

/// What may be edited at a time.
using TimedChange = std::variant<PatchWeightEdit,
                                 PatchEnabledEdit,
                                 PatchRootEdit,
                                 PatchDirectionEdit,
                                 JointLimitEdit,
                                 JointLockEdit,
                                 JointSoftEdit,
                                 DragWay,
                                 ReleaseEdit>;

// An edit of a motion about one time; the grasp that stands for the motion stays as it is.
struct TimedEdit {
  EditTime when;
  TimedChange change;
};

// Takes one edit at a time back, whatever was edited since.
struct TakeBackEdit {
  int index = 0;  ///< of those of the document
};

// === What moves through the history
struct UndoEdit {
  int count = 1;
};

struct RedoEdit {
  int count = 1;
};

struct SnapshotEdit {
  std::string name;  ///< one of that name is replaced
};

struct RestoreEdit {
  std::string name;
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
                          SolvingEdit,
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
                          TakeBackEdit>;

/// One line for people, without numbers that say little: "limit thumb_mcp 0 to 0.6 rad", "drag
/// middle_tip". What it quotes is on one line and cut short.
std::string describe(const Edit& edit);

/// What is edited at a time, without the time.
std::string describe(const TimedChange& change);

}  // namespace handgraft::session
