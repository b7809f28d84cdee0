#pragma once

#include <exception>

#include "core/base/error.h"
#include "idl/cyclone/requester.h"

namespace handgraft::client {

/// An error as callers see it: what the server stopped on somebody's wish is Cancelled.
inline std::exception_ptr asTold(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const idl::cyclone::Refused& refused) {
    return refused.code() == v1::ERROR_CANCELLED ? std::make_exception_ptr(Cancelled()) : error;
  } catch (...) {
    return error;
  }
}

}  // namespace handgraft::client
