#pragma once

#include <string>
#include <vector>

namespace handgraft::server {

/// Keeps a server running: starts this program once more as the server, and again as one that
/// asks it (transport/server_probe.h), and starts the server anew, on its store, when it dies
/// or does not answer.
///
/// A server that gives no answer for 2 s is asked by another asker; what that one does not hear
/// of for as long again is killed, so 4 to 5 s after it fell silent. This process itself speaks
/// no DDS: what wedges a server cannot wedge it. Returns the exit code: 0 where the server was
/// asked to end (SIGTERM and SIGINT are passed on), its own where it never came to answer.
///
/// `arguments`: the server's, without the program's name. SIGTERM and SIGINT must be blocked,
/// and there must be no other thread.
int supervise(const std::vector<std::string>& arguments);

/// What `supervise` adds to the asker's arguments, before the server's process id.
inline constexpr const char* kAskOption = "--ask-process";

/// What the asker writes.
inline constexpr char kFoundServer = 'f';
inline constexpr char kAnswered = 'a';

}  // namespace handgraft::server
