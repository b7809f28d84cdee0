#include "server/handlers/motion_edits.h"

#include <algorithm>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "core/base/error.h"
#include "core/hand/kinematics.h"
#include "core/retargeting/motion_solving.h"
#include "core/session/timed_edit.h"
#include "server/base/rejection.h"
#include "server/handlers/motions.h"
#include "server/messages/convert.h"

namespace handgraft::server {

namespace {

template <class One, class Variant>
inline constexpr bool kIsOneOf = false;
template <class One, class... All>
inline constexpr bool kIsOneOf<One, std::variant<All...>> = (std::is_same_v<One, All> || ...);

/// Takes an edit as one at a time, where there is such a one.
bool takeChange(const session::Edit& edit, session::TimedChange& change) {
  return std::visit(
      [&](const auto& one) {
        constexpr bool kHasTime = kIsOneOf<std::decay_t<decltype(one)>, session::TimedChange>;
        if constexpr (kHasTime) change = one;
        return kHasTime;
      },
      edit);
}

/// The patch that an edit moves on the hand, or null.
const std::string* movedOnHand(const session::Edit& edit) {
  return std::visit(
      [](const auto& one) -> const std::string* {
        using One = std::decay_t<decltype(one)>;
        if constexpr (std::is_same_v<One, session::PatchRootEdit> ||
                      std::is_same_v<One, session::PatchDirectionEdit>) {
          return one.side == session::Side::kHand ? &one.patch : nullptr;
        } else {
          return nullptr;
        }
      },
      edit);
}

void requireObjectsOwnWay(const LiveMotion& motion, const session::Edit& edit) {
  if (!std::holds_alternative<session::ObjectPoseEdit>(edit)) return;
  rejectInput(
      "the object goes the way that motion {} tells; it cannot be placed in a session of it",
      handgraft::quoted(motion.name));
}

/// Recorded points lie where they were recorded.
void requireOutline(const LiveMotion& motion, const session::Edit& edit) {
  const std::string* patch = movedOnHand(edit);
  if (patch == nullptr) return;
  for (const manipulation::PatchTrack& track : motion.motion->tracks) {
    if (track.name != *patch || !manipulation::isRecorded(track.keys.front())) continue;
    rejectInput(
        "patch {}: a recorded point has no outline on the hand; its root there cannot be "
        "moved, nor its direction turned",
        handgraft::quoted(*patch));
  }
}

/// Half way between the least and the most of what a joint does.
double middleOf(const retargeting::SolvedMotion& solved, int dof) {
  double least = solved.trajectory.poses.front().q[dof];
  double most = least;
  for (const hand::HandPose& pose : solved.trajectory.poses) {
    least = std::min(least, pose.q[dof]);
    most = std::max(most, pose.q[dof]);
  }
  return 0.5 * (least + most);
}

}  // namespace

session::Edit wholeEdit(LiveSession& live, session::Edit edit) {
  const LiveMotion* motion = live.motion();
  if (motion == nullptr) return edit;
  requireObjectsOwnWay(*motion, edit);
  requireOutline(*motion, edit);
  auto* lock = std::get_if<session::JointLockEdit>(&edit);
  if (lock == nullptr || !lock->locked || motion->solved == nullptr) return edit;
  lock->value = middleOf(*motion->solved, live.session().hand().model->dofIndex(lock->joint));
  return edit;
}

session::TimedEdit timedEdit(LiveSession& live,
                             const v1::EditTime& when,
                             const session::Edit& edit) {
  const LiveMotion& motion = motionOf(live);
  requireOutline(motion, edit);
  session::TimedEdit timed;
  timed.when = {when.time_s() + motion.motion->time_s.front(), when.falloff_s()};
  const double end_s = motion.motion->duration();
  if (!(when.time_s() >= 0.0 && when.time_s() <= end_s))
    rejectInput("time of the edit: {} s; motion {} has 0 to {:.6g} s", when.time_s(),
                handgraft::quoted(motion.name), end_s);
  if (!(when.falloff_s() >= 0.0 && when.falloff_s() <= session::kLongestFalloff))
    rejectInput("falloff of the edit: {} s; permitted are 0 to {} s", when.falloff_s(),
                session::kLongestFalloff);
  const std::vector<double>& time_s = motion.motion->time_s;
  const int frame = session::frameNearest(time_s, timed.when.time_s);
  const auto answer_at = [&](int k) -> const hand::HandPose& {
    return solvedOf(live).trajectory.poses[static_cast<std::size_t>(k)];
  };
  const hand::HandModel& model = *live.session().hand().model;
  if (const auto* drag = std::get_if<session::DragEdit>(&edit)) {
    const int link = model.linkIndex(drag->link);
    const Eigen::Vector3d target_O =
        inverse(motion.motion->X_WO[static_cast<std::size_t>(frame)]) * drag->target_W;
    timed.change =
        session::dragWayOf(*drag, timed.when, time_s, target_O, [&](int k) -> Eigen::Vector3d {
          return hand::forwardKinematics(model, answer_at(k))[static_cast<std::size_t>(link)] *
                 drag->p_L;
        });
  } else if (const auto* lock = std::get_if<session::JointLockEdit>(&edit)) {
    session::JointLockEdit held = *lock;
    if (held.locked) held.value = answer_at(frame).q[model.dofIndex(held.joint)];
    timed.change = held;
  } else if (!takeChange(edit, timed.change)) {
    rejectInput(
        "'{}' has no time; a patch's weight, enabling, root or direction, a joint's limit, "
        "lock "
        "or soft value, a drag and its release have",
        session::describe(edit));
  }
  return timed;
}

std::optional<v1::EditTime> timeOfWholeEdit(LiveSession& live, const session::Edit& edit) {
  const std::string* patch = movedOnHand(edit);
  if (patch == nullptr || live.motion() == nullptr) return std::nullopt;
  const manipulation::Motion& motion = *live.motion()->motion;
  for (const manipulation::PatchTrack& track : motion.tracks) {
    if (track.name != *patch) continue;
    v1::EditTime when;
    when.time_s(motion.time_s[static_cast<std::size_t>(track.begin())] - motion.time_s.front());
    when.falloff_s(session::kLongestFalloff);
    return when;
  }
  return std::nullopt;
}

}  // namespace handgraft::server
