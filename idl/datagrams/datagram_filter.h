#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "idl/datagrams/sample_pieces.h"

namespace handgraft::idl {

/// Looks at every datagram before Fast DDS 2.9.1 or Cyclone DDS 0.10.2 does, which trust too
/// much. The former: a submessage of its maker's own kind ends the process by an assertion, a
/// heartbeat that jumps by 2^60 spins its thread for ever, a lease of no length crashes its
/// discovery, and the size that the first fragment of a sample announces is allocated. The
/// latter: type information of a kind that does not exist ends the process.
///
/// What goes on is well-formed RTPS 2.x (OMG formal/2019-04-03, section 8.3 and 9.4) of the
/// kinds that our programs and ROS 2's use; submessages of other kinds are cut out, and a
/// datagram with a malformed one is dropped whole. For Fast DDS one thing is mended on the way:
/// see `beginAnew` in the source. For Cyclone DDS type information is blanked, the service that
/// tells of types is cut out, and discovery comes in whole samples alone, since what is put
/// together from fragments is not looked at. It knows nothing of who sends; that is for DDS
/// Security.
///
/// In a secured domain it lets through what is encrypted, and in the clear only what
/// authentication needs, well formed: announcements of participants and handshakes. Where these
/// come in fragments, off the loopback, they go on as the one sample that they make. Fast DDS
/// 2.9.1 takes plain samples, heartbeats and gaps for endpoints that it was told to encrypt, so
/// that who guesses GUIDs needs no key. This holds for the governance of idl/security alone.
///
/// Cost: one pass over the submessages' headers; memory for at most `kMostWriters` writers.
/// Threads: `pass` from any thread.
class DatagramFilter {
 public:
  enum class Domain { kOpen, kSecured };
  enum class Reader { kFastDds, kCyclone };  ///< who takes what goes on

  explicit DatagramFilter(Domain domain = Domain::kOpen, Reader reader = Reader::kFastDds)
      : domain_(domain), reader_(reader) {}

  static constexpr std::size_t kMostWriters = 20'000;
  /// Of a secured domain, whose announcements are remembered; others wait for one that leaves.
  static constexpr std::size_t kMostParticipants = 1'000;
  /// For so long a participant's first announcement stands, after it was last heard.
  static constexpr std::chrono::seconds kRemembered{20};
  /// For so long, at least, what its writers said last is known after it was last heard.
  static constexpr std::chrono::seconds kWritersRemembered{60};
  /// How far ahead of what was seen of a writer its next sample may be.
  static constexpr std::int64_t kLongestJump = 10'000'000;
  /// How many samples a heartbeat may offer and a gap may skip.
  static constexpr std::int64_t kLongestRange = 1'000'000;
  /// Samples of its users' topics that a participant of an open domain may send to Fast DDS,
  /// a second and at once: so many whatever others do, and so many more of what all share, so
  /// that several who flood get no more than one. The rest is left out, and offered again by
  /// who sent it: what floods is slowed down before it costs more than a look.
  static constexpr double kSamplesPerSecond = 100.0;
  static constexpr double kSamplesAtOnce = 400.0;
  static constexpr double kSharedPerSecond = 2000.0;
  static constexpr double kSharedAtOnce = 4000.0;
  static constexpr std::uint32_t kLargestSample = 64U << 20U;  ///< bytes
  static constexpr std::uint32_t kShortestLease = 5;           // s

  /// As clients call themselves when they announce themselves.
  static constexpr std::string_view kClient = "handgraft client";

  /// From now on announcements of clients are left out, so that those of a crowd do not meet
  /// one another. Any thread.
  void passOverClients(bool are_passed_over) { passes_over_clients_ = are_passed_over; }

  /// What may go on of the datagram: nothing, all of it, or a copy in `kept`. The answer refers
  /// to one of both.
  std::span<const std::uint8_t> pass(std::span<const std::uint8_t> datagram,
                                     std::vector<std::uint8_t>& kept);

  /// How a participant's GUIDs begin.
  using Prefix = std::array<std::uint8_t, 12>;
  /// Whose samples were left out since this was last asked, for want of a share. Any thread.
  std::vector<Prefix> takeOverShare();

  /// How the GUIDs of one identity begin (security/guids.h).
  using GuidBegin = std::array<std::uint8_t, 6>;
  /// From now on nothing goes on of what these say, in place of those before. Any thread.
  void refuse(std::set<GuidBegin> whom);

