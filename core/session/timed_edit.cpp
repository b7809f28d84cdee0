// What holds about one time of a motion.
#include "core/session/timed_edit.h"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include <utility>

#include "core/base/error.h"
#include "core/base/smooth_step.h"
#include "core/contact/contact_set.h"
#include "core/manipulation/motion.h"
#include "core/session/edit_checks.h"

namespace handgraft::session {

namespace {

constexpr double kMostTime = 1e12;  // s; recordings count from 1970, some in milliseconds

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

/// Both edit the same thing.
bool concernsSame(const TimedChange& a, const TimedChange& b) {
  if (a.index() != b.index()) return false;
  return std::visit(Overloaded{[&](const PatchRootEdit& one) {
                                 const auto& other = std::get<PatchRootEdit>(b);
                                 return one.patch == other.patch && one.side == other.side;
                               },
                               [&](const PatchDirectionEdit& one) {
                                 const auto& other = std::get<PatchDirectionEdit>(b);
                                 return one.patch == other.patch && one.side == other.side;
                               },
                               [&](const auto& one) {
                                 using One = std::decay_t<decltype(one)>;
                                 const One& other = std::get<One>(b);
                                 if constexpr (requires { one.patch; })
                                   return one.patch == other.patch;
                                 else if constexpr (requires { one.joint; })
                                   return one.joint == other.joint;
                                 else
                                   return one.link == other.link;
                               }},
                    a);
}

const DocumentPatch& requirePatch(const Document& document, const std::string& name) {
  std::vector<std::string> names;
  for (const DocumentPatch& patch : document.patches) {
    if (patch.name == name) return patch;
    names.push_back(patch.name);
  }
  rejectInput("there is no patch {}; there are {}", quoted(name), fmt::join(names, ", "));
}

void requireJointValue(double value, const std::string& what) {
  requireWithin(value, -kLargestJointValue, kLargestJointValue, what);
}

/// Checks what one change names, and its values.
struct ChangeCheck {
  const Document& document;
  const Models& models;

  void operator()(const PatchWeightEdit& edit) const {
    (void)requirePatch(document, edit.patch);
    requireWithin(edit.weight, 0.0, contact::kLargestWeight,
                  "weight of patch " + quoted(edit.patch));
  }

  void operator()(const PatchEnabledEdit& edit) const {
    (void)requirePatch(document, edit.patch);
  }

  void operator()(const PatchRootEdit& edit) const {
    (void)requirePatch(document, edit.patch);
    const std::string what = "root of patch " + quoted(edit.patch);
    validate(edit.side == Side::kObject ? *models.object_O : models.hand->skin->mesh(),
             edit.root, what.c_str());
  }

  void operator()(const PatchDirectionEdit& edit) const {
    (void)requirePatch(document, edit.patch);
    requireWithin(edit.angle_rad, -kLargestTurn, kLargestTurn,
                  "angle of patch " + quoted(edit.patch));
  }

  void operator()(const JointLimitEdit& edit) const {
    (void)models.hand->model->dofIndex(edit.joint);
    const std::string joint = "of joint " + quoted(edit.joint);
    requireJointValue(edit.lower, "lower limit " + joint);
    requireJointValue(edit.upper, "upper limit " + joint);
    if (edit.lower > edit.upper)
      rejectInput("lower limit {} {} is above its upper limit {}", edit.lower, joint,
                  edit.upper);
  }

  void operator()(const JointLockEdit& edit) const {
    (void)models.hand->model->dofIndex(edit.joint);
    if (!edit.locked) return;
    if (!edit.value)
      rejectInput("joint {}: a lock at a time needs a motion that has an answer there",
                  quoted(edit.joint));
    requireJointValue(*edit.value, "joint " + quoted(edit.joint));
  }

  void operator()(const JointSoftEdit& edit) const {
    (void)models.hand->model->dofIndex(edit.joint);
    requireWithin(edit.weight, 0.0, kLargestLambda,
                  "soft weight of joint " + quoted(edit.joint));
    requireJointValue(edit.value, "joint " + quoted(edit.joint));
  }

  void operator()(const DragPath& way) const {
    (void)models.hand->model->linkIndex(way.link);
    const std::string what = "drag of link " + quoted(way.link);
    requireWithin(way.weight, 0.0, contact::kLargestWeight, "weight of the " + what);
    if (way.targets_O.empty() || way.targets_O.size() > kMostDragFrames)
      rejectInput("{} holds {} frames; permitted are 1 to {}", what, way.targets_O.size(),
                  kMostDragFrames);
    requireWithin(way.first_frame, 0, manipulation::kMostFrames, "first frame of the " + what);
    for (const double value : way.p_L)
      requireWithin(value, -kLargestPosition, kLargestPosition, what);
    for (const Eigen::Vector3d& target : way.targets_O)
      for (const double value : target)
        requireWithin(value, -kLargestPosition, kLargestPosition, what);
  }

