#include "server/handlers/sharing.h"

#include "idl/json.h"

namespace handgraft::server {

v1::SessionState shareSession(LiveSession& live,
                              const v1::ShareRequest& request,
                              const Who& who) {
  const SessionAccess access = shared(live.access(), request, who);
  if (live.journal) {
    v1::SessionState state = live.state();
    state.owner(access.owner);
    state.access(access.access);
    live.journal->store().keepAccess(live.id(), access, idl::jsonText(state));
  }
  live.grant(access);
  return live.state();
}

}  // namespace handgraft::server
