#pragma once

#include <algorithm>
#include <atomic>
#include <thread>

#include "server/base/strand_pool.h"
#include "server/sessions/session_store.h"
#include "server/store/model_store.h"
#include "server/store/upload_reader.h"
#include "server/store/upload_store.h"

namespace handgraft::server {

class Bus;              // transport/bus.h
class PersistedModels;  // handlers/persisted_models.h
class StateStore;       // store/state_store.h
struct RequestKey;

/// What handlers work with. Outlives every request.
struct HandlerContext {
  ModelStore& models;
  UploadStore& uploads;
  const UploadReader& reader;
  SessionStore& sessions;
  SessionAudience& audience;
  StrandPool& pool;  ///< where sessions' strands run
  /// What outlives the server; both null: nothing does.
  StateStore* state = nullptr;
  PersistedModels* persisted_models = nullptr;
  const Bus* bus = nullptr;  ///< that knows who asks; null: nobody does

  /// Solves going on: they share the processors.
  std::atomic<int> solving{0};

  /// Counts one solve for as long as it lives.
  class Share {
   public:
    explicit Share(HandlerContext& context) : context_(context), others_(context.solving++) {}

    ~Share() { --context_.solving; }

    Share(const Share&) = delete;
    Share& operator=(const Share&) = delete;

    /// Threads that this solve may use; the answer does not depend on it.
    [[nodiscard]] int threads() const {
      const auto processors = static_cast<int>(std::thread::hardware_concurrency());
      return std::max(1, processors / (1 + others_));
    }

   private:
    HandlerContext& context_;
    int others_;
  };
};

}  // namespace handgraft::server