  /// In a secured domain: what a handshake shows, and in whose name it came, unchecked. False
  /// where the handshake may not go on.
  using OnCertificate = std::function<bool(GuidBegin source, std::string_view pem)>;

  /// Called on the thread of `pass`. To be set before the first datagram. From then on a
  /// handshake that shows two certificates does not go on either.
  void askAboutCertificates(OnCertificate ask) { on_certificate_ = std::move(ask); }

 private:
  static GuidBegin beginOf(const Prefix& source);

  struct Submessage;
  /// The first one; nothing if it is cut short.
  static std::optional<Submessage> submessageAt(std::span<const std::uint8_t> rest);
  bool isSound(const Prefix& source, const Submessage& submessage);
  bool follows(const Prefix& source,
               std::uint32_t writer,
               std::int64_t first,
               std::int64_t last);
  /// The bytes of a secured domain's submessage that may go on, those that belong to it
  /// included; 0 for what is left out. Nothing if the datagram is malformed.
  std::optional<std::size_t> secured(const Prefix& source,
                                     const Submessage& submessage,
                                     std::span<const std::uint8_t> rest);

  /// What became of a submessage.
  struct Passage {
    std::size_t length = 0;    ///< of the datagram, with what belongs to it
    bool has_content = false;  ///< more than of whom and for whom the rest is goes on
  };

  /// Adds to `kept` what may go on of a submessage. `rest`: what follows it. Nothing if the
  /// datagram is malformed.
  std::optional<Passage> passOne(const Prefix& source,
                                 const Submessage& submessage,
                                 std::span<const std::uint8_t> rest,
                                 std::vector<std::uint8_t>& kept);
  /// The same of an open domain, of a secured one, and of a fragment there.
  std::optional<Passage> passOpen(const Prefix& source,
                                  const Submessage& submessage,
                                  std::vector<std::uint8_t>& kept);
  std::optional<Passage> passSecured(const Prefix& source,
                                     const Submessage& submessage,
                                     std::span<const std::uint8_t> rest,
                                     std::vector<std::uint8_t>& kept);
  Passage passSecuredFragment(const Prefix& source,
                              const Submessage& fragment,
                              std::vector<std::uint8_t>& kept);
  /// Forgets who was not heard for long; `mutex_` held.
  void forgetSilent(std::chrono::steady_clock::time_point now);
  bool isRefused(const Prefix& source);
  bool isWithinShare(const Prefix& source, const Submessage& submessage);
  /// True of what this reader must not see, though it may be well formed.
  [[nodiscard]] bool isKeptFrom(const Submessage& submessage) const;
  bool isHandshakeOrAnnouncement(const Prefix& source, const Submessage& submessage);
  /// DATA that a handshake's fragments make up, with the last of them; nothing before.
  std::optional<std::vector<std::uint8_t>> wholeHandshake(const Prefix& source,
                                                          const Submessage& fragment);
  /// A stranger cannot change what a participant said of itself first.
  bool isAsBefore(const Prefix& source, std::span<const std::uint8_t> announcement);

  struct Announced {
    std::size_t hash = 0;
    std::chrono::steady_clock::time_point last;
  };

  const Domain domain_;
  const Reader reader_;
  OnCertificate on_certificate_;
  std::atomic<bool> refuses_{false};
  std::atomic<bool> passes_over_clients_{false};
  std::mutex mutex_;
  std::set<GuidBegin> refused_;
  std::map<Prefix, Announced> announced_;
  SamplePieces handshakes_;

  /// Samples that may be sent now, of so many a second and at once.
  struct Share {
    double samples = 0.0;
    bool was_exceeded = false;  ///< since somebody asked
    std::chrono::steady_clock::time_point last{};

    bool take(double per_second, double at_once, std::chrono::steady_clock::time_point now);
  };

  std::map<Prefix, Share> shares_;
  Share shared_;  ///< by all who send more than their own

  /// The highest sample number seen of each writer of a participant.
  struct Heard {
    std::map<std::uint32_t, std::int64_t> last;
    std::chrono::steady_clock::time_point when;
  };

  std::map<Prefix, Heard> heard_;
  std::size_t writers_ = 0;  ///< in all of it
  std::chrono::steady_clock::time_point tidied_{};
};

}  // namespace handgraft::idl
