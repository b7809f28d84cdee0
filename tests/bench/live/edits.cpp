// handgraft-edit-bench: what an editor waits for, with a server of its own on loopback.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <unistd.h>

#include "tests/bench/live/edit_desk.h"
#include "tests/bench/live/random_edits.h"
#include "tests/bench/timing.h"
#include "tests/support/process.h"
#include "tests/support/shared_data.h"
#include "tests/support/test_domain.h"

namespace {

using namespace handgraft;
using namespace handgraft::bench;
using std::chrono::milliseconds;
using std::chrono::seconds;

struct Options {
  std::string hand = test::sharedData("hands/allegro_right/allegro_hand_right.urdf").string();
  std::string object = test::sharedData("objects/ycb/006_mustard_bottle.obj").string();
  std::string contacts =
      test::sharedData("contacts/dexycb/006_mustard_bottle_grasp0_contact.ply").string();
  int edits = 1000;
  int sessions = 100;
  int rate = 10;
  int seconds = 10;
  unsigned seed = 1;
  int domain = 0;  // of `pour`, as is the next
  std::uint64_t session = 0;
  std::vector<std::string> server;
};

/// A server of a domain of its own, with the models, and an editor of its sessions.
class Room {
 public:
  explicit Room(const Options& options) : options_(options) {
    std::vector<std::string> arguments{"--domain", std::to_string(domain_.number())};
    arguments.insert(arguments.end(), options.server.begin(), options.server.end());
    server_ = std::make_unique<test::Process>(binary("handgraft-server"), arguments);
    desk_ = std::make_unique<EditDesk>(Network{domain_.number(), "lo"});
    if (!desk_->requester().waitForServer(seconds(60)))
      throw std::runtime_error("no server: " + server_->err());
    load({"hand", options.hand, "--name", "bench_hand"});
    load({"object", options.object, "--name", "bench_object"});
    load(
        {"contacts", options.contacts, "--object", "bench_object", "--name", "bench_contacts"});
    hand_ = describe(v1::MODEL_HAND, "bench_hand").hand();
    object_ = describe(v1::MODEL_OBJECT, "bench_object").object();
    contacts_ = describe(v1::MODEL_CONTACTS, "bench_contacts").contacts();
  }

  EditDesk& desk() { return *desk_; }

  [[nodiscard]] Network network() const { return {domain_.number(), "lo"}; }

  test::Process& server() { return *server_; }

  std::uint64_t open() {
    v1::OpenSessionRequest request;
    request.hand("bench_hand");
    request.object("bench_object");
    request.contacts("bench_contacts");
    return desk_->open(request).session_id();
  }

  void solve(std::uint64_t session) {
    v1::OptimizeRequest optimize;
    optimize.session_id(session);
    v1::RequestBody body;
    body.optimize(optimize);
    desk_->requester().ask(body);
  }

  std::uint64_t openSolved() {
    const std::uint64_t session = open();
    solve(session);
    return session;
  }

  RandomEdits edits(std::uint64_t session, unsigned seed) {
    return {seed,           desk_->ofSession(v1::OP_TRANSFER, session).transfer().patches(),
            contacts_,      object_.mesh_O(),
            hand_.skin_S(), hand_.joints()};
  }

  /// Of the server: kB that are its own; seconds of processor.
  double memoryKb() { return field("/status", "RssAnon:"); }

  double processorSeconds() {
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

 private:
  static std::filesystem::path binary(const std::string& name) {
    return std::filesystem::path(HANDGRAFT_BIN_DIR) / name;
  }

  void load(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "load");
    arguments.insert(arguments.end(), {"--domain", std::to_string(domain_.number())});
    const test::Finished done = test::run(binary("handgraft"), arguments);
    if (done.exit_code != 0) throw std::runtime_error(done.err);
  }

  v1::ModelDescription describe(v1::ModelKind kind, const std::string& name) {
    v1::DescribeModelRequest request;
    v1::ModelKey key;
    key.kind(kind);
    key.name(name);
    request.model(key);
    request.with_meshes(true);
    v1::RequestBody body;
    body.describe_model(request);
    return desk_->requester().ask(body).model();
  }

  std::string pid() { return std::to_string(desk_->requester().status().process_id()); }

  double field(const std::string& file, const std::string& name) {
    std::ifstream in("/proc/" + pid() + file);
    std::string word;
    while (in >> word) {
      double value = 0.0;
      if (word == name && in >> value) return value;
    }
    return 0.0;
  }

