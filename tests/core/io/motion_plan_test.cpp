#include "core/io/motion_plan.h"

#include <fstream>
#include <map>

#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/formats/npz_file.h"
#include "core/io/contact_file.h"
#include "core/io/motion_file.h"

#include "tests/support/shared_data.h"

namespace handgraft::io {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class MotionPlan : public testing::Test {
 protected:
  MotionPlan()
      : models(test::sourceDirectory() / "server/models"),
        box(readMesh(models / "objects/box.obj")) {
    write("path.csv", "time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0.3,1,0,0,0\n1,-0.25,0,0.32,1,0,0,0\n");
    files["first.json"] = models / "contacts/box_5.json";
  }

  fs::path write(const std::string& name, const std::string& text) {
    const fs::path path = test::scratchDirectory() / name;
    std::ofstream(path, std::ios::binary) << text;
    files[name] = path;
    return path;
  }

  manipulation::Motion read(const std::string& plan) {
    return readMotionFrom(write("plan.json", plan), box, [this](const std::string& uri) {
      const auto found = files.find(uri);
      if (found == files.end()) rejectInput("{}: this file was not uploaded", quoted(uri));
      return found->second;
    });
  }

  std::string objectionTo(const std::string& plan) {
    try {
      (void)read(plan);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  }

  fs::path models;
  MeshFile box;
  std::map<std::string, fs::path> files;
};

constexpr const char* kPull =
    R"({"format": "handgraft-motion-plan/1", "name": "pull", "first": "first.json",
        "path": "path.csv", "rate_hz": 30})";

TEST_F(MotionPlan, JoinsAGraspToItselfAlongAPath) {
  const manipulation::Motion motion = read(kPull);
  EXPECT_EQ(motion.name, "pull");
  EXPECT_EQ(motion.frameCount(), 31);
  EXPECT_EQ(motion.tracks.size(), 5u);
  EXPECT_NEAR(motion.X_WO.back().translation().x(), -0.25, 1e-12);
}

TEST_F(MotionPlan, ComesBackFromTheFileThatIsMadeOfIt) {
  const manipulation::Motion motion = read(kPull);
  const manipulation::Motion back = read(motionText(motion, box.mesh));
  ASSERT_EQ(back.tracks.size(), motion.tracks.size());
  EXPECT_EQ(back.time_s, motion.time_s);
}

TEST_F(MotionPlan, NamesWhatIsWrong) {
  EXPECT_THAT(objectionTo(R"({"format": "handgraft-motion-plan/1", "first": "first.json"})"),
              AllOf(HasSubstr("plan.json"), HasSubstr("'path' is missing")));
  EXPECT_THAT(objectionTo(R"({"format": "handgraft-motion-plan/1", "first": "first.json",
                              "path": "path.csv", "rat_hz": 3})"),
              HasSubstr("rat_hz"));
  EXPECT_THAT(objectionTo(R"({"format": "handgraft-motion-plan/1", "recording": "gone.json"})"),
              HasSubstr("gone.json"));
  EXPECT_THAT(objectionTo("[1, 2"), HasSubstr("is no JSON"));
}

