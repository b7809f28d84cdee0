#pragma once

#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/session/session.h"

namespace handgraft::server {

/// A hand whose skin, and sites if it brings none, are made when first asked for, once.
///
/// Threads: all methods from any thread.
class LazyHand {
 public:
  /// `sites` missing: found on the skin.
  LazyHand(std::shared_ptr<const hand::HandModel> model,
           std::optional<std::vector<hand::ContactSite>> sites);

  /// The hand, made by the first caller while the others wait and see its progress. Whoever
  /// made it and is cancelled leaves the work to the next. Errors: InvalidInput if no skin can
  /// be made (remembered); Cancelled for this caller alone.
  session::Hand get(const Progress& progress);

  /// The hand if it is made already; its sites are known before that if the model brings them.
  [[nodiscard]] std::optional<session::Hand> ready() const;

  [[nodiscard]] const hand::HandModel& model() const { return *model_; }

  [[nodiscard]] const std::optional<std::vector<hand::ContactSite>>& ownSites() const {
    return own_sites_;
  }

 private:
  session::Hand make(const Progress& progress);

  std::shared_ptr<const hand::HandModel> model_;
  std::optional<std::vector<hand::ContactSite>> own_sites_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<session::Hand> hand_;
  std::exception_ptr failure_;
  bool being_made_ = false;
  std::string stage_;
  double fraction_ = 0.0;
};

}  // namespace handgraft::server
