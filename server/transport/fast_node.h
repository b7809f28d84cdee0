#pragma once

#include <memory>
#include <optional>

#include "core/base/network.h"
#include "idl/datagrams/datagram_filter.h"
#include "idl/security/identity.h"
#include "server/transport/fast_endpoints.h"
#include "server/transport/participant_directory.h"

/// This process among others on Fast DDS; private to this folder.
namespace handgraft::server {

using Identity = std::optional<idl::security::Identity>;

/// Of a network that names one. Errors: InvalidInput (security::readIdentity).
Identity identityOf(const Network& network);

/// The participant and all that lives in it, taken down in order.
class Node {
 public:
  /// `participants` hears of others and is asked about what they show; it must outlive the
  /// node. Errors: InvalidInput for the network; TransportError if DDS refuses.
  Node(const Network& network, const Identity& identity, ParticipantDirectory& participants);

  ~Node() { close(); }

  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// For topics that are everybody's.
  [[nodiscard]] Endpoints endpoints() const { return {participant_, publisher_, subscriber_}; }

  /// For topics of one server, in the partition of its name (idl/topics.h).
  [[nodiscard]] Endpoints own() const {
    return {participant_, own_publisher_, own_subscriber_};
  }

  /// What every datagram to it goes through.
  [[nodiscard]] idl::DatagramFilter& filter() const { return *filter_; }

 private:
  void close();

  std::shared_ptr<idl::DatagramFilter> filter_;
  eprosima::fastdds::dds::DomainParticipant* participant_ = nullptr;
  eprosima::fastdds::dds::Publisher* publisher_ = nullptr;
  eprosima::fastdds::dds::Subscriber* subscriber_ = nullptr;
  eprosima::fastdds::dds::Publisher* own_publisher_ = nullptr;
  eprosima::fastdds::dds::Subscriber* own_subscriber_ = nullptr;
};

}  // namespace handgraft::server
