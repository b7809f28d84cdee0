#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "idl/cyclone/entity.h"
#include "idl/cyclone/participant.h"

namespace handgraft::idl::cyclone {

/// Topics that somebody on the bus writes, this program included, among those whose names begin
/// alike. To read only what is written spares everybody the news of readers that nobody needs.
/// Threads: one.
class WrittenTopics {
 public:
  /// `on_change` as a Reader's `on_data`. Errors: TransportError.
  WrittenTopics(const Participant& participant,
                std::string prefix,
                std::function<void()> on_change);
  WrittenTopics(const WrittenTopics&) = delete;
  WrittenTopics& operator=(const WrittenTopics&) = delete;

  /// By what was heard until now. Cost: O(log n), and what came since the last call.
  [[nodiscard]] bool contains(const std::string& topic);

 private:
  using Writer = std::array<std::uint8_t, 16>;

  [[nodiscard]] std::int32_t createReader();
  void hear();
  void forget(const Writer& writer);

  const Participant participant_;  // which the reader keeps alive
  const std::string prefix_;
  const std::function<void()> on_change_;
  std::map<Writer, std::string> topics_;
  std::map<std::string, int> writers_;
  Entity reader_;  // deleting it waits for a callback that is running
};

}  // namespace handgraft::idl::cyclone
