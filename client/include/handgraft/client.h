#pragma once

/// A handgraft-server, from a program of one's own: models read and sent, grasps, live
/// sessions.
///
///     handgraft::client::Client server;
///     auto state = server.openSession(request).get();
///     handgraft::client::Session session(server, state);
///     auto pose = session.solve().get();
///
/// Every call returns at once with an answer on its way (pending.h): `get` waits for it, `then`
/// has a callback called. Messages are the contract's own (idl/*.idl), in SI units and radians;
/// a field is a pair of methods, `request.hand("human20")` and `request.hand()`. Errors are
/// exceptions: Refused with the server's own words, NoServer, InvalidInput. client/examples has
/// a worked example.
///
/// These headers are public: they change with a line in the changelog. What they include
/// besides is installed, too, and may change at any time.

#include "client/link/client.h"
#include "client/link/following.h"
#include "client/link/model_files.h"
#include "client/link/pending.h"
#include "client/link/session.h"
#include "client/link/wire_pose.h"
#include "core/base/error.h"
#include "core/base/pose.h"
#include "idl/edits.h"
#include "idl/service.h"
