// Variants and sweeps, through the service.
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/hand/kinematics.h"
#include "core/io/urdf_file.h"
#include "server/admission/service.h"

#include "tests/server/recording_bus.h"
#include "tests/server/small_grasp.h"

namespace handgraft::server {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;

v1::HandChange change(v1::HandProperty property, const std::string& target, double value) {
  v1::HandChange one;
  one.property(property);
  one.target(target);
  one.value(value);
  return one;
}

v1::RequestBody variant(const std::string& hand,
                        const std::string& name,
                        const std::vector<v1::HandChange>& changes) {
  v1::VariantRequest request;
  request.hand(hand);
  request.name(name);
  request.changes(changes);
  v1::RequestBody body;
  body.variant(request);
  body._d(v1::OP_MAKE_VARIANT);
  return body;
}

v1::RequestBody sweep(const std::vector<double>& uppers,
                      const std::string& contacts = "marks") {
  v1::SweepRequest request;
  request.hand("clamp");
  v1::SweepGrasp grasp;
  grasp.object("fruit");
  grasp.contacts(contacts);
  request.grasps({grasp});
  v1::SweepAxis axis;
  axis.property(v1::PROPERTY_UPPER);
  axis.target("hinge");
  axis.values(uppers);
  request.axes({axis});
  v1::RequestBody body;
  body.sweep(request);
  body._d(v1::OP_SWEEP);
  return body;
}

class StudyTest : public testing::Test {
 protected:
  StudyTest() {
    service.start();
    for (const v1::RequestBody& body : test::smallGrasp())
      EXPECT_EQ(bus.ask(body).error(), v1::ERROR_NONE);
  }

