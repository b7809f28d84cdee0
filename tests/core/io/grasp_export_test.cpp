#include <fstream>
#include <map>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <yaml-cpp/yaml.h>

#include "core/io/file_mesh.h"
#include "core/io/grasp_writer.h"
#include "core/io/mesh_file.h"
#include "core/io/row_writer.h"
#include "core/io/scene_writer.h"

#include "tests/support/shared_data.h"
#include "tests/support/small_hand.h"

namespace handgraft::io {
namespace {

using nlohmann::json;

/// A hand bent at every joint, turned and moved, at a box that is turned and moved, too.
PosedGrasp bentGrasp() {
  PosedGrasp grasp;
  grasp.hand = "small hand";
  grasp.object = "box, \"red\"";
  grasp.model = test::makeSmallHand().model;
  grasp.object_O =
      std::make_shared<const geometry::TriangleMesh>(geometry::makeBox({0.04, 0.05, 0.06}));
  grasp.pose.q.resize(6);
  grasp.pose.q << 0.1, 0.7, -0.2, 1.1, 0.30000000000000004, 1e-5;
  grasp.pose.X_WH = Eigen::Translation3d(0.01, -0.2, 0.3) *
                    Eigen::AngleAxisd(2.2, Eigen::Vector3d(1, 2, -1).normalized());
  grasp.X_WO = Eigen::Translation3d(-0.5, 0.02, 0.1) *
               Eigen::AngleAxisd(-0.9, Eigen::Vector3d(0, 1, 3).normalized());
  return grasp;
}

std::filesystem::path write(const std::string& name, const std::string& bytes) {
  const std::filesystem::path path = test::scratchDirectory() / name;
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

/// All vertices of the grasp in W, by forward kinematics and the object's pose, in the order of
/// the parts.
Eigen::Matrix3Xd verticesOf(const PosedGrasp& grasp) {
  const hand::LinkPoses X_WL = hand::forwardKinematics(*grasp.model, grasp.pose);
  std::vector<Eigen::Vector3d> points;
  for (std::size_t i = 0; i < X_WL.size(); ++i) {
    for (const hand::Shape& shape : grasp.model->links()[i].surface()) {
      for (int v = 0; v < shape.mesh_L.vertexCount(); ++v)
        points.emplace_back(X_WL[i] * shape.mesh_L.vertex(v));
    }
  }
  for (int v = 0; v < grasp.object_O->vertexCount(); ++v)
    points.emplace_back(grasp.X_WO * grasp.object_O->vertex(v));
  return Eigen::Map<const Eigen::Matrix3Xd>(points.front().data(), 3,
                                            static_cast<Eigen::Index>(points.size()));
}

Eigen::Matrix3Xd matrixOf(const FileMesh& mesh) {
  return Eigen::Map<const Eigen::Matrix3Xd>(mesh.vertices.front().data(), 3,
                                            static_cast<Eigen::Index>(mesh.vertices.size()));
}

double volumeOf(const FileMesh& mesh) {
  double six = 0.0;
  for (const auto& t : mesh.triangles)
    six += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]]));
  return six / 6.0;
}

TEST(GraspExport, ObjHoldsEveryVertexWhereForwardKinematicsPutsIt) {
  const PosedGrasp grasp = bentGrasp();
  const FileMesh read = readObj(write("grasp.obj", objText(grasp)));
  const Eigen::Matrix3Xd expected_W = verticesOf(grasp);
  ASSERT_EQ(read.vertices.size(), static_cast<std::size_t>(expected_W.cols()));
  EXPECT_LT((matrixOf(read) - expected_W).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_TRUE(read.notes.empty());
}

TEST(GraspExport, ObjHasAGroupForEachLinkAndTheObject) {
  const PosedGrasp grasp = bentGrasp();
  std::istringstream lines(objText(grasp));
  std::vector<std::string> groups;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("g ")) groups.push_back(line.substr(2));
  }
  std::vector<std::string> expected;
  for (const hand::Link& link : grasp.model->links())
    expected.push_back(link.name);
  expected.emplace_back("object_box,_\"red\"");
  EXPECT_EQ(groups, expected);
}

TEST(GraspExport, GlbHoldsTheSameSceneWithYUp) {
  const PosedGrasp grasp = bentGrasp();
  const FileMesh read = readScene(write("grasp.glb", glbBytes(grasp)));
  Eigen::Matrix3Xd expected = verticesOf(grasp);
  // x stays, z goes up along y, so y comes towards the viewer as -z.
  expected.row(1).swap(expected.row(2));
  expected.row(2) *= -1.0;
  ASSERT_EQ(read.vertices.size(), static_cast<std::size_t>(expected.cols()));
  EXPECT_LT((matrixOf(read) - expected).cwiseAbs().maxCoeff(), 1e-6) << "single precision";
}

