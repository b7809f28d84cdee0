// The server on Fast DDS.
#include <algorithm>
#include <atomic>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/ranges.h>

#include "idl/fields.h"
#include "idl/peer_names.h"
#include "idl/security/identity.h"
#include "idl/security/revocations.h"
#include "idl/topics.h"
#include "server/log/log.h"
#include "server/transport/addressed_writer.h"
#include "server/transport/bus.h"
#include "server/transport/fast_endpoints.h"
#include "server/transport/fast_node.h"
#include "server/transport/participant_directory.h"

namespace handgraft::server {

namespace {

/// A keyed topic whose writer keeps the last value of every session for late joiners.
///
/// Instances cannot be disposed across the vendors (idl/README), so closed sessions, and those
/// that rest for long, are forgotten now and then by emptying the writer's history and writing
/// what still counts once more.
template <class Message>
class SessionTopic {
 public:
  SessionTopic(const Endpoints& endpoints, const idl::Topic<Message>& topic)
      : writer_(endpoints, topic) {}

  void write(const Message& message) {
    const std::lock_guard lock(mutex_);
    last_[message.session_id()] = message;
    std::erase(resting_, message.session_id());
    writer_.write(message);
  }

  /// The session will not speak again.
  void close(std::uint64_t session_id) {
    const std::lock_guard lock(mutex_);
    std::erase(resting_, session_id);
    closed_.push_back(session_id);
    tidy();
  }

  /// The session will not speak for long, or never again.
  void rest(std::uint64_t session_id) {
    const std::lock_guard lock(mutex_);
    if (last_.count(session_id) == 0) return;
    std::erase(resting_, session_id);
    resting_.push_back(session_id);
    tidy();
  }

  void flush() { writer_.flush(); }

 private:
  static constexpr std::size_t kClosedKept = 32;  // their news may still be on the way
  static constexpr std::size_t kRestingKept = 128;
  static constexpr std::size_t kAtOnce = 96;

  void tidy() {
    const auto excess = [](const auto& ids, std::size_t kept) {
      return ids.size() - std::min(ids.size(), kept);
    };
    if (excess(closed_, kClosedKept) + excess(resting_, kRestingKept) < kAtOnce) return;
    const auto forget = [&](auto& ids, std::size_t kept) {
      for (; ids.size() > kept; ids.pop_front())
        last_.erase(ids.front());
    };
    forget(closed_, kClosedKept);
    forget(resting_, kRestingKept);
    writer_.forgetAll();
    for (const auto& [id, message] : last_)
      writer_.write(message);
  }

  std::mutex mutex_;
  std::map<std::uint64_t, Message> last_;
  std::deque<std::uint64_t> closed_;
  std::deque<std::uint64_t> resting_;
  FastWriter<Message> writer_;
};

/// Large answers that may still be on their way: another one behind would keep the first one
/// back, where the network loses some. Measured, 1 % of lost frames: 301 MB for an answer of
/// 1.9 MB, whose client asked every 50 ms. Threads: all methods from any thread.
class OnTheirWay {
 public:
  /// Of a participant, a client and its request.
  using Key = std::tuple<Sender, v1::ClientId, std::uint64_t>;

  void sent(const Key& key, std::size_t bytes) {
    const auto now = std::chrono::steady_clock::now();
    const std::lock_guard lock(mutex_);
    if (known_.size() >= kMostKnown) {
      std::erase_if(known_, [now](const auto& one) {
        return one.second.late < now;
      });
      if (known_.size() >= kMostKnown) known_.erase(known_.begin());
    }
    Sent& one = known_[key];
    const std::chrono::milliseconds least(bytes / kSlowestBytesPerMs);
    one.patience = std::max({2 * one.patience, least, kLeastPatience});
    one.late = now + one.patience;
  }

