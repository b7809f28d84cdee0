#pragma once

#include <chrono>
#include <cstdint>
#include <thread>

#include "core/base/network.h"
#include "idl/cyclone/participant.h"
#include "idl/edits.h"
#include "idl/service.h"

namespace handgraft::test {

/// Asks, and counts all answers that come to its participant.
struct HearingClient {
  explicit HearingClient(const Network& network) : participant(network) {}

  /// Says it again until it is answered; false if it never is.
  bool ask(std::uint64_t id) {
    v1::Request request;
    request.client({9});
    request.request_id(id);
    request.body().nothing(v1::Nothing());
    v1::Edit edit;
    edit.client({9});
    edit.edit_id(id);
    bool is_replied = false;
    bool is_edited = false;
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!is_replied || !is_edited) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      if (!is_replied) requests.write(request);
      if (!is_edited) edits.write(edit);
      if (!is_replied) replies.wait(std::chrono::milliseconds(50));
      replies.take([&](const v1::Reply& one) {
        is_replied = is_replied || one.request_id() == id;
      });
      if (!is_edited) edit_replies.wait(std::chrono::milliseconds(50));
      edit_replies.take([&](const v1::EditReply& one) {
        is_edited = is_edited || one.edit_id() == id;
      });
    }
    return true;
  }

  /// Answers of all kinds that came since, until none did for a while.
  int heard() {
    int all = 0;
    for (int last = -1; last != all;) {
      last = all;
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
      all += replies.take([](const v1::Reply&) {});
      all += edit_replies.take([](const v1::EditReply&) {});
      all += progresses.take([](const v1::Progress&) {});
    }
    return all;
  }

  idl::cyclone::Participant participant;
  idl::cyclone::Writer<v1::Request> requests{participant, idl::kRequestTopic};
  idl::cyclone::Writer<v1::Edit> edits{participant, idl::kEditTopic};
  idl::cyclone::Reader<v1::Reply> replies{participant, idl::kReplyTopic};
  idl::cyclone::Reader<v1::EditReply> edit_replies{participant, idl::kEditReplyTopic};
  idl::cyclone::Reader<v1::Progress> progresses{participant, idl::kProgressTopic};
};

}  // namespace handgraft::test
