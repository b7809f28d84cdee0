#pragma once

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/admission/service.h"

#include "tests/server/motion_messages.h"
#include "tests/server/recording_bus.h"
#include "tests/server/small_grasp.h"

/// A service that has a small grasp's models, and is given motions.
namespace handgraft::server {

using test::kPath;
using test::kPlan;
using test::openMotion;
using test::solveMotion;

inline v1::RequestBody framesFrom(std::uint64_t session,
                                  std::uint32_t first,
                                  std::uint32_t count = 0,
                                  std::uint32_t every = 0,
                                  bool with_shapes = false) {
  v1::MotionFramesRequest request;
  request.session_id(session);
  request.first(first);
  request.count(count);
  request.every(every);
  request.with_shapes(with_shapes);
  v1::RequestBody body;
  body.motion_frames(request);
  return body;
}

inline v1::RequestBody exportAs(std::uint64_t session, v1::ExportFormat format) {
  v1::ExportRequest request;
  request.session_id(session);
  request.format(format);
  v1::RequestBody body;
  body.export_file(request);
  return body;
}

class MotionTest : public testing::Test {
 protected:
  MotionTest() {
    service.start();
    for (const v1::RequestBody& body : test::smallGrasp())
      EXPECT_EQ(bus.ask(body).error(), v1::ERROR_NONE);
  }

  v1::Reply load(const std::string& name,
                 const std::string& plan = kPlan,
                 const std::string& path = kPath) {
    const std::uint64_t upload = ++uploads_;
    bus.ask(test::putFile(upload, "plan.json", plan));
    bus.ask(test::putFile(upload, "first.json", test::builtIn("contacts/lemon_6.json")));
    bus.ask(test::putFile(upload, "path.csv", path));
    return bus.ask(test::loadModel(upload, v1::MODEL_MOTION, name, "plan.json", "fruit"));
  }

  std::uint64_t open() {
    EXPECT_EQ(load("pull").error(), v1::ERROR_NONE);
    const v1::Reply opened = bus.ask(openMotion("clamp", "fruit", "pull"));
    EXPECT_EQ(opened.error(), v1::ERROR_NONE) << opened.message();
    EXPECT_EQ(opened.body().session().motion(), "pull");
    EXPECT_EQ(opened.body().session().contacts(), "");
    return opened.body().session().session_id();
  }

  test::RecordingBus bus;
  ModelStore models;
  Service service{bus, models, ServiceOptions()};

 private:
  std::uint64_t uploads_ = 10;
};

}  // namespace handgraft::server