  /// True where it should have arrived long ago, so that it must be lost.
  [[nodiscard]] bool isLate(const Key& key) const {
    const std::lock_guard lock(mutex_);
    const auto found = known_.find(key);
    return found == known_.end() || found->second.late < std::chrono::steady_clock::now();
  }

 private:
  static constexpr std::size_t kMostKnown = 256;
  static constexpr std::size_t kSlowestBytesPerMs = 5000;
  static constexpr std::chrono::milliseconds kLeastPatience{1000};

  struct Sent {
    std::chrono::milliseconds patience{0};
    std::chrono::steady_clock::time_point late;
  };

  mutable std::mutex mutex_;
  std::map<Key, Sent> known_;
};

class FastBus final : public Bus {
 public:
  FastBus(const Network& network, const Identity& identity)
      : server_(network.server),
        is_secured_(identity.has_value()),
        directory_(identity),
        node_(network, identity, directory_),
        is_paced_(!validate(network).loopback),
        replies_(node_.own(), idl::kReplyTopic, is_paced_),
        progresses_(node_.own(), idl::kProgressTopic),
        edit_replies_(node_.own(), idl::kEditReplyTopic),
        statuses_(node_.endpoints(), idl::kStatusTopic),
        solutions_(node_.own(), idl::kSolutionTopic),
        states_(node_.own(), idl::kSessionTopic),
        frames_(node_.own(), idl::kMotionFramesTopic, is_paced_),
        clocks_(node_.own(), idl::kMotionClockTopic) {
    if (identity) revocations_.emplace(*identity);
  }

  ~FastBus() override { stop(); }

  FastBus(const FastBus&) = delete;
  FastBus& operator=(const FastBus&) = delete;

  void start(BusListener& listener) override {
    using Privilege = idl::Privilege;
    directory_.tell(&listener);
    if (is_secured_) {
      for (const Privilege held : {Privilege::kLook, Privilege::kEdit, Privilege::kOperate})
        hearRequests(listener, held);
    } else {
      hearRequests(listener, std::nullopt);
    }
    edits_ = std::make_unique<FastReader<v1::Edit>>(
        node_.own(), idl::kEditTopic, [&listener](v1::Edit&& edit, const Sender& sender) {
          listener.onEdit(std::move(edit), sender);
        });
    demonstrators_ = std::make_unique<FastReader<v1::DemonstratorFrame>>(
        node_.endpoints(), idl::kDemonstratorTopic,
        [&listener](v1::DemonstratorFrame&& frame, const Sender& sender) {
          listener.onDemonstrator(std::move(frame), sender);
        });
    heard_ = std::make_unique<FastReader<v1::ServerStatus>>(
        node_.endpoints(), idl::kStatusTopic,
        [&listener](v1::ServerStatus&& status, const Sender&) {
          listener.onStatus(status);
        });
  }

  void stop() override {
    directory_.tell(nullptr);
    requests_.clear();
    edits_.reset();
    demonstrators_.reset();
    heard_.reset();
  }

  void publish(const v1::Reply& reply, const Sender& whom) override {
    const std::size_t bytes = v1::Reply::getCdrSerializedSize(reply);
    if (bytes > kLarge) on_their_way_.sent({whom, reply.client(), reply.request_id()}, bytes);
    replies_.write(reply, whom);
  }

  void publishAgain(const v1::Reply& reply, const Sender& whom) override {
    if (v1::Reply::getCdrSerializedSize(reply) > kLarge && !replies_.areAllThere() &&
        !on_their_way_.isLate({whom, reply.client(), reply.request_id()}))
      return;
    publish(reply, whom);
  }

  void publish(const v1::Progress& progress, const Sender& whom) override {
    progresses_.write(progress, whom);
  }

  void publish(const v1::EditReply& reply, const Sender& whom) override {
    edit_replies_.write(reply, whom);
  }

  void publish(const v1::ServerStatus& status) override { statuses_.write(status); }

  void publish(const v1::PoseSolution& solution) override { solutions_.write(solution); }

