#pragma once

#include <exception>
#include <string>

#include "idl/common.h"

namespace handgraft::server {

/// What an exception tells a client.
struct ErrorReply {
  v1::ErrorCode code = v1::ERROR_INTERNAL;
  std::string message;
  std::string field;  ///< of the message, that is at fault; empty: none
};

/// The table of the README, "The way of a request". Our own mistakes are logged, too.
ErrorReply errorReplyOf(const std::exception_ptr& error);

}  // namespace handgraft::server
