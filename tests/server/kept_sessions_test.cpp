// Sessions that a store kept while their server was started anew.
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/admission/service.h"
#include "server/store/state_store.h"

#include "tests/server/recording_bus.h"
#include "tests/server/small_grasp.h"

namespace handgraft::server {
namespace {

class KeptSessions : public testing::Test {
 protected:
  KeptSessions() { begin(); }

  /// The server begins, or begins anew with what the store kept.
  void begin() {
    service.reset();
    models = std::make_unique<ModelStore>();
    ServiceOptions options;
    options.state = &state;
    service = std::make_unique<Service>(bus, *models, options);
    service->start();
  }

  v1::HandDescription describeHand(const std::string& name) {
    const v1::Reply reply = bus.ask(test::describeModel(v1::MODEL_HAND, name, false));
    EXPECT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
    return reply.error() == v1::ERROR_NONE ? reply.body().model().hand()
                                           : v1::HandDescription();
  }

  StateStore state{":memory:"};
  test::RecordingBus bus;
  std::unique_ptr<ModelStore> models;
  std::unique_ptr<Service> service;
};

TEST_F(KeptSessions, TellTheSitesThatWereFoundOnTheirHands) {
  for (const v1::RequestBody& body : test::smallGrasp())
    ASSERT_EQ(bus.ask(body).error(), v1::ERROR_NONE);
  ASSERT_EQ(bus.ask(test::putFile(9, "bare.urdf", test::clamp_urdf)).error(), v1::ERROR_NONE);
  ASSERT_EQ(bus.ask(test::loadModel(9, v1::MODEL_HAND, "bare", "bare.urdf")).error(),
            v1::ERROR_NONE);
  const v1::Reply opened = bus.ask(test::openSession("bare", "fruit", "marks"));
  ASSERT_EQ(opened.error(), v1::ERROR_NONE) << opened.message();
  const v1::HandDescription before = describeHand("bare");
  ASSERT_FALSE(before.sites().empty());

  begin();
  const v1::HandDescription after = describeHand("bare");
  EXPECT_EQ(after.sites(), before.sites());
  EXPECT_EQ(after.sites_file(), before.sites_file());
  EXPECT_EQ(after.digits(), before.digits());
  EXPECT_EQ(after.notes(), before.notes());
}

// Motors tell by the stamp what somebody wants now from what a store kept.
TEST_F(KeptSessions, StandAsOfThenUntilTheyAreAskedForAnew) {
  for (const v1::RequestBody& body : test::smallGrasp())
    ASSERT_EQ(bus.ask(body).error(), v1::ERROR_NONE);
  const std::uint64_t session =
      bus.ask(test::openSession("clamp", "fruit", "marks")).body().session().session_id();
  ASSERT_EQ(bus.ask(test::optimize(session, v1::SOLVER_LM, 4)).error(), v1::ERROR_NONE);
  const auto final_pose = [&](std::int64_t after_ns) {
    return bus.await<v1::PoseSolution>(bus.solutions, [&](const v1::PoseSolution& one) {
      return one.session_id() == session && one.is_final() && one.stamp_ns() > after_ns;
    });
  };
  ASSERT_TRUE(final_pose(0));

  const std::int64_t end = nowNs();
  service.reset();
  bus.solutions.clear();
  begin();
  const auto kept = final_pose(0);
  ASSERT_TRUE(kept);
  EXPECT_LE(kept->stamp_ns(), end);
  ASSERT_EQ(bus.ask(test::optimize(session, v1::SOLVER_LM, 4)).error(), v1::ERROR_NONE);
  EXPECT_TRUE(final_pose(end));
}

}  // namespace
}  // namespace handgraft::server
