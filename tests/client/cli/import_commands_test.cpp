#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/cli/commands/commands.h"
#include "client/present/interruption.h"
#include "client/present/send_model.h"
#include "core/base/error.h"

#include "tests/client/fake_server.h"
#include "tests/client/hands.h"
#include "tests/support/shared_data.h"
#include "tests/support/test_domain.h"

namespace handgraft::client {
namespace {

namespace fs = std::filesystem;
using idl::cyclone::Refused;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// Knows a flat hand and a box with contacts, takes whatever is loaded, and keeps the requests.
struct ImportingServer {
  bool operator()(const v1::Request& request, v1::Reply& reply) {
    v1::ReplyBody& body = reply.body();
    switch (request.body()._d()) {
      case v1::OP_LOAD_MODEL: {
        const v1::LoadModelRequest& load = request.body().load_model();
        loads.push_back(load);
        if (load.units().empty() && doubtful == load.main_uri())
          return refuse(reply, v1::ERROR_UNITS, "152 m across: say --units mm");
        if (taken == load.name()) return refuse(reply, v1::ERROR_CONFLICT, "taken");
        body.models(listOf(load.kind(), load.name()));
        break;
      }
      case v1::OP_POSE_CONTACTS:
        poses.push_back(request.body().pose_contacts());
        if (taken == poses.back().name()) return refuse(reply, v1::ERROR_CONFLICT, "taken");
        body.models(listOf(v1::MODEL_CONTACTS, poses.back().name()));
        break;
      case v1::OP_DESCRIBE_MODEL:
        body.model(describe(request.body().describe_model()));
        break;
      default:
        break;
    }
    body._d(request.body()._d());
    return true;
  }

  static bool refuse(v1::Reply& reply, v1::ErrorCode code, const std::string& message) {
    reply.error(code);
    reply.message(message);
    return true;
  }

  static v1::ModelList listOf(v1::ModelKind kind, const std::string& name) {
    v1::ModelList list;
    list.models().resize(1);
    list.models()[0].kind(kind);
    list.models()[0].name(name);
    return list;
  }

  [[nodiscard]] v1::ModelDescription describe(const v1::DescribeModelRequest& request) const {
    v1::ModelDescription description;
    switch (request.model().kind()) {
      case v1::MODEL_HAND:
        description.hand(hand);
        break;
      case v1::MODEL_OBJECT:
        description.object(test::boxObject());
        break;
      case v1::MODEL_CONTACTS:
        description.contacts(test::squareOnBox());
        break;
      case v1::MODEL_MOTION:
        break;
    }
    return description;
  }

  v1::HandDescription hand = test::flatHand();
  std::string taken;     // a name
  std::string doubtful;  // a file whose units must be told
  std::vector<v1::LoadModelRequest> loads;
  std::vector<v1::PoseContactsRequest> poses;
};

class ImportCommands : public testing::Test {
 protected:
  ImportCommands()
      : server({domain.number(), "lo"}, [this](const v1::Request& request, v1::Reply& reply) {
          return script(request, reply);
        }) {
    common.network = {domain.number(), "lo"};
    static int count = 0;
    folder = test::scratchDirectory() / ("import" + std::to_string(++count));
    fs::create_directories(folder);
  }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name, std::ios::binary) << text;
    return folder / name;
  }

  template <class Options>
  std::string printed(const Options& options) {
    testing::internal::CaptureStdout();
    try {
      EXPECT_EQ(run(options, common, interruption), 0);
    } catch (...) {
      testing::internal::GetCapturedStdout();
      throw;
    }
    return testing::internal::GetCapturedStdout();
  }

  test::TestDomain domain;
  ImportingServer script;
  test::FakeServer server;
  CommonOptions common;
  Interruption interruption;
  fs::path folder;
};

TEST_F(ImportCommands, InspectWritesTheSitesAndAPicture) {
  InspectOptions options;
  options.hand = write("my.urdf", "<robot/>").string();
  options.reading.options.mirrored(true);
  options.sites = folder / "sites.yaml";
  options.png = folder / "hand.png";
  EXPECT_THAT(printed(options), HasSubstr("hand flat: 2 joints"));
  EXPECT_EQ(readFile(options.sites), test::flatHand().sites_file());
  EXPECT_GT(fs::file_size(options.png), 1000U);
  ASSERT_EQ(script.loads.size(), 1U);
  EXPECT_TRUE(script.loads[0].hand().at(0).mirrored());
}

