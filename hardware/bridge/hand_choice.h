#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "hardware/bridge/hand_describer.h"
#include "hardware/bridge/hand_plan.h"
#include "hardware/bridge/stream_feed.h"
#include "hardware/config/hand_config.h"

namespace handgraft::bridge {

/// What the server knows of the hand that streams: where none is configured, the hand to
/// simulate; else how its model and the config differ.
class HandChoice {
 public:
  explicit HandChoice(const idl::cyclone::Participant& participant) : describer_(participant) {}

  /// Whether the hand of `pose` is the one that was begun.
  [[nodiscard]] bool isOf(const StreamFeed::Pose& pose) const {
    return answered_ == questionOf(pose);
  }

  /// The server may know other hands when it is back.
  void forget() { answered_.reset(); }

  /// Asks for the hand of the pose that waits; `begin` is called with one that moves otherwise
  /// than the one before. Why that hand cannot be, or empty: the next pose asks again.
  std::string choose(const std::optional<StreamFeed::Pose>& waiting,
                     const MotionBounds& bounds,
                     const std::function<void(const HandPlan&)>& begin);

  /// How the config differs from the hand's model as the server has it, for people.
  struct Comparison {
    std::string differences;  ///< all of them; empty: they agree, or nobody knows
    std::string kinds;        ///< of those, what keeps it from being moved
  };

  /// Once for each session; nothing: there is no news.
  std::optional<Comparison> compare(std::uint64_t session, const config::HandConfig& config);

 private:
  static HandQuestion questionOf(const StreamFeed::Pose& pose) {
    return {pose.pose.session_id, pose.pose.hand};
  }

  HandDescriber describer_;
  std::optional<HandQuestion> answered_;  // the plan's
  std::optional<HandPlan> plan_;
  std::uint64_t compared_ = 0;  // session whose hand's model was compared with the config
};

}  // namespace handgraft::bridge
