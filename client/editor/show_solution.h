#pragma once

#include <string>

#include "client/editor/told.h"
#include "idl/models.h"
#include "idl/sessions.h"

/// What the editor says about a solution, for people and for programs.
namespace handgraft::client::editor {

/// Objective, mean distance, worst patch: what is known of a pose at once.
std::string poseLine(const v1::PoseSolution& solution);

/// The same, and what is known once a pose is explained.
std::string statusLine(const v1::PoseSolution& solution);
json::Json status(const v1::PoseSolution& solution);

/// Patch by patch how a solution fits.
Told tellSolution(const v1::PoseSolution& solution);

/// Where its searches ended, ranked.
Told tellMinima(const v1::PoseSolution& solution, const v1::HandDescription& hand);

}  // namespace handgraft::client::editor
