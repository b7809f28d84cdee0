#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/admission/service.h"

#include "tests/server/recording_bus.h"
#include "tests/server/small_grasp.h"

namespace handgraft::server {

/// A service on a small grasp, edits as a client sends them, and what comes of them.
class LiveEdits : public testing::Test {
 protected:
  static constexpr v1::ClientId kMe{1};
  static constexpr v1::ClientId kOther{2};

  explicit LiveEdits(const ServiceOptions& options = {}) : service(bus, models, options) {
    service.start();
    for (const v1::RequestBody& body : test::smallGrasp()) {
      const v1::Reply reply = bus.ask(body);
      EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    }
  }

  std::uint64_t open() {
    const v1::Reply reply = bus.ask(test::openSession("clamp", "fruit", "marks"));
    EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    return reply.error() == v1::ERROR_NONE ? reply.body().session().session_id() : 0;
  }

  /// Opened and solved.
  std::uint64_t openSolved() {
    const std::uint64_t session = open();
    EXPECT_EQ(bus.ask(test::optimize(session)).error(), v1::ERROR_NONE);
    return session;
  }

  v1::Edit editOf(std::uint64_t session, const v1::EditBody& body, v1::ClientId client = kMe) {
    v1::Edit edit;
    edit.client(client);
    edit.edit_id(++last_edit);
    edit.session_id(session);
    edit.body(body);
    return edit;
  }

  v1::EditReply replyTo(const v1::Edit& edit) {
    const auto reply =
        bus.await<v1::EditReply>(bus.edit_replies, [&](const v1::EditReply& one) {
          return one.edit_id() == edit.edit_id();
        });
    EXPECT_TRUE(reply.has_value()) << "no answer to edit " << edit.edit_id();
    return reply.value_or(v1::EditReply());
  }

  v1::EditReply apply(const v1::Edit& edit) {
    bus.send(edit);
    return replyTo(edit);
  }

  v1::EditReply apply(std::uint64_t session, const v1::EditBody& body) {
    return apply(editOf(session, body));
  }

  v1::PoseSolution finalOf(std::uint64_t session, std::uint64_t revision) {
    const auto solution =
        bus.await<v1::PoseSolution>(bus.solutions, [&](const v1::PoseSolution& one) {
          return one.session_id() == session && one.revision() == revision && one.is_final();
        });
    EXPECT_TRUE(solution.has_value()) << "no final solution of revision " << revision;
    return solution.value_or(v1::PoseSolution());
  }

  v1::SessionState stateAt(std::uint64_t session, std::uint64_t revision) {
    const auto state =
        bus.await<v1::SessionState>(bus.states, [&](const v1::SessionState& one) {
          return one.session_id() == session && one.revision() == revision;
        });
    EXPECT_TRUE(state.has_value()) << "no state of revision " << revision;
    return state.value_or(v1::SessionState());
  }

  void readyAt(std::uint64_t revision) {
    EXPECT_TRUE(bus.await<v1::SessionState>(bus.states,
                                            [&](const v1::SessionState& one) {
                                              return one.revision() == revision &&
                                                     one.phase() == v1::PHASE_READY;
                                            }))
        << "never ready at revision " << revision;
  }

  v1::SessionSettings settings(std::uint64_t session) {
    const v1::Reply reply = bus.ask(test::ofSession(v1::OP_SESSION_SETTINGS, session));
    EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    return reply.error() == v1::ERROR_NONE ? reply.body().settings() : v1::SessionSettings();
  }

  // === Edits, by their values
  static v1::EditBody weight(double value) {
    v1::PatchWeightEdit edit;
    edit.patch("palm");
    edit.weight(value);
    v1::EditBody body;
    body.patch_weight(edit);
    return body;
  }

  static v1::EditBody limit(double upper_rad) {
    v1::JointLimitEdit edit;
    edit.joint("hinge");
    edit.lower(-0.5);
    edit.upper(upper_rad);
    v1::EditBody body;
    body.joint_limit(edit);
    return body;
  }

  static v1::EditBody steps(v1::EditKind kind, unsigned count = 0) {
    v1::StepsEdit edit;
    edit.count(count);
    v1::EditBody body;
    body.steps(edit);
    body._d(kind);
    return body;
  }

  static v1::EditBody snapshot(v1::EditKind kind, const std::string& name) {
    v1::SnapshotEdit edit;
    edit.name(name);
    v1::EditBody body;
    body.snapshot(edit);
    body._d(kind);
    return body;
  }

  static v1::EditBody drag(const std::string& link, double x_m) {
    v1::DragEdit edit;
    edit.link(link);
    edit.target_W_m({x_m, 0.0, 0.0});
    v1::EditBody body;
    body.drag(edit);
    return body;
  }

  static v1::EditBody swap(v1::EditKind kind, const std::string& name) {
    v1::ModelEdit edit;
    edit.name(name);
    v1::EditBody body;
    body.swapped_model(edit);
    body._d(kind);
    return body;
  }

  /// The finals of a revision so far, in order.
  static std::vector<v1::PoseSolution> finalsOf(test::RecordingBus& bus,
                                                std::uint64_t revision) {
    std::vector<v1::PoseSolution> finals;
    for (const v1::PoseSolution& one : bus.copyOf(bus.solutions)) {
      if (one.is_final() && one.revision() == revision) finals.push_back(one);
    }
    return finals;
  }

  std::uint64_t last_edit = 0;
  test::RecordingBus bus;
  ModelStore models;
  Service service;
};

}  // namespace handgraft::server
