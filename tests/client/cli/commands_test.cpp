#include "client/cli/commands/commands.h"

#include <algorithm>
#include <atomic>
#include <csignal>
#include <fstream>
#include <thread>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/link/client.h"
#include "client/present/interactive_client.h"
#include "client/present/output_file.h"
#include "core/base/error.h"
#include "core/base/progress.h"

#include "tests/client/fake_server.h"
#include "tests/support/shared_data.h"
#include "tests/support/test_domain.h"

namespace handgraft::client {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

// What a server of one claw, one plate and one contact set answers.
class ScriptedServer {
 public:
  bool operator()(const v1::Request& request, v1::Reply& reply) {
    const v1::Operation operation = request.body()._d();
    v1::ReplyBody& body = reply.body();
    switch (operation) {
      case v1::OP_PUT_FILE: {
        const v1::PutFileRequest& put = request.body().put_file();
        std::string& file = files[put.uri()];
        if (put.offset() != file.size()) ADD_FAILURE() << "a chunk out of order";
        file.append(put.bytes().begin(), put.bytes().end());
        total_bytes = put.total_bytes();
        break;
      }
      case v1::OP_LOAD_MODEL: {
        const v1::LoadModelRequest& load = request.body().load_model();
        loaded_names.push_back(load.name());
        loaded_objects.push_back(load.object());
        last_upload = std::exchange(files, {});
        if (load.name() == taken_name)
          return refuse(reply, v1::ERROR_CONFLICT, "name is taken");
        v1::ModelSummary summary;
        summary.kind(load.kind());
        summary.name(load.name());
        v1::ModelList list;
        list.models().push_back(summary);
        body.models(list);
        break;
      }
      case v1::OP_DESCRIBE_MODEL:
        describe(request.body().describe_model(), body);
        break;
      case v1::OP_OPEN_SESSION: {
        const v1::OpenSessionRequest& open = request.body().open_session();
        if (open.hand() == "glove")
          return refuse(reply, v1::ERROR_NOT_FOUND, "no hand 'glove'");
        v1::SessionState state;
        state.session_id(42);
        state.hand(open.hand());
        state.object(open.object());
        state.contacts(open.contacts());
        body.session(state);
        break;
      }
      case v1::OP_TRANSFER: {
        v1::TransferReply transfer;
        v1::PatchReport report;
        report.name("rim");
        report.placed(true);
        if (!solved) report.lost().resize(7);
        transfer.patches().push_back(report);
        transfer.transfer_ms(solved ? 0.0 : 12.0);
        body.transfer(transfer);
        break;
      }
      case v1::OP_CLOSE_SESSION:
        if (request.body().session().session_id() != 42) {
          return refuse(reply, v1::ERROR_NOT_FOUND, "no such session");
        }
        break;
      case v1::OP_UNLOAD_MODEL:
        if (request.body().unload_model().name() != "bowl") {
          return refuse(reply, v1::ERROR_NOT_FOUND, "no such model");
        }
        unloaded_kind = request.body().unload_model().kind();
        break;
      case v1::OP_OPTIMIZE: {
        if (hang) return false;
        solved = true;
        body.solution(solution());
        break;
      }
      case v1::OP_SESSION_SETTINGS:
        body.settings(v1::SessionSettings());
        break;
      case v1::OP_EXPORT: {
        const v1::ExportRequest& ask = request.body().export_file();
        std::string text = ask.urdf_path();
        for (std::size_t i = 0; i < ask.package_names().size(); ++i) {
          text += "|" + ask.package_names()[i] + "=" + ask.package_paths()[i];
        }
        v1::ExportReply exported;
        exported.content().assign(text.begin(), text.end());
        body.exported_file(exported);
        break;
      }
      default:
        break;
    }
    body._d(operation);
    return true;
  }

  std::string taken_name;
  std::atomic<bool> hang{false};  // on an optimisation
  std::map<std::string, std::string> files;
  std::map<std::string, std::string> last_upload;
  std::uint64_t total_bytes = 0;
  bool solved = false;  // which lays the patch so that no point is lost
  v1::ModelKind unloaded_kind = v1::MODEL_HAND;
  std::vector<std::string> loaded_names;
  std::vector<std::string> loaded_objects;

 private:
  static bool refuse(v1::Reply& reply, v1::ErrorCode code, const std::string& message) {
    reply.error(code);
    reply.message(message);
    return true;
  }

