#include "client/present/interactive_client.h"

namespace handgraft::client {

ClientOptions interactiveClient(const Network& network,
                                Absence absence,
                                const Interruption& interruption,
                                ProgressLine* progress) {
  ClientOptions options;
  options.network = network;
  options.absence = absence;
  options.waiting.checkpoint = [&interruption] {
    interruption.checkpoint();
  };
  if (progress != nullptr) {
    options.waiting.on_progress = [progress](const std::string& stage, double fraction) {
      progress->show(stage, fraction);
    };
  }
  return options;
}

Absence absenceFor(bool keeps_session, const Network& network) {
  return keeps_session && !network.peers.empty() ? Absence::kFail : Absence::kStartPrivate;
}

}  // namespace handgraft::client
