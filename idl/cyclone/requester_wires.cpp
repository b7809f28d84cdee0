#include "idl/cyclone/requester_wires.h"

#include "idl/cyclone/requester.h"
#include "idl/fields.h"
#include "idl/operations.h"
#include "idl/security/rights.h"

namespace handgraft::idl::cyclone {

RequesterWires::RequesterWires(const Participant& participant,
                               const std::function<void()>& arrived)
    : is_secured_(participant.identity().has_value()),
      requests_(participant, kRequestTopic),
      looks_(participant, kLookTopic),
      operations_(participant, kOperateTopic),
      edits_(participant, kEditTopic),
      replies_(participant, kReplyTopic, arrived),
      edit_replies_(participant, kEditReplyTopic, arrived),
      progresses_(participant, kProgressTopic, arrived),
      statuses_(participant, kStatusTopic, arrived) {
  // Soon in an open domain, so that the first request finds all matched; in a secured one once
  // it is known what is asked for.
  if (is_secured_) return;
  requests_.get();
  edits_.get();
  hearAnswers();
}

void RequesterWires::hearAnswers() {
  replies_.get();
  edit_replies_.get();
  progresses_.get();
}

Writer<v1::Request>& RequesterWires::writerOf(v1::Operation operation) {
  if (!is_secured_) return requests_.get();
  const Privilege privilege = traitsOf(operation).privilege;
  try {
    switch (privilege) {
      case Privilege::kLook:
        return looks_.get();
      case Privilege::kEdit:
        return requests_.get();
      case Privilege::kOperate:
        break;
    }
    return operations_.get();
  } catch (const NotPermitted& error) {
    throw Refused(v1::ERROR_NOT_PERMITTED,
                  fmt::format("{}: request '{}' is for {}", error.what(), nameOf(operation),
                              security::holdersOf(privilege)));
  }
}

Writer<v1::Edit>& RequesterWires::writerOfEdits() {
  try {
    return edits_.get();
  } catch (const NotPermitted& error) {
    throw Refused(v1::ERROR_NOT_PERMITTED, fmt::format("{}: edits are for {}", error.what(),
                                                       security::holdersOf(Privilege::kEdit)));
  }
}

}  // namespace handgraft::idl::cyclone