  void publish(const v1::SessionState& state) override {
    states_.write(state);
    if (state.phase() != v1::PHASE_CLOSED) return;
    states_.close(state.session_id());
    solutions_.close(state.session_id());
    clocks_.close(state.session_id());
    const std::lock_guard lock(commands_mutex_);
    commands_.erase(state.session_id());
    unannounced_.erase(state.session_id());
  }

  void rest(std::uint64_t session_id) override {
    states_.rest(session_id);
    solutions_.rest(session_id);
    clocks_.rest(session_id);
  }

  void publish(const v1::MotionFrames& frames) override { frames_.write(frames); }

  void publish(const v1::MotionClock& clock) override { clocks_.write(clock); }

  void publishJointCommand(std::uint64_t session_id,
                           const sensor_msgs::msg::dds_::JointState_& command) override {
    const std::lock_guard lock(commands_mutex_);
    if (const auto writer = commandsOf(session_id)) writer->write(command);
  }

  [[nodiscard]] std::optional<idl::security::Named> whoIs(const Sender& sender) const override {
    if (!is_secured_) return std::nullopt;
    return directory_.whoIs(sender).value_or(idl::security::Named());
  }

  void lookAround() override {
    announceWhatIsRead();
    tellWhoIsOverItsShare();
    const auto news = revocations_ ? revocations_->look() : std::nullopt;
    if (!news) return;
    if (!news->trouble.empty()) {
      log::error("event=revocations_not_read reason={}", handgraft::quoted(news->trouble));
      return;
    }
    if (news->is_own)
      log::error(
          "event=own_identity_revoked reason=\"programs that know of it do not meet "
          "this server any more\"");
    // All that they say is left out: after a lease they are gone for DDS, too.
    node_.filter().refuse(news->revoked);
    log::info("event=revocations_read count={}", news->revoked.size());
  }

  void flush() override {
    replies_.flush();
    edit_replies_.flush();
    states_.flush();
    statuses_.flush();
  }

 private:
  /// Of what is left out DDS says nothing: who sent it sees answers that take their time.
  void tellWhoIsOverItsShare() {
    using Filter = idl::DatagramFilter;
    for (const Filter::Prefix& prefix : node_.filter().takeOverShare()) {
      Sender sender{};
      std::copy(prefix.begin(), prefix.end(), sender.begin());
      v1::Progress told;  // of no request: all that it has under way
      told.stage(
          fmt::format("over this program's share: {:.0f} messages a second, and {:.0f} "
                      "more of all programs together; the rest waits",
                      Filter::kSamplesPerSecond, Filter::kSharedPerSecond));
      publish(told, sender);
      log::info("event=over_share participant={}",
                fmt::format("{:02x}", fmt::join(prefix, "")));
    }
  }

  /// Of one privilege's topic, or of all who ask in an open domain: who writes a topic of
  /// privileged requests is known by DDS to hold that privilege, whatever the request says.
  void hearRequests(BusListener& listener, std::optional<idl::Privilege> held) {
    const auto hear = [this, &listener, held](v1::Request&& request, const Sender& sender) {
      if (held && !isPermitted(request, sender, *held)) return;
      listener.onRequest(std::move(request), sender);
    };
    requests_.push_back(std::make_unique<FastReader<v1::Request>>(
        node_.own(), held ? idl::security::requestTopicOf(*held) : idl::kRequestTopic, hear));
  }

  /// Refuses what takes more than its sender holds.
  bool isPermitted(const v1::Request& request, const Sender& sender, idl::Privilege held) {
    const v1::Operation operation = request.body()._d();
    const idl::Privilege needed = idl::traitsOf(operation).privilege;
    if (needed <= held) return true;
    v1::Reply reply;
    reply.client(request.client());
    reply.request_id(request.request_id());
    reply.error(v1::ERROR_NOT_PERMITTED);
    reply.message(
        fmt::format("{} is for {}", v1::nameOf(operation), idl::security::holdersOf(needed)));
    publish(reply, sender);
    return false;
  }

