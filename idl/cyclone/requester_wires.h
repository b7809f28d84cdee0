#pragma once

#include <functional>

#include "idl/cyclone/participant.h"
#include "idl/edits.h"
#include "idl/service.h"

namespace handgraft::idl::cyclone {

/// What a requester writes to and hears on: made when first needed, since in a secured domain
/// roles differ in what they may write and read.
class RequesterWires {
 public:
  /// `arrived` is called on DDS' thread when something is there to be taken.
  RequesterWires(const Participant& participant, const std::function<void()>& arrived);

  /// From now on answers are heard.
  void hearAnswers();

  /// Errors: Refused (ERROR_NOT_PERMITTED).
  Writer<v1::Request>& writerOf(v1::Operation operation);
  Writer<v1::Edit>& writerOfEdits();

  /// Null before `hearAnswers`.
  Reader<v1::Reply>* replies() { return replies_.made(); }

  Reader<v1::EditReply>* editReplies() { return edit_replies_.made(); }

  Reader<v1::Progress>* progresses() { return progresses_.made(); }

  Reader<v1::ServerStatus>& statuses() { return statuses_; }

 private:
  const bool is_secured_;
  Lazy<Writer<v1::Request>> requests_;
  Lazy<Writer<v1::Request>> looks_;
  Lazy<Writer<v1::Request>> operations_;
  Lazy<Writer<v1::Edit>> edits_;
  // Their listeners touch what they are given: made last, gone first.
  Lazy<Reader<v1::Reply>> replies_;
  Lazy<Reader<v1::EditReply>> edit_replies_;
  Lazy<Reader<v1::Progress>> progresses_;
  Reader<v1::ServerStatus> statuses_;
};

}  // namespace handgraft::idl::cyclone
