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
/// begun by the reply to the one before, on the requester's thread, and keeps this alive. What
/// was sent does not outlive its server: where that was started anew it begins from the front,
/// so often and no more.
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
  static constexpr int kMostTimes = 10;

  void next();
  /// True where the server has lost what was sent: then it is on its way again.
  bool beginAnew(const std::exception_ptr& error);
  /// Asks whether what was sent first is there: of several files the first may have gone to the
  /// server before.
  bool nextCheck(v1::RequestBody& body);
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
  std::uint64_t upload_id_;
  int times_ = 1;                     ///< that it was begun
  bool is_checked_ = false;           ///< all is sent, to one server
  std::size_t file_ = 0;              ///< that is being sent
  std::unique_ptr<std::istream> in_;  ///< null before the first file
  std::uintmax_t total_ = 0;          ///< bytes of it
  std::uintmax_t offset_ = 0;
  std::size_t first_file_ = 0;      ///< that has bytes
  std::uintmax_t first_bytes_ = 0;  ///< of it
  std::mutex mutex_;                ///< guards the rest
  bool cancelled_ = false;
  idl::cyclone::Requester::CallId call_ = 0;
};

}  // namespace handgraft::client
