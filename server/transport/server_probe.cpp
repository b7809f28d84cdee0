#include "server/transport/server_probe.h"

#include <chrono>
#include <mutex>
#include <optional>
#include <thread>

#include "idl/client_id.h"
#include "idl/peer_names.h"
#include "idl/security/rights.h"
#include "server/transport/fast_endpoints.h"
#include "server/transport/fast_node.h"
#include "server/transport/participant_directory.h"

namespace handgraft::server {

namespace {

/// What the server was heard to say last.
class Heard {
 public:
  Heard(unsigned process_id, const std::function<void(bool)>& on_status)
      : process_id_(process_id), on_status_(on_status) {}

  void take(const v1::ServerStatus& status) {
    if (status.process_id() != process_id_) return;
    const std::lock_guard lock(mutex_);
    on_status_(known_ && status.requests_answered() > known_->requests_answered());
    known_ = status;
  }

  /// 0 before it was heard.
  [[nodiscard]] std::uint64_t server() const {
    const std::lock_guard lock(mutex_);
    return known_ ? known_->server_id() : 0;
  }

 private:
  const unsigned process_id_;
  const std::function<void(bool)>& on_status_;
  mutable std::mutex mutex_;
  std::optional<v1::ServerStatus> known_;
};

}  // namespace

void probeServer(const Network& network,
                 unsigned process_id,
                 const std::function<void(bool)>& on_status,
                 const std::function<bool()>& is_over) {
  constexpr std::chrono::milliseconds kPeriod(500);
  routeVendorLog();
  validate(network);
  std::vector<std::string> without_address;
  const Network reached = idl::withPeerAddresses(network, &without_address);
  const Identity identity = identityOf(network);
  ParticipantDirectory participants(identity);
  const Node node(reached, identity, participants);
  std::optional<FastWriter<v1::Request>> requests;
  try {
    requests.emplace(node.own(), identity ? idl::kLookTopic : idl::kRequestTopic);
  } catch (const TransportError& error) {
    if (identity) rejectInput("{}: {}", network.identity, error.what());
    throw;
  }
  Heard heard(process_id, on_status);
  const FastReader<v1::ServerStatus> statuses(
      node.endpoints(), idl::kStatusTopic, [&heard](v1::ServerStatus&& status, const Sender&) {
        heard.take(status);
      });
  v1::Request question;
  question.client(idl::randomClient());
  question.protocol_version(v1::PROTOCOL_VERSION);
  question.body().nothing(v1::Nothing());
  for (std::uint64_t id = 1; !is_over(); ++id) {
    question.request_id(id);
    question.server_id(heard.server());
    if (question.server_id() != 0) requests->write(question);
    std::this_thread::sleep_for(kPeriod);
  }
}

}  // namespace handgraft::server