TEST_F(MotionPlan, WhatAHandDidNeedsThatHand) {
  constexpr const char* kDone =
      R"({"format": "handgraft-trajectory/1", "object": "box", "joint_names": ["close"],
          "frames": [{"time_s": 0, "joints": [0.5]}]})";
  EXPECT_THAT(objectionTo(kDone), HasSubstr("it takes that hand to tell what it touched"));
  write("done.json", kDone);
  const auto planned = [this](const std::string& more) {
    return readHandTrajectoryPlan(
        write("plan.json", R"({"format": "handgraft-motion-plan/1", "name": "done",
                               "hand_trajectory": "done.json")" +
                               more + "}"),
        [this](const std::string& uri) {
          return files.at(uri);
        });
  };
  const auto plan = planned(R"(, "hand": "clamp", "every_s": 0.02)");
  ASSERT_TRUE(plan.has_value());
  EXPECT_EQ(plan->name, "done");
  EXPECT_EQ(plan->hand, "clamp");
  EXPECT_EQ(plan->every_s, 0.02);
  EXPECT_EQ(plan->reach_m, std::nullopt);
  EXPECT_EQ(plan->trajectory.object, "box");
  const auto objection = [&](const std::string& more) -> std::string {
    try {
      static_cast<void>(planned(more));
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(objection(""), AllOf(HasSubstr("plan.json"), HasSubstr("'hand' is missing")));
  EXPECT_THAT(objection(R"(, "hand": "clamp", "reach": 3)"), HasSubstr("reach"));
  EXPECT_THAT(objection(R"(, "hand": "clamp", "reach_m": "3 mm")"), HasSubstr("'reach_m'"));
  EXPECT_FALSE(readHandTrajectoryPlan(write("pull.json", kPull), {}).has_value());
}

TEST_F(MotionPlan, TimesThatRunBackwardsAreRefused) {
  write("path.csv", "time_s,x,y,z,qw,qx,qy,qz\n1,0,0,0,1,0,0,0\n0.5,0,0,0,1,0,0,0\n");
  EXPECT_THAT(objectionTo(kPull), AllOf(HasSubstr("line 3"), HasSubstr("0.5")));
  write("path.csv", "time_s,x,y,z,qw,qx,qy,qz\n0,nan,0,0,1,0,0,0\n");
  EXPECT_THAT(objectionTo(kPull), AllOf(HasSubstr("line 2"), HasSubstr("nan")));
}

TEST_F(MotionPlan, PointsOnTheManoHandGetPlacesOfAnyHand) {
  const manipulation::Motion motion = read(
      R"({"hand": "MANO", "fps": 120, "frames": [{"frame": 0, "contacts": [
          {"object_point": [0, 0.03, 0], "link": "index3", "hand_point": [-0.016, -0.007, 0]},
          {"object_point": [0, 0.03, 0], "link": "pinky2", "hand_point": [-0.008, -0.004, -0.006]},
          {"object_point": [0, 0.03, 0], "link": "tail", "hand_point": [0, 0, 0]}]}]})");
  std::map<std::string, std::optional<hand::HandLocation>> places;
  for (const manipulation::PatchTrack& track : motion.tracks)
    places[track.name] = track.keys.front().patch.place;
  ASSERT_TRUE(places.at("index_distal"));
  EXPECT_EQ(places.at("index_distal")->digit, "index");
  EXPECT_EQ(places.at("index_distal")->segment, "distal");
  EXPECT_NEAR(places.at("index_distal")->along, 0.68, 0.05);
  EXPECT_NEAR(places.at("index_distal")->around_rad, 0.0, 0.1);
  EXPECT_EQ(places.at("little_middle")->digit, "little");
  EXPECT_EQ(places.at("little_middle")->segment, "middle");
  EXPECT_FALSE(places.at("c1"));
}

