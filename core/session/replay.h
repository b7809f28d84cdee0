#pragma once

#include <string>

#include "core/session/session.h"

namespace handgraft::session {

/// What became of a log that was played.
struct Replay {
  Session session;          ///< as far as it went
  std::size_t entries = 0;  ///< played
  bool same = false;        ///< it ended as the saved session did, to the byte
  std::string message;      ///< where it differs first; empty if it does not
};

/// Plays a saved session's log from its first state. Edits are made anew; committed solves are
/// taken as the log has them, so that the result depends on no clock, or, with `solve_again`,
/// solved anew and compared with it.
/// Errors: InvalidInput if the first state does not fit the models. Cancelled on wish.
/// Cost: some 20 us an edit, and what drags, swaps and solves cost.
Replay replay(SessionModels models,
              const SavedSession& saved,
              bool solve_again,
              const Progress& progress);

}  // namespace handgraft::session
