#include "server/handlers/settings.h"

#include "server/messages/session_messages.h"

namespace handgraft::server {

v1::SessionSettings sessionSettings(LiveSession& live) {
  v1::SessionSettings message = settingsMessage(live.session());
  message.state(live.state());
  return message;
}

v1::CompareReply compareSnapshots(LiveSession& live,
                                  const v1::CompareRequest& request,
                                  const Progress& progress) {
  return toMessage(live.session().compare(request.a(), request.b(), progress));
}

}  // namespace handgraft::server