  static void describe(const v1::DescribeModelRequest& request, v1::ReplyBody& body) {
    v1::ModelDescription description;
    if (request.model().kind() == v1::MODEL_HAND) {
      v1::HandDescription hand;
      hand.name(request.model().name());
      hand.joints().resize(1);
      hand.joints()[0].name("bend");
      hand.links().resize(1);
      hand.links()[0].name("base");
      hand.urdf("<robot name='claw'/>");
      if (request.with_meshes()) hand.links()[0].surface_L() = triangle();
      description.hand(hand);
    } else if (request.model().kind() == v1::MODEL_OBJECT) {
      v1::ObjectDescription object;
      object.mesh_O() = triangle();
      object.notes().emplace_back("turned all faces");
      description.object(object);
    } else {
      description.contacts(v1::ContactsDescription());
    }
    body.model(description);
  }

  static v1::Mesh triangle() {
    v1::Mesh mesh;
    mesh.vertices_m() = {0, 0, 0, 0.1F, 0, 0, 0, 0.1F, 0};
    mesh.triangles() = {0, 1, 2};
    return mesh;
  }

  static v1::PoseSolution solution() {
    v1::Pose X;
    X.q_wxyz() = {1.0, 0.0, 0.0, 0.0};
    v1::PoseSolution solution;
    solution.session_id(42);
    solution.is_final(true);
    solution.X_WH() = X;
    solution.X_WO() = X;
    solution.joint_positions() = {0.5};
    solution.X_WL() = {X};
    solution.patches().resize(1);
    solution.patches()[0].name("rim");
    return solution;
  }
};

class CommandsTest : public testing::Test {
 protected:
  CommandsTest()
      : network{domain.number(), "lo"},
        server(network, [this](const v1::Request& request, v1::Reply& reply) {
          return script(request, reply);
        }) {
    common.network = network;
    static int count = 0;
    folder = test::scratchDirectory() / ("link" + std::to_string(++count));
    fs::create_directories(folder);
  }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name, std::ios::binary) << text;
    return folder / name;
  }

  std::string grasp(const GraspOptions& options) { return printed(options); }

  template <class Options>
  std::string printed(const Options& options) {
    testing::internal::CaptureStdout();
    int code = -1;
    try {
      code = run(options, common, interruption);
    } catch (...) {
      testing::internal::GetCapturedStdout();
      throw;
    }
    EXPECT_EQ(code, 0);
    return testing::internal::GetCapturedStdout();
  }

  test::TestDomain domain;
  Network network;
  ScriptedServer script;
  test::FakeServer server;
  CommonOptions common;
  Interruption interruption;
  fs::path folder;
};

