#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/hand/skin_report.h"
#include "core/hand/variant.h"
#include "core/session/session.h"

namespace handgraft::server {

/// A hand whose skin, and sites if it brings none, are made when first asked for, once.
///
/// Threads: all methods from any thread.
class LazyHand {
 public:
  /// Makes the hand, and says how its skin was made.
  using Maker = std::function<hand::Hand(const Progress&, hand::SkinReport&)>;

  /// `sites` missing: found on the skin.
  LazyHand(const std::shared_ptr<const hand::HandModel>& model,
           const std::optional<std::vector<hand::ContactSite>>& sites,
           const hand::SkinOptions& options = {});
  /// `sites` are what is known of them before the hand is made, if anything is.
  LazyHand(std::shared_ptr<const hand::HandModel> model,
           std::optional<std::vector<hand::ContactSite>> sites,
           Maker maker);

  /// The hand, made by the first caller while the others wait and see its progress. Whoever
  /// made it and is cancelled leaves the work to the next. Errors: InvalidInput if no skin can
  /// be made (remembered); Cancelled for this caller alone.
  hand::Hand get(const Progress& progress);

  /// The hand if it is made already; its sites are known before that if the model brings them.
  [[nodiscard]] std::optional<hand::Hand> ready() const;

  /// What there is to say of the skin once it is made: its maker's notes, also where it came
  /// from a cache. Empty before.
  [[nodiscard]] std::vector<std::string> skinNotes() const;

  /// How the skin was made and how good it is; made first if need be, measured once. Errors: as
  /// `get`. Cost: some 0.3 s the first time.
  hand::SkinReport skinReport(const Progress& progress);

  [[nodiscard]] const hand::HandModel& model() const { return *model_; }

  [[nodiscard]] const std::optional<std::vector<hand::ContactSite>>& ownSites() const {
    return own_sites_;
  }

 private:
  std::shared_ptr<const hand::HandModel> model_;
  std::optional<std::vector<hand::ContactSite>> own_sites_;
  Maker maker_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<hand::Hand> hand_;
  hand::SkinReport report_;  ///< of `hand_`
  bool is_measured_ = false;
  bool being_measured_ = false;
  std::exception_ptr failure_;
  bool being_made_ = false;
  std::string stage_;
  double fraction_ = 0.0;
};

/// A variant of `parent`'s hand: its skin is the parent's, which is made first if need be, bent
/// along; its sites are the parent's, moved along.
std::shared_ptr<LazyHand> variantOf(std::shared_ptr<LazyHand> parent,
                                    std::shared_ptr<const hand::HandVariant> variant);

}  // namespace handgraft::server