TEST(GraspExport, MeshesKeepTheirInsides) {
  const PosedGrasp grasp = bentGrasp();
  const FileMesh obj = readObj(write("inside.obj", objText(grasp)));
  const FileMesh glb = readScene(write("inside.glb", glbBytes(grasp)));
  double expected = 0.0;
  for (const ScenePart& part : partsOf(grasp)) {
    for (int f = 0; f < part.mesh_P.faceCount(); ++f) {
      const Eigen::Vector3i t = part.mesh_P.face(f);
      expected += part.mesh_P.vertex(t[0]).dot(
                      part.mesh_P.vertex(t[1]).cross(part.mesh_P.vertex(t[2]))) /
                  6.0;
    }
  }
  ASSERT_GT(expected, 1e-5) << "the box alone has 1.2e-4 m3";
  EXPECT_NEAR(volumeOf(obj), expected, 1e-12);
  EXPECT_NEAR(volumeOf(glb), expected, 1e-8);
}

TEST(GraspExport, GlbNamesItsNodesAndKeepsItsLengths) {
  const std::string bytes = glbBytes(bentGrasp());
  const auto word = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof(value));
    return value;
  };
  ASSERT_EQ(word(8), bytes.size());
  const json document = json::parse(bytes.substr(20, word(12)));
  EXPECT_EQ(document["asset"]["version"], "2.0");
  EXPECT_EQ(document["nodes"].size(), 9u) << "the world, seven links and the object";
  EXPECT_EQ(document["nodes"][1]["name"], "palm");
  EXPECT_EQ(document["nodes"].back()["name"], "object box, \"red\"");
  EXPECT_EQ(document["materials"].size(), 2u);
  std::size_t end = 0;
  for (const json& view : document["bufferViews"]) {
    EXPECT_EQ(view["byteOffset"].get<std::size_t>() % 4, 0u);
    EXPECT_EQ(view["byteOffset"].get<std::size_t>(), end);
    end += view["byteLength"].get<std::size_t>();
  }
  EXPECT_EQ(document["buffers"][0]["byteLength"].get<std::size_t>(), end);
  EXPECT_EQ(20 + word(12) + 8 + end, bytes.size());
}

TEST(GraspExport, CsvHasTheJointsInOrderAndExactly) {
  PosedGrasp grasp = bentGrasp();
  std::istringstream lines(jointCsv(grasp));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "name,value,unit");
  const std::vector<std::string> names = grasp.model->dofNames();
  for (int dof = 0; dof < grasp.model->dofCount(); ++dof) {
    std::getline(lines, line);
    const std::size_t comma = line.find(',');
    EXPECT_EQ(line.substr(0, comma), names[static_cast<std::size_t>(dof)]);
    EXPECT_EQ(std::stod(line.substr(comma + 1)), grasp.pose.q[dof]) << line;
    EXPECT_TRUE(line.ends_with(",rad")) << line;
  }
  std::getline(lines, line);
  EXPECT_EQ(line, "X_WH.x,0.01,m");
}

TEST(GraspExport, CsvTellsFollowersBehindTheOthers) {
  std::vector<hand::Link> links{{"palm", {}, {}}, {"a", {}, {}}, {"b", {}, {}}};
  hand::Joint leader;
  leader.name = "leader, \"1\"";
  leader.type = hand::JointType::kRevolute;
  leader.parent_link = "palm";
  leader.child_link = "b";
  hand::Joint follower = leader;
  follower.name = "follower";
  follower.type = hand::JointType::kPrismatic;
  follower.child_link = "a";
  follower.mimic = hand::Mimic{leader.name, 0.5, 0.25};
  PosedGrasp grasp;
  grasp.model =
      std::make_shared<const hand::HandModel>("two", links, std::vector{follower, leader});
  grasp.pose.q = Eigen::VectorXd::Constant(1, 0.5);
  const std::string text = jointCsv(grasp);
  EXPECT_TRUE(text.starts_with(
      "name,value,unit\n\"leader, \"\"1\"\"\",0.5,rad\nfollower,0.5,m\nX_WH.x,"))
      << text;
}

TEST(GraspExport, ConfidenceIsTheShareOfPointsWithinFiveMillimetres) {
  optimize::SolveReport report;
  EXPECT_EQ(confidenceOf(report), 0.0);
  optimize::PatchFit fit;
  fit.point_count = 25;
  fit.within_5mm = 0.8;
  report.patches.push_back(fit);
  EXPECT_DOUBLE_EQ(confidenceOf(report), 0.8);
}

