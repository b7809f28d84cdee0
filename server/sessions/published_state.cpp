#include "server/sessions/published_state.h"

namespace handgraft::server {

v1::SessionState PublishedState::get() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

bool PublishedState::isClosed() const {
  const std::lock_guard lock(mutex_);
  return state_.phase() == v1::PHASE_CLOSED;
}

void PublishedState::change(const Change& change, PublishPolicy telling) {
  {
    const std::lock_guard lock(mutex_);
    if (state_.phase() == v1::PHASE_CLOSED) return;
    change(state_);
    if (!telling.least_period || told_ == state_) return;
    const Clock::time_point now = now_();
    if (told_ && now - told_at_ < *telling.least_period) return;
    told_ = state_;
    told_at_ = now;
    queued_.push_back(state_);
  }
  publishQueued();
}

void PublishedState::publishQueued() {
  const std::lock_guard order(publishing_);
  for (;;) {
    v1::SessionState next;
    {
      const std::lock_guard lock(mutex_);
      if (queued_.empty()) return;
      next = std::move(queued_.front());
      queued_.pop_front();
    }
    publish_(next);
  }
}

}  // namespace handgraft::server
