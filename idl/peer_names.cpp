#include "idl/peer_names.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>

#include "core/base/error.h"

namespace handgraft::idl {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kAskedAgain(250);
constexpr std::chrono::seconds kPatience(2);

bool isAddress(const std::string& peer) {
  in_addr address{};
  return inet_pton(AF_INET, peer.c_str(), &address) == 1;
}

/// Shared with the threads that ask, which may outlive whoever waits for them.
struct Answers {
  std::mutex mutex;
  std::condition_variable arrived;
  std::map<std::string, NameAnswer> known;  // by name
};

void ask(const std::shared_ptr<Answers>& answers,
         const NameService& service,
         const std::string& name) {
  std::thread([answers, service, name] {
    NameAnswer answer = service(name);
    const std::lock_guard lock(answers->mutex);
    NameAnswer& known = answers->known[name];
    if (known.is_final) return;
    known = std::move(answer);
    answers->arrived.notify_all();
  }).detach();
}

std::map<std::string, NameAnswer> addressesOf(const std::vector<std::string>& names,
                                              const NameService& service) {
  const auto answers = std::make_shared<Answers>();
  const auto is_open = [&](const std::string& name) {
    return !answers->known[name].is_final;
  };
  const auto are_all_known = [&] {
    return std::none_of(names.begin(), names.end(), is_open);
  };
  const Clock::time_point give_up = Clock::now() + kPatience;
  std::unique_lock lock(answers->mutex);
  while (!are_all_known() && Clock::now() < give_up) {
    for (const std::string& name : names) {
      if (is_open(name)) ask(answers, service, name);
    }
    const Clock::time_point again = std::min(Clock::now() + kAskedAgain, give_up);
    answers->arrived.wait_until(lock, again, are_all_known);
  }
  return answers->known;
}

}  // namespace

NameAnswer askNameService(const std::string& name) {
  addrinfo wanted{};
  wanted.ai_family = AF_INET;
  wanted.ai_socktype = SOCK_DGRAM;
  addrinfo* first = nullptr;
  const int error = getaddrinfo(name.c_str(), nullptr, &wanted, &first);
  if (error != 0) return {"", gai_strerror(error), error != EAI_AGAIN};
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> list(first, freeaddrinfo);
  std::array<char, INET_ADDRSTRLEN> text{};
  const auto* const address = reinterpret_cast<const sockaddr_in*>(first->ai_addr);
  inet_ntop(AF_INET, &address->sin_addr, text.data(), text.size());
  return {text.data(), "", true};
}

Network withPeerAddresses(const Network& network,
                          std::vector<std::string>* without_address,
                          const NameService& service) {
  std::vector<std::string> names;
  for (const std::string& peer : network.peers) {
    const bool is_asked = std::find(names.begin(), names.end(), peer) != names.end();
    if (!peer.empty() && !isAddress(peer) && !is_asked) names.push_back(peer);
  }
  if (names.empty()) return network;
  const std::map<std::string, NameAnswer> known = addressesOf(names, service);
  Network resolved = network;
  resolved.peers.clear();
  for (const std::string& peer : network.peers) {
    const auto answer = known.find(peer);
    if (answer == known.end()) {
      resolved.peers.push_back(peer);
    } else if (!answer->second.address.empty()) {
      resolved.peers.push_back(answer->second.address);
    } else if (without_address != nullptr) {
      without_address->push_back(peer);
    } else if (answer->second.is_final) {
      rejectInput("peers: {} has no IPv4 address: {}", quoted(peer), answer->second.why);
    } else {
      throw TransportError(fmt::format(
          "peers: {} has no IPv4 address yet: the name service did not answer within {} s{}{}; "
          "try again, or give the address itself",
          quoted(peer), kPatience.count(), answer->second.why.empty() ? "" : ": ",
          answer->second.why));
    }
  }
  return resolved;
}

}  // namespace handgraft::idl
