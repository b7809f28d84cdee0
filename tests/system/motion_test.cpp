// A motion through all programs: joined of built-in grasps, followed by built-in hands, drawn
// and written.
#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <optional>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/link/client.h"
#include "client/link/session_stream.h"
#include "client/present/motion_result.h"
#include "core/base/sanitized.h"

#include "tests/support/shared_data.h"
#include "tests/system/service.h"
#include "tests/system/shared_skins.h"

namespace handgraft::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kPull =
    "time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0.3,1,0,0,0\n0.5,-0.25,0,0.32,1,0,0,0\n"
    "1,-0.3,0.1,0.2,0.877582562,0,0,0.479425539\n";

std::string written(const std::string& name, const std::string& text) {
  const auto path = scratchDirectory() / name;
  std::ofstream(path, std::ios::binary) << text;
  return path.string();
}

std::string whole(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string begins(const std::filesystem::path& path, std::size_t count) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes(count, '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(count));
  return bytes;
}

TEST(Motion, OfAGraspIsNotExported) {
  const SharedSkins skins;
  const Service service;
  const json grasp = service.ask(
      {"grasp", "--hand", "human20", "--object", "lemon", "--contacts", "lemon_6", "--keep"});
  const std::string session = std::to_string(grasp.at("session_id").get<std::uint64_t>());
  const auto file = scratchDirectory() / "grasp.json";
  const Finished refused =
      service.client({"motion", "export", session, "--out", file.string()});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, AllOf(HasSubstr("no motion"), HasSubstr("handgraft export")));
  EXPECT_FALSE(std::filesystem::exists(file));
}

TEST(Motion, ABoxIsPulledOffAShelfAndTurned) {
  const SharedSkins skins;
  const Service service;
  const auto scratch = scratchDirectory();
  const std::string file = (scratch / "pull.json").string();
  const json motion =
      service.ask({"motion", "join", "box_5", "box_5", "--path", written("pull.csv", kPull),
                   "--rate", "30", "--name", "pull", "--out", file});
  EXPECT_EQ(motion.at("frame_count"), 31);
  EXPECT_EQ(motion.at("object"), "box");
  EXPECT_EQ(motion.at("presence").size(), 5u);

  const json solved = service.ask(
      {"motion", "solve", "--hand", "human20", "--motion", "pull", "--keep", "--png",
       (scratch / "pull.png").string(), "--out", (scratch / "pull.npz").string(), "--out",
       (scratch / "pull.glb").string(), "--frames", (scratch / "frames.csv").string()});
  ASSERT_EQ(solved.at("frames").size(), 31u);
  EXPECT_LT(solved.at("mean_mm"), 5.0);
  EXPECT_LT(solved.at("max_depth_m"), 0.002);
  EXPECT_LT(solved.at("max_step"), 0.05);
  EXPECT_EQ(solved.at("patches").at(0).at("frames"), 31);
  EXPECT_TRUE(solved.at("frames").at(0).at("velocity").is_null());
  EXPECT_EQ(begins(scratch / "pull.png", 4).substr(1), "PNG");
  EXPECT_EQ(begins(scratch / "pull.npz", 2), "PK");
  EXPECT_EQ(begins(scratch / "pull.glb", 4), "glTF");
  EXPECT_EQ(begins(scratch / "frames.csv", 7), "time_s,");

  // The session stays, and writes what it was asked to keep.
  const std::string session = std::to_string(solved.at("session_id").get<std::uint64_t>());
  const json exported =
      service.ask({"motion", "export", session, "--out", (scratch / "pull.yaml").string()});
  EXPECT_EQ(exported.at("format"), "ros_trajectory");
  EXPECT_EQ(begins(scratch / "pull.yaml", 7), "header:");

  // At the prompt: solved anew, drawn, and edited at times that it has.
  const std::string picture = (scratch / "prompt.png").string();
  const Finished prompt = service.client(
      {"edit", session, "--script",
       written("prompt.txt", "solve --starts 3\nat 0.5 0.2\nat all\npng " + picture + "\n")});
  EXPECT_EQ(prompt.exit_code, 0) << prompt.err;
  EXPECT_THAT(prompt.out, HasSubstr("every patch is reached"));
  EXPECT_EQ(begins(picture, 4), "\x89PNG");
  const Finished too_late =
      service.client({"edit", session, "--script", written("late.txt", "at 1.5\n")});
  EXPECT_NE(too_late.exit_code, 0);
  EXPECT_THAT(too_late.err, HasSubstr("at 1.5 s: the motion lasts from 0 to 1 s"));
  const Finished of_grasps =
      service.client({"edit", session, "--script", written("paper.txt", "solve --paper\n")});
  EXPECT_THAT(of_grasps.err, HasSubstr("--paper: it is of grasps"));

  // It is played by the clock, whether anybody listens or not.
  const json played = service.ask(
      {"motion", "play", session, "--speed", "4", "--from", "0.2", "--lead-in", "0.1"});
  EXPECT_NEAR(played.at("duration_s"), 1.0, 1e-9);
  EXPECT_NEAR(played.at("time_s"), 1.0, 1e-9);
  EXPECT_GT(played.at("samples"), 10);
  EXPECT_LE(played.at("samples"), 40);
  EXPECT_GE(played.at("spent_s"), 0.3);

  const Finished told = service.client({"motion", "play", session, "--speed", "10"});
  EXPECT_TRUE(told.out.starts_with("playing at 0.00 of 1.00 s")) << told.out;

  // What is edited while it plays is taken up.
  const auto playing = service.start("handgraft", {"motion", "play", session, "--loop"});
  ASSERT_TRUE(playing->waitForText("looping")) << playing->err();
  const Finished edited =
      service.client({"edit", session, "--script", written("weight.txt", "weight index 3\n")});
  ASSERT_EQ(edited.exit_code, 0) << edited.err;
  EXPECT_TRUE(playing->waitForText("revision 1 is played from here on")) << playing->err();
  (void)service.client({"close", session});
  EXPECT_EQ(playing->wait(), 2);
  EXPECT_THAT(playing->err(), HasSubstr("session " + session));

  // A file of a motion is as good, on another hand and frame by frame.
  const json causal =
      service.ask({"motion", "solve", "--hand", "tendon16", "--motion", file, "--causal"});
  EXPECT_EQ(causal.at("options").at("causal"), true);
  EXPECT_LT(causal.at("mean_mm"), 6.0);
  EXPECT_TRUE(causal.at("session_id").is_null());
}

