#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <utility>

#include "idl/hardware.h"

namespace handgraft::bridge {

/// Lets each command to one bridge through once. A command is known by its id and kind, so that
/// an ESTOP is never taken for the repeat of another command.
class CommandFilter {
 public:
  explicit CommandFilter(std::uint32_t bridge_id) : bridge_id_(bridge_id) {}

  bool passes(const v1::HandCommand& command) {
    if (command.bridge_id() != bridge_id_) return false;
    const std::pair key{command.command_id(), command.kind()};
    if (std::find(seen_.begin(), seen_.end(), key) != seen_.end()) return false;
    if (seen_.size() >= kRemembered) seen_.pop_front();
    seen_.push_back(key);
    return true;
  }

 private:
  static constexpr std::size_t kRemembered = 1024;

  std::uint32_t bridge_id_;
  std::deque<std::pair<std::uint64_t, v1::HandCommandKind>> seen_;
};

}  // namespace handgraft::bridge
