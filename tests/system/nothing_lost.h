#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/environment.h"
#include "core/base/sanitized.h"
#include "idl/cyclone/requester.h"

#include "tests/server/small_grasp.h"
#include "tests/support/environment_variable.h"
#include "tests/system/service.h"

/// Servers that are killed, and disks that fail: what tests of both stand on.
namespace handgraft::test {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using idl::cyclone::Participant;
using idl::cyclone::Refused;
using idl::cyclone::Requester;

inline constexpr std::chrono::seconds kLong(60);

/// Of the environment, for longer runs than every change's.
inline int countOf(const char* name, int otherwise) {
  const std::string text = environment(name);
  return text.empty() ? otherwise : std::stoi(text);
}

/// A server whose state is kept, and which is killed and started again.
class NothingLost : public testing::Test {
 protected:
  NothingLost() {
    std::string name = (fs::temp_directory_path() / "handgraft-lost-XXXXXX").string();
    folder = mkdtemp(name.data());
    service = std::make_unique<Service>(arguments());
    running = &service->server();
  }

  ~NothingLost() override {
    restarted.reset();
    service.reset();
    fs::remove_all(folder);
  }

  [[nodiscard]] std::vector<std::string> arguments() const {
    return {"--state", (folder / "state").string(), "--sessions", "4096"};
  }

  void killServer() {
    running->send(SIGKILL);
    running->wait();
  }

  void startServer(const std::vector<std::string>& more = {}) {
    std::vector<std::string> all = arguments();
    all.insert(all.end(), more.begin(), more.end());
    restarted = service->start("handgraft-server", all);
    running = restarted.get();
  }

  void restart() {
    killServer();
    startServer();
  }

  /// What `--check` says of what lies there.
  [[nodiscard]] Finished checkOf(const fs::path& state) const {
    return run(program("handgraft-server"), {"--check", "--state", state.string(), "--domain",
                                             std::to_string(service->domain())});
  }

  fs::path folder;
  std::unique_ptr<Service> service;
  std::unique_ptr<Process> restarted;
  Process* running = nullptr;
};

inline v1::EditBody weightOf(double weight) {
  v1::PatchWeightEdit edit;
  edit.patch("palm");
  edit.weight(weight);
  v1::EditBody body;
  body.patch_weight(edit);
  return body;
}

/// One client with a session on models that it has sent.
struct Editor {
  explicit Editor(const Network& network) : participant(network), requester(participant) {
    EXPECT_TRUE(requester.waitForServer(kLong));
    for (const v1::RequestBody& body : smallGrasp())
      requester.ask(body);
    session = requester.ask(openSession("clamp", "fruit", "marks")).session().session_id();
  }

  v1::EditReply edit(double weight) { return requester.edit(session, 0, weightOf(weight)); }

  v1::SessionSettings settings() {
    return requester.ask(ofSession(v1::OP_SESSION_SETTINGS, session)).settings();
  }

  Participant participant;
  Requester requester;
  std::uint64_t session = 0;
};

inline double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

// === Disks that fail

/// A server whose store's writes fail as told (tests/support/failing_disk.cpp).
class FailingDisk : public NothingLost {
 protected:
  FailingDisk() {
    if (kIsSanitized) return;  // whose own library has to come before every other one
    killServer();
    startOnFailingDisk(0);
  }

  /// On a sound disk, which fails from then on, so many of 256 writes.
  void startOnFailingDisk(unsigned char of_256) {
    fail(0, 'r');
    {
      const EnvironmentVariable shim("LD_PRELOAD", HANDGRAFT_FAILING_DISK);
      const EnvironmentVariable told("FAILING_DISK", orders());
      const EnvironmentVariable part("FAILING_DISK_PATH", ".db");
      startServer();
    }
    EXPECT_TRUE(running->waitForText("event=ready")) << running->err();
    fail(of_256, 'r');
  }

  void SetUp() override {
    if (kIsSanitized)
      GTEST_SKIP() << "a sanitizer's library has to be loaded before the failing disk's";
  }

  [[nodiscard]] std::string orders() const { return (folder / "orders").string(); }

  /// So many of 256 writes, from now on: at random, on a full or on a read-only disk.
  void fail(unsigned char of_256, char how) const {
    // In place: the server has it mapped.
    std::FILE* file = std::fopen(orders().c_str(), fs::exists(orders()) ? "r+b" : "wb");
    const unsigned char bytes[2] = {of_256, static_cast<unsigned char>(how)};
    EXPECT_EQ(std::fwrite(bytes, 1, 2, file), 2u);
    std::fclose(file);
  }
};

/// What became of one edit: its revision, or 0 where the disk did not take it.
inline std::uint64_t tryEdit(Editor& editor, double weight) {
  try {
    return editor.edit(weight).revision();
  } catch (const Refused& refused) {
    EXPECT_EQ(refused.code(), v1::ERROR_STORAGE) << refused.what();
    return 0;
  }
}

}  // namespace handgraft::test