  void operator()(const ReleaseEdit& /*edit*/) const {
    rejectInput("a release is no state of a motion");
  }
};

}  // namespace

double influenceOf(const TimedEdit& edit, double time_s) {
  const double away = std::abs(time_s - edit.when.time_s);
  if (!(away < edit.when.falloff_s)) return away == 0.0 ? 1.0 : 0.0;
  return smoothStep(1.0 - away / edit.when.falloff_s);
}

int frameNearest(const std::vector<double>& time_s, double at_s) {
  const auto behind = std::lower_bound(time_s.begin(), time_s.end(), at_s);
  if (behind == time_s.begin()) return 0;
  const auto index = static_cast<int>(behind - time_s.begin());
  if (behind == time_s.end()) return index - 1;
  return at_s - *(behind - 1) <= *behind - at_s ? index - 1 : index;
}

std::map<int, double> influencesOf(const TimedEdit& edit, const std::vector<double>& time_s) {
  // Fully at a frame, so that what a user sees there is what was asked for.
  const int own = frameNearest(time_s, edit.when.time_s);
  std::map<int, double> influences = {{own, 1.0}};
  TimedEdit there = edit;
  there.when.time_s = time_s[static_cast<std::size_t>(own)];
  for (const int way : {-1, 1}) {
    for (int k = own + way; k >= 0 && k < static_cast<int>(time_s.size()); k += way) {
      const double influence = influenceOf(there, time_s[static_cast<std::size_t>(k)]);
      if (!(influence > 0.0)) break;
      influences[k] = influence;
    }
  }
  return influences;
}

void validate(const TimedEdit& edit, const Document& document, const Models& models) {
  requireWithin(edit.when.time_s, -kMostTime, kMostTime, "time of an edit");
  requireWithin(edit.when.falloff_s, 0.0, kLongestFalloff, "falloff of an edit");
  std::visit(ChangeCheck{document, models}, edit.change);
}

void addTimed(const TimedEdit& edit, const Models& models, Document& document) {
  if (const auto* release = std::get_if<ReleaseEdit>(&edit.change)) {
    const auto let_go = std::erase_if(document.timed, [&](const TimedEdit& held) {
      const auto* way = std::get_if<DragPath>(&held.change);
      return way != nullptr && (release->link.empty() || release->link == way->link) &&
             influenceOf(held, edit.when.time_s) > 0.0;
    });
    if (let_go == 0)
      rejectInput("{} is not held at {} s",
                  release->link.empty() ? "nothing" : "link " + quoted(release->link),
                  edit.when.time_s);
    return;
  }
  validate(edit, document, models);
  TimedEdit added = edit;
  const auto before =
      std::find_if(document.timed.begin(), document.timed.end(), [&](const TimedEdit& one) {
        return one.when.time_s == edit.when.time_s && concernsSame(one.change, edit.change);
      });
  if (before != document.timed.end()) {
    // Turns are told from where the direction is.
    if (auto* turn = std::get_if<PatchDirectionEdit>(&added.change))
      turn->angle_rad += std::get<PatchDirectionEdit>(before->change).angle_rad;
    document.timed.erase(before);
  }
  if (document.timed.size() >= kMostTimed)
    rejectInput("{} edits at times of this motion, as many as are permitted; undo some",
                document.timed.size());
  document.timed.push_back(std::move(added));
}

int dropUnfittingTimed(const Models& models, Document& document) {
  return static_cast<int>(std::erase_if(document.timed, [&](const TimedEdit& edit) {
    try {
      validate(edit, document, models);
    } catch (const InvalidInput&) {
      return true;
    }
    return false;
  }));
}

DragPath dragWayOf(const DragEdit& drag,
                   const EditTime& when,
                   const std::vector<double>& time_s,
                   const Eigen::Vector3d& target_O,
                   const std::function<Eigen::Vector3d(int frame)>& place_O) {
  if (drag.target_R_WL)
    rejectInput("drag of link {}: at a time a place is moved; a link is not turned",
                quoted(drag.link));
  const std::map<int, double> influences = influencesOf({when, ReleaseEdit{}}, time_s);
  if (influences.size() > kMostDragFrames)
    rejectInput("drag of link {}: its falloff of {} s takes in {} frames; permitted are {}",
                quoted(drag.link), when.falloff_s, influences.size(), kMostDragFrames);
  const Eigen::Vector3d way_O = target_O - place_O(frameNearest(time_s, when.time_s));
  DragPath way;
  way.link = drag.link;
  way.p_L = drag.p_L;
  way.weight = drag.weight > 0.0 ? drag.weight : 1.0;
  way.first_frame = influences.begin()->first;
  for (const auto& [frame, influence] : influences)
    way.targets_O.emplace_back(place_O(frame) + influence * way_O);
  return way;
}

}  // namespace handgraft::session
