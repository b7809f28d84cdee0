#include "client/present/failure.h"

#include "client/present/typed_words.h"
#include "core/base/error.h"
#include "idl/cyclone/requester.h"

namespace handgraft::client {

namespace {

constexpr int kFailed = 1;
constexpr int kWrongInput = 2;

bool isWrongInput(v1::ErrorCode code) {
  return code == v1::ERROR_INVALID_INPUT || code == v1::ERROR_NOT_FOUND ||
         code == v1::ERROR_CONFLICT || code == v1::ERROR_UNITS;
}

}  // namespace

Failure failureOf(const std::exception& error) {
  if (dynamic_cast<const InvalidInput*>(&error) != nullptr) return {kWrongInput, error.what()};
  if (const auto* failed = dynamic_cast<const CommandFailed*>(&error)) {
    return {failed->exitCode(), failed->what()};
  }
  if (const auto* refused = dynamic_cast<const idl::cyclone::Refused*>(&error)) {
    return {isWrongInput(refused->code()) ? kWrongInput : kFailed, asTyped(refused->what())};
  }
  return {kFailed, error.what()};
}

}  // namespace handgraft::client
