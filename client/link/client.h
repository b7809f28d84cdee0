#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "client/link/model_files.h"
#include "client/link/pending.h"
#include "core/base/network.h"
#include "idl/cyclone/requester.h"
#include "idl/service.h"

namespace handgraft::client {

using idl::cyclone::NoServer;
using idl::cyclone::Refused;

/// What to do when no server answers. None is started in a secured domain: NoServer there.
enum class Absence {
  kFail,          ///< NoServer within 2 s
  kStartPrivate,  ///< start one that ends with the client and that no other meets
  kStartShared,   ///< start one that ends with the client; until then others meet it, too
};

struct ClientOptions {
  Network network;
  Absence absence = Absence::kFail;
  Waiting waiting = {};
  /// For people, e.g. that a server was started; empty: on standard error.
  std::function<void(const std::string& line)> on_notice = {};
};

/// A session as a file for other programs.
struct ExportedFile {
  std::string content;             ///< its bytes
  std::vector<std::string> notes;  ///< what the file does not say, or says with less
};

/// A handgraft-server, as functions. None waits; each returns an answer on its way, and any
/// number may be under way at once.
///
/// Errors of every call, told by its answer: Refused with the server's own words; Cancelled;
/// NoServer; TransportError for what does not fit a request.
/// Threads: all methods from any thread, but for `rejoin`.
class Client {
 public:
  /// Waits for a server: up to 2 s, or until the private one is up.
  /// Errors: InvalidInput for a bad network; NoServer; Refused (ERROR_VERSION); TransportError
  /// if a private server does not come up within 20 s (the message quotes its last words).
  explicit Client(ClientOptions options = {});
  /// What is under way ends as NoServer.
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  // === The connection

  /// True of a server that ends with this client.
  [[nodiscard]] bool isPrivate() const;
  [[nodiscard]] const Network& network() const;
  [[nodiscard]] v1::ServerStatus status() const;
  [[nodiscard]] bool alive() const;

  /// Under which the server knows this program's edits.
  [[nodiscard]] v1::ClientId id() const;

  /// Throws what `Waiting::checkpoint` throws.
  void checkpoint() const;

  /// Finds a server that is not heard any more, for up to 2 s, if need be by joining the
  /// network anew: true is returned then, the id is another one, what was under way ends as
  /// NoServer, and sessions' streams follow. A server that slept for longer than its lease is
  /// not found so (idl/README). Errors: NoServer if none is heard.
  bool rejoin();

  /// The connection that stands; what reads streams keeps it and looks whether it changed.
  [[nodiscard]] std::shared_ptr<const idl::cyclone::Participant> participant() const;

  /// True of a viewer in a secured domain (idl/security): what would change something is
  /// Refused (ERROR_NOT_PERMITTED).
  [[nodiscard]] bool onlyLooks() const;

  /// Any request of the contract, for what has no function below.
  Pending<v1::ReplyBody> ask(const v1::RequestBody& body);

  // === Models

  Pending<Done> ping();
  Pending<v1::ModelList> listModels();
  Pending<v1::ModelDescription> describe(v1::ModelKind kind,
                                         const std::string& name,
                                         bool with_meshes);
  /// Sends all files, then has the server read them. InvalidInput for a file that cannot be
  /// read.
  Pending<v1::ModelSummary> load(ModelFiles model);
  Pending<Done> unload(v1::ModelKind kind, const std::string& name);
  /// Contacts of a posed hand, as a model of the request's name.
  Pending<v1::ModelSummary> poseContacts(const v1::PoseContactsRequest& request);
  /// A hand like another one, as a model of the request's name.
  Pending<v1::ModelSummary> makeVariant(const v1::VariantRequest& request);
  Pending<v1::SweepReply> sweep(const v1::SweepRequest& request);

  // === Sessions; client/link/session.h has them as objects

  Pending<v1::SessionState> openSession(const v1::OpenSessionRequest& request);
  Pending<v1::SessionState> describeSession(std::uint64_t session_id);
  Pending<v1::SessionList> listSessions();
  Pending<v1::TransferReply> transfer(std::uint64_t session_id);
  Pending<v1::SuggestReply> suggest(const v1::SuggestRequest& request);
  /// Refused (ERROR_CONFLICT) if the session is no longer at `base_revision`; 0: whatever it
  /// is. Edits are applied in the order of the calls where each waits for the one before. A
  /// wish to stop leaves it 2 s for its answer: Refused (ERROR_OUTCOME_UNKNOWN) then, as after
  /// 30 s in which the server was silent: it may have been applied. `when`: at a time of the
  /// session's motion alone.
  Pending<v1::EditReply> edit(std::uint64_t session_id,
                              std::uint64_t base_revision,
                              const v1::EditBody& body,
                              const std::optional<v1::EditTime>& when = {});
  Pending<v1::PoseSolution> optimize(const v1::OptimizeRequest& request);
  /// Of a session that holds a motion: its frames are asked for afterwards.
  Pending<v1::MotionSummary> solveMotion(const v1::SolveMotionRequest& request);
  /// As many frames as fit into a message; `is_last` says whether there are more.
  Pending<v1::MotionFrames> motionFrames(const v1::MotionFramesRequest& request);
  /// The clock that all who watch a session's motion share, as it stands then.
  Pending<v1::MotionClock> setClock(const v1::ClockRequest& request);
  Pending<v1::SessionSettings> settings(std::uint64_t session_id);
  Pending<v1::CompareReply> compare(const v1::CompareRequest& request);
  /// handgraft-session/1.
  Pending<std::string> saveSession(std::uint64_t session_id);
  /// Opens a session of what `saveSession` gave.
  Pending<v1::SessionState> loadSession(const std::string& text);
  Pending<v1::ReplayReply> replay(const std::string& text);
  Pending<ExportedFile> exportSession(const v1::ExportRequest& request);
  /// In a secured domain; for the session's owner and operators.
  Pending<v1::SessionState> shareSession(const v1::ShareRequest& request);
  /// Works after an interruption, too, where the server answers within 2 s.
  Pending<Done> closeSession(std::uint64_t session_id);
  /// Stops the solve in flight, whoever asked for it, also one that follows an edit. Likewise.
  Pending<Done> stopSolving(std::uint64_t session_id);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace handgraft::client
