#include "server/admission/error_reply.h"

#include <new>

#include <fmt/format.h>

#include "core/base/error.h"
#include "idl/check.h"
#include "server/base/rejection.h"
#include "server/log/log.h"
#include "server/store/database.h"

namespace handgraft::server {

ErrorReply errorReplyOf(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const Rejection& rejection) {
    return {rejection.code(), rejection.what(), ""};
  } catch (const idl::InvalidField& wrong) {
    return {v1::ERROR_INVALID_INPUT, wrong.what(), wrong.path()};
  } catch (const InvalidInput& input) {
    return {v1::ERROR_INVALID_INPUT, input.what(), ""};
  } catch (const Cancelled& cancelled) {
    return {v1::ERROR_CANCELLED, cancelled.what(), ""};
  } catch (const StorageError& failure) {
    log::error("event=storage_error what={}", handgraft::quoted(failure.what()));
    return {v1::ERROR_STORAGE, failure.what(), ""};
  } catch (const std::bad_alloc&) {
    return {v1::ERROR_OVERLOADED, "the server has not enough memory for this", ""};
  } catch (const std::exception& mistake) {
    log::error("event=internal_error what={}", handgraft::quoted(mistake.what()));
    return {v1::ERROR_INTERNAL, fmt::format("internal error: {}", mistake.what()), ""};
  } catch (...) {
    log::error("event=internal_error what=unknown");
    return {v1::ERROR_INTERNAL, "internal error", ""};
  }
}

}  // namespace handgraft::server
