#include "tests/bench/live/room.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <unistd.h>

namespace handgraft::bench {

namespace {

std::filesystem::path binary(const std::string& name) {
  return std::filesystem::path(HANDGRAFT_BIN_DIR) / name;
}

}  // namespace

Room::Room(const LiveOptions& options) {
  std::vector<std::string> arguments{"--domain", std::to_string(domain_.number())};
  const auto& given = options.server;
  arguments.insert(arguments.end(), given.begin(), given.end());
  // What a benchmark made shall not be there the next time.
  if (std::find(given.begin(), given.end(), "--state") == given.end())
    arguments.insert(arguments.end(), {"--state", ":memory:"});
  server_ = std::make_unique<test::Process>(binary("handgraft-server"), arguments);
  client_ = std::make_unique<EditClient>(network());
  if (!client_->requester().waitForServer(std::chrono::seconds(60)))
    throw std::runtime_error("no server: " + server_->err());
  load({"hand", options.hand, "--name", "bench_hand"});
  load({"object", options.object, "--name", "bench_object"});
  load({"contacts", options.contacts, "--object", "bench_object", "--name", "bench_contacts"});
  hand_ = describe(v1::MODEL_HAND, "bench_hand").hand();
  object_ = describe(v1::MODEL_OBJECT, "bench_object").object();
  contacts_ = describe(v1::MODEL_CONTACTS, "bench_contacts").contacts();
}

std::uint64_t Room::open() {
  v1::OpenSessionRequest request;
  request.hand("bench_hand");
  request.object("bench_object");
  request.contacts("bench_contacts");
  return client_->open(request).session_id();
}

void Room::solve(std::uint64_t session) {
  v1::OptimizeRequest optimize;
  optimize.session_id(session);
  v1::RequestBody body;
  body.optimize(optimize);
  client_->requester().ask(body);
}

std::uint64_t Room::openSolved() {
  const std::uint64_t session = open();
  solve(session);
  return session;
}

RandomEdits Room::edits(std::uint64_t session, unsigned seed) {
  return {seed,           client_->ofSession(v1::OP_TRANSFER, session).transfer().patches(),
          contacts_,      object_.mesh_O(),
          hand_.skin_S(), hand_.joints()};
}

std::string Room::placedPatch(std::uint64_t session) {
  const v1::ReplyBody laid = client_->ofSession(v1::OP_TRANSFER, session);
  for (const v1::PatchReport& patch : laid.transfer().patches())
    if (patch.placed()) return patch.name();
  throw std::runtime_error("no patch lies on the hand");
}

double Room::memoryKb() {
  std::ifstream in("/proc/" + pid() + "/status");
  std::string word;
  while (in >> word) {
    double value = 0.0;
    if (word == "RssAnon:" && in >> value) return value;
  }
  return 0.0;
}

double Room::processorSeconds() {
  std::ifstream file("/proc/" + pid() + "/stat");
  std::string text;
  std::getline(file, text);
  std::istringstream words(text.substr(text.rfind(')') + 2));
  std::string word;
  double ticks = 0.0;
  constexpr int kUser = 11, kSystem = 12;  // proc(5): fields 14 and 15
  for (int i = 0; words >> word; ++i) {
    if (i == kUser || i == kSystem) ticks += std::stod(word);
  }
  return ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

void Room::load(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "load");
  arguments.insert(arguments.end(), {"--domain", std::to_string(domain_.number())});
  const test::Finished done = test::run(binary("handgraft"), arguments);
  if (done.exit_code != 0) throw std::runtime_error(done.err);
}

v1::ModelDescription Room::describe(v1::ModelKind kind, const std::string& name) {
  v1::DescribeModelRequest request;
  v1::ModelKey key;
  key.kind(kind);
  key.name(name);
  request.model(key);
  request.with_meshes(true);
  v1::RequestBody body;
  body.describe_model(request);
  return client_->requester().ask(body).model();
}

std::string Room::pid() {
  return std::to_string(client_->requester().status().process_id());
}

}  // namespace handgraft::bench
