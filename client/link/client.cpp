#include "client/link/client.h"

#include <cstdio>
#include <mutex>
#include <utility>

#include "client/link/cancellation.h"
#include "client/link/private_server.h"
#include "client/link/upload.h"
#include "core/base/error.h"
#include "idl/fields.h"

namespace handgraft::client {

namespace {

using idl::cyclone::Discovers;
using idl::cyclone::Participant;
using idl::cyclone::Requester;
using std::chrono::milliseconds;

constexpr milliseconds kStartPatience(20000);

/// How long to look for a server before one is started: on this machine alone it is met within
/// 0.2 s, on a busy one, too; elsewhere it says once a second that it lives.
milliseconds lookOn(const Network& network) {
  constexpr milliseconds kHere(500);
  constexpr milliseconds kElsewhere(2000);
  return network.peers.empty() && validate(network).loopback ? kHere : kElsewhere;
}

v1::RequestBody plainBody(v1::Operation operation) {
  v1::RequestBody body;
  body.nothing(v1::Nothing());
  body._d(operation);
  return body;
}

v1::RequestBody sessionBody(v1::Operation operation, std::uint64_t session_id) {
  v1::SessionKey key;
  key.session_id(session_id);
  v1::RequestBody body;
  body.session(key);
  body._d(operation);
  return body;
}

Done done(const v1::ReplyBody& /*reply*/) {
  return {};
}

v1::SessionState sessionIn(v1::ReplyBody& reply) {
  return std::move(reply.session());
}

/// The model of that name in what the server lists after it made it.
v1::ModelSummary summaryIn(const v1::ModelList& list,
                           v1::ModelKind kind,
                           const std::string& name) {
  for (const v1::ModelSummary& summary : list.models()) {
    if (summary.kind() == kind && summary.name() == name) return summary;
  }
  throw TransportError(
      fmt::format("the server made {} '{}' and did not list it", nameOf(kind), name));
}

}  // namespace

struct Client::Impl {
  struct Connection {
    explicit Connection(const Network& network, Discovers discovers = Discovers::kNoClients)
        : participant(std::make_shared<Participant>(network, discovers)),
          requester(*participant) {}

    std::shared_ptr<Participant> participant;
    Requester requester;
  };

  explicit Impl(ClientOptions given)
      : options(std::move(given)),
        waiting(std::make_shared<const Waiting>(options.waiting)),
        connection(std::make_shared<Connection>(options.network)) {
    if (!options.on_notice) {
      options.on_notice = [](const std::string& line) {
        fmt::print(stderr, "{}\n", line);
      };
    }
  }

  [[nodiscard]] std::shared_ptr<Connection> connected() const {
    const std::lock_guard lock(mutex);
    return connection;
  }

  void checkpoint() const {
    if (waiting->checkpoint) waiting->checkpoint();
  }

  void startPrivateServer() {
    checkpoint();
    Network& network = options.network;
    const auto program = findServerProgram();
    if (!program) {
      throw NoServer(
          fmt::format("no handgraft-server answers on {}, and there is no program of that name "
                      "beside this one "
                      "or on PATH to start",
                      handgraft::describe(network)));
    }
    options.on_notice(fmt::format("no server answers on {}: started one for this command",
                                  handgraft::describe(network)));
    // Two commands at once: without a name each might ask the other's server, which ends first.
    if (options.absence == Absence::kStartPrivate && network.server.empty()) {
      network.server = ownServerName();
    }
    private_server = std::make_unique<PrivateServer>(*program, network);
    connection.reset();  // first: how often it announces itself is a matter of the domain
    connection = std::make_shared<Connection>(network, Discovers::kStartingServer);
    const auto until = std::chrono::steady_clock::now() + kStartPatience;
    while (!connection->requester.waitForServer(milliseconds(200))) {
      checkpoint();
      const bool ended = !private_server->running();
      if (!ended && std::chrono::steady_clock::now() < until) continue;
      throw TransportError(fmt::format("{} {}: {}", program->string(),
                                       ended ? "ended at once" : "does not answer",
                                       quoted(private_server->lastWords())));
    }
  }

