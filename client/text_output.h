#pragma once

#include <string>
#include <vector>

#include "client/grasp_result.h"
#include "idl/models.h"
#include "idl/sessions.h"

/// What the commands print for people. Every text ends with a line break; names that came over
/// the wire are shown on one line.
namespace handgraft::client::text {

std::string doctor(const DoctorReport& report);
std::string models(const v1::ModelList& list);
std::string sessions(const v1::SessionList& list);

/// The table of patches, what was dropped, the objective, joints at their limits, times.
std::string grasp(const GraspResult& result);

/// One line each, without a line break.
std::string stateLine(const v1::SessionState& state);
std::string solutionLine(const v1::PoseSolution& solution);

/// Text from the wire on one line, as `quoted` has it but without its quotes.
std::string plain(const std::string& text);

/// The same of several, with commas between them.
std::string listed(const std::vector<std::string>& items);

/// A line each: `note: ...`.
std::string notes(const std::vector<std::string>& notes);

/// Rows in columns as wide as they need. `alignment` has a letter a column, `l` or `r`, the
/// last one for all that follow.
std::string table(const std::vector<std::vector<std::string>>& rows,
                  const std::string& alignment);

}  // namespace handgraft::client::text
