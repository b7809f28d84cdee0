#pragma once

#include <gtest/gtest.h>

#include "server/admission/service.h"

#include "tests/server/recording_bus.h"
#include "tests/server/small_grasp.h"

namespace handgraft::server {

/// A service without wires.
class ServiceTest : public testing::Test {
 protected:
  ServiceTest() { service.start(); }

  void loadSmallGrasp() {
    for (const v1::RequestBody& body : test::smallGrasp()) {
      const v1::Reply reply = bus.ask(body);
      ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    }
  }

  std::uint64_t openSmallSession() {
    loadSmallGrasp();
    const v1::Reply reply = bus.ask(test::openSession("clamp", "fruit", "marks"));
    EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    return reply.error() == v1::ERROR_NONE ? reply.body().session().session_id() : 0;
  }

  v1::EditReply edit(v1::Edit message) {
    message.client({1});
    bus.send(message);
    const auto reply =
        bus.await<v1::EditReply>(bus.edit_replies, [&](const v1::EditReply& one) {
          return one.edit_id() == message.edit_id();
        });
    return reply.value_or(v1::EditReply());
  }

  test::RecordingBus bus;
  ModelStore models;
  Service service{bus, models, ServiceOptions()};
};

}  // namespace handgraft::server