TEST_F(ImportCommands, InspectMayWriteTheSitesThatItRead) {
  write("sites.yaml", "format: handgraft-sites/1\nsites: []\n");
  InspectOptions options;
  options.hand = write("my.urdf", "<robot/>").string();
  options.sites = folder / "sites.yaml";
  printed(options);
  EXPECT_EQ(readFile(options.sites), test::flatHand().sites_file());
  options.sites = options.hand;
  EXPECT_THROW(printed(options), InvalidInput);
  EXPECT_EQ(readFile(options.hand), "<robot/>");
}

TEST_F(ImportCommands, InspectOfAModelOnTheServerLoadsNothing) {
  common.json = true;
  InspectOptions options;
  options.hand = "flat";
  EXPECT_EQ(nlohmann::json::parse(printed(options))["skin_report"]["valid"], true);
  EXPECT_THAT(server.operations(), ElementsAre(v1::OP_DESCRIBE_MODEL));
}

TEST_F(ImportCommands, SkinWritesAPly) {
  SkinOptions options;
  options.hand = "flat";
  options.out = folder / "skin.ply";
  options.png = folder / "skin.png";
  EXPECT_THAT(printed(options), HasSubstr("skin is sound"));
  EXPECT_EQ(readFile(options.out).substr(0, 4), "ply\n");
  common.json = true;
  EXPECT_EQ(nlohmann::json::parse(printed(options))["hand"], "flat");
}

TEST_F(ImportCommands, ImportSendsTheObjectAndThenTheMapOnIt) {
  ImportOptions options;
  options.map = write("scan.ply", "ply");
  options.object = write("bulb.obj", "v 0 0 0").string();
  options.reading.options.threshold().push_back(0.3);
  options.units = "mm";
  options.out = folder / "set.json";
  options.png = folder / "set.png";
  EXPECT_THAT(printed(options), HasSubstr("1 patch"));
  EXPECT_EQ(readFile(options.out), test::squareOnBox().file());
  ASSERT_EQ(script.loads.size(), 2U);
  EXPECT_EQ(script.loads[0].name(), "bulb");
  EXPECT_EQ(script.loads[0].units(), "mm");
  EXPECT_TRUE(script.loads[0].contacts().empty());
  EXPECT_EQ(script.loads[1].object(), "bulb");
  EXPECT_EQ(script.loads[1].units(), "mm");
  EXPECT_EQ(script.loads[1].contacts().at(0).threshold().at(0), 0.3);
}

TEST_F(ImportCommands, ImportPrintsTheSetAsJson) {
  common.json = true;
  ImportOptions options;
  options.map = write("scan.ply", "ply");
  options.object = "box";
  EXPECT_EQ(nlohmann::json::parse(printed(options))["kind"], "contacts");
}

TEST_F(ImportCommands, ImportTellsMapsReadInDifferentWaysApart) {
  script.taken = "scan";
  ImportOptions options;
  options.map = write("scan.ply", "ply");
  options.object = "box";
  testing::internal::CaptureStderr();
  printed(options);
  EXPECT_THAT(testing::internal::GetCapturedStderr(),
              AllOf(HasSubstr("'scan' is on the server with other content"),
                    HasSubstr("this is '" + script.loads[1].name() + "'"),
                    HasSubstr("`handgraft unload contacts scan`")));
  options.reading.options.otsu(true);
  printed(options);
  ASSERT_EQ(script.loads.size(), 4U);
  EXPECT_THAT(script.loads[1].name(), testing::MatchesRegex("scan-[0-9a-f]+"));
  EXPECT_NE(script.loads[1].name(), script.loads[3].name());
  options.name = "scan";  // asked for: nobody may be surprised by another
  EXPECT_THROW(printed(options), Refused);
}

TEST_F(ImportCommands, LoadTellsWhatWasNoted) {
  LoadOptions options;
  options.path = write("claw.urdf", "<robot name='claw'/>");
  script.hand.notes().emplace_back("its joints have no limits");
  EXPECT_THAT(printed(options), HasSubstr("note: its joints have no limits\n"));
  EXPECT_THAT(printed(options), testing::Not(HasSubstr("no contact sites")));
  script.hand.sites().clear();
  EXPECT_THAT(printed(options), HasSubstr("it brings no contact sites"));
  options.kind = v1::MODEL_CONTACTS;
  options.path = write("set.json", "{}");
  options.object = "box";
  EXPECT_THAT(printed(options), HasSubstr("note: dropped nothing\n"));
}