/// A MANO hand that closes about a box within half a second, then both are moved.
std::string demonstration(const std::string& object = "box") {
  json file = {{"format", "handgraft-demonstration/1"}, {"object", object}};
  for (int k = 0; k < 60; ++k) {
    const double share = std::min(1.0, k / 30.0);
    const double way_m = 0.002 * std::max(0, k - 30);
    std::vector<double> pose(48, 0.0);
    for (std::size_t joint = 0; joint < 12; ++joint)  // all but the thumb's
      pose[3 + 3 * joint + 2] = 0.1 + 0.6 * share;
    file["time_s"].push_back(k / 60.0);
    file["mano_pose_rad"].push_back(pose);
    file["mano_translation_m"].push_back({0.0, 0.0, way_m});
    file["object_pose"].push_back({0.0, -0.036, way_m, 1, 0, 0, 0});
  }
  return file.dump();
}

TEST(Motion, ADemonstratorIsImportedAndFollowedLive) {
  const SharedSkins skins;
  const Service service;
  const std::string file = written("demonstration.json", demonstration());
  const json motion =
      service.ask({"motion", "import", file, "--object", "box", "--name", "shown"});
  EXPECT_EQ(motion.at("frame_count"), 60);
  const json solved = service.ask(
      {"motion", "solve", "--hand", "human20", "--motion", "shown", "--causal", "--keep"});
  EXPECT_LT(solved.at("max_depth_m"), 0.003);
  const std::string session = std::to_string(solved.at("session_id").get<std::uint64_t>());
  // A server under a sanitizer is some ten times slower; so is its demonstrator then.
  const std::string speed = kIsSanitized ? "0.05" : "1";
  const std::filesystem::path live = scratchDirectory() / "live.csv";
  const json followed = service.ask(
      {"motion", "follow", session, file, "--speed", speed, "--out", live.string()});
  EXPECT_EQ(followed.at("frames"), 60);
  EXPECT_GT(followed.at("answered"), 20);
  EXPECT_LT(followed.at("largest_step"), 2.0);
  EXPECT_EQ(followed.at("message"), "");

  // What it did is kept, and so is how it is solved.
  const std::string kept = whole(live);
  const auto rows = std::count(kept.begin(), kept.end(), '\n') - 1;
  EXPECT_GE(rows, followed.at("answered").get<int>()) << "an answer may be lost on its way";
  EXPECT_LE(rows, 60);
  const std::filesystem::path again = scratchDirectory() / "again.csv";
  const json live_file =
      service.ask({"motion", "export", session, "--live", "--out", again.string()});
  EXPECT_EQ(live_file.at("format"), "csv");
  EXPECT_EQ(whole(again), kept);
  const json solved_file = service.ask({"motion", "export", session, "--out", again.string()});
  EXPECT_THAT(solved_file.at("notes").dump(), HasSubstr("another export (live)"));
  const std::string as_solved = whole(again);
  EXPECT_EQ(std::count(as_solved.begin(), as_solved.end(), '\n'), 61);
  const json did = service.ask({"motion", "import", live.string(), "--hand", "human20",
                                "--object", "box", "--name", "did"});
  EXPECT_EQ(did.at("frame_count"), rows);

  // Of another object it is followed all the same, and both names are told.
  const Finished of_another = service.client(
      {"motion", "follow", session, written("of_a_lemon.json", demonstration("lemon"))});
  EXPECT_EQ(of_another.exit_code, 0) << of_another.err;
  EXPECT_THAT(of_another.err,
              HasSubstr("is of object 'lemon', session " + session + " holds 'box'"));

  // While somebody else is followed, it is said and ends.
  {
    const auto other =
        service.start("handgraft", {"motion", "follow", session, file, "--loop"});
    std::this_thread::sleep_for(std::chrono::seconds(2));
    const Finished refused =
        service.client({"motion", "follow", session, file, "--speed", "0.1"});
    EXPECT_EQ(refused.exit_code, 1) << refused.out;
    EXPECT_THAT(refused.err, HasSubstr("another one is followed"));
    EXPECT_THAT(refused.err, Not(HasSubstr("after 60 of 60")));
    EXPECT_THAT(refused.out, Not(HasSubstr("nan")));
  }

  // Joints in millimetres are refused with the first of the frames, and nothing is left unsaid.
  json in_mm = {{"format", "handgraft-demonstration/1"}, {"object", "box"}};
  for (int k = 0; k < 60; ++k) {
    std::vector<std::vector<double>> joints;
    for (int joint = 0; joint < 21; ++joint)
      joints.push_back({45.0 * (joint == 0 ? 0 : (joint - 1) % 4 + 1), 0.0, 0.0});
    in_mm["time_s"].push_back(k / 30.0);
    in_mm["joints_W_m"].push_back(joints);
    in_mm["object_pose"].push_back({0.0, 0.0, 0.0, 1, 0, 0, 0});
  }
  for (int run = 0; run < 2; ++run) {
    const Finished refused =
        service.client({"motion", "follow", session, written("in_mm.json", in_mm.dump())});
    EXPECT_EQ(refused.exit_code, 1) << refused.out;
    EXPECT_THAT(refused.err, HasSubstr("millimetres?"));
    EXPECT_THAT(refused.err, Not(HasSubstr("after 60 of 60")));
    EXPECT_THAT(refused.out, Not(HasSubstr("nan")));
  }
}

