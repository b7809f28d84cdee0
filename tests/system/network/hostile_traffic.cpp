// hostile_traffic: sends datagrams of both vendors' own traffic, as recorded and mutated, to
// the programs of a domain on the loopback. The recording is of participants of its own, which
// are announced again and again, so that what is said in their name reaches endpoints.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace {

using Datagram = std::vector<std::uint8_t>;

constexpr std::size_t kHeader = 20;
constexpr std::size_t kPrefix = 12;

/// Each with its length, two bytes, little end first.
std::vector<Datagram> recorded(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<Datagram> all;
  while (true) {
    const int low = file.get();
    const int high = file.get();
    if (!file) break;
    Datagram one(static_cast<std::size_t>(low + 256 * high));
    file.read(reinterpret_cast<char*>(one.data()), static_cast<std::streamsize>(one.size()));
    all.push_back(std::move(one));
  }
  if (all.empty()) throw std::runtime_error(path + ": no recorded datagrams");
  return all;
}

/// Where each submessage begins.
std::vector<std::size_t> submessagesOf(const Datagram& bytes) {
  std::vector<std::size_t> places;
  for (std::size_t at = kHeader; at + 4 <= bytes.size();) {
    places.push_back(at);
    const bool little = (bytes[at + 1] & 1U) != 0;
    const std::size_t length =
        little ? bytes[at + 2] + 256U * bytes[at + 3] : bytes[at + 3] + 256U * bytes[at + 2];
    if (length == 0) break;
    at += 4 + length;
  }
  return places;
}

/// For whoever receives it: what names a participant of the recording as its receiver names
/// nobody.
void addressToAll(Datagram& bytes) {
  constexpr std::uint8_t kInfoDestination = 0x0e;
  for (const std::size_t at : submessagesOf(bytes)) {
    if (bytes[at] == kInfoDestination && at + 4 + kPrefix <= bytes.size())
      std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at) + 4, kPrefix,
                  std::uint8_t{0});
  }
}

/// Participants of another domain are not met.
void moveTo(int domain, Datagram& bytes) {
  constexpr std::array<std::uint8_t, 4> kDomainId{0x0f, 0, 4,
                                                  0};  // a parameter, and its length
  for (auto at = bytes.begin();;) {
    at = std::search(at, bytes.end(), kDomainId.begin(), kDomainId.end());
    if (bytes.end() - at < 8) return;
    at += 4;
    *at = static_cast<std::uint8_t>(domain);
  }
}

class Mutator {
 public:
  Mutator(std::vector<Datagram> all, int domain, unsigned seed)
      : all_(std::move(all)), random_(seed) {
    for (Datagram& one : all_) {
      addressToAll(one);
      moveTo(domain, one);
    }
  }

  /// One after the other, as they are.
  Datagram nextAsRecorded() { return all_[at_++ % all_.size()]; }

  [[nodiscard]] std::size_t size() const { return all_.size(); }

  Datagram next() {
    Datagram bytes = any();
    constexpr int kAsRecorded = 8;  // one of so many
    if (below(kAsRecorded) == 0) return bytes;
    for (std::size_t i = 1 + below(4); i > 0; --i)
      mutate(bytes);
    return bytes;
  }

 private:
  std::size_t below(std::size_t count) { return random_() % count; }

  const Datagram& any() { return all_[below(all_.size())]; }

  void mutate(Datagram& bytes) {
    if (bytes.size() <= kHeader + 4) return;
    const std::size_t at = kHeader + below(bytes.size() - kHeader);
    switch (below(9)) {
      case 0:
        bytes[at] ^= static_cast<std::uint8_t>(1U << below(8));
        break;
      case 1:
        bytes[at] = static_cast<std::uint8_t>(random_());
        break;
      case 2: {  // numbers at the ends of their ranges
        constexpr std::array<std::uint8_t, 4> kValues{0x00, 0x7f, 0x80, 0xff};
        const std::uint8_t value = kValues[below(kValues.size())];
        const std::size_t word = at / 4 * 4;
        for (std::size_t i = word; i < std::min(word + 4, bytes.size()); ++i)
          bytes[i] = value;
        break;
      }
      case 3:  // small numbers: lengths, counts, kinds
        bytes[at / 4 * 4] = static_cast<std::uint8_t>(below(256));
        break;
      case 4:
        bytes.resize(at);
        break;
      case 5: {  // the length of a submessage
        const auto places = submessagesOf(bytes);
        const std::size_t place = places[below(places.size())];
        bytes[place + 2 + below(2)] = static_cast<std::uint8_t>(random_());
        break;
      }
      case 6: {  // another one's end
        const Datagram& other = any();
        const auto places = submessagesOf(other);
        bytes.insert(bytes.end(),
                     other.begin() + static_cast<std::ptrdiff_t>(places[below(places.size())]),
                     other.end());
        break;
      }
      case 7: {  // what stands elsewhere
        const std::size_t from = kHeader + below(bytes.size() - kHeader);
        const std::size_t count =
            std::min({below(32) + 1, bytes.size() - from, bytes.size() - at});
        std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(from), count,
                    bytes.begin() + static_cast<std::ptrdiff_t>(at));
        break;
      }
      default: {  // a kind or a flag of a submessage
        const auto places = submessagesOf(bytes);
        bytes[places[below(places.size())] + below(2)] = static_cast<std::uint8_t>(random_());
        break;
      }
    }
    constexpr std::size_t kLargest = 60'000;
    if (bytes.size() > kLargest) bytes.resize(kLargest);
  }

  std::vector<Datagram> all_;
  std::size_t at_ = 0;
  std::mt19937 random_;
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "hostile_traffic: mutated datagrams to the programs of a domain on the loopback");
  std::string recording;
  int domain = 0;
  unsigned long count = 100'000;
  unsigned seed = 1;
  unsigned rate = 20'000;
  unsigned participants = 8;
  app.add_option("recording", recording)->required();
  bool as_recorded = false;
  app.add_flag("--as-recorded", as_recorded, "each once to each port, unchanged");
  app.add_option("--domain", domain);
  app.add_option("--count", count);
  app.add_option("--seed", seed);
  app.add_option("--rate", rate, "datagrams a second");
  app.add_option("--participants", participants, "whose ports are sent to");
  CLI11_PARSE(app, argc, argv);
  try {
    Mutator mutator(recorded(recording), domain, seed);
    const int out = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const auto begin = std::chrono::steady_clock::now();
    const unsigned places = 2 * participants + 1;
    if (as_recorded) count = mutator.size() * places;
    Datagram bytes;
    for (unsigned long i = 0; i < count; ++i) {
      if (!as_recorded) {
        bytes = mutator.next();
      } else if (i % places == 0) {
        bytes = mutator.nextAsRecorded();
      }
      // RTPS 2.3, 9.6.1.1: metatraffic and the user's of each participant, and the groups' own.
      const auto place = static_cast<unsigned>(i % places);
      const unsigned port =
          7400U + 250U * static_cast<unsigned>(domain) + (place == 0 ? 0 : 9 + place);
      to.sin_port = htons(static_cast<std::uint16_t>(port));
      sendto(out, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to),
             sizeof to);
      constexpr unsigned long kTogether = 50;
      if (i % kTogether == 0)
        std::this_thread::sleep_until(
            begin + std::chrono::duration<double>(static_cast<double>(i) / rate));
    }
    close(out);
    std::printf(
        "%lu datagrams in %.1f s\n", count,
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "hostile_traffic: %s\n", error.what());
    return 1;
  }
}
