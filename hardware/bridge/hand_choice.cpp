#include "hardware/bridge/hand_choice.h"

#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"

namespace handgraft::bridge {

std::string HandChoice::choose(const std::optional<StreamFeed::Pose>& waiting,
                               const MotionBounds& bounds,
                               const std::function<void(const HandPlan&)>& begin) {
  const bool is_open = waiting && !isOf(*waiting);
  describer_.want(is_open ? std::optional(questionOf(*waiting)) : std::nullopt);
  const std::optional<HandDescriber::Answer> answer = describer_.take();
  if (!answer || !is_open || answer->question != questionOf(*waiting)) return {};
  try {
    if (!answer->description) rejectInput("{}", answer->refusal);
    HandPlan wanted = planHand(*answer->description, bounds);
    wanted.hand = answer->question.hand;
    if (!plan_ || !movesAlike(*plan_, wanted)) {
      begin(wanted);
      plan_ = std::move(wanted);
    }
    answered_ = answer->question;
    return {};
  } catch (const InvalidInput& error) {
    return fmt::format("session {}: {}", answer->question.session_id, error.what());
  }
}

std::optional<HandChoice::Comparison> HandChoice::compare(std::uint64_t session,
                                                          const config::HandConfig& config) {
  const HandQuestion question{session, config.hand};
  const bool is_open = session != 0 && compared_ != session;
  describer_.want(is_open ? std::optional(question) : std::nullopt);
  const std::optional<HandDescriber::Answer> answer = describer_.take();
  if (!answer || answer->question != question) return std::nullopt;
  compared_ = session;
  if (!answer->description) return Comparison{};
  return Comparison{differencesOf(*answer->description, config),
                    kindsThatDiffer(*answer->description, config)};
}

}  // namespace handgraft::bridge