  test::RecordingBus bus;
  ModelStore models;
  Service service{bus, models, ServiceOptions()};
};

TEST_F(StudyTest, AVariantIsAHandAsAnyOther) {
  const v1::Reply made = bus.ask(
      variant("clamp", "wide",
              {change(v1::PROPERTY_UPPER, "hinge", 0.9), change(v1::PROPERTY_SIZE, "", 1.5)}));
  ASSERT_EQ(made.error(), v1::ERROR_NONE) << made.message();
  EXPECT_EQ(made.body().models().models()[0].name(), "wide");

  const v1::Reply told = bus.ask(test::describeModel(v1::MODEL_HAND, "wide", true));
  ASSERT_EQ(told.error(), v1::ERROR_NONE) << told.message();
  const v1::HandDescription& hand = told.body().model().hand();
  EXPECT_EQ(hand.joints()[0].upper(), 0.9);
  EXPECT_NEAR(hand.sites()[0].p_L_m()[0], 0.015, 1e-12);
  EXPECT_FALSE(hand.sites_found());
  EXPECT_TRUE(hand.skin_report().front().valid());
  EXPECT_THAT(hand.notes(),
              testing::Contains(AllOf(HasSubstr("'clamp'"), HasSubstr("hinge.upper = 0.9"),
                                      HasSubstr("hand.size = 1.5"))));
  EXPECT_THAT(hand.notes(), testing::Contains(HasSubstr("bent along")));

  // Its URDF is the variant.
  const auto path = test::scratchDirectory() / "wide.urdf";
  std::ofstream(path) << hand.urdf();
  const hand::HandModel read = io::readUrdfKinematics(path);
  EXPECT_EQ(read.name(), "wide");
  EXPECT_NE(hand.urdf().find("effort=\"1\""), std::string::npos) << hand.urdf();
  EXPECT_EQ(read.upper()[0], 0.9);
  EXPECT_NEAR(read.joints()[0].X_PJ.translation().y(), 0.075, 1e-12);

  const v1::Reply opened = bus.ask(test::openSession("wide", "fruit", "marks"));
  ASSERT_EQ(opened.error(), v1::ERROR_NONE) << opened.message();
  const v1::Reply solved = bus.ask(test::optimize(opened.body().session().session_id()));
  ASSERT_EQ(solved.error(), v1::ERROR_NONE) << solved.message();
  EXPECT_LE(solved.body().solution().joint_positions()[0], 0.9 + 1e-9);
  EXPECT_EQ(bus.ask(test::unloadModel(v1::MODEL_HAND, "wide")).error(), v1::ERROR_NONE);
}

TEST_F(StudyTest, AVariantOfAVariantHasBothChanges) {
  ASSERT_EQ(bus.ask(variant("clamp", "a", {change(v1::PROPERTY_SIZE, "", 1.5)})).error(),
            v1::ERROR_NONE);
  ASSERT_EQ(bus.ask(variant("a", "b", {change(v1::PROPERTY_SIZE, "", 0.5)})).error(),
            v1::ERROR_NONE);
  const v1::Reply told = bus.ask(test::describeModel(v1::MODEL_HAND, "b", true));
  ASSERT_EQ(told.error(), v1::ERROR_NONE) << told.message();
  EXPECT_NEAR(told.body().model().hand().sites()[0].p_L_m()[0], 0.0075, 1e-12);
}

TEST_F(StudyTest, AVariantTellsLimitsInDegrees) {
  const auto notes_of = [&](const char* name, double upper) {
    EXPECT_EQ(
        bus.ask(variant("clamp", name, {change(v1::PROPERTY_UPPER, "hinge", upper)})).error(),
        v1::ERROR_NONE);
    return bus.ask(test::describeModel(v1::MODEL_HAND, name, false))
        .body()
        .model()
        .hand()
        .notes();
  };
  const auto told = testing::Contains(HasSubstr("radians, not degrees"));
  EXPECT_THAT(notes_of("wide", 0.9), testing::Not(told));
  EXPECT_THAT(notes_of("mistaken", 60.0), told);
}

TEST_F(StudyTest, TheSameVariantTwiceIsNoConflict) {
  const auto body = variant("clamp", "wide", {change(v1::PROPERTY_UPPER, "hinge", 0.9)});
  EXPECT_EQ(bus.ask(body).error(), v1::ERROR_NONE);
  EXPECT_EQ(bus.ask(body).error(), v1::ERROR_NONE);
  EXPECT_EQ(
      bus.ask(variant("clamp", "wide", {change(v1::PROPERTY_UPPER, "hinge", 0.8)})).error(),
      v1::ERROR_CONFLICT);
}

TEST_F(StudyTest, NamesWhatIsWrongWithAVariant) {
  EXPECT_EQ(bus.ask(variant("nobody", "v", {})).error(), v1::ERROR_NOT_FOUND);
  const v1::Reply unknown =
      bus.ask(variant("clamp", "v", {change(v1::PROPERTY_UPPER, "elbow", 1.0)}));
  EXPECT_EQ(unknown.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(unknown.message(), AllOf(HasSubstr("'elbow'"), HasSubstr("'hinge'")));
  EXPECT_EQ(bus.ask(variant("clamp", "v", {change(static_cast<v1::HandProperty>(77), "", 1.0)}))
                .error(),
            v1::ERROR_INVALID_INPUT);
  EXPECT_EQ(bus.ask(variant("clamp", "../v", {})).error(), v1::ERROR_INVALID_INPUT);
}

TEST_F(StudyTest, SweepsALimit) {
  const v1::Reply swept = bus.ask(sweep({0.1, 0.6, 1.2}));
  ASSERT_EQ(swept.error(), v1::ERROR_NONE) << swept.message();
  const v1::SweepReply& reply = swept.body().sweep();
  EXPECT_EQ(reply.joint_names(), std::vector<std::string>{"hinge"});
  ASSERT_EQ(reply.rows().size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    const v1::SweepRow& row = reply.rows()[i];
    EXPECT_EQ(row.error(), "");
    EXPECT_EQ(row.grasp(), 0u);
    ASSERT_EQ(row.joint_positions().size(), 1u);
    EXPECT_LE(row.joint_positions()[0], row.values()[0] + 1e-9);
    EXPECT_EQ(row.patch_count(), 2u) << "palm and index";
    EXPECT_GT(row.mean_mm(), 0.0);
    if (i > 0) {
      EXPECT_LE(row.terms().objective(), reply.rows()[i - 1].terms().objective());
    }
  }
  // What a session of that grasp says is said of the sweep's, too.
  const std::uint64_t session =
      bus.ask(test::openSession("clamp", "fruit", "marks")).body().session().session_id();
  std::vector<std::string> notes;
  for (const v1::SweepNote& note : reply.notes()) {
    EXPECT_EQ(note.grasp(), 0u);
    notes.push_back(note.text());
  }
  EXPECT_EQ(
      notes,
      bus.ask(test::ofSession(v1::OP_SESSION_SETTINGS, session)).body().settings().notes());
  EXPECT_THAT(notes, Contains(HasSubstr("little"))) << "which the clamp has no finger for";
  bus.ask(test::ofSession(v1::OP_CLOSE_SESSION, session));
  // No session stays behind.
  EXPECT_TRUE(bus.ask(test::plain(v1::OP_LIST_SESSIONS)).body().sessions().sessions().empty());
}

TEST_F(StudyTest, ARowOfASweepIsThatOfTheVariant) {
  const v1::Reply swept = bus.ask(sweep({0.1}));
  ASSERT_EQ(swept.error(), v1::ERROR_NONE) << swept.message();
  ASSERT_EQ(
      bus.ask(variant("clamp", "tight", {change(v1::PROPERTY_UPPER, "hinge", 0.1)})).error(),
      v1::ERROR_NONE);
  const v1::Reply opened = bus.ask(test::openSession("tight", "fruit", "marks"));
  ASSERT_EQ(opened.error(), v1::ERROR_NONE) << opened.message();
  const v1::Reply solved = bus.ask(test::optimize(opened.body().session().session_id()));
  ASSERT_EQ(solved.error(), v1::ERROR_NONE) << solved.message();
  const double objective = solved.body().solution().terms().objective();
  // The variant's own limits give it a posture of its own, which weighs little.
  const v1::SweepRow& row = swept.body().sweep().rows()[0];
  EXPECT_NEAR(row.terms().objective(), objective, 1e-4 * objective);
  const v1::Penetration& inside = solved.body().solution().penetration()[0];
  EXPECT_NEAR(row.max_depth_m(), inside.max_depth_m(), 5e-5);
  EXPECT_NEAR(row.self_depth_m(), inside.self_depth_m(), 5e-5);
}

TEST_F(StudyTest, NamesWhatIsWrongWithASweep) {
  EXPECT_EQ(bus.ask(sweep({0.1}, "nothing")).error(), v1::ERROR_NOT_FOUND);
  const v1::Reply empty = bus.ask(sweep({}));
  EXPECT_EQ(empty.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(empty.message(), HasSubstr("'hinge.upper' has no values"));
  const v1::Reply crossing = bus.ask(sweep({-0.7, 0.5}));
  ASSERT_EQ(crossing.error(), v1::ERROR_NONE) << crossing.message();
  EXPECT_THAT(crossing.body().sweep().rows()[0].error(), HasSubstr("'hinge'"));
  EXPECT_EQ(crossing.body().sweep().rows()[1].error(), "");
}

}  // namespace
}  // namespace handgraft::server