TEST_F(ImportCommands, DoubtfulUnitsAreAnErrorWhereNobodyCanBeAsked) {
  script.doubtful = "bulb.obj";
  ImportOptions options;
  options.map = write("scan.ply", "ply");
  options.object = write("bulb.obj", "v 0 0 0").string();
  try {
    printed(options);
    FAIL() << "must throw";
  } catch (const Refused& refused) {
    EXPECT_EQ(refused.code(), v1::ERROR_UNITS);
    EXPECT_THAT(refused.what(), HasSubstr("--units mm"));
  }
}

TEST_F(ImportCommands, JoinRefusesGraspsOfTwoObjectsBeforeAnythingIsSent) {
  MotionImportOptions options;
  options.name = "joined";
  options.first = "box_1";
  options.last = write("last.json", R"({"object": "cup", "patches": []})").string();
  options.path = write("path.csv", "time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n");
  try {
    printed(options);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), testing::MatchesRegex(".*'box_1' lie on object 'box' and "
                                                    ".*last.json' on 'cup'.*"));
  }
  EXPECT_TRUE(script.loads.empty());
}

TEST_F(ImportCommands, ARecordingOfAMeshIsRefusedWithItsWordForIt) {
  MotionImportOptions options;
  options.recording = write("grab.json", R"({"fps": 120, "object_mesh": "apple.obj"})");
  options.name = "grab";
  try {
    run(options, common, interruption);
    ADD_FAILURE() << "it says no object";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("its object_mesh is 'apple.obj'; say by --object"));
  }
  EXPECT_TRUE(script.loads.empty()) << "nothing was sent";
}

TEST_F(ImportCommands, FromPosePassesTheFileOn) {
  PoseContactsOptions options;
  options.hand = "flat";
  options.object = "box";
  options.pose = write("pose.json", R"({"joints": {"index_mcp": 0.5},
      "X_WH": {"p_m": [0, 0, 0.1], "q_wxyz": [1, 0, 0, 0]},
      "X_WO": {"p_m": [0, 0.2, 0], "q_wxyz": [1, 0, 0, 0]}})");
  options.reach_mm = 4.0;
  options.contacts.interpolation_count(30);
  EXPECT_THAT(printed(options), HasSubstr("1 patch"));
  ASSERT_EQ(script.poses.size(), 1U);
  const v1::PoseContactsRequest& request = script.poses[0];
  EXPECT_EQ(request.name(), "box_flat");
  EXPECT_EQ(request.hand(), "flat");
  EXPECT_THAT(request.joints(), ElementsAre("index_mcp"));
  EXPECT_THAT(request.joint_positions(), ElementsAre(0.5));
  EXPECT_EQ(request.X_WH().at(0).p_m()[2], 0.1);
  EXPECT_EQ(request.X_WO().at(0).p_m()[1], 0.2);
  EXPECT_DOUBLE_EQ(request.reach_m(), 0.004);
  EXPECT_EQ(request.contacts().at(0).interpolation_count(), 30U);
  EXPECT_EQ(request.start_pose(), "");
}

TEST_F(ImportCommands, FromPoseTakesNamedPosesAndThePlaceThatWasTold) {
  PoseContactsOptions options;
  options.hand = "flat";
  options.object = "box";
  options.pose = "fist";
  options.place = Place{0, 0, 0.3, 1, 0, 0, 0};
  printed(options);
  ASSERT_EQ(script.poses.size(), 1U);
  EXPECT_EQ(script.poses[0].start_pose(), "fist");
  EXPECT_TRUE(script.poses[0].X_WH().empty());
  EXPECT_EQ(script.poses[0].X_WO().at(0).p_m()[2], 0.3);
}

TEST_F(ImportCommands, FromPoseTellsPosesOfOneHandApart) {
  script.taken = "box_flat";
  PoseContactsOptions options;
  options.hand = "flat";
  options.object = "box";
  options.pose = "fist";
  printed(options);
  options.pose = "open";
  printed(options);
  ASSERT_EQ(script.poses.size(), 4U);
  EXPECT_NE(script.poses[1].name(), script.poses[3].name());
}

TEST(Units, AreWhatARefusalRecommends) {
  EXPECT_THAT(unitsIn("bottle: 152 m across; say --units mm"), ElementsAre("mm"));
  EXPECT_THAT(unitsIn("say --units cm or --units in"), ElementsAre("cm", "in"));
  EXPECT_THAT(unitsIn("say --units m"), ElementsAre("m"));
  EXPECT_THAT(unitsIn("no such file"), testing::IsEmpty());
  EXPECT_THAT(unitsIn("--units mmm"), testing::IsEmpty());
}

}  // namespace
}  // namespace handgraft::client
