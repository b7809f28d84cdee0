#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "client/link/grasp_result.h"
#include "idl/json.h"
#include "idl/models.h"
#include "idl/sessions.h"

/// What `--json` prints and `--out` writes: messages as idl/json.h writes them, and the few
/// documents that are put together of several.
namespace handgraft::client::json {

using idl::Json;
using idl::jsonOf;

/// Over several lines, for a document; on one, for events. Numbers that are not finite and
/// bytes that are no UTF-8 do not hurt.
inline std::string written(const Json& document, int indent = 2) {
  return idl::textOf(document, indent);
}

/// A message, as it is.
template <class Message>
std::string document(const Message& message) {
  return written(jsonOf(message));
}

Json doctor(const DoctorReport& report);

/// A summary, with what was noted when the model was read.
Json loaded(const v1::ModelSummary& summary, const std::vector<std::string>& notes);

/// `kind` and what describes it, but for meshes: of those, how large they are.
Json description(v1::ModelDescription description);

/// `handgraft-grasp/1` (idl/grasp_file.h), each patch with its report, dropped ones too.
Json grasp(const GraspResult& result);

/// A suggestion that was applied, and what came of it.
struct Applied {
  std::size_t number = 0;  ///< from 1
  std::uint64_t revision = 0;
  v1::PatchReport report;
};

Json suggestions(const v1::SuggestReply& reply, const std::optional<Applied>& applied);

/// The lines of `watch`: {"event": "state", ...} and {"event": "solution", ...}, the latter
/// with `joints`, positions by name.
std::string stateEvent(const v1::SessionState& state);
std::string solutionEvent(const v1::PoseSolution& solution,
                          const std::vector<std::string>& joint_names);
/// {"event": "motion", "session_id", "revision", "frame_count"}
std::string motionEvent(const v1::MotionFrames& frames);

}  // namespace handgraft::client::json
