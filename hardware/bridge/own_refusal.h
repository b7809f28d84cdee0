#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "idl/hardware.h"

namespace handgraft::bridge {

/// The refusal of a command that the motion never saw; until it hears of another one.
class OwnRefusal {
 public:
  void note(v1::BridgeRefusal code, std::string text) {
    code_ = code;
    text_ = std::move(text);
    ++count_;
  }

  /// Counted it stays.
  void forget() {
    code_ = v1::REFUSAL_NONE;
    text_.clear();
  }

  /// Into a status that tells the motion's refusals.
  void addTo(v1::BridgeStatus& status) const {
    status.refusal_count(status.refusal_count() + count_);
    if (code_ == v1::REFUSAL_NONE) return;
    status.last_refusal(text_);
    status.refusal(code_);
  }

 private:
  v1::BridgeRefusal code_ = v1::REFUSAL_NONE;
  std::string text_;
  std::uint64_t count_ = 0;
};

}  // namespace handgraft::bridge
