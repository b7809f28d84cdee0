#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/bench/live/edit_client.h"
#include "tests/bench/live/random_edits.h"
#include "tests/support/process.h"
#include "tests/support/shared_data.h"
#include "tests/support/test_domain.h"

namespace handgraft::bench {

/// What a grasp is made of, and how long it is edited.
struct LiveOptions {
  std::string hand = test::sharedData("hands/allegro_right/allegro_hand_right.urdf").string();
  std::string object = test::sharedData("objects/ycb/006_mustard_bottle.obj").string();
  std::string contacts =
      test::sharedData("contacts/dexycb/006_mustard_bottle_grasp0_contact.ply").string();
  int edits = 1000;
  int sessions = 100;
  int rate = 10;
  int seconds = 10;
  unsigned seed = 1;
  bool json = false;
  std::vector<std::string> server;  ///< arguments
  // Of `pour`.
  int domain = 0;
  std::uint64_t session = 0;
  std::string patch;
};

/// A server of a domain of its own, with the models, and an editor of its sessions.
/// Errors: std::runtime_error with what the server or the client wrote.
class Room {
 public:
  explicit Room(const LiveOptions& options);

  EditClient& client() { return *client_; }

  [[nodiscard]] Network network() const { return {domain_.number(), "lo"}; }

  test::Process& server() { return *server_; }

  std::uint64_t open();
  void solve(std::uint64_t session);
  std::uint64_t openSolved();

  RandomEdits edits(std::uint64_t session, unsigned seed);
  /// The first patch of a session that lies on the hand.
  std::string placedPatch(std::uint64_t session);

  /// Of the server: kB that are its own; seconds of processor.
  double memoryKb();
  double processorSeconds();

 private:
  void load(std::vector<std::string> arguments);
  v1::ModelDescription describe(v1::ModelKind kind, const std::string& name);
  std::string pid();

  test::TestDomain domain_;
  std::unique_ptr<test::Process> server_;
  std::unique_ptr<EditClient> client_;
  v1::HandDescription hand_;
  v1::ObjectDescription object_;
  v1::ContactsDescription contacts_;
};

}  // namespace handgraft::bench
