#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/progress.h"
#include "core/session/session.h"

namespace handgraft::io {

/// A model that travels in the file, in a form that servers know: what it is made of.
struct EmbeddedModel {
  std::string kind;  ///< hand, object, contacts, motion
  std::string name;
  std::string content;  ///< SHA-256 of what it was made from
  std::string form;
  std::string settings;  ///< bytes, as are the next
  std::string bytes;
  std::string base;  ///< name of the model that it rests on; empty: none
};

/// The motion that a session holds instead of contacts, which go by its name.
struct MotionOfSession {
  std::string name;     ///< empty: it holds none
  std::string content;  ///< SHA-256 of what it was made from; empty for built-in ones
};

/// A saved session as its text says, before its models are looked up.
struct SessionFile {
  std::string hand;  ///< names of the models it was opened with
  std::string object;
  std::string contacts;
  MotionOfSession motion;
  /// SHA-256 of all models that it knew, by "hand NAME", "object NAME" and "contacts NAME".
  std::map<std::string, std::string> hashes;
  /// Some of them, each after what it rests on.
  std::vector<EmbeddedModel> held;
  session::SavedSession session;
};

/// The text of `handgraft-session/1` (README of this folder), exact: every number is written so
/// that reading gives the same bits.
/// Cost: milliseconds; models are hashed when they are first saved.
std::string sessionText(session::Session& session,
                        const std::vector<EmbeddedModel>& held = {},
                        const MotionOfSession& motion = {});

/// Kind and name of all models that opening and replaying it asks for.
std::set<std::pair<std::string, std::string>> modelsNamedIn(session::Session& session);

/// Reads such a text. Nothing is believed of it but its form: what it says is checked when it
/// is opened. Errors: InvalidInput naming the field.
SessionFile readSessionText(const std::string& text);

/// One entry of a session's log as a line of text, exact, and back: what a journal keeps of a
/// session between two of its texts. Errors of reading: InvalidInput naming the field.
std::string entryText(const session::LogEntry& entry);
session::LogEntry readEntryText(const std::string& text);

/// The session that a file holds, on these models, which carry the file's names.
/// Errors: InvalidInput naming a model that is another one than the session was saved with, or
/// what in its documents does not fit the models.
session::Session openSession(const SessionFile& file,
                             session::SessionModels models,
                             const Progress& progress);

/// The same for a replay: names and hashes alone. Errors: InvalidInput naming the model.
void requireSameModels(const SessionFile& file,
                       session::SessionModels models,
                       const Progress& progress);

}  // namespace handgraft::io
