#include "server/store/lazy_hand.h"

#include <chrono>
#include <utility>

#include "core/base/error.h"
#include "core/hand/skin_bending.h"
#include "core/hand/skin_cache.h"
#include "server/log/log.h"
#include "server/store/model_library.h"

namespace handgraft::server {

namespace {

constexpr std::chrono::milliseconds kGlance(100);  // for a wish to stop

LazyHand::Maker wrapping(std::shared_ptr<const hand::HandModel> model,
                         std::optional<std::vector<hand::ContactSite>> sites,
                         const hand::SkinOptions& options) {
  return [model = std::move(model), sites = std::move(sites), options](
             const Progress& progress, hand::SkinReport& report) {
    hand::Hand made;
    made.model = model;
    made.skin =
        std::make_shared<const hand::Skin>(hand::SkinCache::fromEnvironment(builtInSkins())
                                               .get(*model, options, progress, &report));
    made.sites = sites ? *sites : hand::findContactSites(*model, *made.skin);
    made.sites_are_found = !sites;
    return made;
  };
}

}  // namespace

LazyHand::LazyHand(const std::shared_ptr<const hand::HandModel>& model,
                   const std::optional<std::vector<hand::ContactSite>>& sites,
                   const hand::SkinOptions& options)
    : LazyHand(model, sites, wrapping(model, sites, options)) {}

LazyHand::LazyHand(std::shared_ptr<const hand::HandModel> model,
                   std::optional<std::vector<hand::ContactSite>> sites,
                   Maker maker)
    : model_(std::move(model)), own_sites_(std::move(sites)), maker_(std::move(maker)) {}

std::optional<hand::Hand> LazyHand::ready() const {
  const std::lock_guard lock(mutex_);
  return hand_;
}

std::vector<std::string> LazyHand::skinNotes() const {
  const std::lock_guard lock(mutex_);
  return report_.notes;
}

hand::SkinReport LazyHand::skinReport(const Progress& progress) {
  const hand::Hand made = get(progress);
  std::unique_lock lock(mutex_);
  while (being_measured_) {
    lock.unlock();
    progress.checkpoint();
    lock.lock();
    changed_.wait_for(lock, kGlance, [this] {
      return !being_measured_;
    });
  }
  if (is_measured_) return report_;
  being_measured_ = true;
  hand::SkinReport report = report_;
  lock.unlock();
  std::exception_ptr failure;
  try {
    hand::measure(*made.skin, report);
  } catch (...) {
    failure = std::current_exception();
  }
  lock.lock();
  being_measured_ = false;
  changed_.notify_all();
  if (failure) std::rethrow_exception(failure);
  report_ = report;
  is_measured_ = true;
  return report;
}

hand::Hand LazyHand::get(const Progress& progress) {
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
    std::optional<hand::Hand> made;
    hand::SkinReport report;
    std::exception_ptr failure;
    bool cancelled = false;
    try {
      const Progress shared(progress, [&](std::string_view stage, double fraction) {
        {
          const std::lock_guard told(mutex_);
          stage_ = stage;
          fraction_ = fraction;
        }
        progress.report(stage, fraction);
      });
      made = maker_(shared, report);
      for (const std::string& note : report.notes)
        log::warn("event=skin hand={} note={}", quoted(model_->name()), quoted(note));
    } catch (const Cancelled&) {
      cancelled = true;
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    being_made_ = false;
    stage_.clear();
    hand_ = std::move(made);
    report_ = std::move(report);
    failure_ = failure;
    changed_.notify_all();
    if (cancelled) throw Cancelled();
  }
  return *hand_;
}

std::shared_ptr<LazyHand> variantOf(std::shared_ptr<LazyHand> parent,
                                    std::shared_ptr<const hand::HandVariant> variant) {
  std::shared_ptr<const hand::HandModel> model(variant, &variant->model);
  std::optional<std::vector<hand::ContactSite>> sites = parent->ownSites();
  if (sites) sites = hand::sitesOfVariant(*variant, *sites);
  return std::make_shared<LazyHand>(
      model, sites,
      [parent = std::move(parent), variant = std::move(variant), model](
          const Progress& progress, hand::SkinReport& report) {
        const hand::Hand original = parent->get(progress);
        progress.report("bending the skin along", 0.9);
        const auto begin = std::chrono::steady_clock::now();
        hand::Hand made;
        made.model = model;
        made.skin = hand::SkinBending(original.model, original.skin).bent(*variant);
        made.sites = hand::sitesOfVariant(*variant, original.sites);
        made.sites_are_found = original.sites_are_found;
        const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
        report.time_s = spent.count();
        report.notes = parent->skinNotes();
        return made;
      });
}

}  // namespace handgraft::server
