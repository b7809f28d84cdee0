#pragma once

#include <optional>
#include <string>
#include <vector>

#include "idl/models.h"
#include "idl/service.h"
#include "idl/sessions.h"

namespace handgraft::client {

/// All that `handgraft grasp` knows at its end.
struct GraspResult {
  v1::SessionState session;
  v1::HandDescription hand;
  std::vector<std::string> object_notes;  ///< what reading its file had to say
  v1::TransferReply transfer;
  v1::PoseSolution solution;
  std::optional<v1::Weights> weights;  ///< that it was solved with; empty: not known
  double total_ms = 0.0;               ///< from the first request to the last reply
  bool kept = false;                   ///< the session lives on
  /// Of the hand that touched; unknown where nobody tells, or it was not asked for.
  v1::Chirality touched = v1::CHIRALITY_UNKNOWN;

  // === What else was waited for
  double server_ms = 0.0;  ///< until a server answered that was looked for, or started
  double models_ms = 0.0;  ///< until the session was open, with the hand's skin; in total_ms
  double files_ms = 0.0;   ///< of what was read before and written afterwards
};

/// What `handgraft doctor` found.
struct DoctorReport {
  std::string version;
  std::string interface;
  std::string address;
  int domain = 0;
  std::optional<v1::ServerStatus> server;  ///< nothing: none answered
  double found_ms = 0.0;                   ///< until the server's first status came
  double round_trip_ms = 0.0;              ///< median; 0: who only watches
  v1::ModelList models;
  std::string advice;  ///< what to do; empty when all is well
};

/// Throws TransportError unless joints, link poses and point lists fit the hand and are finite:
/// what comes from the wire may be anything.
void requireConsistent(const GraspResult& result);

/// The report of a patch's transfer; nullptr if there is none.
const v1::PatchReport* reportOf(const GraspResult& result, const std::string& patch);

}  // namespace handgraft::client