// A hand that lies on the box' upper side with its fingers, by MANO's pose and by its joints.
TEST_F(MotionPlan, AHumanHandOverTimeIsAMotionOfWhatItTouches) {
  std::string pose = "0";
  for (int i = 1; i < 48; ++i)
    pose += ",0";
  const auto file = [&](const std::string& hand, const std::string& times = "0,0.1,0.2") {
    return "{\"format\":\"handgraft-demonstration/1\",\"object\":\"box\",\"time_s\":[" + times +
           "],\"object_pose\":[[0,-0.026,0,1,0,0,0]]," + hand + "}";
  };
  const std::string row = "[" + pose + "]";
  const std::string still = "\"mano_translation_m\":[[0,0,0],[0,0,0],[0,0,0]]";
  const std::string poses = "\"mano_pose_rad\":[" + row + "," + row + "," + row + "]";
  const manipulation::Motion motion = read(file(poses + "," + still));
  EXPECT_EQ(motion.name, "plan");
  EXPECT_EQ(motion.frameCount(), 3);
  ASSERT_GE(motion.tracks.size(), 3u);
  for (const manipulation::PatchTrack& track : motion.tracks)
    EXPECT_TRUE(track.keys.front().patch.place.has_value()) << track.name;

  const auto objection = [&](const std::string& text) -> std::string {
    try {
      read(text);
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(objection(file(still)), HasSubstr("'joints_W_m' and 'mano_pose_rad'"));
  EXPECT_THAT(objection(file(poses)), HasSubstr("'mano_translation_m' is missing"));
  EXPECT_THAT(objection(file(poses + "," + still, "0,0.2,0.1")),
              AllOf(HasSubstr("'time_s', frame 2"), HasSubstr("does not lie behind")));
  EXPECT_THAT(objection(file("\"joints_W_m\":[[[0,0,0]]]")), HasSubstr("list of 21 places"));
  EXPECT_THAT(objection(file(poses + ",\"hand\":1," + still)), HasSubstr("hand"));
}

TEST_F(MotionPlan, AWristsPlaceInsteadOfManosTranslationIsTold) {
  json root = {{"format", "handgraft-demonstration/1"},
               {"object", "box"},
               {"time_s", {0.0, 0.1, 0.2}},
               {"object_pose", {{0, -0.026, 0, 1, 0, 0, 0}}},
               {"mano_pose_rad", std::vector(3, std::vector<double>(48, 0.0))}};
  const auto told = [&](double x) {
    root["mano_translation_m"] = std::vector(3, std::vector<double>{x, 0.0064, 0.0062});
    try {
      const manipulation::Motion motion = read(root.dump());
      return fmt::format("{}", fmt::join(motion.notes, "; "));
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
  };
  EXPECT_THAT(told(0.0), Not(HasSubstr("the wrist's place")));
  EXPECT_THAT(told(0.0957), AllOf(HasSubstr("is the translation the wrist's place?"),
                                  HasSubstr("(0.0957, 0.0064, 0.0062) m")));
}

TEST_F(MotionPlan, AManoSequenceMayBeNumPys) {
  formats::NpzFile file;
  file.add("global_orient", std::vector<double>(9, 0.0), {3, 3});
  file.add("hand_pose", std::vector<double>(3 * 45, 0.0), {3, 45});
  file.add("transl", std::vector<double>(9, 0.0), {3, 3});
  file.add("fps", {10.0}, {});
  file.add("object_global_orient", {0.0, 0.0, 0.0}, {1, 3});
  file.add("object_transl", {0.0, -0.026, 0.0}, {1, 3});
  const std::string bytes = file.bytes();
  const fs::path path = write("hand.npz", bytes);
  const manipulation::Motion motion = readMotionFrom(path, box, {});
  EXPECT_EQ(motion.name, "hand");
  EXPECT_EQ(motion.frameCount(), 3);
  EXPECT_NEAR(motion.time_s[2], 0.2, 1e-12);
  EXPECT_GE(motion.tracks.size(), 3u);
  EXPECT_EQ(objectNameIn(path), "");

  const auto objection = [&](const std::string& text) -> std::string {
    try {
      (void)readMotionFrom(write("bad.npz", text), box, {});
    } catch (const InvalidInput& error) {
      return error.what();
    }
    return "";
  };
  for (std::size_t size = 5; size + 1 < bytes.size(); size += 97)
    EXPECT_NE(objection(bytes.substr(0, size)), "") << size;
  formats::NpzFile lacking;
  lacking.add("pose", std::vector<double>(96, 0.0), {2, 48});
  EXPECT_THAT(objection(lacking.bytes()), HasSubstr("'fps'"));
  formats::NpzFile sides;
  sides.add("pose", std::vector<double>(96, 0.0), {2, 48});
  sides.add("object", {1.0, 2.0}, {2});  // of something else: no name
  sides.add("side", {"left", "right"});
  EXPECT_THAT(objection(sides.bytes()), AllOf(HasSubstr("'side'"), HasSubstr("shape (2)")));
  formats::NpzFile narrow;
  narrow.add("pose", std::vector<double>(20, 0.0), {2, 10});
  EXPECT_THAT(objection(narrow.bytes()), AllOf(HasSubstr("'pose'"), HasSubstr("48")));
}

}  // namespace
}  // namespace handgraft::io
