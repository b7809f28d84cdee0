#pragma once

#include <optional>
#include <string>

#include "client/gateway/web_server.h"

namespace handgraft::client::gateway {

/// What the head of a request says, and what follows from it. No errors: whatever a stranger
/// writes is a name that nobody knows.

/// True for addresses that only programs of this machine reach.
bool isLoopback(const std::string& address);

/// "/live" of "/live?token=abc".
std::string pathOf(const std::string& target);

/// "abc" for the token of "/live?token=abc"; empty where there is none.
std::string parameterOf(const std::string& target, const std::string& name);

/// A page whose address names a session wants to see it, and need not come to say so: what it
/// would say. Empty: nothing.
std::string firstWord(const std::string& target);

/// On the loopback, whether `host` ("localhost:8080") is a name of this machine: one that
/// somebody else had point there is not. With another address any is.
bool isHostKnown(const std::string& address, const std::string& host);

/// Browsers say which page asks (`origin`); other programs need not.
bool isOriginKnown(const std::string& host, const std::string& origin);

/// What the token in the address permits; nothing if it is missing or wrong.
std::optional<Rights> rightsOf(const WebOptions& options, const std::string& target);

}  // namespace handgraft::client::gateway
