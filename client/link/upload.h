#pragma once

#include <cstdint>
#include <istream>
#include <memory>
#include <mutex>

#include "client/link/model_files.h"
#include "client/link/pending.h"
#include "idl/cyclone/requester.h"
#include "idl/models.h"

namespace handgraft::client {

/// Sends a model: chunk after chunk of its files, then the request to read them. Each step is
/// begun by the reply to the one before, on the requester's thread, and keeps this alive.
class Upload : public std::enable_shared_from_this<Upload> {
 public:
  using State = Pending<v1::ModelSummary>::State;

  /// The requester outlives its callbacks.
  Upload(idl::cyclone::Requester& requester, ModelFiles model, std::shared_ptr<State> state);

  void start() { next(); }

  /// No further step is begun, and the one under way is cancelled. From any thread, while the
  /// requester lives.
  void cancel();

 private:
  void next();
  /// Errors: InvalidInput.
  void open(const UploadFile& file);
  /// The next chunk; false when all were sent. Errors: InvalidInput.
  bool nextChunk(v1::RequestBody& body);
  v1::RequestBody loadRequest() const;
  void send(const v1::RequestBody& body, bool is_last);
  void finish(const v1::ReplyBody& reply);

  idl::cyclone::Requester& requester_;
  const ModelFiles model_;
  const std::shared_ptr<State> state_;
  const std::uint64_t upload_id_;
  std::size_t file_ = 0;              ///< that is being sent
  std::unique_ptr<std::istream> in_;  ///< null before the first file
  std::uintmax_t total_ = 0;          ///< bytes of it
  std::uintmax_t offset_ = 0;
  std::mutex mutex_;  ///< guards the rest
  bool cancelled_ = false;
  idl::cyclone::Requester::CallId call_ = 0;
};

}  // namespace handgraft::client
