#include "server/admission/session_rights.h"

namespace handgraft::server {

bool modifiesSession(v1::Operation operation) {
  switch (operation) {
    case v1::OP_CLOSE_SESSION:
    case v1::OP_OPTIMIZE:
    case v1::OP_STOP_SOLVING:
    case v1::OP_SOLVE_MOTION:
    case v1::OP_SET_CLOCK:
      return true;
    default:
      return false;
  }
}

void requireMayDo(v1::Operation operation, const LiveSession& live, const Who& who) {
  if (modifiesSession(operation)) requireMaySteer(live.access(), who, live.id());
}

}  // namespace handgraft::server
