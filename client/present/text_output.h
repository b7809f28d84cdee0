#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/link/grasp_result.h"
#include "core/base/network.h"
#include "idl/models.h"
#include "idl/motions.h"
#include "idl/sessions.h"

/// What the commands print for people. Every text ends with a line break; names that came over
/// the wire are shown on one line.
namespace handgraft::client::text {

std::string doctor(const DoctorReport& report);
std::string models(const v1::ModelList& list);
std::string sessions(const v1::SessionList& list);

/// The table of patches, what was dropped, the objective, joints at their limits, times.
std::string grasp(const GraspResult& result);

/// "shadow_hand (mirrored) grasps mug": by the names that people gave.
std::string titleOf(const v1::SessionState& session,
                    const v1::HandDescription& hand,
                    const std::string& does);

/// "2 of 3 patches reached", of a solution that is diagnosed.
std::string reachedText(const v1::PoseSolution& solution);

/// What the mirrored hand might change: see `grasp`.
bool isLessThanHalfReached(const v1::PoseSolution& solution);

/// One line each, without a line break.
std::string stateLine(const v1::SessionState& state);
/// "on the way" while the solve goes on, "pose" once it ended, "solution" once that is
/// diagnosed.
std::string solutionLine(const v1::PoseSolution& solution);
/// A motion that is solved.
std::string motionLine(const v1::MotionFrames& frames);
/// Verdict and depth, without a line break: what is known once a pose is diagnosed; may be
/// empty.
std::string explanation(const v1::PoseSolution& solution);

/// Text from the wire on one line, as `quoted` has it but without its quotes.
std::string plain(const std::string& text);

/// "thumb_mcp upper", each.
std::vector<std::string> limitNames(const std::vector<v1::JointLimit>& limits);

/// The same of several, with commas between them.
std::string listed(const std::vector<std::string>& items);

/// A text from the wire in lines of at most 100 columns, each ended, all but the first
/// indented: none of it is left out. A longer word has a line of its own.
std::string wrapped(const std::string& text);

/// What keeps patches away: a paragraph each of those that are not reached; and which angle is
/// judged, where the tables' could be taken for it.
std::string shortfalls(const v1::PoseSolution& solution);

/// A line each: `note: ...`.
std::string notes(const std::vector<std::string>& notes);

/// The terms of a solution's objective; with the weights, all that it is the sum of, and what
/// penetration is charged for where none is seen in the object.
std::string terms(const v1::PoseSolution& solution, const std::optional<v1::Weights>& weights);

/// Rows in columns as wide as they need on a terminal. `alignment` has a letter a column, `l`
/// or `r`, the last one for all that follow.
std::string table(const std::vector<std::vector<std::string>>& rows,
                  const std::string& alignment);

/// The options that bring another command to the same network, a blank before each; none where
/// they are the usual ones.
std::string networkOptions(const Network& network);

}  // namespace handgraft::client::text
