// Fast DDS 2.9.1. UDP on one interface, nothing else: shared memory would leave files behind
// and Cyclone DDS cannot use it. idl/README explains the profiles.
#include "server/transport/fast_node.h"

#include <string>
#include <vector>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/rtps/flowcontrol/FlowControllerDescriptor.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>

#include "server/transport/filtered_transport.h"
#include "server/transport/own_ports.h"

namespace handgraft::server {

namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;

constexpr std::uint32_t kSocketBuffer = 4 * 1024 * 1024;
// On the loopback; never below Cyclone's 65500: smaller ones made a storm of retransmissions.
constexpr std::uint32_t kDatagram = 65500;
// Elsewhere what is sent is one frame: of 45 fragments each would have to arrive.
constexpr std::uint32_t kFrame = 1400;
// But for a secured domain: Fast DDS 2.9.1 sends a message of a handshake in one datagram or
// not at all, and it holds a certificate and signed permissions, 6 kB in all. (A second try of
// who was not answered then ends the process, by an assertion.)
constexpr std::uint32_t kHandshake = 12'000;
// So much goes out at once there, and every so often: more than a gigabit carries is lost in
// buffers on the way.
constexpr std::int32_t kBurst = 50'000;
constexpr std::uint64_t kBurstPeriodMs = 2;

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
                                         const Identity& identity,
                                         const std::shared_ptr<idl::DatagramFilter>& filter) {
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
  if (!interface.loopback) {
    const auto pace = std::make_shared<eprosima::fastdds::rtps::FlowControllerDescriptor>();
    pace->name = kPace;
    pace->max_bytes_per_period = kBurst;
    pace->period_ms = kBurstPeriodMs;
    qos.flow_controllers().push_back(pace);
  }
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
  udp->maxInitialPeersRange = kMostProgramsOfAMachine;
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
  qos.transport().user_transports.push_back(
      std::make_shared<FilteredTransportDescriptor>(udp, filter,
                                                    interface.loopback ? kDatagram
                                                    : identity         ? kHandshake
                                                                       : kFrame));
  if (identity) secure(*identity, qos);
  return qos;
}

}  // namespace

Identity identityOf(const Network& network) {
  if (network.identity.empty()) return std::nullopt;
  return idl::security::readIdentity(network.identity, {idl::security::Role::kServer});
}

Node::Node(const Network& network, const Identity& identity, ParticipantDirectory& participants)
    : filter_(std::make_shared<idl::DatagramFilter>(identity
                                                        ? idl::DatagramFilter::Domain::kSecured
                                                        : idl::DatagramFilter::Domain::kOpen)) {
  const NetworkInterface interface = validate(network);
  filter_->askAboutCertificates(
      [&participants](idl::security::GuidBegin begin, std::string_view shown) {
        return participants.admits(begin, shown);
      });
  const auto heard_before = portsHeard(network.domain);
  auto* factory = dds::DomainParticipantFactory::get_instance();
  participant_ =
      factory->create_participant(static_cast<dds::DomainId_t>(network.domain),
                                  participantQos(network, interface, identity, filter_),
                                  &participants, dds::StatusMask::none());
  // Fast DDS goes on without any port where all are taken, and hears nobody.
  constexpr std::size_t kPortsOfOne = 2;
  const auto heard = portsHeard(network.domain);
  if (heard && heard_before && heard->size() < heard_before->size() + kPortsOfOne) {
    close();
    throw TransportError(describe(network) +
                         ": all ports of DDS participants are taken on this machine; stop "
                         "some programs, or choose another --domain");
  }
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

void Node::close() {
  if (participant_ == nullptr) return;
  participant_->delete_contained_entities();
  dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  participant_ = nullptr;
}

}  // namespace handgraft::server
