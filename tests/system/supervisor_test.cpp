#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/sanitized.h"
#include "idl/cyclone/requester.h"

#include "tests/server/small_grasp.h"
#include "tests/support/environment_variable.h"
#include "tests/system/service.h"

// Servers that die, stop or do not hear any more, and end by SIGTERM all the same.

namespace handgraft::test {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using idl::cyclone::Participant;
using idl::cyclone::Requester;

double secondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

class Supervised : public testing::Test {
 protected:
  Supervised() {
    std::string name = (fs::temp_directory_path() / "handgraft-supervised-XXXXXX").string();
    folder = mkdtemp(name.data());
  }

  ~Supervised() override {
    if (service && service->server().running()) {
      service->server().send(SIGTERM);
      service->server().wait();
    }
    service.reset();
    fs::remove_all(folder);
  }

  void start(std::vector<std::string> arguments = {"--supervised"}) {
    arguments.insert(arguments.end(), {"--state", (folder / "state").string()});
    service = std::make_unique<Service>(arguments);
  }

  /// A server whose threads can be made deaf.
  void startFragile(std::vector<std::string> arguments = {"--supervised"}) {
    const EnvironmentVariable shim("LD_PRELOAD", HANDGRAFT_DEAF_NETWORK);
    const EnvironmentVariable told("DEAF_NETWORK", deaf());
    start(std::move(arguments));
  }

  void deafen(pid_t process) const { std::ofstream(deaf()) << process; }

  [[nodiscard]] std::string deaf() const { return (folder / "deaf").string(); }

  /// The process that serves: not the one that looks after it.
  [[nodiscard]] pid_t serving() const {
    const std::string log = service->server().err();
    const std::string words = "event=supervising process=";
    return std::stoi(log.substr(log.rfind(words) + words.size()));
  }

  /// Until another process serves; how long that took, from `begin`.
  [[nodiscard]] double waitForAnother(pid_t than, Clock::time_point begin) const {
    while (serving() == than && secondsSince(begin) < 60)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return secondsSince(begin);
  }

  fs::path folder;
  std::unique_ptr<Service> service;
};

/// A client with a session that has one edit.
struct Worker {
  explicit Worker(const Network& network) : participant(network), requester(participant) {
    EXPECT_TRUE(requester.waitForServer(std::chrono::seconds(60)));
    for (const v1::RequestBody& body : smallGrasp())
      requester.ask(body);
    session = requester.ask(openSession("clamp", "fruit", "marks")).session().session_id();
    edit();
  }

  std::uint64_t edit() {
    v1::PatchWeightEdit weight;
    weight.patch("palm");
    weight.weight(0.25);
    v1::EditBody body;
    body.patch_weight(weight);
    return requester.edit(session, 0, body).revision();
  }

  Participant participant;
  Requester requester;
  std::uint64_t session = 0;
};

// Noticed within 5 s; some more for a busy machine.
constexpr double kNoticed = 5.0 + 2.0;  // s

TEST_F(Supervised, AServerThatIsStoppedIsReplacedOnItsStore) {
  start();
  Worker worker(service->network());
  const pid_t first = serving();
  kill(first, SIGSTOP);
  const double noticed = waitForAnother(first, Clock::now());
  EXPECT_LT(noticed, kNoticed);
  EXPECT_THAT(service->server().err(), testing::HasSubstr("event=server_deaf"));
  EXPECT_EQ(worker.edit(), 2u);
  EXPECT_NE(kill(first, 0), 0) << "the first one still runs";
}

TEST_F(Supervised, AServerThatDiesIsReplaced) {
  start();
  Worker worker(service->network());
  const pid_t first = serving();
  kill(first, SIGKILL);
  EXPECT_LT(waitForAnother(first, Clock::now()), kNoticed);
  EXPECT_EQ(worker.edit(), 2u);
}

TEST_F(Supervised, AServerThatDoesNotHearIsReplaced) {
  if (kIsSanitized)
    GTEST_SKIP() << "a sanitizer's library has to be loaded before the one that deafens";
  startFragile();
  Worker worker(service->network());
  const pid_t first = serving();
  deafen(first);
  EXPECT_LT(waitForAnother(first, Clock::now()), kNoticed);
  EXPECT_EQ(worker.edit(), 2u);
}

TEST_F(Supervised, ABusyServerIsLeftAlone) {
  start({"--supervised", "--workers", "1"});
  Worker worker(service->network());
  const pid_t first = serving();
  v1::RequestBody body = optimize(worker.session, v1::SOLVER_ALL, 10'000);
  body.optimize().options().front().max_evaluations(100'000);
  worker.requester.begin(body, [](const auto&) {});
  std::this_thread::sleep_for(std::chrono::seconds(6));
  EXPECT_EQ(serving(), first);
}

TEST_F(Supervised, EndsWithItsServer) {
  start();
  Worker worker(service->network());
  const pid_t served = serving();
  service->server().send(SIGTERM);
  EXPECT_EQ(service->server().wait(std::chrono::seconds(10)), 0);
  EXPECT_NE(kill(served, 0), 0);
}

TEST_F(Supervised, WhatCannotStartIsNotStartedAgain) {
  const Finished finished =
      run(program("handgraft-server"),
          {"--supervised", "--models", "/no/such/folder", "--state", ":memory:"});
  EXPECT_EQ(finished.exit_code, 2);
}

TEST_F(Supervised, AServerThatDoesNotHearEndsBySIGTERMWithin10s) {
  if (kIsSanitized)
    GTEST_SKIP() << "a sanitizer's library has to be loaded before the one that deafens";
  startFragile({});
  Worker worker(service->network());
  deafen(static_cast<pid_t>(worker.requester.status().process_id()));
  // Each thread hears something before it falls silent.
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const auto begin = Clock::now();
  service->server().send(SIGTERM);
  service->server().wait(std::chrono::seconds(30));
  EXPECT_LT(secondsSince(begin), 12.0);
}

}  // namespace
}  // namespace handgraft::test