  using CommandWriter = FastWriter<sensor_msgs::msg::dds_::JointState_>;

  [[nodiscard]] std::string commandTopicOf(std::uint64_t session_id) const {
    return "rt/handgraft/" + (server_.empty() ? "" : server_ + "/") +
           std::to_string(session_id) + "/joint_command";
  }

  /// Null where there are many and nobody reads this one's: a writer is told of to everybody,
  /// and everybody answers. Beside a hundred clients that come and go with a session each that
  /// was most of what there was to say. `commands_mutex_` held.
  std::shared_ptr<CommandWriter> commandsOf(std::uint64_t session_id) {
    const auto found = commands_.find(session_id);
    if (found != commands_.end()) return found->second;
    const std::string name = commandTopicOf(session_id);
    if (!directory_.isRead(name)) {
      if (commands_.size() >= kAnnouncedCommands || announced_ >= kAnnouncedInAll) {
        unannounced_.insert(session_id);
        return nullptr;
      }
      ++announced_;
    }
    unannounced_.erase(session_id);
    return commands_[session_id] = std::make_shared<CommandWriter>(
               node_.endpoints(), idl::Topic<sensor_msgs::msg::dds_::JointState_>{
                                      name.c_str(), idl::Qos::kTelemetry});
  }

  /// So that who reads one has met its writer when the next command comes.
  void announceWhatIsRead() {
    const std::lock_guard lock(commands_mutex_);
    const auto sessions = unannounced_;
    for (const std::uint64_t session_id : sessions)
      commandsOf(session_id);
  }

  static constexpr std::size_t kLarge = 65'536;  // bytes of an answer
  /// Sessions whose joint commands have a writer before anybody reads them, so that ROS 2 lists
  /// their topics.
  static constexpr std::size_t kAnnouncedCommands = 16;
  /// Since the server began: Fast DDS 2.9 keeps, for each participant, that a writer is gone.
  /// Measured: 12 kB a session, in a server that a thousand programs come to and leave.
  static constexpr std::size_t kAnnouncedInAll = 256;

  std::string server_;
  bool is_secured_;
  std::optional<idl::security::Revocations> revocations_;
  ParticipantDirectory directory_;
  Node node_;
  bool is_paced_;
  OnTheirWay on_their_way_;
  AddressedWriter<v1::Reply> replies_;
  AddressedWriter<v1::Progress> progresses_;
  AddressedWriter<v1::EditReply> edit_replies_;
  FastWriter<v1::ServerStatus> statuses_;
  SessionTopic<v1::PoseSolution> solutions_;
  SessionTopic<v1::SessionState> states_;
  FastWriter<v1::MotionFrames> frames_;
  SessionTopic<v1::MotionClock> clocks_;
  std::mutex commands_mutex_;
  std::map<std::uint64_t, std::shared_ptr<CommandWriter>> commands_;
  std::set<std::uint64_t> unannounced_;  ///< sessions without such a writer
  std::size_t announced_ = 0;            ///< writers made that nobody had asked for
  std::vector<std::unique_ptr<FastReader<v1::Request>>> requests_;
  std::unique_ptr<FastReader<v1::Edit>> edits_;
  std::unique_ptr<FastReader<v1::DemonstratorFrame>> demonstrators_;
  std::unique_ptr<FastReader<v1::ServerStatus>> heard_;
};

}  // namespace

std::unique_ptr<Bus> openFastBus(const Network& network) {
  routeVendorLog();
  validate(network);
  // Who has no address yet will come, and name this host.
  std::vector<std::string> without_address;
  const Network reached = idl::withPeerAddresses(network, &without_address);
  for (const std::string& peer : without_address)
    log::warn("event=peer_without_address peer={}", handgraft::quoted(peer));
  return std::make_unique<FastBus>(reached, identityOf(network));
}

}  // namespace handgraft::server
