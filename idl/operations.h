#pragma once

#include "idl/service.h"

/// What whoever carries requests must know of each operation: a new one is a line of the table
/// in operations.cpp, and one of the server's (server/admission/operations.cpp).
namespace handgraft::idl {

/// What one must be to ask for it. In a secured domain each has a topic of requests of its own,
/// so that DDS itself refuses who may not; in an open one all go by one topic.
enum class Privilege { kLook, kEdit, kOperate };

/// Who may answer it. What names something that lives in one server (a session, an upload, a
/// request) must not be taken by another one for its own.
enum class AnsweredBy { kAnyServer, kOneServer };

/// Which pages of the gateway may ask for it; of those who look, the others may, too.
enum class Pages { kNone, kThatEdit, kThatLook };

struct OperationTraits {
  v1::Operation operation;
  Privilege privilege;
  AnsweredBy answered_by;
  Pages pages;
};

/// Of an operation that does not exist: the highest privilege, one server, no pages.
OperationTraits traitsOf(v1::Operation operation);

/// The session that a request names; 0: its operation names none.
std::uint64_t sessionOf(const v1::RequestBody& body);

}  // namespace handgraft::idl
