#pragma once

#include <functional>
#include <memory>
#include <string>

#include "client/link/absence.h"
#include "client/link/interruption.h"
#include "client/link/model_files.h"
#include "idl/cyclone/participant.h"
#include "idl/cyclone/requester.h"
#include "idl/service.h"

namespace handgraft::client {

class PrivateServer;

/// The server, as functions. Every call waits for the answer.
///
/// Errors of every call: Refused with the server's own words; NoServer; Cancelled once the user
/// asked to stop (a request under way is cancelled on the server first).
class ServerLink {
 public:
  using OnProgress = std::function<void(const std::string& stage, double fraction)>;

  /// Errors: InvalidInput for a bad network; NoServer; TransportError if a private server does
  /// not come up within 20 s (the message quotes its last words).
  ServerLink(const Network& network, Absence absence, Interruption& interruption);
  ~ServerLink();
  ServerLink(const ServerLink&) = delete;
  ServerLink& operator=(const ServerLink&) = delete;

  /// Called with the stages of whatever takes long, from now on.
  void onProgress(OnProgress on_progress) { on_progress_ = std::move(on_progress); }

  [[nodiscard]] bool isPrivate() const { return private_server_ != nullptr; }

  [[nodiscard]] v1::ServerStatus status() const { return connection_->requester.status(); }

  [[nodiscard]] bool alive() {
    return connection_->requester.waitForServer(std::chrono::milliseconds(0));
  }

  /// Finds a server that is not heard any more, for up to 2 s, if need be by joining the
  /// network anew, under another client's id: true is returned then, and readers made before
  /// stay deaf. A server that slept for longer than its lease is not found so (idl/README).
  /// Errors: NoServer if none is heard.
  bool rejoin();

  /// Under which the server knows this program's edits.
  [[nodiscard]] v1::ClientId client() const { return connection_->requester.client(); }

  [[nodiscard]] const idl::cyclone::Participant& participant() const {
    return connection_->participant;
  }

  void ping();
  v1::ModelList listModels();
  v1::ModelDescription describe(v1::ModelKind kind, const std::string& name, bool with_meshes);

  /// Sends all files, then has the server read them. Returns the server's summary of the model.
  v1::ModelSummary load(const ModelFiles& model);

  /// Contacts of a posed hand, as a model of the request's name.
  v1::ModelSummary poseContacts(const v1::PoseContactsRequest& request);

  /// A hand like another one, as a model of the request's name.
  v1::ModelSummary makeVariant(const v1::VariantRequest& request);
  v1::SweepReply sweep(const v1::SweepRequest& request);

  void unload(v1::ModelKind kind, const std::string& name);

  v1::SessionState openSession(const v1::OpenSessionRequest& request);
  v1::SessionState describeSession(std::uint64_t session_id);
  v1::SessionList listSessions();
  v1::TransferReply transfer(std::uint64_t session_id);
  v1::SuggestReply suggest(const v1::SuggestRequest& request);
  /// Refused (ERROR_CONFLICT) if the session is no longer at `base_revision`; 0: whatever it
  /// is.
  v1::EditReply edit(std::uint64_t session_id,
                     std::uint64_t base_revision,
                     const v1::EditBody& body);
  v1::PoseSolution optimize(const v1::OptimizeRequest& request);
  v1::SessionSettings settings(std::uint64_t session_id);
  v1::CompareReply compare(const v1::CompareRequest& request);
  /// handgraft-session/1.
  std::string saveSession(std::uint64_t session_id);
  /// Opens a session of what `saveSession` gave.
  v1::SessionState loadSession(const std::string& text);
  v1::ReplayReply replay(const std::string& text);
  /// The bytes of the file.
  std::string exportSession(const v1::ExportRequest& request);

  /// Works after an interruption, too. Errors: as above but for Cancelled.
  void closeSession(std::uint64_t session_id);
  /// Stops the solve in flight, whoever asked for it, also one that follows an edit. Likewise.
  void stopSolving(std::uint64_t session_id);

 private:
  struct Connection {
    explicit Connection(const Network& network)
        : participant(network), requester(participant) {}

    idl::cyclone::Participant participant;
    idl::cyclone::Requester requester;
  };

  void startPrivateServer(const Network& network);
  v1::ReplyBody ask(const v1::RequestBody& body);
  void putFile(std::uint64_t upload_id, const UploadFile& file);

  Interruption& interruption_;
  std::unique_ptr<PrivateServer> private_server_;
  std::unique_ptr<Connection> connection_;  // never null
  OnProgress on_progress_;
};

}  // namespace handgraft::client