  /// Sends a request; `read` makes the answer of the reply's body, and may throw.
  template <class T, class Read>
  Pending<T> call(const v1::RequestBody& body, Read read, bool can_stop = true) {
    const auto state = std::make_shared<typename Pending<T>::State>();
    state->waiting = waiting;
    state->finishes = !can_stop;
    const auto on = connected();
    const Requester::CallId id = on->requester.begin(
        body,
        [state, read, operation = body._d()](Requester::Outcome<v1::ReplyBody> outcome) {
          state->settle(answerOf<T>(outcome, operation, read));
        },
        [state](const std::string& stage, double fraction) {
          state->report(stage, fraction);
        });
    const std::lock_guard lock(state->mutex);
    if (!state->outcome && !state->taken) {
      state->cancel = [weak = std::weak_ptr(on), id] {
        if (const auto still = weak.lock()) still->requester.cancel(id);
      };
    }
    return Pending<T>(state);
  }

  template <class T, class Read>
  static Outcome<T> answerOf(Requester::Outcome<v1::ReplyBody>& outcome,
                             v1::Operation asked,
                             const Read& read) {
    if (const auto* error = std::get_if<std::exception_ptr>(&outcome)) return asTold(*error);
    auto& reply = std::get<v1::ReplyBody>(outcome);
    try {
      if (reply._d() != asked) {
        throw TransportError(fmt::format("the server answered operation {} with a reply to {}",
                                         static_cast<int>(asked),
                                         static_cast<int>(reply._d())));
      }
      return read(reply);
    } catch (...) {
      return std::current_exception();
    }
  }

  /// True of one that may change nothing, by its role in a secured domain.
  [[nodiscard]] bool onlyLooks() const {
    const auto& identity = connected()->participant->identity();
    return identity && identity->role == idl::security::Role::kViewer;
  }

