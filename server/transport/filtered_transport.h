#pragma once

#include <chrono>
#include <memory>

#include <fastdds/rtps/network/SenderResource.h>
#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastdds/rtps/transport/ChainingTransportDescriptor.h>
#include <fastdds/rtps/transport/TransportReceiverInterface.h>

#include "idl/datagrams/datagram_filter.h"

namespace handgraft::server {

/// What comes through another transport goes through the filter first; what is sent, does not.
class FilteredTransport final : public eprosima::fastdds::rtps::ChainingTransport {
 public:
  using ChainingTransport = eprosima::fastdds::rtps::ChainingTransport;
  using Descriptor = eprosima::fastdds::rtps::ChainingTransportDescriptor;

  FilteredTransport(const Descriptor& descriptor, std::shared_ptr<idl::DatagramFilter> filter)
      : ChainingTransport(descriptor),
        filter_(std::move(filter)),
        low_(descriptor.low_level_descriptor) {}

  bool send(eprosima::fastrtps::rtps::SenderResource* low,
            const eprosima::fastrtps::rtps::octet* bytes,
            std::uint32_t size,
            eprosima::fastrtps::rtps::LocatorsIterator* begin,
            eprosima::fastrtps::rtps::LocatorsIterator* end,
            const std::chrono::steady_clock::time_point& until) override {
    return low->send(bytes, size, begin, end, until);
  }

  void receive(eprosima::fastdds::rtps::TransportReceiverInterface* next,
               const eprosima::fastrtps::rtps::octet* bytes,
               std::uint32_t size,
               const eprosima::fastrtps::rtps::Locator_t& local,
               const eprosima::fastrtps::rtps::Locator_t& remote) override {
    thread_local std::vector<std::uint8_t> kept;
    const auto passed = filter_->pass({bytes, size}, kept);
    if (passed.empty()) return;
    next->OnDataReceived(passed.data(), static_cast<std::uint32_t>(passed.size()), local,
                         remote);
  }

  eprosima::fastdds::rtps::TransportDescriptorInterface* get_configuration() override {
    return low_.get();
  }

 private:
  std::shared_ptr<idl::DatagramFilter> filter_;
  std::shared_ptr<eprosima::fastdds::rtps::TransportDescriptorInterface> low_;
};

struct FilteredTransportDescriptor final : FilteredTransport::Descriptor {
  /// `largest_sent`: datagram that is sent; `low` takes what others send, of its own size.
  FilteredTransportDescriptor(
      std::shared_ptr<eprosima::fastdds::rtps::TransportDescriptorInterface> low,
      std::shared_ptr<idl::DatagramFilter> with,
      std::uint32_t largest_sent)
      : FilteredTransport::Descriptor(std::move(low)),
        filter(std::move(with)),
        largest(largest_sent) {}

  std::uint32_t max_message_size() const override { return largest; }

  eprosima::fastdds::rtps::TransportInterface* create_transport() const override {
    return new FilteredTransport(*this, filter);
  }

  std::shared_ptr<idl::DatagramFilter> filter;
  std::uint32_t largest;
};

}  // namespace handgraft::server