// A hand given its own way comes back to it, and another hand follows the same areas.
TEST(Motion, WhatAHandDidIsAMotionForAnyHand) {
  const SharedSkins skins;
  const Service service;
  const auto scratch = scratchDirectory();
  const json joined =
      service.ask({"motion", "join", "box_5", "box_5", "--path", written("pull.csv", kPull),
                   "--rate", "30", "--name", "pull"});
  const std::string done = (scratch / "done.json").string();
  const std::string table = (scratch / "done.csv").string();
  const json first = service.ask({"motion", "solve", "--hand", "human20", "--motion", "pull",
                                  "--out", done, "--out", table});
  const std::string areas = (scratch / "areas.json").string();
  const json motion = service.ask(
      {"motion", "import", done, "--hand", "human20", "--every", "100", "--out", areas});
  EXPECT_EQ(motion.at("frame_count"), joined.at("frame_count"));
  EXPECT_EQ(motion.at("object"), "box");
  EXPECT_GE(motion.at("patches").size(), first.at("patches").size());
  // A table names no object.
  const Finished of_nothing = service.client({"motion", "import", table, "--hand", "human20"});
  EXPECT_NE(of_nothing.exit_code, 0);
  EXPECT_THAT(of_nothing.err, HasSubstr("which object they lie on"));
  const json from_table = service.ask(
      {"motion", "import", table, "--hand", "human20", "--every", "100", "--object", "box"});
  EXPECT_EQ(from_table.at("patches"), motion.at("patches"));

  for (const char* hand : {"human20", "tendon16"}) {
    const json solved = service.ask({"motion", "solve", "--hand", hand, "--motion", areas});
    EXPECT_LT(solved.at("mean_mm"), 4.0) << hand;
    EXPECT_LT(solved.at("max_depth_m"), 0.002) << hand;
  }
}