TEST(GraspExport, IsaacFileBringsTheHandBackToTheObject) {
  PosedGrasp grasp = bentGrasp();
  const Eigen::VectorXd before = 0.5 * grasp.pose.q;
  const std::string text = isaacGraspYaml(grasp, 0.8, before, {"it is not clear"});
  EXPECT_TRUE(text.ends_with("\n# note: it is not clear\n"));
  const YAML::Node file = YAML::Load(text);
  EXPECT_EQ(file["format"].as<std::string>(), "isaac_grasp");
  EXPECT_EQ(file["format_version"].as<double>(), 1.0);
  EXPECT_EQ(file["object_frame_link"].as<std::string>(), grasp.object);
  EXPECT_EQ(file["gripper_frame_link"].as<std::string>(), "palm");
  ASSERT_EQ(file["grasps"].size(), 1u);
  const YAML::Node one = file["grasps"].begin()->second;
  EXPECT_EQ(one["confidence"].as<double>(), 0.8);

  const auto p = one["position"].as<std::vector<double>>();
  const auto xyz = one["orientation"]["xyz"].as<std::vector<double>>();
  const Pose X_OH = poseFromQuaternion(
      {p[0], p[1], p[2]}, {one["orientation"]["w"].as<double>(), xyz[0], xyz[1], xyz[2]},
      "X_OH");
  const Pose X_WH = grasp.X_WO * X_OH;
  EXPECT_LT((X_WH.matrix() - grasp.pose.X_WH.matrix()).cwiseAbs().maxCoeff(), 1e-11);

  ASSERT_EQ(one["cspace_position"].size(), 6u);
  for (int dof = 0; dof < 6; ++dof) {
    const std::string name = grasp.model->dofJoint(dof).name;
    EXPECT_NEAR(one["cspace_position"][name].as<double>(), grasp.pose.q[dof], 1e-12);
    EXPECT_NEAR(one["pregrasp_cspace_position"][name].as<double>(), before[dof], 1e-12);
  }
}

TEST(GraspExport, IsaacFileHasNoExponents) {
  // PyYAML takes 1e-05 for text.
  const std::string text = isaacGraspYaml(bentGrasp(), 0.0, bentGrasp().model->restPose());
  EXPECT_NE(text.find("0.000010000000"), std::string::npos);
  EXPECT_EQ(text.find("e-"), std::string::npos) << text;
}

TEST(GraspExport, RowsAreOneFrameAtRestInTheWorld) {
  const PosedGrasp grasp = bentGrasp();
  const TrajectoryRows rows = rowsOf(grasp);
  const std::vector<JointValue> joints = jointValues(*grasp.model, grasp.pose.q);
  ASSERT_EQ(rows.qpos.cols(), 1);
  ASSERT_EQ(rows.qpos.rows(), 14 + static_cast<Eigen::Index>(joints.size()));
  EXPECT_EQ(rows.qvel.norm(), 0.0);
  EXPECT_EQ(rows.time_s, std::vector<double>{0.0});
  const auto pose = [&](Eigen::Index at) {
    const Eigen::VectorXd q = rows.qpos.col(0);
    return Eigen::Translation3d(q.segment<3>(at)) *
           Eigen::Quaterniond(q[at + 3], q[at + 4], q[at + 5], q[at + 6]);
  };
  EXPECT_TRUE(pose(0).isApprox(grasp.pose.X_WH, 1e-12));
  EXPECT_TRUE(pose(rows.qpos.rows() - 7).isApprox(grasp.X_WO, 1e-12));
  for (std::size_t i = 0; i < joints.size(); ++i) {
    EXPECT_EQ(rows.joint_names[i], joints[i].name);
    EXPECT_EQ(rows.qpos(7 + static_cast<Eigen::Index>(i), 0), joints[i].value);
  }
}

TEST(GraspExport, ContactsMustBeThoseOfAllRows) {
  const TrajectoryRows rows = rowsOf(bentGrasp());
  ContactRows contacts{{"index"}, {1.0}, {0.0, 0.1, 0.2}};
  const std::string bytes = npzOf(rows, contacts);
  for (const char* array : {"qpos.npy", "qvel.npy", "contact.npy", "contact_pos.npy"})
    EXPECT_NE(bytes.find(array), std::string::npos) << array;
  contacts.p_W_m.pop_back();
  EXPECT_THROW((void)npzOf(rows, contacts), BrokenContract);
}

}  // namespace
}  // namespace handgraft::io
