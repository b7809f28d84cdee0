#pragma once

#include <algorithm>
#include <chrono>
#include <iterator>
#include <list>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <fastdds/rtps/network/SenderResource.h>
#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastdds/rtps/transport/ChainingTransportDescriptor.h>
#include <fastdds/rtps/transport/TransportReceiverInterface.h>

#include "idl/datagrams/datagram_filter.h"
#include "server/transport/fair_queue.h"
#include "server/transport/heartbeat_throttle.h"

namespace handgraft::server {

/// What comes through another transport goes through the filter first, on the thread that reads
/// the socket and does nothing else, and then by turns of its senders to Fast DDS, which does
/// all that follows on the thread that brings it a datagram. What is sent does not, but that
/// who is silent is not asked all the time.
class FilteredTransport final : public eprosima::fastdds::rtps::ChainingTransport {
 public:
  using ChainingTransport = eprosima::fastdds::rtps::ChainingTransport;
  using Descriptor = eprosima::fastdds::rtps::ChainingTransportDescriptor;
  using Receiver = eprosima::fastdds::rtps::TransportReceiverInterface;
  using Locator = eprosima::fastrtps::rtps::Locator_t;

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
    if (!insistence_.maySend({bytes, size})) return true;
    return low->send(bytes, size, begin, end, until);
  }

  bool OpenInputChannel(const Locator& locator,
                        Receiver* receiver,
                        std::uint32_t largest) override {
    {
      const std::lock_guard lock(mutex_);
      lanes_.emplace_back(locator, receiver);
    }
    const bool is_open = ChainingTransport::OpenInputChannel(locator, receiver, largest);
    if (!is_open) endLanes(locator);
    return is_open;
  }

  /// Nothing reaches its receiver any more once this returned.
  bool CloseInputChannel(const Locator& locator) override {
    const bool is_closed = ChainingTransport::CloseInputChannel(locator);
    endLanes(locator);
    return is_closed;
  }

  void receive(Receiver* next,
               const eprosima::fastrtps::rtps::octet* bytes,
               std::uint32_t size,
               const Locator& /*local*/,
               const Locator& remote) override {
    thread_local std::vector<std::uint8_t> kept;
    const auto passed = filter_->pass({bytes, size}, kept);
    if (passed.empty()) return;
    insistence_.hear(passed);
    FairQueue::Sender sender{{}, remote.port};
    std::copy(std::begin(remote.address), std::end(remote.address), sender.address.begin());
    const std::lock_guard lock(mutex_);
    const auto lane = std::find_if(lanes_.begin(), lanes_.end(), [next](const Lane& one) {
      return one.receiver == next;
    });
    if (lane != lanes_.end()) lane->queue.push(sender, passed);
  }

  eprosima::fastdds::rtps::TransportDescriptorInterface* get_configuration() override {
    return low_.get();
  }

 private:
  /// From one or more sockets to one receiver.
  struct Lane {
    Lane(const Locator& at, Receiver* whose) : locator(at), receiver(whose) {}

    ~Lane() {
      queue.shut();
      worker.join();
    }

    Lane(const Lane&) = delete;
    Lane& operator=(const Lane&) = delete;

    void work() {
      while (const auto next = queue.pop()) {
        Locator remote(locator.kind, next->sender.port);
        std::copy(next->sender.address.begin(), next->sender.address.end(),
                  std::begin(remote.address));
        receiver->OnDataReceived(next->bytes.data(),
                                 static_cast<std::uint32_t>(next->bytes.size()), locator,
                                 remote);
      }
    }

    const Locator locator;
    Receiver* const receiver;
    FairQueue queue;
    std::thread worker{[this] {
      work();
    }};
  };

  void endLanes(const Locator& locator) {
    std::list<Lane> ended;  // and gone once the mutex is free
    const std::lock_guard lock(mutex_);
    for (auto at = lanes_.begin(); at != lanes_.end();) {
      const auto next = std::next(at);
      if (at->locator == locator) ended.splice(ended.end(), lanes_, at);
      at = next;
    }
  }

  std::shared_ptr<idl::DatagramFilter> filter_;
  std::shared_ptr<eprosima::fastdds::rtps::TransportDescriptorInterface> low_;
  HeartbeatThrottle insistence_;
  std::mutex mutex_;
  std::list<Lane> lanes_;
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

  [[nodiscard]] std::uint32_t max_message_size() const override { return largest; }

  [[nodiscard]] eprosima::fastdds::rtps::TransportInterface* create_transport() const override {
    return new FilteredTransport(*this, filter);
  }

  std::shared_ptr<idl::DatagramFilter> filter;
  std::uint32_t largest;
};

}  // namespace handgraft::server