  ClientOptions options;
  const std::shared_ptr<const Waiting> waiting;
  std::unique_ptr<PrivateServer> private_server;
  mutable std::mutex mutex;                ///< guards the pointer
  std::shared_ptr<Connection> connection;  ///< never null
  std::shared_ptr<Connection> joining;     ///< one that looks for a server; of rejoin alone
};

Client::Client(ClientOptions options) : impl_(std::make_unique<Impl>(std::move(options))) {
  Requester& requester = impl_->connection->requester;
  // None is started in a secured domain: a server's identity is not for its clients to have.
  const bool must_be_there =
      impl_->options.absence == Absence::kFail || !impl_->options.network.identity.empty();
  if (must_be_there || requester.waitForServer(lookOn(impl_->options.network))) {
    requester.requireServer();
  } else {
    impl_->startPrivateServer();
  }
}

Client::~Client() = default;

bool Client::onlyLooks() const {
  return impl_->onlyLooks();
}

// === The connection

bool Client::isPrivate() const {
  return impl_->private_server != nullptr;
}

const Network& Client::network() const {
  return impl_->options.network;
}

v1::ServerStatus Client::status() const {
  return impl_->connected()->requester.status();
}

bool Client::alive() const {
  return impl_->connected()->requester.waitForServer(milliseconds(0));
}

v1::ClientId Client::id() const {
  return impl_->connected()->requester.client();
}

void Client::checkpoint() const {
  impl_->checkpoint();
}

bool Client::rejoin() {
  constexpr milliseconds kPatience(2000);  // a server says once a second that it lives
  constexpr milliseconds kLook(20);
  // Kept from one attempt to the next: programs that are always new to each other may never
  // meet.
  if (impl_->joining == nullptr) impl_->joining = std::make_shared<Impl::Connection>(network());
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (!alive()) {
    if (impl_->joining->requester.waitForServer(kLook)) {
      std::shared_ptr<Impl::Connection> before = std::move(impl_->joining);
      {
        const std::lock_guard lock(impl_->mutex);
        impl_->connection.swap(before);
      }
      impl_->connection->requester.requireServer();
      return true;
    }
    checkpoint();
    if (std::chrono::steady_clock::now() < until) continue;
    throw NoServer(fmt::format("handgraft-server on {} stopped answering",
                               handgraft::describe(network())));
  }
  impl_->joining.reset();
  return false;
}

std::shared_ptr<const Participant> Client::participant() const {
  return impl_->connected()->participant;
}

Pending<v1::ReplyBody> Client::ask(const v1::RequestBody& body) {
  return impl_->call<v1::ReplyBody>(body, [](v1::ReplyBody& reply) {
    return std::move(reply);
  });
}

// === Models

Pending<Done> Client::ping() {
  return impl_->call<Done>(plainBody(v1::OP_NOTHING), done);
}

Pending<v1::ModelList> Client::listModels() {
  return impl_->call<v1::ModelList>(plainBody(v1::OP_LIST_MODELS), [](v1::ReplyBody& reply) {
    return std::move(reply.models());
  });
}

Pending<v1::ModelDescription> Client::describe(v1::ModelKind kind,
                                               const std::string& name,
                                               bool with_meshes) {
  v1::DescribeModelRequest request;
  request.model().kind(kind);
  request.model().name(name);
  request.with_meshes(with_meshes);
  v1::RequestBody body;
  body.describe_model(request);
  return impl_->call<v1::ModelDescription>(body, [kind, name](v1::ReplyBody& reply) {
    if (reply.model()._d() != kind) {
      throw TransportError(fmt::format("the server described '{}' as a {}, not a {}", name,
                                       nameOf(reply.model()._d()), nameOf(kind)));
    }
    return std::move(reply.model());
  });
}

Pending<v1::ModelSummary> Client::load(ModelFiles model) {
  const auto on = impl_->connected();
  const auto state = std::make_shared<Pending<v1::ModelSummary>::State>();
  state->waiting = impl_->waiting;
  const auto upload = std::make_shared<Upload>(on->requester, std::move(model), state);
  {
    const std::lock_guard lock(state->mutex);
    state->cancel = [upload = std::weak_ptr(upload), weak = std::weak_ptr(on)] {
      const auto still = weak.lock();
      if (const auto sending = upload.lock(); still && sending) sending->cancel();
    };
  }
  upload->start();
  return Pending<v1::ModelSummary>(state);
}

Pending<Done> Client::unload(v1::ModelKind kind, const std::string& name) {
  v1::ModelKey key;
  key.kind(kind);
  key.name(name);
  v1::RequestBody body;
  body.unload_model(key);
  return impl_->call<Done>(body, done);
}

Pending<v1::ModelSummary> Client::poseContacts(const v1::PoseContactsRequest& request) {
  v1::RequestBody body;
  body.pose_contacts(request);
  return impl_->call<v1::ModelSummary>(body, [name = request.name()](v1::ReplyBody& reply) {
    return summaryIn(reply.models(), v1::MODEL_CONTACTS, name);
  });
}

Pending<v1::ModelSummary> Client::makeVariant(const v1::VariantRequest& request) {
  v1::RequestBody body;
  body.variant(request);
  body._d(v1::OP_MAKE_VARIANT);
  return impl_->call<v1::ModelSummary>(body, [name = request.name()](v1::ReplyBody& reply) {
    return summaryIn(reply.models(), v1::MODEL_HAND, name);
  });
}

Pending<v1::SweepReply> Client::sweep(const v1::SweepRequest& request) {
  v1::RequestBody body;
  body.sweep(request);
  body._d(v1::OP_SWEEP);
  return impl_->call<v1::SweepReply>(body, [](v1::ReplyBody& reply) {
    return std::move(reply.sweep());
  });
}

// === Sessions

Pending<v1::SessionState> Client::openSession(const v1::OpenSessionRequest& request) {
  v1::RequestBody body;
  body.open_session(request);
  return impl_->call<v1::SessionState>(body, sessionIn);
}

Pending<v1::SessionState> Client::describeSession(std::uint64_t session_id) {
  return impl_->call<v1::SessionState>(sessionBody(v1::OP_DESCRIBE_SESSION, session_id),
                                       sessionIn);
}

Pending<v1::SessionList> Client::listSessions() {
  return impl_->call<v1::SessionList>(plainBody(v1::OP_LIST_SESSIONS),
                                      [](v1::ReplyBody& reply) {
                                        return std::move(reply.sessions());
                                      });
}

Pending<v1::TransferReply> Client::transfer(std::uint64_t session_id) {
  return impl_->call<v1::TransferReply>(sessionBody(v1::OP_TRANSFER, session_id),
                                        [](v1::ReplyBody& reply) {
                                          return std::move(reply.transfer());
                                        });
}

Pending<v1::SuggestReply> Client::suggest(const v1::SuggestRequest& request) {
  v1::RequestBody body;
  body.suggest(request);
  return impl_->call<v1::SuggestReply>(body, [](v1::ReplyBody& reply) {
    return std::move(reply.suggest());
  });
}

Pending<v1::EditReply> Client::edit(std::uint64_t session_id,
                                    std::uint64_t base_revision,
                                    const v1::EditBody& body,
                                    const std::optional<v1::EditTime>& when) {
  checkpoint();
  const auto state = std::make_shared<Pending<v1::EditReply>::State>();
  state->waiting = impl_->waiting;
  state->finishes = true;
  state->unfinished = std::make_exception_ptr(
      Refused(v1::ERROR_OUTCOME_UNKNOWN,
              "interrupted while no answer came: whether the edit was applied is not known"));
  impl_->connected()->requester.beginEdit(
      session_id, base_revision, body,
      [state](Outcome<v1::EditReply> outcome) {
        state->settle(std::move(outcome));
      },
      [state](const std::string& stage, double fraction) {
        state->report(stage, fraction);
      },
      when);
  return Pending<v1::EditReply>(state);
}

Pending<v1::PoseSolution> Client::optimize(const v1::OptimizeRequest& request) {
  v1::RequestBody body;
  body.optimize(request);
  return impl_->call<v1::PoseSolution>(body, [](v1::ReplyBody& reply) {
    return std::move(reply.solution());
  });
}

Pending<v1::SessionSettings> Client::settings(std::uint64_t session_id) {
  return impl_->call<v1::SessionSettings>(sessionBody(v1::OP_SESSION_SETTINGS, session_id),
                                          [](v1::ReplyBody& reply) {
                                            return std::move(reply.settings());
                                          });
}

Pending<v1::CompareReply> Client::compare(const v1::CompareRequest& request) {
  v1::RequestBody body;
  body.compare(request);
  return impl_->call<v1::CompareReply>(body, [](v1::ReplyBody& reply) {
    return std::move(reply.compare());
  });
}

Pending<std::string> Client::saveSession(std::uint64_t session_id) {
  return impl_->call<std::string>(sessionBody(v1::OP_SAVE_SESSION, session_id),
                                  [](v1::ReplyBody& reply) {
                                    return std::move(reply.saved_session().text());
                                  });
}

Pending<v1::SessionState> Client::loadSession(const std::string& text) {
  v1::LoadSessionRequest request;
  request.text(text);
  v1::RequestBody body;
  body.load_session(request);
  return impl_->call<v1::SessionState>(body, sessionIn);
}

Pending<v1::SessionState> Client::shareSession(const v1::ShareRequest& request) {
  v1::RequestBody body;
  body.share(request);
  return impl_->call<v1::SessionState>(body, sessionIn);
}

Pending<v1::ReplayReply> Client::replay(const std::string& text) {
  v1::ReplayRequest request;
  request.text(text);
  v1::RequestBody body;
  body.replay(request);
  return impl_->call<v1::ReplayReply>(body, [](v1::ReplyBody& reply) {
    return std::move(reply.replay());
  });
}

Pending<v1::MotionSummary> Client::solveMotion(const v1::SolveMotionRequest& request) {
  v1::RequestBody body;
  body.solve_motion(request);
  return impl_->call<v1::MotionSummary>(body, [](v1::ReplyBody& reply) {
    return std::move(reply.motion());
  });
}

Pending<v1::MotionFrames> Client::motionFrames(const v1::MotionFramesRequest& request) {
  v1::RequestBody body;
  body.motion_frames(request);
  return impl_->call<v1::MotionFrames>(body, [](v1::ReplyBody& reply) {
    return std::move(reply.motion_frames());
  });
}

Pending<v1::MotionClock> Client::setClock(const v1::ClockRequest& request) {
  v1::RequestBody body;
  body.clock(request);
  return impl_->call<v1::MotionClock>(body, [](v1::ReplyBody& reply) {
    return std::move(reply.clock());
  });
}

Pending<ExportedFile> Client::exportSession(const v1::ExportRequest& request) {
  v1::RequestBody body;
  body.export_file(request);
  return impl_->call<ExportedFile>(body, [](v1::ReplyBody& reply) {
    const std::vector<std::uint8_t>& content = reply.exported_file().content();
    return ExportedFile{{content.begin(), content.end()},
                        std::move(reply.exported_file().notes())};
  });
}

Pending<Done> Client::closeSession(std::uint64_t session_id) {
  return impl_->call<Done>(sessionBody(v1::OP_CLOSE_SESSION, session_id), done, false);
}

Pending<Done> Client::stopSolving(std::uint64_t session_id) {
  return impl_->call<Done>(sessionBody(v1::OP_STOP_SOLVING, session_id), done, false);
}

}  // namespace handgraft::client