/// What edits changed of a motion, as one who watches is told.
struct Told {
  std::uint64_t revision = 0;
  std::vector<std::uint32_t> frames;
  bool is_complete = false;
};

Told toldTo(client::SessionStream& watcher, std::uint64_t revision) {
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  Told told;
  while (!told.is_complete && std::chrono::steady_clock::now() < give_up) {
    for (const v1::MotionFrames& some : watcher.takeMotion()) {
      if (some.revision() < revision) continue;
      told.revision = some.revision();
      for (const v1::MotionFrame& frame : some.frames())
        told.frames.push_back(frame.index());
      told.is_complete = some.is_last();
    }
    watcher.wait(std::chrono::milliseconds(20));
  }
  return told;
}

TEST(Motion, IsShownOverTimeNotAsTheGraspThatStandsForThem) {
  const SharedSkins skins;
  const Service service;
  const json motion = service.ask({"motion", "join", "box_5", "box_5", "--path",
                                   written("shown.csv",
                                           "time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0.3,1,0,0,0\n"
                                           "2,-0.25,0,0.32,1,0,0,0\n"),
                                   "--rate", "15", "--name", "shown_over_time"});
  EXPECT_EQ(motion.at("frame_count"), 31);
  const json solved = service.ask({"motion", "solve", "--hand", "human20", "--motion",
                                   "shown_over_time", "--causal", "--keep"});
  EXPECT_EQ(solved.at("frame_count"), 31);
  EXPECT_EQ(solved.at("frames_touching"), 31);
  EXPECT_LE(solved.at("frames_reached"), 31);
  const std::string session = std::to_string(solved.at("session_id").get<std::uint64_t>());

  const Finished watched = service.client({"watch", session, "--count", "1"});
  ASSERT_EQ(watched.exit_code, 0) << watched.err;
  EXPECT_THAT(watched.out, HasSubstr("revision 0: motion of 31 frames solved"));

  const Finished shown =
      service.client({"edit", session, "--script",
                      written("shown.txt", "disable little\nshow\nat 1\nshow\n")});
  ASSERT_EQ(shown.exit_code, 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("31 frames touch, in "));
  EXPECT_THAT(shown.out, HasSubstr("little (off)"));
  EXPECT_THAT(shown.out, HasSubstr("frame 15 at 1.000 s"));
  EXPECT_THAT(shown.out, Not(HasSubstr("objective")));
}

