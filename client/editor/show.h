#pragma once

#include <string>
#include <vector>

#include "client/json_parts.h"
#include "idl/models.h"
#include "idl/sessions.h"

/// What the editor says about a session, for people and for programs.
namespace handgraft::client::editor {

/// Of what a command has to say: lines for people, each ended, and an object for programs.
struct Told {
  std::string text;
  json::Json data = json::Json::object();
};

/// One line: objective, mean distance, worst patch, verdict.
std::string statusLine(const v1::PoseSolution& solution);
json::Json status(const v1::PoseSolution& solution);

/// Patch by patch how a solution fits.
Told tellSolution(const v1::PoseSolution& solution);

// === Topics of `show`
Told tellSession(const v1::SessionSettings& settings);
Told tellPatches(const v1::SessionSettings& settings);
Told tellJoints(const v1::SessionSettings& settings);
Told tellSettings(const v1::SessionSettings& settings);
Told tellHistory(const v1::SessionSettings& settings);
Told tellSnapshots(const v1::SessionSettings& settings);
Told tellMinima(const v1::PoseSolution& solution, const v1::HandDescription& hand);

Told tellDifferences(const v1::CompareReply& reply);

}  // namespace handgraft::client::editor
