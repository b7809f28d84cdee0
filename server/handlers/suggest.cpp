#include "server/handlers/suggest.h"

#include "server/handlers/transfer.h"
#include "server/messages/transfer_messages.h"

namespace handgraft::server {

v1::SuggestReply suggestPlacements(LiveSession& live,
                                   const v1::SuggestRequest& request,
                                   const Progress& progress) {
  const transfer::SuggestOptions options = suggestOptionsFrom(request);
  updateTransfers(live, progress);
  session::Session& session = live.session();
  const auto suggestions = session.suggest(request.patch(), options, progress);

  v1::SuggestReply reply;
  reply.session_id(live.id());
  reply.revision(session.revision());
  reply.patch(request.patch());
  for (const session::SessionPatch& patch : session.patches()) {
    if (patch.patch.name != request.patch()) continue;
    reply.present(patchReport(patch, *hand::coordinatesOf(session.hand())));
  }
  for (const transfer::Suggestion& suggestion : suggestions) {
    reply.suggestions().push_back(toMessage(suggestion, session.hand().skin->mesh()));
  }
  return reply;
}

}  // namespace handgraft::server