TEST(Motion, AnEditAtATimeIsSeenByAllWhoWatch) {
  const SharedSkins skins;
  const Service service;
  const json motion = service.ask({"motion", "join", "box_5", "box_5", "--path",
                                   written("pull4.csv",
                                           "time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0.3,1,0,0,0\n"
                                           "4,-0.25,0,0.32,1,0,0,0\n"),
                                   "--rate", "30", "--name", "pull", "--out",
                                   (scratchDirectory() / "pull4.json").string()});
  EXPECT_EQ(motion.at("frame_count"), 121);
  const json solved =
      service.ask({"motion", "solve", "--hand", "human20", "--motion", "pull", "--keep"});
  const auto id = solved.at("session_id").get<std::uint64_t>();
  const std::string session = std::to_string(id);
  client::ClientOptions options;
  options.network = service.network();
  client::Client one(options);
  client::Client two(options);
  client::SessionStream first(one, id);
  client::SessionStream second(two, id);
  const auto frames_before = client::framesOf(one, id);

  // The editor's own words, then what others see of it.
  const Finished end =
      service.client({"edit", session, "--at", "2", "--falloff", "0.2", "--script",
                      written("at.txt", "weight index 30\nat all\nat 2\nat 2 0.2\nundo\n")});
  ASSERT_EQ(end.exit_code, 0) << end.err;
  EXPECT_THAT(end.out, HasSubstr("of 121 frames changed"));
  const Told undone = toldTo(first, 2);
  EXPECT_EQ(undone.revision, 2u);
  EXPECT_EQ(toldTo(second, 2).frames, undone.frames);
  ASSERT_FALSE(undone.frames.empty());
  EXPECT_LT(undone.frames.size(), 60u);

  // Undone to the byte, as who joins late is told, too.
  const auto frames_after = client::framesOf(two, id);
  ASSERT_EQ(frames_after.size(), frames_before.size());
  for (std::size_t k = 0; k < frames_after.size(); ++k)
    EXPECT_EQ(frames_after[k], frames_before[k]) << k;

  // Taken back by number, whatever was edited since.
  const Finished taken =
      service.client({"edit", session, "--at", "2", "--falloff", "0.2", "--script",
                      written("back.txt",
                              "weight index 30\nweight thumb 20\nshow times\ntake back 1\n"
                              "take back 1\nshow times\n")});
  ASSERT_EQ(taken.exit_code, 0) << taken.err;
  EXPECT_EQ(toldTo(first, 6).revision, 6u);
  const auto frames_taken = client::framesOf(two, id);
  for (std::size_t k = 0; k < frames_taken.size(); ++k)
    EXPECT_EQ(frames_taken[k], frames_before[k]) << k;

  // One clock.
  const json clock = service.ask({"motion", "clock", session, "seek", "1.25"});
  EXPECT_EQ(clock.at("time_s"), 1.25);
  client::SessionStream late(two, id);
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  std::optional<v1::MotionClock> seen;
  while (!seen && std::chrono::steady_clock::now() < give_up) {
    seen = late.takeClock();
    late.wait(std::chrono::milliseconds(20));
  }
  ASSERT_TRUE(seen.has_value());
  EXPECT_EQ(seen->time_s(), 1.25);
}

TEST(Motion, WhatIsWrongIsOneLine) {
  const SharedSkins skins;
  const Service service;
  const auto objection_to = [&](const std::vector<std::string>& words) {
    const Finished end = service.client(words);
    EXPECT_EQ(end.exit_code, 2) << end.err;
    return end.err;
  };
  EXPECT_THAT(objection_to({"motion", "join", "box_5", "box_5", "--path",
                            written("back.csv",
                                    "time_s,x,y,z,qw,qx,qy,qz\n1,0,0,0,1,0,0,0\n"
                                    "0.5,0,0,0,1,0,0,0\n")}),
              AllOf(HasSubstr("line 3"), HasSubstr("does not lie behind")));
  EXPECT_THAT(objection_to({"motion", "solve", "--hand", "human20", "--motion", "nowhere"}),
              HasSubstr("motion 'nowhere' is not known"));
  EXPECT_THAT(objection_to({"motion", "solve", "--hand", "human20", "--motion", "pull", "--out",
                            (scratchDirectory() / "pull.bvh").string()}),
              AllOf(HasSubstr(".npz"), HasSubstr("--out")));
  EXPECT_THAT(
      objection_to({"motion", "export", "7", "--out", (scratchDirectory() / "a.npz").string()}),
      HasSubstr("session 7 is not open"));
}

}  // namespace
}  // namespace handgraft::test
