#pragma once

#include "client/link/client.h"
#include "client/present/interruption.h"
#include "client/present/progress_line.h"

namespace handgraft::client {

/// How a client waits while a person looks on: Ctrl-C cancels what it waits for (Cancelled),
/// and `progress`, if there is one, shows what goes on. Both outlive the client.
ClientOptions interactiveClient(const Network& network,
                                Absence absence,
                                const Interruption& interruption,
                                ProgressLine* progress = nullptr);

/// Of a command that leaves a session open: who names hosts means a server there, not one that
/// ends with the command.
Absence absenceFor(bool keeps_session, const Network& network);

}  // namespace handgraft::client
