#pragma once

#include "idl/topics.h"
#include "server/transport/bus.h"
#include "server/transport/delivery.h"
#include "server/transport/fast_endpoints.h"

namespace handgraft::server {

/// Publishes messages of one topic, each to who asked.
template <class Message>
class AddressedWriter {
 public:
  AddressedWriter(const Endpoints& endpoints,
                  const idl::Topic<Message>& topic,
                  bool is_paced = false)
      : writer_(endpoints, topic, is_paced, Heartbeats::kOnTheirOwn) {
    sendToOneAlone(writer_.entity());
  }

  void write(const Message& message, const Sender& whom) {
    const WritingTo one(whom);
    writer_.write(message);
  }

  [[nodiscard]] bool areAllThere() { return writer_.areAllThere(); }

  void flush() { writer_.flush(); }

 private:
  FastWriter<Message> writer_;
};

}  // namespace handgraft::server