  Options options_;
  test::TestDomain domain_;
  std::unique_ptr<test::Process> server_;
  std::unique_ptr<EditDesk> desk_;
  v1::HandDescription hand_;
  v1::ObjectDescription object_;
  v1::ContactsDescription contacts_;
};

void printRow(const std::string& name, const std::vector<double>& values) {
  if (values.empty()) return;
  fmt::print("{:<24} {:>6} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f}\n", name, values.size(),
             quantile(values, 0.5), quantile(values, 0.9), quantile(values, 0.99),
             *std::max_element(values.begin(), values.end()));
}

void printHead(const char* what) {
  fmt::print("{:<24} {:>6} {:>9} {:>9} {:>9} {:>9}\n", what, "count", "p50", "p90", "p99",
             "max");
}

/// One edit after another, each waited for.
void latency(const Options& options) {
  Room room(options);
  const std::uint64_t session = room.openSolved();
  RandomEdits random = room.edits(session, options.seed);
  std::map<std::string, std::vector<double>> by_kind;
  std::map<std::string, std::vector<double>> shares;
  std::map<std::string, int> refused;
  const double processor_before = room.processorSeconds();
  int lost = 0;
  for (int i = 0; i < options.edits; ++i) {
    const v1::EditBody body = random.next();
    const std::uint64_t edit = room.desk().send(session, body);
    const EditFate fate = room.desk().await(session, edit, seconds(5));
    if (fate.error != v1::ERROR_NONE) {
      ++refused[fate.message];
      continue;
    }
    if (!fate.solved) {
      ++lost;
      continue;
    }
    by_kind[random.kind()].push_back(fate.solution_ms);
    by_kind["all"].push_back(fate.solution_ms);
    double known = fate.back_ms;
    shares["answer to the edit"].push_back(fate.reply_ms);
    shares["solution's way back"].push_back(fate.back_ms);
    for (const auto& [stage, ms] : fate.stages_ms) {
      if (stage == "skin") continue;
      shares[stage].push_back(ms);
      known += ms;
    }
    shares["edit's way, queue, rest"].push_back(fate.solution_ms - known);
  }
  printHead("edit to final, ms");
  for (const auto& [kind, values] : by_kind)
    printRow(kind, values);
  printHead("shares, ms");
  for (const auto& [share, values] : shares)
    printRow(share, values);
  fmt::print("server's processor time: {:.3f} ms an edit\n",
             1e3 * (room.processorSeconds() - processor_before) / options.edits);
  fmt::print("lost: {}\n", lost);
  for (const auto& [message, count] : refused)
    fmt::print("refused {} times: {}\n", count, message);
}

/// Many sessions, each edited at the same rate; whether all are served alike.
void crowd(const Options& options) {
  Room room(options);
  room.openSolved();  // the models are there
  const double memory_before = room.memoryKb();
  std::vector<std::uint64_t> sessions;
  std::vector<RandomEdits> random;
  for (int i = 0; i < options.sessions; ++i) {
    sessions.push_back(room.open());
  }
  const double memory_open = room.memoryKb();
  for (const std::uint64_t session : sessions) {
    room.solve(session);
    random.push_back(room.edits(session, options.seed + static_cast<unsigned>(session)));
  }
  const double memory_solved = room.memoryKb();
  const double processor_before = room.processorSeconds();
  const auto begin = Clock::now();
  const long count = static_cast<long>(options.sessions) * options.rate * options.seconds;
  const double step_s = 1.0 / (options.sessions * options.rate);
  for (long i = 0; i < count; ++i) {
    std::this_thread::sleep_until(
        begin + std::chrono::duration_cast<Clock::duration>(
                    std::chrono::duration<double>(static_cast<double>(i) * step_s)));
    const auto at = static_cast<std::size_t>(i % options.sessions);
    room.desk().send(sessions[at], random[at].next());
  }
  const double took_s = std::chrono::duration<double>(Clock::now() - begin).count();
  std::this_thread::sleep_for(seconds(3));
  std::vector<double> medians, p99s, replies;
  long solved = 0, unanswered = 0, refused = 0, shared = 0;
  for (const std::uint64_t session : sessions) {
    std::vector<double> mine;
    for (const EditFate& fate : room.desk().fates(session)) {
      if (!fate.answered) ++unanswered;
      if (fate.error != v1::ERROR_NONE) ++refused;
      if (fate.answered) replies.push_back(fate.reply_ms);
      if (!fate.solved) continue;
      ++solved;
      shared += fate.shared ? 1 : 0;
      mine.push_back(fate.solution_ms);
    }
    medians.push_back(quantile(mine, 0.5));
    p99s.push_back(quantile(mine, 0.99));
  }
  fmt::print(
      "{} sessions, {} edits in {:.1f} s: {} solved ({} with a later one), {} refused, "
      "{} unanswered\n",
      options.sessions, count, took_s, solved, shared, refused, unanswered);
  printHead("ms");
  printRow("reply", replies);
  printRow("p50 of the sessions", medians);
  printRow("p99 of the sessions", p99s);
  fmt::print("p99 of the slowest / the median: {:.2f}\n",
             *std::max_element(p99s.begin(), p99s.end()) / quantile(p99s, 0.5));
  fmt::print("server's memory: {:.0f} kB a session open, {:.0f} kB solved, {:.0f} kB edited\n",
             (memory_open - memory_before) / options.sessions,
             (memory_solved - memory_before) / options.sessions,
             (room.memoryKb() - memory_before) / options.sessions);
  fmt::print("server's processor time: {:.3f} ms an edit\n",
             1e3 * (room.processorSeconds() - processor_before) / static_cast<double>(count));
}

/// Publishes edits of a session at a rate, and counts what became of them; a process of its
/// own.
void pour(const Options& options) {
  EditDesk desk(Network{options.domain, "lo"});
  if (!desk.requester().waitForServer(seconds(60))) throw std::runtime_error("no server");
  std::this_thread::sleep_for(seconds(1));  // for the edits' own discovery
  v1::EditBody body;
  v1::PriorShares edit;
  const auto begin = Clock::now();
  long sent = 0;
  long timeouts = 0;
  while (Clock::now() - begin < seconds(options.seconds)) {
    const double due =
        options.rate * std::chrono::duration<double>(Clock::now() - begin).count();
    for (; static_cast<double>(sent) < due; ++sent) {
      edit.joints(1.0 + 1e-6 * static_cast<double>(sent));
      edit.root_rotation(1.0);
      edit.root_translation(1.0);
      body.prior_shares(edit);
      try {
        desk.send(options.session, body);
      } catch (const idl::cyclone::WriteTimeout&) {
        ++timeouts;
      }
    }
    std::this_thread::sleep_for(milliseconds(1));
  }
  std::this_thread::sleep_for(seconds(2));
  std::map<std::string, long> fates;
  for (const EditFate& fate : desk.fates(options.session)) {
    ++fates[!fate.answered                 ? "unanswered"
            : fate.error != v1::ERROR_NONE ? fate.message
            : fate.shared                  ? "applied, solved with a later one"
            : fate.solved                  ? "applied and solved"
                                           : "applied"];
  }
  fmt::print("{} edits in {} s; the writer waited in vain for {}\n", sent, options.seconds,
             timeouts);
  for (const auto& [fate, count] : fates)
    fmt::print("  {:>6} {}\n", count, fate);
}

/// A session edited calmly, while another process floods a second one.
void flood(const Options& options) {
  constexpr int kRate = 10'000;
  Room room(options);
  const std::uint64_t calm = room.openSolved();
  const std::uint64_t flooded = room.openSolved();
  RandomEdits calm_edits = room.edits(calm, options.seed);
  const auto calmly = [&](int count) {
    std::vector<double> times;
    for (int i = 0; i < count; ++i) {
      const auto edit = room.desk().send(calm, calm_edits.next());
      const EditFate fate = room.desk().await(calm, edit, seconds(5));
      times.push_back(fate.solved ? fate.solution_ms : 5000.0);
      std::this_thread::sleep_for(milliseconds(100));
    }
    return times;
  };
  const std::vector<double> before = calmly(30);
  const double memory_before = room.memoryKb();
  test::Process wild("/proc/self/exe",
                     {"pour", "--domain", std::to_string(room.network().domain), "--session",
                      std::to_string(flooded), "--rate", std::to_string(kRate), "--seconds",
                      std::to_string(options.seconds)});
  std::vector<double> during;
  while (wild.running()) {
    const auto more = calmly(5);
    during.insert(during.end(), more.begin(), more.end());
  }
  const double memory_after = room.memoryKb();
  const std::vector<double> after = calmly(20);
  fmt::print("{}{}", wild.out(), wild.err());
  printHead("calm session, ms");
  printRow("before", before);
  printRow("during", during);
  printRow("after", after);
  fmt::print("server: {}, {:.0f} kB before, {:.0f} kB after\n",
             room.server().running() ? "alive" : "dead", memory_before, memory_after);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("What an editor waits for", "handgraft-edit-bench");
  app.require_subcommand(1);
  app.fallthrough();
  app.add_option("--hand", options.hand, "URDF");
  app.add_option("--object", options.object, "mesh");
  app.add_option("--contacts", options.contacts, "contact map or set on the object");
  app.add_option("--seed", options.seed, "of the edits");
  app.add_option("--server", options.server, "arguments of the server");
  auto* one = app.add_subcommand("latency", "one edit after another");
  one->add_option("--edits", options.edits, "how many");
  auto* many = app.add_subcommand("crowd", "many sessions at once");
  many->add_option("--sessions", options.sessions, "how many");
  many->add_option("--rate", options.rate, "edits a second and session");
  many->add_option("--seconds", options.seconds, "how long");
  auto* wild = app.add_subcommand("flood", "10,000 edits a second on one session");
  wild->add_option("--seconds", options.seconds, "how long");
  auto* wild_edits = app.add_subcommand("pour", "the flood itself");
  wild_edits->add_option("--domain", options.domain, "of the server");
  wild_edits->add_option("--session", options.session, "to flood");
  wild_edits->add_option("--rate", options.rate, "edits a second");
  wild_edits->add_option("--seconds", options.seconds, "how long");
  CLI11_PARSE(app, argc, argv);
  try {
    if (one->parsed()) latency(options);
    if (many->parsed()) crowd(options);
    if (wild->parsed()) flood(options);
    if (wild_edits->parsed()) pour(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "handgraft-edit-bench: %s\n", error.what());
    return 2;
  }
  return 0;
}
