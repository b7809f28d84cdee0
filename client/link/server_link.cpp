#include "client/link/server_link.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <random>
#include <utility>

#include "client/link/private_server.h"
#include "core/base/error.h"
#include "core/base/progress.h"
#include "idl/fields.h"

namespace handgraft::client {

namespace {

using std::chrono::milliseconds;

constexpr std::size_t kChunk = 524288;  // PutFileRequest.bytes
constexpr milliseconds kStartPatience(20000);

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

std::uint64_t randomId() {
  std::random_device device;
  return (static_cast<std::uint64_t>(device()) << 32U) | device();
}

}  // namespace

ServerLink::ServerLink(const Network& network, Absence absence, Interruption& interruption)
    : interruption_(interruption), connection_(std::make_unique<Connection>(network)) {
  if (absence == Absence::kFail || connection_->requester.waitForServer()) {
    connection_->requester.requireServer();
  } else {
    startPrivateServer(network);
  }
}

ServerLink::~ServerLink() {
  interruption_.whenRequested({});
}

bool ServerLink::rejoin() {
  constexpr milliseconds kPatience(2000);  // a server says once a second that it lives
  constexpr milliseconds kLook(20);
  auto fresh = std::make_unique<Connection>(participant().network());
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (!alive()) {
    if (fresh->requester.waitForServer(kLook)) {
      connection_ = std::move(fresh);
      connection_->requester.requireServer();
      return true;
    }
    interruption_.checkpoint();
    if (std::chrono::steady_clock::now() < until) continue;
    throw idl::cyclone::NoServer(fmt::format("handgraft-server on {} stopped answering",
                                             handgraft::describe(participant().network())));
  }
  return false;
}

void ServerLink::startPrivateServer(const Network& network) {
  interruption_.checkpoint();
  const auto program = findServerProgram();
  if (!program) {
    throw idl::cyclone::NoServer(
        fmt::format("no handgraft-server answers on {}, and there is no program of that name "
                    "beside this one "
                    "or on PATH to start",
                    handgraft::describe(network)));
  }
  fmt::print(stderr, "no server answers on {}: started one for this command\n",
             handgraft::describe(network));
  private_server_ = std::make_unique<PrivateServer>(*program, network);
  const auto until = std::chrono::steady_clock::now() + kStartPatience;
  while (!connection_->requester.waitForServer(milliseconds(200))) {
    interruption_.checkpoint();
    const bool ended = !private_server_->running();
    if (!ended && std::chrono::steady_clock::now() < until) continue;
    throw TransportError(fmt::format("{} {}: {}", program->string(),
                                     ended ? "ended at once" : "does not answer",
                                     quoted(private_server_->lastWords())));
  }
}

v1::ReplyBody ServerLink::ask(const v1::RequestBody& body) {
  interruption_.checkpoint();
  interruption_.whenRequested([this] {
    connection_->requester.cancel();
  });
  v1::ReplyBody reply;
  try {
    reply = connection_->requester.ask(body, on_progress_);
  } catch (const idl::cyclone::Refused& refused) {
    interruption_.whenRequested({});
    if (refused.code() == v1::ERROR_CANCELLED) throw Cancelled();
    throw;
  } catch (...) {
    interruption_.whenRequested({});
    throw;
  }
  interruption_.whenRequested({});
  interruption_.checkpoint();
  if (reply._d() != body._d()) {
    throw TransportError(fmt::format("the server answered operation {} with a reply to {}",
                                     static_cast<int>(body._d()),
                                     static_cast<int>(reply._d())));
  }
  return reply;
}

void ServerLink::ping() {
  ask(plainBody(v1::OP_NOTHING));
}

v1::ModelList ServerLink::listModels() {
  return ask(plainBody(v1::OP_LIST_MODELS)).models();
}

v1::ModelDescription ServerLink::describe(v1::ModelKind kind,
                                          const std::string& name,
                                          bool with_meshes) {
  v1::DescribeModelRequest request;
  request.model().kind(kind);
  request.model().name(name);
  request.with_meshes(with_meshes);
  v1::RequestBody body;
  body.describe_model(request);
  v1::ModelDescription description = ask(body).model();
  if (description._d() != kind) {
    throw TransportError(fmt::format("the server described '{}' as a {}, not a {}", name,
                                     nameOf(description._d()), nameOf(kind)));
  }
  return description;
}

void ServerLink::putFile(std::uint64_t upload_id, const UploadFile& file) {
  std::error_code error;
  const std::uintmax_t total = std::filesystem::file_size(file.path, error);
  std::ifstream in(file.path, std::ios::binary);
  if (error || !in) rejectInput("{}: cannot be read", quoted(file.path.string()));
  for (std::uintmax_t offset = 0; offset < total;) {
    v1::PutFileRequest request;
    request.upload_id(upload_id);
    request.uri(file.uri);
    request.total_bytes(total);
    request.offset(offset);
    request.bytes().resize(
        static_cast<std::size_t>(std::min<std::uintmax_t>(kChunk, total - offset)));
    in.read(reinterpret_cast<char*>(request.bytes().data()),
            static_cast<std::streamsize>(request.bytes().size()));
    if (!in) rejectInput("{}: changed while it was read", quoted(file.path.string()));
    offset += request.bytes().size();
    if (on_progress_) {
      on_progress_("sending " + file.path.filename().string(),
                   static_cast<double>(offset) / static_cast<double>(total));
    }
    v1::RequestBody body;
    body.put_file(std::move(request));
    ask(body);
  }
}

v1::ModelSummary ServerLink::load(const ModelFiles& model) {
  const std::uint64_t upload_id = randomId();
  for (const UploadFile& file : model.files)
    putFile(upload_id, file);
  v1::LoadModelRequest request;
  request.kind(model.kind);
  request.name(model.name);
  request.upload_id(upload_id);
  request.main_uri(model.main_uri);
  request.object(model.object);
  request.units(model.units);
  if (model.hand_options) request.hand().push_back(*model.hand_options);
  if (model.contact_options) request.contacts().push_back(*model.contact_options);
  v1::RequestBody body;
  body.load_model(request);
  const v1::ModelList list = ask(body).models();
  for (const v1::ModelSummary& summary : list.models()) {
    if (summary.kind() == model.kind && summary.name() == model.name) return summary;
  }
  throw TransportError(fmt::format("the server loaded '{}' and did not list it", model.name));
}

void ServerLink::unload(v1::ModelKind kind, const std::string& name) {
  v1::ModelKey key;
  key.kind(kind);
  key.name(name);
  v1::RequestBody body;
  body.unload_model(key);
  ask(body);
}

v1::ModelSummary ServerLink::poseContacts(const v1::PoseContactsRequest& request) {
  v1::RequestBody body;
  body.pose_contacts(request);
  const v1::ModelList list = ask(body).models();
  for (const v1::ModelSummary& summary : list.models()) {
    if (summary.kind() == v1::MODEL_CONTACTS && summary.name() == request.name())
      return summary;
  }
  throw TransportError(
      fmt::format("the server made contacts '{}' and did not list them", request.name()));
}

v1::ModelSummary ServerLink::makeVariant(const v1::VariantRequest& request) {
  v1::RequestBody body;
  body.variant(request);
  body._d(v1::OP_MAKE_VARIANT);
  const v1::ModelList list = ask(body).models();
  for (const v1::ModelSummary& summary : list.models()) {
    if (summary.kind() == v1::MODEL_HAND && summary.name() == request.name()) return summary;
  }
  throw TransportError(
      fmt::format("the server made hand '{}' and did not list it", request.name()));
}

v1::SweepReply ServerLink::sweep(const v1::SweepRequest& request) {
  v1::RequestBody body;
  body.sweep(request);
  body._d(v1::OP_SWEEP);
  return ask(body).sweep();
}

v1::SessionState ServerLink::openSession(const v1::OpenSessionRequest& request) {
  v1::RequestBody body;
  body.open_session(request);
  return ask(body).session();
}

v1::SessionState ServerLink::describeSession(std::uint64_t session_id) {
  return ask(sessionBody(v1::OP_DESCRIBE_SESSION, session_id)).session();
}

v1::SessionList ServerLink::listSessions() {
  return ask(plainBody(v1::OP_LIST_SESSIONS)).sessions();
}

v1::TransferReply ServerLink::transfer(std::uint64_t session_id) {
  return ask(sessionBody(v1::OP_TRANSFER, session_id)).transfer();
}

v1::SuggestReply ServerLink::suggest(const v1::SuggestRequest& request) {
  v1::RequestBody body;
  body.suggest(request);
  return ask(body).suggest();
}

v1::EditReply ServerLink::edit(std::uint64_t session_id,
                               std::uint64_t base_revision,
                               const v1::EditBody& body) {
  interruption_.checkpoint();
  return connection_->requester.edit(session_id, base_revision, body);
}

v1::PoseSolution ServerLink::optimize(const v1::OptimizeRequest& request) {
  v1::RequestBody body;
  body.optimize(request);
  return ask(body).solution();
}

v1::SessionSettings ServerLink::settings(std::uint64_t session_id) {
  return ask(sessionBody(v1::OP_SESSION_SETTINGS, session_id)).settings();
}

v1::CompareReply ServerLink::compare(const v1::CompareRequest& request) {
  v1::RequestBody body;
  body.compare(request);
  return ask(body).compare();
}

std::string ServerLink::saveSession(std::uint64_t session_id) {
  return ask(sessionBody(v1::OP_SAVE_SESSION, session_id)).saved_session().text();
}

v1::SessionState ServerLink::loadSession(const std::string& text) {
  v1::LoadSessionRequest request;
  request.text(text);
  v1::RequestBody body;
  body.load_session(request);
  return ask(body).session();
}

v1::ReplayReply ServerLink::replay(const std::string& text) {
  v1::ReplayRequest request;
  request.text(text);
  v1::RequestBody body;
  body.replay(request);
  return ask(body).replay();
}

std::string ServerLink::exportSession(const v1::ExportRequest& request) {
  v1::RequestBody body;
  body.export_file(request);
  const v1::ReplyBody reply = ask(body);
  const std::vector<std::uint8_t>& content = reply.exported_file().content();
  return {content.begin(), content.end()};
}

void ServerLink::closeSession(std::uint64_t session_id) {
  connection_->requester.ask(sessionBody(v1::OP_CLOSE_SESSION, session_id), {});
}

void ServerLink::stopSolving(std::uint64_t session_id) {
  connection_->requester.ask(sessionBody(v1::OP_STOP_SOLVING, session_id), {});
}

}  // namespace handgraft::client
