#include "idl/cyclone/domain.h"

#include <chrono>
#include <cstdio>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include <dds/dds.h>
#include <fmt/format.h>

#include "core/base/error.h"
#include "idl/cyclone/datagram_gate.h"
#include "idl/cyclone/entity.h"
#include "idl/peer_names.h"

namespace handgraft::idl::cyclone {

namespace {

// Commands live for some 50 ms. What they say of their topics before the server has heard of
// them is lost on it, and comes again at their next heartbeat or its first question (70 ms): at
// Cyclone's 100 ms each, one command in ten waited (docker/DECISIONS.md). A program that ends
// waits for what was not acknowledged; it has the answer to all that it asked.
constexpr const char* kTiming =
    "<HeartbeatInterval min=\"5ms\" minsched=\"10ms\" max=\"8s\">20ms</HeartbeatInterval>"
    "<NackDelay>20ms</NackDelay><WriterLingerDuration>50ms</WriterLingerDuration>";

// A participant has two ports, from the tenth of its domain's 250 on (RTPS 9.6.1.4).
static_assert(10 + 2 * kMostProgramsOfAMachine <= 250);

// A server announces itself five times a second: who was not heard is heard by its answer.
constexpr const char* announcementsOf(Discovers discovers) {
  switch (discovers) {
    case Discovers::kNoClients:
      return "2s";
    case Discovers::kStartingServer:
      return "250ms";
    case Discovers::kAll:
      break;
  }
  return "500ms";
}

std::string configurationOf(const Network& network,
                            const NetworkInterface& interface,
                            Discovers discovers) {
  // 65 kB datagrams and 4 MB buffers carry an 8 MB mesh in 12 ms on loopback. Elsewhere a
  // datagram is one frame: of 45 fragments each would have to arrive. A kernel that grants a
  // smaller buffer makes it slower, not impossible, hence `max`. Names of interfaces may hold
  // any character.
  std::string name;
  for (const char c : interface.name) {
    if (c == '&') {
      name += "&amp;";
    } else if (c == '<') {
      name += "&lt;";
    } else if (c == '"') {
      name += "&quot;";
    } else {
      name += c;
    }
  }
  // Multicast is for finding each other, nothing else: Fast DDS sends to the group, once two
  // readers have it in common, what no router and few wireless networks would deliver.
  std::string peers;
  const Network reached = withPeerAddresses(network);
  for (const std::string& address : unicastAddresses(reached, interface))
    peers += fmt::format("<Peer Address=\"{}\"/>", address);
  if (!peers.empty()) peers = "<Peers>" + peers + "</Peers>";
  return fmt::format(
      "<CycloneDDS><Domain Id=\"any\">"
      "<General><Interfaces><NetworkInterface name=\"{}\"/></Interfaces>"
      "<AllowMulticast>{}</AllowMulticast>"
      "<MaxMessageSize>{}</MaxMessageSize><FragmentSize>{}</FragmentSize></General>"
      "<Discovery><LeaseDuration>{}s</LeaseDuration><SPDPInterval>{}</SPDPInterval>"
      "<ParticipantIndex>auto</ParticipantIndex>"
      "<MaxAutoParticipantIndex>{}</MaxAutoParticipantIndex>{}</Discovery>"
      "<Internal><SocketReceiveBufferSize max=\"4MB\"/>{}</Internal>"
      "</Domain></CycloneDDS>",
      name, interface.loopback ? "false" : "spdp", interface.loopback ? "65500B" : "1400B",
      interface.loopback ? "65000B" : "1200B", kLeaseDuration, announcementsOf(discovers),
      kMostProgramsOfAMachine - 1, peers, kTiming);
}

std::string notJoined() {
  return fmt::format(
      "the domain cannot be joined; its ports are enough for {} programs of a "
      "machine",
      kMostProgramsOfAMachine);
}

struct JoinedDomain {
  dds_entity_t handle = 0;
  std::string how;
  int users = 0;
};

std::mutex& joining() {
  static std::mutex one;
  return one;
}

std::map<int, JoinedDomain>& joinedDomains() {
  static std::map<int, JoinedDomain> domains;
  return domains;
}

}  // namespace

Domain::Domain(const Network& network, Discovers discovers) : id_(network.domain) {
  const NetworkInterface interface = validate(network);
  const std::lock_guard lock(joining());
  JoinedDomain& shared = joinedDomains()[id_];
  // Its identity, too: Cyclone's plugins judge all of a process by the first one's rights.
  const std::string how = describe(network);
  if (shared.users > 0 && shared.how != how) {
    rejectInput("{} cannot be joined: this process is on {} already", how, shared.how);
  }
  if (shared.users == 0) {
    using Kind = DatagramFilter::Domain;
    if (!gateDatagrams(id_, network.identity.empty() ? Kind::kOpen : Kind::kSecured)) {
      fmt::print(stderr,
                 "handgraft: this Cyclone DDS is not the library that was expected: what comes "
                 "from the network is not looked at first\n");
    }
    shared.handle =
        checked(dds_create_domain(static_cast<dds_domainid_t>(id_),
                                  configurationOf(network, interface, discovers).c_str()),
                notJoined().c_str(), describe(network));
    shared.how = how;
  }
  if (shared.users == 0 || discovers == Discovers::kAll)
    passOverClients(id_, discovers != Discovers::kAll);
  ++shared.users;
}

Domain::~Domain() {
  const std::lock_guard lock(joining());
  JoinedDomain& shared = joinedDomains()[id_];
  if (--shared.users > 0) return;
  // Without its interface Cyclone DDS waits for its own receiving thread for ever; then that
  // is left behind, so that a program whose network went away still ends.
  constexpr std::chrono::seconds kPatience(5);
  const auto gone = std::make_shared<std::promise<void>>();
  std::thread([gone, handle = shared.handle] {
    dds_delete(handle);
    gone->set_value();
  }).detach();
  gone->get_future().wait_for(kPatience);
}

}  // namespace handgraft::idl::cyclone
