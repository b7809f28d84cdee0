// Requests to load models, through the service: options, units, and readers that fail.

#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/admission/service.h"
#include "server/messages/load_messages.h"

#include "tests/server/recording_bus.h"
#include "tests/server/small_grasp.h"

namespace handgraft::server {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kLargeTriangle = "v 0 0 0\nv 100 0 0\nv 0 100 0\nf 1 2 3\n";

class LoadingTest : public testing::Test {
 protected:
  LoadingTest() { service.start(); }

  v1::Reply load(v1::RequestBody body, const std::string& uri, const std::string& bytes) {
    bus.ask(test::putFile(1, uri, bytes));
    return bus.ask(body);
  }

  static v1::RequestBody objectIn(const std::string& units) {
    v1::RequestBody body = test::loadModel(1, v1::MODEL_OBJECT, "sheet", "sheet.obj");
    body.load_model().units(units);
    return body;
  }

  test::RecordingBus bus;
  ModelStore models;
  Service service{bus, models, ServiceOptions()};
};

TEST_F(LoadingTest, AsksForUnitsAndTakesThem) {
  const v1::Reply asked = load(objectIn(""), "sheet.obj", kLargeTriangle);
  EXPECT_EQ(asked.error(), v1::ERROR_UNITS);
  EXPECT_THAT(asked.message(), AllOf(HasSubstr("'sheet'"), HasSubstr("--units mm")));
  const v1::Reply taken = load(objectIn("mm"), "sheet.obj", kLargeTriangle);
  ASSERT_EQ(taken.error(), v1::ERROR_NONE) << taken.message();
  EXPECT_NEAR(models.object("sheet")->file->mesh.diagonal(), 0.1414, 1e-4);
  EXPECT_EQ(models.object("sheet")->units, "mm");
  const v1::Reply unknown = load(objectIn("ft"), "sheet.obj", kLargeTriangle);
  EXPECT_EQ(unknown.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(unknown.message(), HasSubstr("'ft'"));
}

TEST_F(LoadingTest, TellsTheSameFilesReadInOtherWaysApart) {
  ASSERT_EQ(load(objectIn("mm"), "sheet.obj", kLargeTriangle).error(), v1::ERROR_NONE);
  EXPECT_EQ(load(objectIn("mm"), "sheet.obj", kLargeTriangle).error(), v1::ERROR_NONE);
  EXPECT_EQ(load(objectIn("cm"), "sheet.obj", kLargeTriangle).error(), v1::ERROR_CONFLICT);
}

TEST_F(LoadingTest, RefusesOptionsOfAnotherKindOrOutOfRange) {
  v1::RequestBody object = objectIn("mm");
  object.load_model().hand().emplace_back();
  EXPECT_THAT(load(object, "sheet.obj", kLargeTriangle).message(), HasSubstr("hand options"));

  v1::RequestBody hand = test::loadModel(1, v1::MODEL_HAND, "clamp", "clamp.urdf");
  hand.load_model().hand().emplace_back();
  hand.load_model().hand()[0].skin().edge_m(1.0);
  const v1::Reply edge = load(hand, "clamp.urdf", test::clamp_urdf);
  EXPECT_EQ(edge.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(edge.message(), AllOf(HasSubstr("edge"), HasSubstr("0.0005 to 0.05")));
  hand.load_model().hand()[0].skin(v1::SkinRecipe());
  hand.load_model().hand()[0].rest_pose("shut");
  EXPECT_THAT(load(hand, "clamp.urdf", test::clamp_urdf).message(), HasSubstr("'shut'"));
}

TEST_F(LoadingTest, TellsASetThatSaysItLiesOnAnotherObject) {
  for (const v1::RequestBody& body : test::smallGrasp())
    ASSERT_EQ(bus.ask(body).error(), v1::ERROR_NONE);
  const auto notes_of = [&](const std::string& set) {
    const v1::Reply told = bus.ask(test::describeModel(v1::MODEL_CONTACTS, set, false));
    EXPECT_EQ(told.error(), v1::ERROR_NONE) << told.message();
    return told.body().model().contacts().notes();
  };
  const auto tells = testing::Contains(AllOf(HasSubstr("'lemon'"), HasSubstr("'fruit'")));
  EXPECT_THAT(notes_of("marks"), tells);

  // A lemon by a longer name is one.
  bus.ask(test::putFile(8, "lemon.obj", test::builtIn("objects/lemon.obj")));
  ASSERT_EQ(bus.ask(test::loadModel(8, v1::MODEL_OBJECT, "lemon-2", "lemon.obj")).error(),
            v1::ERROR_NONE);
  bus.ask(test::putFile(9, "lemon_6.json", test::builtIn("contacts/lemon_6.json")));
  ASSERT_EQ(
      bus.ask(test::loadModel(9, v1::MODEL_CONTACTS, "own", "lemon_6.json", "lemon-2")).error(),
      v1::ERROR_NONE);
  EXPECT_THAT(notes_of("own"), testing::Each(testing::Not(HasSubstr("lies on object"))));
}

TEST_F(LoadingTest, LoadsAMirroredHandThatRestsInANamedPose) {
  v1::RequestBody hand = test::loadModel(1, v1::MODEL_HAND, "clamp", "clamp.urdf");
  hand.load_model().hand().emplace_back();
  hand.load_model().hand()[0].mirrored(true);
  hand.load_model().hand()[0].srdf_uri("clamp.srdf");
  hand.load_model().hand()[0].rest_pose("shut");
  bus.ask(test::putFile(1, "clamp.srdf",
                        "<robot name='clamp'><group_state name='shut' group='g'>"
                        "<joint name='hinge' value='1.1'/></group_state></robot>"));
  const v1::Reply reply = load(hand, "clamp.urdf", test::clamp_urdf);
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  const auto stored = models.hand("clamp");
  EXPECT_TRUE(stored->mirrored);
  EXPECT_EQ(stored->poses.size(), 1u);
  EXPECT_EQ(stored->hand->model().restPose()[0], 1.1);
}

TEST(Segmentation, IsCheckedAsItComes) {
  v1::ContactOptions options;
  EXPECT_EQ(segmentationFrom(options).threshold, contact::SegmentationOptions().threshold);
  options.threshold({0.7});
  options.low_share({0.5});
  options.outline_share({0.0});
  options.minimum_area_m2({1e-5});
  options.interpolation_count(40);
  options.smoothing_steps(3);
  const contact::SegmentationOptions taken = segmentationFrom(options);
  EXPECT_EQ(taken.threshold, 0.7);
  EXPECT_EQ(taken.low_share, 0.5);
  EXPECT_EQ(taken.outline_share, 0.0);
  EXPECT_EQ(taken.minimum_area_m2, 1e-5);
  EXPECT_EQ(taken.interpolation_count, 40);
  EXPECT_EQ(taken.smoothing_steps, 3);
  const auto refused = [](const std::function<void(v1::ContactOptions&)>& spoil) {
    v1::ContactOptions bad;
    spoil(bad);
    EXPECT_THROW((void)segmentationFrom(bad), InvalidInput);
  };
  refused([](auto& bad) {
    bad.threshold({0.3});
    bad.otsu(true);
  });
  refused([](auto& bad) {
    bad.low_share({0.0});
  });
  refused([](auto& bad) {
    bad.outline_share({1.0});
  });
  refused([](auto& bad) {
    bad.threshold({std::nan("")});
  });
  refused([](auto& bad) {
    bad.interpolation_count(2);
  });
  refused([](auto& bad) {
    bad.smoothing_steps(1001);
  });
  refused([](auto& bad) {
    bad.minimum_area_m2({-1.0});
  });
}

ServiceOptions withFakeReader() {
  ServiceOptions options;
  options.reader = HANDGRAFT_FAKE_READER;
  return options;
}

TEST(Loading, AReaderThatFailsCostsItsRequestAlone) {
  test::RecordingBus bus;
  ModelStore models;
  Service service(bus, models, withFakeReader());
  service.start();
  for (const char* name : {"crashes", "lies", "babbles", "quits"}) {
    bus.ask(test::putFile(1, "x.obj", kLargeTriangle));
    const v1::Reply reply = bus.ask(test::loadModel(1, v1::MODEL_OBJECT, name, "x.obj"));
    EXPECT_EQ(reply.error(), v1::ERROR_INVALID_INPUT) << name << reply.message();
    EXPECT_THAT(reply.message(), AllOf(HasSubstr("'x.obj'"), Not(HasSubstr("\n"))));
  }
  bus.ask(test::putFile(1, "x.obj", kLargeTriangle));
  const v1::Reply mistake = bus.ask(test::loadModel(1, v1::MODEL_OBJECT, "errs", "x.obj"));
  EXPECT_EQ(mistake.error(), v1::ERROR_INTERNAL);
  EXPECT_EQ(bus.ask(test::plain(v1::OP_LIST_MODELS)).error(), v1::ERROR_NONE);
  EXPECT_EQ(models.size(), 0u);
}

TEST(Loading, IsCancelledWhileItsReaderWorks) {
  test::RecordingBus bus;
  ModelStore models;
  Service service(bus, models, withFakeReader());
  service.start();
  bus.ask(test::putFile(1, "x.obj", kLargeTriangle));
  bus.send(50, test::loadModel(1, v1::MODEL_OBJECT, "sleeps", "x.obj"));
  const auto told = bus.await<v1::Progress>(bus.progress, [](const v1::Progress& one) {
    return one.stage() == "sleeping";
  });
  ASSERT_TRUE(told.has_value());
  bus.ask(test::cancel(50));
  const auto reply = bus.await<v1::Reply>(bus.replies, [](const v1::Reply& one) {
    return one.request_id() == 50;
  });
  ASSERT_TRUE(reply.has_value());
  EXPECT_EQ(reply->error(), v1::ERROR_CANCELLED);
}

TEST(Loading, NeedsAReaderFromTheStart) {
  test::RecordingBus bus;
  ModelStore models;
  ServiceOptions options;
  options.reader = "/nowhere/handgraft-reader";
  EXPECT_THROW(Service(bus, models, options), InvalidInput);
}

}  // namespace
}  // namespace handgraft::server
