#pragma once

#include <span>

#include "client/editor/command_table.h"
#include "client/editor/grammar.h"
#include "idl/sessions.h"

/// The commands that make edits, each row beside the function that makes its edit of what was
/// typed: InvalidInput names the thing, its value and what it may be; and errors of the
/// context.
namespace handgraft::client::editor {

// === In edit_builders.cpp
std::span<const Command> patchCommands();
std::span<const Command> jointCommands();

// === In pose_builders.cpp
std::span<const Command> poseCommands();
std::span<const Command> motionCommands();
std::span<const Command> modelCommands();
std::span<const Command> historyCommands();

/// `solving` with what the options of `solver` and `solve` change of it. Errors: InvalidInput
/// for options that contradict each other and for counts out of range.
v1::SolveOptions solvingWith(v1::SolveOptions solving, const Match& match);

}  // namespace handgraft::client::editor
