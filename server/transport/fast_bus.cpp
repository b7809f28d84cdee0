// Fast DDS 2.9.1. UDP on one interface, nothing else: shared memory would leave files behind
// and Cyclone DDS cannot use it. idl/README explains the profiles.
#include <atomic>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <spdlog/spdlog.h>

#include "idl/fields.h"
#include "idl/peer_names.h"
#include "idl/security/identity.h"
#include "idl/topics.h"
#include "server/transport/bus.h"
#include "server/transport/fast_endpoints.h"
#include "server/transport/filtered_transport.h"

namespace handgraft::server {

namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

constexpr std::uint32_t kSocketBuffer = 4 * 1024 * 1024;
// Never below Cyclone's 65500: smaller datagrams made a storm of retransmissions.
constexpr std::uint32_t kDatagram = 65500;
constexpr std::uint32_t kPeersOfThisMachine = 101;  // Cyclone's participant indices, 0-100

using Identity = std::optional<idl::security::Identity>;

/// Fast DDS' own plugins, told who this is.
void secure(const idl::security::Identity& identity, dds::DomainParticipantQos& qos) {
  namespace security = idl::security;
  const auto put = [&](const std::string& key, const std::string& value) {
    qos.properties().properties().emplace_back(key, value);
  };
  const auto put_file = [&](const std::string& key, const char* file) {
    put(key, "file://" + identity.file(file));
  };
  const std::string who = "dds.sec.auth.builtin.PKI-DH.";
  put("dds.sec.auth.plugin", "builtin.PKI-DH");
  put_file(who + "identity_ca", security::kAuthorityFile);
  put_file(who + "identity_certificate", security::kCertificateFile);
  put_file(who + "private_key", security::kKeyFile);
  put_file(who + "identity_crl", security::kRevokedFile);
  const std::string may = "dds.sec.access.builtin.Access-Permissions.";
  put("dds.sec.access.plugin", "builtin.Access-Permissions");
  put_file(may + "permissions_ca", security::kAuthorityFile);
  put_file(may + "governance", security::kGovernanceFile);
  put_file(may + "permissions", security::kPermissionsFile);
  put("dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC");
}

dds::DomainParticipantQos participantQos(const Network& network,
                                         const NetworkInterface& interface,
                                         const Identity& identity) {
  dds::DomainParticipantQos qos;
  // The second is known to idl/cyclone: who has no identity is told that one is needed.
  qos.name(identity ? "handgraft-server, secured" : "handgraft-server");
  qos.transport().use_builtin_transports = false;
  auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList.push_back(interface.address);
  udp->receiveBufferSize = kSocketBuffer;
  udp->sendBufferSize = kSocketBuffer;
  udp->maxMessageSize = kDatagram;
  udp->non_blocking_send = false;
  auto& protocol = qos.wire_protocol();
  auto& discovery = protocol.builtin.discovery_config;
  // Who outlasts its lease is dropped and never found again, though it lives: stopped processes
  // need time (idl/README).
  discovery.leaseDuration = {20, 0};
  // A client that has just come up learns of us by the next announcement: measured, it misses
  // the direct answer to its own.
  discovery.leaseDuration_announcementperiod = {0, 200'000'000};
  const auto locator = [](const std::string& address, std::uint32_t port) {
    rtps::Locator_t made(LOCATOR_KIND_UDPv4, port);  // 0: each participant's, by RTPS' rules
    rtps::IPLocator::setIPv4(made, address);
    return made;
  };
  const std::vector<std::string> peers = unicastAddresses(network, interface);
  udp->maxInitialPeersRange = kPeersOfThisMachine;
  for (const std::string& address : peers)
    protocol.builtin.initialPeersList.push_back(locator(address, 0));
  if (interface.loopback) {
    // Unicast both ways, so that loopback needs no multicast route.
    protocol.builtin.metatrafficUnicastLocatorList.push_back(locator(interface.address, 0));
  } else if (!peers.empty()) {
    // Those who are told one by one replace the multicast group, unless it is named, too.
    const auto group = 7400U + 250U * static_cast<std::uint32_t>(network.domain);
    protocol.builtin.initialPeersList.push_back(locator("239.255.0.1", group));
  }
  qos.transport().user_transports.push_back(std::make_shared<FilteredTransportDescriptor>(
      udp, identity ? DatagramFilter::Domain::kSecured : DatagramFilter::Domain::kOpen));
  if (identity) secure(*identity, qos);
  return qos;
}

/// The participant and all that lives in it, taken down in order.
class Node {
 public:
  Node(const Network& network, const Identity& identity) {
    const NetworkInterface interface = validate(network);
    auto* factory = dds::DomainParticipantFactory::get_instance();
    participant_ = factory->create_participant(static_cast<dds::DomainId_t>(network.domain),
                                               participantQos(network, interface, identity));
    if (participant_ != nullptr) {
      publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
      subscriber_ = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
      dds::PublisherQos writing = dds::PUBLISHER_QOS_DEFAULT;
      dds::SubscriberQos reading = dds::SUBSCRIBER_QOS_DEFAULT;
      if (!network.server.empty()) {
        writing.partition().push_back(network.server.c_str());
        reading.partition().push_back(network.server.c_str());
      }
      own_publisher_ = participant_->create_publisher(writing);
      own_subscriber_ = participant_->create_subscriber(reading);
    }
    if (publisher_ == nullptr || subscriber_ == nullptr || own_publisher_ == nullptr ||
        own_subscriber_ == nullptr) {
      close();
      throw TransportError(describe(network) + ": Fast DDS cannot join");
    }
  }

