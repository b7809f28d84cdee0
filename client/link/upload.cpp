#include "client/link/upload.h"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <utility>

#include "client/link/cancellation.h"
#include "core/base/error.h"
#include "core/base/random_id.h"

namespace handgraft::client {

namespace {

constexpr std::uintmax_t kChunk = 524288;  // PutFileRequest.bytes

}  // namespace

Upload::Upload(idl::cyclone::Requester& requester,
               ModelFiles model,
               std::shared_ptr<State> state)
    : requester_(requester),
      model_(std::move(model)),
      state_(std::move(state)),
      upload_id_(randomId()) {}

void Upload::cancel() {
  idl::cyclone::Requester::CallId call = 0;
  {
    const std::lock_guard lock(mutex_);
    cancelled_ = true;
    call = call_;
  }
  requester_.cancel(call);
}

void Upload::next() {
  try {
    v1::RequestBody body;
    const bool is_last = !nextChunk(body) && !nextCheck(body);
    send(is_last ? loadRequest() : body, is_last);
  } catch (...) {
    state_->settle(std::current_exception());
  }
}

void Upload::open(const UploadFile& file) {
  offset_ = 0;
  if (file.text) {
    total_ = file.text->size();
    in_ = std::make_unique<std::istringstream>(*file.text);
    return;
  }
  std::error_code error;
  total_ = std::filesystem::file_size(file.path, error);
  in_ = std::make_unique<std::ifstream>(file.path, std::ios::binary);
  if (error || !*in_) rejectInput("{}: cannot be read", quoted(file.path.string()));
}

bool Upload::nextChunk(v1::RequestBody& body) {
  while (!in_ || offset_ == total_) {
    if (in_) {
      in_.reset();
      ++file_;
    }
    if (file_ == model_.files.size()) return false;
    open(model_.files[file_]);
  }
  const UploadFile& file = model_.files[file_];
  const std::string name = file.text ? file.uri : file.path.filename().string();
  v1::PutFileRequest request;
  request.upload_id(upload_id_);
  request.uri(file.uri);
  request.total_bytes(total_);
  request.offset(offset_);
  request.bytes().resize(static_cast<std::size_t>(std::min(kChunk, total_ - offset_)));
  in_->read(reinterpret_cast<char*>(request.bytes().data()),
            static_cast<std::streamsize>(request.bytes().size()));
  if (!*in_) rejectInput("{}: changed while it was read", quoted(file.path.string()));
  offset_ += request.bytes().size();
  if (first_bytes_ == 0) {
    first_bytes_ = total_;
    first_file_ = file_;
  }
  state_->report("sending " + name, static_cast<double>(offset_) / static_cast<double>(total_));
  body.put_file(std::move(request));
  return true;
}

bool Upload::nextCheck(v1::RequestBody& body) {
  if (std::exchange(is_checked_, true) || first_bytes_ == 0 || model_.files.size() < 2)
    return false;
  v1::PutFileRequest nothing;
  nothing.upload_id(upload_id_);
  nothing.uri(model_.files[first_file_].uri);
  nothing.total_bytes(first_bytes_);
  nothing.offset(first_bytes_);
  body.put_file(std::move(nothing));
  return true;
}

bool Upload::beginAnew(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const idl::cyclone::Refused& refused) {
    const bool is_gone =
        refused.code() == v1::ERROR_UPLOAD_GONE || refused.code() == v1::ERROR_OTHER_SERVER;
    if (!is_gone || times_ == kMostTimes) return false;
  } catch (...) {
    return false;
  }
  ++times_;
  upload_id_ = randomId();
  file_ = 0;
  in_.reset();
  first_bytes_ = 0;
  is_checked_ = false;
  next();
  return true;
}

v1::RequestBody Upload::loadRequest() const {
  v1::LoadModelRequest request;
  request.kind(model_.kind);
  request.name(model_.name);
  request.upload_id(upload_id_);
  request.main_uri(model_.main_uri);
  request.object(model_.object);
  request.units(model_.units);
  if (model_.hand_options) request.hand().push_back(*model_.hand_options);
  if (model_.contact_options) request.contacts().push_back(*model_.contact_options);
  v1::RequestBody body;
  body.load_model(request);
  return body;
}

void Upload::send(const v1::RequestBody& body, bool is_last) {
  const std::lock_guard lock(mutex_);
  if (cancelled_) throw Cancelled();
  call_ = requester_.begin(
      body,
      [self = shared_from_this(),
       is_last](idl::cyclone::Requester::Outcome<v1::ReplyBody> outcome) {
        if (const auto* error = std::get_if<std::exception_ptr>(&outcome)) {
          if (!self->beginAnew(*error)) self->state_->settle(asTold(*error));
        } else if (is_last) {
          self->finish(std::get<v1::ReplyBody>(outcome));
        } else {
          self->next();
        }
      },
      [state = state_](const std::string& stage, double fraction) {
        state->report(stage, fraction);
      });
}

void Upload::finish(const v1::ReplyBody& reply) {
  if (reply._d() == v1::OP_LOAD_MODEL) {
    for (const v1::ModelSummary& summary : reply.models().models()) {
      if (summary.kind() == model_.kind && summary.name() == model_.name) {
        return state_->settle(summary);
      }
    }
  }
  state_->settle(std::make_exception_ptr(
      TransportError(fmt::format("the server loaded '{}' and did not list it", model_.name))));
}

}  // namespace handgraft::client
