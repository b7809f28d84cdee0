// A problem file says exactly what was solved: reading it back and evaluating the objective at
// the pose that the grasp reports gives the terms that the grasp reports.

#include <fstream>

#include <gtest/gtest.h>

#include "core/io/problem_file.h"
#include "core/optimize/objective.h"

#include "tests/support/shared_data.h"
#include "tests/system/service.h"

namespace handgraft::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

hand::HandPose poseOf(const json& grasp, const hand::HandModel& model) {
  hand::HandPose pose;
  const auto p = grasp.at("X_WH").at("p_m").get<std::vector<double>>();
  const auto q = grasp.at("X_WH").at("q_wxyz").get<std::vector<double>>();
  pose.X_WH = poseFromQuaternion({p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}, "X_WH");
  pose.q.resize(model.dofCount());
  const std::vector<std::string> names = model.dofNames();
  for (int i = 0; i < model.dofCount(); ++i) {
    pose.q[i] = grasp.at("joints").at(names[static_cast<std::size_t>(i)]).get<double>();
  }
  return pose;
}

/// Of a solve by touch alone: the file has no term for penetration.
void expectExact(const json& grasp, const fs::path& problem_file) {
  const optimize::PoseProblem problem = io::readProblem(problem_file);
  optimize::Objective objective(problem);
  const optimize::Terms terms = objective.evaluate(poseOf(grasp, *problem.model));
  const json& reported = grasp.at("terms");
  EXPECT_NEAR(terms.distance, reported.at("distance_m2").get<double>(), 1e-12);
  EXPECT_NEAR(terms.normal, reported.at("normal").get<double>(), 1e-9);
  EXPECT_NEAR(terms.prior, reported.at("prior").get<double>(), 1e-9);
  EXPECT_NEAR(terms.objective, reported.at("objective").get<double>(), 1e-8);
}

TEST(ProblemExport, OfABuiltInHandIsExactAndBringsItsUrdf) {
  const Service service;
  const fs::path folder = scratchDirectory() / "export";
  fs::create_directories(folder);
  const fs::path file = folder / "problem.json";
  const json grasp = service.ask({"grasp", "--hand", "human20", "--object", "box", "--contacts",
                                  "box_5", "--touch-only", "--problem", file.string()});
  std::ifstream stream(file);
  const json document = json::parse(stream);
  EXPECT_EQ(document.at("format"), "handgraft-problem/1");
  EXPECT_TRUE(fs::path(document.at("hand").at("urdf").get<std::string>()).is_relative());
  EXPECT_EQ(document.at("dofs").size(), 26u);
  EXPECT_TRUE(document.at("lower").at(0).is_null()) << "the root is unbounded";
  expectExact(grasp, file);
}

TEST(ProblemExport, OfARealHandPointsToItsUrdf) {
  HANDGRAFT_NEEDS_SHARED_DATA("hands/mia_hand_right");
  const Service service;
  const fs::path file = scratchDirectory() / "mia.json";
  const json grasp = service.ask(
      {"grasp", "--hand",
       sharedData("hands/mia_hand_right/mia_hand_description/urdf/mia_hand.urdf").string(),
       "--object", "lemon", "--contacts", "lemon_6", "--touch-only", "--problem",
       file.string()});
  std::ifstream stream(file);
  const json document = json::parse(stream);
  EXPECT_EQ(document.at("dofs").size(), 10u) << "mimic joints are no dofs";
  EXPECT_TRUE(
      fs::exists(file.parent_path() / document.at("hand").at("urdf").get<std::string>()));
  const auto packages = document.at("hand").at("packages");
  ASSERT_TRUE(packages.contains("mia_hand_description"));
  EXPECT_TRUE(fs::path(packages.at("mia_hand_description").get<std::string>()).is_absolute());
  expectExact(grasp, file);
}

}  // namespace
}  // namespace handgraft::test