  ~Node() { close(); }

  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// For topics that are everybody's.
  [[nodiscard]] Endpoints endpoints() const { return {participant_, publisher_, subscriber_}; }

  /// For topics of one server, in the partition of its name (idl/topics.h).
  [[nodiscard]] Endpoints own() const {
    return {participant_, own_publisher_, own_subscriber_};
  }

 private:
  void close() {
    if (participant_ == nullptr) return;
    participant_->delete_contained_entities();
    dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
    participant_ = nullptr;
  }

  dds::DomainParticipant* participant_ = nullptr;
  dds::Publisher* publisher_ = nullptr;
  dds::Subscriber* subscriber_ = nullptr;
  dds::Publisher* own_publisher_ = nullptr;
  dds::Subscriber* own_subscriber_ = nullptr;
};

/// A keyed topic whose writer keeps the last value of every session for late joiners.
///
/// Instances cannot be disposed across the vendors (idl/README), so closed sessions are
/// forgotten now and then by emptying the writer's history and writing what still counts once
/// more.
template <class Message>
class SessionTopic {
 public:
  SessionTopic(const Endpoints& endpoints, const idl::Topic<Message>& topic)
      : writer_(endpoints, topic) {}

  void write(const Message& message) {
    const std::lock_guard lock(mutex_);
    last_[message.session_id()] = message;
    writer_.write(message);
  }

  /// The session will not speak again.
  void close(std::uint64_t session_id) {
    const std::lock_guard lock(mutex_);
    closed_.push_back(session_id);
    if (closed_.size() < kClosedKept + kClosedAtOnce) return;
    while (closed_.size() > kClosedKept) {
      last_.erase(closed_.front());
      closed_.pop_front();
    }
    writer_.forgetAll();
    for (const auto& [id, message] : last_)
      writer_.write(message);
  }

  void flush() { writer_.flush(); }

 private:
  static constexpr std::size_t kClosedKept = 32;  // their news may still be on the way
  static constexpr std::size_t kClosedAtOnce = 96;

  std::mutex mutex_;
  std::map<std::uint64_t, Message> last_;
  std::deque<std::uint64_t> closed_;
  FastWriter<Message> writer_;
};

class FastBus final : public Bus {
 public:
  FastBus(const Network& network, const Identity& identity)
      : server_(network.server),
        is_secured_(identity.has_value()),
        node_(network, identity),
        lookout_(network, identity),
        replies_(node_.own(), idl::kReplyTopic),
        progresses_(node_.own(), idl::kProgressTopic),
        edit_replies_(node_.own(), idl::kEditReplyTopic),
        statuses_(node_.endpoints(), idl::kStatusTopic),
        solutions_(node_.own(), idl::kSolutionTopic),
        states_(node_.own(), idl::kSessionTopic),
        frames_(node_.own(), idl::kMotionFramesTopic),
        clocks_(node_.own(), idl::kMotionClockTopic) {}

  ~FastBus() override { stop(); }

  FastBus(const FastBus&) = delete;
  FastBus& operator=(const FastBus&) = delete;

