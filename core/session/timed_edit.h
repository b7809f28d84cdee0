#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/session/document.h"
#include "core/session/models.h"

namespace handgraft::session {

/// How much of a timed edit holds at a time, in [0, 1]: all of it at its own, nothing
/// `falloff_s` away and beyond, without a bend between.
double influenceOf(const TimedEdit& edit, double time_s);

/// Of the frames of a motion at which it is above 0. An edit without a falloff is that of the
/// frame nearest to its time. `time_s` rises and is not empty.
std::map<int, double> influencesOf(const TimedEdit& edit, const std::vector<double>& time_s);

/// The frame whose time is nearest. `time_s` rises and is not empty.
int frameNearest(const std::vector<double>& time_s, double at_s);

/// Puts an edit into a document: in place of an earlier one of the same thing at the same time,
/// behind all others. A release lets the drags of its link go that hold at its time.
/// Errors: InvalidInput naming the patch, joint, link or value.
void addTimed(const TimedEdit& edit, const Models& models, Document& document);

/// What a document promises of a timed edit. Errors: InvalidInput.
void validate(const TimedEdit& edit, const Document& document, const Models& models);

/// Lets timed edits go that name what the models of a document do not have (after a swap);
/// how many went.
int dropUnfittingTimed(const Models& models, Document& document);

/// A drag at a time: the place of a link goes from where a motion has it to `target_O` at the
/// edit's own frame, and about it as far as the edit holds there.
///
/// `place_O` tells where the motion has the place, frame by frame. Errors: InvalidInput for
/// more than kMostDragFrames.
DragPath dragWayOf(const DragEdit& drag,
                   const EditTime& when,
                   const std::vector<double>& time_s,
                   const Eigen::Vector3d& target_O,
                   const std::function<Eigen::Vector3d(int frame)>& place_O);

inline constexpr std::size_t kMostTimed = 256;        ///< of a document
inline constexpr std::size_t kMostDragFrames = 4096;  ///< that one drag holds
inline constexpr double kLongestFalloff = 1e6;        // s

}  // namespace handgraft::session
