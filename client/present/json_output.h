#pragma once

#include <cstdint>
#include <string>

#include "client/link/grasp_result.h"
#include "idl/models.h"
#include "idl/sessions.h"

/// What `--json` prints and `--out` writes; the README documents the documents. SI units and
/// radians unless a name says otherwise; numbers that are not finite are null; text that is not
/// UTF-8 has its bytes replaced. `indent` < 0 puts everything on one line.
namespace handgraft::client::json {

std::string doctor(const DoctorReport& report, int indent = 2);
std::string models(const v1::ModelList& list, int indent = 2);
/// With the notes of an object.
std::string loaded(const v1::ModelSummary& summary,
                   const std::vector<std::string>& notes = {},
                   int indent = 2);
std::string sessions(const v1::SessionList& list, int indent = 2);
std::string closed(std::uint64_t session_id, int indent = 2);
std::string unloaded(v1::ModelKind kind, const std::string& name, int indent = 2);

/// "format": "handgraft-grasp/1".
std::string grasp(const GraspResult& result, int indent = 2);

/// The lines of `watch`: {"event": "state", ...} and {"event": "solution", ...}.
std::string stateEvent(const v1::SessionState& state);
std::string solutionEvent(const v1::PoseSolution& solution,
                          const std::vector<std::string>& joint_names);

}  // namespace handgraft::client::json
