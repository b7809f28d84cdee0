#include "server/lazy_hand.h"

#include <chrono>
#include <utility>

#include <spdlog/spdlog.h>

#include "core/base/error.h"
#include "core/hand/skin_cache.h"

namespace handgraft::server {

LazyHand::LazyHand(std::shared_ptr<const hand::HandModel> model,
                   std::optional<std::vector<hand::ContactSite>> sites)
    : model_(std::move(model)), own_sites_(std::move(sites)) {}

std::optional<session::Hand> LazyHand::ready() const {
  const std::lock_guard lock(mutex_);
  return hand_;
}

session::Hand LazyHand::get(const Progress& progress) {
  constexpr std::chrono::milliseconds kGlance(100);
  std::unique_lock lock(mutex_);
  while (!hand_) {
    if (failure_) std::rethrow_exception(failure_);
    if (being_made_) {
      const std::string stage = stage_;
      const double fraction = fraction_;
      lock.unlock();
      progress.checkpoint();
      if (!stage.empty()) progress.report(stage, fraction);
      lock.lock();
      changed_.wait_for(lock, kGlance, [this] {
        return !being_made_;
      });
      continue;
    }
    being_made_ = true;
    lock.unlock();
    std::optional<session::Hand> made;
    std::exception_ptr failure;
    bool cancelled = false;
    try {
      made = make(progress);
    } catch (const Cancelled&) {
      cancelled = true;
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    being_made_ = false;
    stage_.clear();
    hand_ = std::move(made);
    failure_ = failure;
    changed_.notify_all();
    if (cancelled) throw Cancelled();
  }
  return *hand_;
}

session::Hand LazyHand::make(const Progress& progress) {
  const Progress shared(progress, [&](std::string_view stage, double fraction) {
    {
      const std::lock_guard lock(mutex_);
      stage_ = stage;
      fraction_ = fraction;
    }
    progress.report(stage, fraction);
  });
  session::Hand made;
  made.model = model_;
  hand::SkinReport report;
  made.skin = std::make_shared<const hand::Skin>(
      hand::SkinCache::fromEnvironment().get(*model_, hand::SkinOptions(), shared, &report));
  for (const std::string& note : report.notes)
    spdlog::warn("event=skin hand={} note={}", quoted(model_->name()), quoted(note));
  made.sites = own_sites_ ? *own_sites_ : hand::findContactSites(*model_, *made.skin);
  return made;
}

}  // namespace handgraft::server
