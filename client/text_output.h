#pragma once

#include <string>

#include "client/grasp_result.h"
#include "idl/models.h"
#include "idl/sessions.h"

/// What the commands print for people. Every text ends with a line break; names that came over
/// the wire are shown on one line.
namespace handgraft::client::text {

std::string doctor(const DoctorReport& report);
std::string models(const v1::ModelList& list);
std::string description(const v1::ModelDescription& description);
std::string sessions(const v1::SessionList& list);

/// The table of patches, what was dropped, the objective, joints at their limits, times.
std::string grasp(const GraspResult& result);

/// One line each, without a line break.
std::string stateLine(const v1::SessionState& state);
std::string solutionLine(const v1::PoseSolution& solution);

/// Text from the wire on one line, as `quoted` has it but without its quotes.
std::string plain(const std::string& text);

/// Rows in columns as wide as they need; all but the first column flush right if `numbers`.
std::string table(const std::vector<std::vector<std::string>>& rows, bool numbers);

}  // namespace handgraft::client::text
