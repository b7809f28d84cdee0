#include <algorithm>
#include <chrono>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/version.h"
#include "client/link/client.h"
#include "client/present/interactive_client.h"
#include "client/present/interruption.h"
#include "client/present/json_output.h"
#include "client/present/text_output.h"
#include "idl/peer_names.h"

namespace handgraft::client {

namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

double roundTrip(Client& server) {
  std::vector<double> times;
  for (int i = 0; i < 11; ++i) {
    const Clock::time_point begin = Clock::now();
    server.ping().get();
    times.push_back(millisecondsSince(begin));
  }
  std::nth_element(times.begin(), times.begin() + 5, times.end());
  return times[5];
}

/// What else may keep two programs apart, from this end.
std::string adviceOn(const Network& network) {
  const NetworkInterface interface = validate(network);
  if (interface.loopback && network.peers.empty()) {
    return "; for a server on another machine, name the interface that leads there "
           "(--interface auto).";
  }
  if (interface.loopback &&
      std::any_of(network.peers.begin(), network.peers.end(), [](const std::string& peer) {
        return peer != "localhost" && peer.rfind("127.", 0) != 0;
      })) {
    return fmt::format(
        ". Interface {} ({}) leads to no other machine: name the one that leads to {} "
        "(--interface auto, HANDGRAFT_INTERFACE).",
        network.interface, interface.address, fmt::join(network.peers, ", "));
  }
  if (network.peers.empty()) {
    return fmt::format(
        ". None was heard by multicast (239.255.0.1, UDP port {}); many networks drop it: name "
        "the server's host by --peers HOST here, or this one ({}) by --peers there.",
        7400 + 250 * network.domain, interface.address);
  }
  std::string asked;
  const Network reached = idl::withPeerAddresses(network);
  for (const std::string& address : unicastAddresses(reached, interface))
    asked += (asked.empty() ? "" : ", ") + address;
  return fmt::format(
      ". None answered at {} nor by multicast: see that one runs there, not on its loopback "
      "alone (--interface auto), and that no firewall between keeps UDP ports {}-{} from "
      "passing, both ways.",
      asked, 7400 + 250 * network.domain, 7400 + 250 * network.domain + 249);
}

/// Who is not let in hears nothing of it: it is not known to be another's domain.
std::string secrecyAdvice(const Network& network) {
  if (network.identity.empty())
    return "; where it is secured, an identity is needed (--identity, HANDGRAFT_IDENTITY)";
  return "; one of another authority, an open one, and one that this identity was revoked for "
         "do not answer it either";
}

}  // namespace

int run(const DoctorOptions& /*options*/,
        const CommonOptions& common,
        Interruption& interruption) {
  DoctorReport report;
  report.version = kVersion;
  report.domain = common.network.domain;
  report.interface = common.network.interface;
  report.address = validate(common.network).address;
  try {
    const Clock::time_point begin = Clock::now();
    Client server(interactiveClient(common.network, Absence::kFail, interruption));
    report.found_ms = millisecondsSince(begin);
    if (server.onlyLooks())
      report.advice =
          "This identity is a viewer's: it may look at everything and change nothing.";
    report.round_trip_ms = roundTrip(server);
    report.models = server.listModels().get();
    report.server = server.status();
  } catch (const NoServer& error) {
    report.advice = fmt::format(
        "{}{}. Start one with: handgraft-server --domain {} --interface {}{}; if one runs "
        "elsewhere, give this program the same options{}",
        error.what(), secrecyAdvice(common.network), report.domain, report.interface,
        common.network.server.empty() ? "" : " --name " + common.network.server,
        adviceOn(common.network));
  }
  fmt::print("{}",
             common.json ? json::written(json::doctor(report)) + "\n" : text::doctor(report));
  return report.server ? 0 : 1;
}

}  // namespace handgraft::client
