#pragma once

#include <optional>
#include <set>
#include <string>

#include "client/editor/command_output.h"
#include "idl/models.h"
#include "idl/sessions.h"

/// What the editor says about a solution, for people and for programs.
namespace handgraft::client::editor {

/// Names of patches that do not count.
using Off = std::set<std::string>;

/// Of a solution that is diagnosed.
Off offIn(const v1::PoseSolution& solution);

/// Objective, mean distance, worst patch: what is known of a pose at once.
std::string poseLine(const v1::PoseSolution& solution, const Off& off);

/// The same, and what is known once a pose is diagnosed.
std::string statusLine(const v1::PoseSolution& solution, const Off& off);
json::Json status(const v1::PoseSolution& solution, const Off& off);

/// Patch by patch how a solution fits; `weights` that it was solved with, if they are known.
CommandOutput tellSolution(const v1::PoseSolution& solution,
                           const Off& off,
                           const std::optional<v1::Weights>& weights);

/// Where its searches ended, ranked.
CommandOutput tellMinima(const v1::PoseSolution& solution, const v1::HandDescription& hand);

}  // namespace handgraft::client::editor