TEST_F(CommandsTest, SendsLargeFilesInOrderAndWhole) {
  std::string bytes(1'300'000, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<char>(i * 31 >> 3);
  const ModelFiles model = objectFiles(write("big.obj", bytes));
  Client link(interactiveClient(network, Absence::kFail, interruption));
  link.load(model).get();
  EXPECT_EQ(script.last_upload["big.obj"], bytes);
  EXPECT_EQ(script.total_bytes, bytes.size());
  EXPECT_THAT(server.operations(), ElementsAre(v1::OP_PUT_FILE, v1::OP_PUT_FILE,
                                               v1::OP_PUT_FILE, v1::OP_LOAD_MODEL));
}

TEST_F(CommandsTest, PassesTheServersRefusalOn) {
  GraspOptions options;
  options.hand = "glove";
  options.object = "plate";
  options.contacts = "plate_2";
  try {
    grasp(options);
    FAIL() << "must throw";
  } catch (const Refused& refused) {
    EXPECT_EQ(refused.code(), v1::ERROR_NOT_FOUND);
    EXPECT_STREQ(refused.what(), "no hand 'glove'");
  }
}

TEST_F(CommandsTest, GraspClosesItsSession) {
  GraspOptions options;
  options.hand = "claw";
  options.object = "plate";
  options.contacts = "plate_2";
  EXPECT_THAT(grasp(options), AllOf(HasSubstr("claw grasps plate by plate_2"),
                                    HasSubstr("note: turned all faces\n")));
  EXPECT_THAT(server.operations(),
              ElementsAre(v1::OP_OPEN_SESSION, v1::OP_TRANSFER, v1::OP_OPTIMIZE,
                          v1::OP_TRANSFER, v1::OP_SESSION_SETTINGS, v1::OP_DESCRIBE_MODEL,
                          v1::OP_DESCRIBE_MODEL, v1::OP_CLOSE_SESSION));
}

TEST_F(CommandsTest, GraspLeavesASessionThatIsKept) {
  GraspOptions options;
  options.hand = "claw";
  options.object = "plate";
  options.contacts = "plate_2";
  options.keep = true;
  EXPECT_THAT(grasp(options), HasSubstr("session 42 stays open"));
  EXPECT_THAT(server.operations(), testing::Not(testing::Contains(v1::OP_CLOSE_SESSION)));
}

TEST_F(CommandsTest, GraspPrintsAndWritesTheSameDocument) {
  common.json = true;
  GraspOptions options;
  options.hand = "claw";
  options.object = "plate";
  options.contacts = "plate_2";
  options.out = folder / "out.json";
  options.png = folder / "out.png";
  const std::string printed = grasp(options);
  EXPECT_EQ(readFile(options.out), printed);
  EXPECT_EQ(nlohmann::json::parse(printed)["joints"]["bend"], 0.5);
  EXPECT_GT(fs::file_size(options.png), 1000U);
}

TEST_F(CommandsTest, GraspTellsModelsOfOneNameApart) {
  script.taken_name = "bowl";
  GraspOptions options;
  options.hand = "claw";
  options.object = write("bowl.obj", "v 0 0 0").string();
  options.contacts = write("rim.json", "{}").string();
  grasp(options);
  ASSERT_EQ(script.loaded_names.size(), 3U);
  EXPECT_EQ(script.loaded_names[0], "bowl");
  EXPECT_THAT(script.loaded_names[1], testing::MatchesRegex("bowl-[0-9a-f]+"));
  EXPECT_EQ(script.loaded_names[2], "rim");
  EXPECT_EQ(script.loaded_objects[2],
            script.loaded_names[1]);  // contacts follow their object
}

TEST_F(CommandsTest, ProblemOfAServersHandComesWithItsUrdf) {
  GraspOptions options;
  options.hand = "claw";
  options.object = "plate";
  options.contacts = "plate_2";
  options.problem = folder / "problem.json";
  grasp(options);
  EXPECT_EQ(readFile(options.problem), "claw.urdf");
  EXPECT_EQ(readFile(folder / "claw.urdf"), "<robot name='claw'/>");
}

TEST_F(CommandsTest, ProblemOfAHandOnDiskPointsToIt) {
  fs::create_directories(folder / "my_pkg");
  write("my_pkg/palm.stl", "solid");
  GraspOptions options;
  options.hand = write("my_pkg/claw.urdf",
                       R"(<robot><mesh filename="package://my_pkg/palm.stl"/></robot>)")
                     .string();
  options.object = "plate";
  options.contacts = "plate_2";
  fs::create_directories(folder / "results");
  options.problem = folder / "results" / "problem.json";
  grasp(options);
  EXPECT_EQ(readFile(options.problem),
            "../my_pkg/claw.urdf|my_pkg=" + (folder / "my_pkg").string());
}

TEST_F(CommandsTest, ChecksItsOutputsBeforeAnyWork) {
  GraspOptions options;
  options.hand = "claw";
  options.object = "plate";
  options.contacts = "plate_2";
  options.png = folder / "no such folder" / "a.png";
  EXPECT_THROW(grasp(options), InvalidInput);
  EXPECT_TRUE(server.operations().empty());
}

TEST_F(CommandsTest, RefusesOneFileForTwoOptionsBeforeAnyWork) {
  GraspOptions options;
  options.hand = "claw";
  options.object = write("bowl.obj", "v 0 0 0").string();
  options.contacts = "plate_2";
  options.out = options.png = folder / "a";
  EXPECT_THROW(grasp(options), InvalidInput);
  options.png = options.object;
  EXPECT_THROW(grasp(options), InvalidInput);
  EXPECT_TRUE(server.operations().empty());
  EXPECT_EQ(readFile(options.object), "v 0 0 0");
}

TEST_F(CommandsTest, GraspShowsTheTransferAsTheSolveLeftIt) {
  common.json = true;
  GraspOptions options;
  options.hand = "claw";
  options.object = "plate";
  options.contacts = "plate_2";
  const auto document = nlohmann::json::parse(grasp(options));
  EXPECT_TRUE(document["patches"][0]["lost"].empty());
  EXPECT_EQ(document["transfer_ms"], 12.0);
}

TEST_F(CommandsTest, ProblemLeavesAnotherHandOfThatNameAlone) {
  write("claw.urdf", "<robot name='mine'/>");
  GraspOptions options;
  options.hand = "claw";
  options.object = "plate";
  options.contacts = "plate_2";
  options.problem = folder / "problem.json";
  grasp(options);
  EXPECT_EQ(readFile(folder / "claw.urdf"), "<robot name='mine'/>");
  const std::string name = readFile(options.problem);
  EXPECT_THAT(name, testing::MatchesRegex("claw-[0-9a-f]+\\.urdf"));
  EXPECT_EQ(name.size(), std::string("claw-01234567.urdf").size());
  EXPECT_EQ(readFile(folder / name), "<robot name='claw'/>");
  grasp(options);  // finds its own file again
  EXPECT_EQ(readFile(options.problem), name);
}

TEST_F(CommandsTest, ProblemsHandIsNotWrittenWhereTheResultGoes) {
  GraspOptions options;
  options.hand = "claw";
  options.object = "plate";
  options.contacts = "plate_2";
  options.problem = folder / "problem.json";
  options.out = folder / "claw.urdf";
  grasp(options);
  EXPECT_THAT(readFile(options.out), HasSubstr("handgraft-grasp/1"));
  EXPECT_EQ(readFile(folder / readFile(options.problem)), "<robot name='claw'/>");
}

TEST_F(CommandsTest, ClosesASession) {
  EXPECT_EQ(printed(CloseOptions{42}), "closed session 42\n");
  common.json = true;
  EXPECT_EQ(nlohmann::json::parse(printed(CloseOptions{42}))["closed"], true);
  EXPECT_THAT(server.operations(), ElementsAre(v1::OP_CLOSE_SESSION, v1::OP_CLOSE_SESSION));
  EXPECT_THROW(printed(CloseOptions{43}), Refused);
}

TEST_F(CommandsTest, UnloadsAModel) {
  EXPECT_EQ(printed(UnloadOptions{v1::MODEL_OBJECT, "bowl"}), "unloaded object bowl\n");
  EXPECT_EQ(script.unloaded_kind, v1::MODEL_OBJECT);
  common.json = true;
  EXPECT_EQ(nlohmann::json::parse(printed(UnloadOptions{v1::MODEL_OBJECT, "bowl"}))["name"],
            "bowl");
  EXPECT_THROW(printed(UnloadOptions{v1::MODEL_OBJECT, "plate"}), Refused);
}

TEST_F(CommandsTest, CtrlCCancelsOnTheServerAndClosesTheSession) {
  script.hang = true;
  GraspOptions options;
  options.hand = "claw";
  options.object = "plate";
  options.contacts = "plate_2";
  std::thread user([&] {
    for (int i = 0; i < 2000; ++i) {
      const auto seen = server.operations();
      if (std::count(seen.begin(), seen.end(), v1::OP_TRANSFER) != 0) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    raise(SIGINT);
    // A real server answers a cancelled request with ERROR_CANCELLED; this one ends it as well.
    for (int i = 0; i < 2000; ++i) {
      const auto seen = server.operations();
      if (std::count(seen.begin(), seen.end(), v1::OP_CANCEL) != 0) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    script.hang = false;
  });
  EXPECT_THROW(grasp(options), Cancelled);
  user.join();
  EXPECT_THAT(server.operations(), testing::Contains(v1::OP_CANCEL));
  EXPECT_EQ(server.operations().back(), v1::OP_CLOSE_SESSION);
}

TEST(CommandsAlone, SaysWhereNoServerAnswers) {
  const test::TestDomain domain;
  Interruption interruption;
  try {
    Client link(interactiveClient({domain.number(), "lo"}, Absence::kFail, interruption));
    FAIL() << "must throw";
  } catch (const NoServer& error) {
    EXPECT_THAT(error.what(), HasSubstr("domain " + std::to_string(domain.number())));
    EXPECT_THAT(error.what(), HasSubstr("interface lo"));
  }
}

}  // namespace
}  // namespace handgraft::client