  void start(BusListener& listener) override {
    using Privilege = idl::security::Privilege;
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
        [&listener](v1::DemonstratorFrame&& frame, const Sender&) {
          listener.onDemonstrator(std::move(frame));
        });
    heard_ = std::make_unique<FastReader<v1::ServerStatus>>(
        lookout_.endpoints(), idl::kStatusTopic,
        [&listener](v1::ServerStatus&& status, const Sender&) {
          listener.onStatus(status);
        });
  }

  void stop() override {
    requests_.clear();
    edits_.reset();
    demonstrators_.reset();
    heard_.reset();
  }

  void publish(const v1::Reply& reply) override { replies_.write(reply); }

  void publish(const v1::Progress& progress) override { progresses_.write(progress); }

  void publish(const v1::EditReply& reply) override { edit_replies_.write(reply); }

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
  }

  void publish(const v1::MotionFrames& frames) override { frames_.write(frames); }

  void publish(const v1::MotionClock& clock) override { clocks_.write(clock); }

  void publishJointCommand(std::uint64_t session_id,
                           const sensor_msgs::msg::dds_::JointState_& command) override {
    const std::lock_guard lock(commands_mutex_);
    auto& writer = commands_[session_id];
    if (writer == nullptr) {
      const std::string name = "rt/handgraft/" + (server_.empty() ? "" : server_ + "/") +
                               std::to_string(session_id) + "/joint_command";
      writer = std::make_unique<FastWriter<sensor_msgs::msg::dds_::JointState_>>(
          node_.endpoints(),
          idl::Topic<sensor_msgs::msg::dds_::JointState_>{name.c_str(), idl::Qos::kTelemetry});
    }
    writer->write(command);
  }

  void flush() override {
    replies_.flush();
    edit_replies_.flush();
    states_.flush();
    statuses_.flush();
  }

 private:
  /// Of one privilege's topic, or of all who ask in an open domain: who writes a topic of
  /// privileged requests is known by DDS to hold that privilege, whatever the request says.
  void hearRequests(BusListener& listener, std::optional<idl::security::Privilege> held) {
    const auto hear = [this, &listener, held](v1::Request&& request, const Sender& sender) {
      if (held && !isPermitted(request, *held)) return;
      listener.onRequest(std::move(request), sender);
    };
    requests_.push_back(std::make_unique<FastReader<v1::Request>>(
        node_.own(), held ? idl::security::requestTopicOf(*held) : idl::kRequestTopic, hear));
  }

  /// Refuses what takes more than its sender holds.
  bool isPermitted(const v1::Request& request, idl::security::Privilege held) {
    const v1::Operation operation = request.body()._d();
    const idl::security::Privilege needed = idl::security::privilegeOf(operation);
    if (needed <= held) return true;
    v1::Reply reply;
    reply.client(request.client());
    reply.request_id(request.request_id());
    reply.error(v1::ERROR_NOT_PERMITTED);
    reply.message(
        fmt::format("{} is for {}", v1::nameOf(operation), idl::security::holdersOf(needed)));
    publish(reply);
    return false;
  }

  std::string server_;
  bool is_secured_;
  Node node_;
  /// Reads the topic that `node_` writes: a Fast DDS participant knows a topic by one type
  /// support only, and the hardened one that reading needs cannot write.
  Node lookout_;
  FastWriter<v1::Reply> replies_;
  FastWriter<v1::Progress> progresses_;
  FastWriter<v1::EditReply> edit_replies_;
  FastWriter<v1::ServerStatus> statuses_;
  SessionTopic<v1::PoseSolution> solutions_;
  SessionTopic<v1::SessionState> states_;
  FastWriter<v1::MotionFrames> frames_;
  SessionTopic<v1::MotionClock> clocks_;
  std::mutex commands_mutex_;
  std::map<std::uint64_t, std::unique_ptr<FastWriter<sensor_msgs::msg::dds_::JointState_>>>
      commands_;
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
    spdlog::warn("event=peer_without_address peer={}", handgraft::quoted(peer));
  Identity identity;
  if (!network.identity.empty()) {
    identity = idl::security::readIdentity(network.identity, {idl::security::Role::kServer});
  }
  return std::make_unique<FastBus>(reached, identity);
}

}  // namespace handgraft::server
