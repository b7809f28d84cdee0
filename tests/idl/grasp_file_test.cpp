// handgraft-grasp/1: positions and poses by name, exact.
#include "idl/grasp_file.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace handgraft {
namespace {

v1::PoseSolution solved() {
  v1::PoseSolution solution;
  solution.joint_positions() = {0.1, 1.0 / 3.0};
  solution.X_WL().resize(2);
  solution.X_WL()[1].p_m({0.1, 0.2, 1.0 / 7.0});
  solution.terms().objective(1.25);
  solution.outcome(v1::OUTCOME_CONVERGED);
  solution.minima().resize(1);
  solution.minima()[0].joint_positions() = {0.5, 0.25};
  return solution;
}

TEST(GraspFile, IsAPoseThatGivesTheSameBitsBack) {
  const auto file = nlohmann::json::parse(idl::graspText(
      {"claw", "ball", "marks", {"bend", "slide"}, {"palm", "tip"}}, solved(), {}));
  EXPECT_EQ(file["format"], "handgraft-grasp/1");
  EXPECT_EQ(file["hand"], "claw");
  EXPECT_EQ(file["object"], "ball");
  EXPECT_EQ(file["contacts"], "marks");
  EXPECT_EQ(file["joints"]["slide"], 1.0 / 3.0);
  EXPECT_EQ(file["links_X_WL"]["tip"]["p_m"][2], 1.0 / 7.0);
  EXPECT_EQ(file["minima"][0]["joints"]["bend"], 0.5);
}

TEST(GraspFile, TellsAllElseOfTheSolution) {
  const idl::Json file =
      idl::graspFile({"claw", "ball", "marks", {"bend", "slide"}, {}}, solved(), {});
  EXPECT_EQ(file["outcome"], "converged");
  EXPECT_EQ(file["terms"]["objective"], 1.25);
  for (const idl::Field& field : idl::typeOf<v1::PoseSolution>().fields) {
    const bool by_name = std::string_view(field.name) == "joint_positions" ||
                         std::string_view(field.name) == "X_WL";
    EXPECT_EQ(file.contains(field.name), !by_name) << field.name;
  }
}

TEST(GraspFile, HasTermsThatAddUpToTheObjective) {
  v1::PoseSolution solution = solved();
  v1::Terms terms;
  terms.distance_m2(0.01);
  terms.normal(2.0);
  terms.prior(250.0);
  terms.objective(103.0);  // 0.75 of it for depth
  solution.terms(terms);
  solution.minima()[0].terms(terms);
  v1::Weights weights;
  weights.distance(1e4);
  weights.normal(1.0);
  weights.prior(1e-3);
  const idl::Json file = idl::graspFile({"", "", "", {}, {}, weights}, solution, {});
  EXPECT_NEAR(file["terms"]["penetration"].get<double>(), 0.75, 1e-12);
  EXPECT_NEAR(file["minima"][0]["terms"]["penetration"].get<double>(), 0.75, 1e-12);
  EXPECT_EQ(file["weights"]["distance"], 1e4);
  terms.objective(102.25 * (1.0 + 1e-15));  // rounding is no depth
  EXPECT_EQ(idl::penetrationCharge(terms, weights), 0.0);
  EXPECT_FALSE(idl::graspFile({}, solution, {})["terms"].contains("penetration"));
}

TEST(GraspFile, TellsWhatBecameOfEachPatchDroppedOnesToo) {
  v1::PoseSolution solution = solved();
  solution.patches().resize(1);
  solution.patches()[0].name("thumb");
  solution.patches()[0].diagnosis().text("too far");
  std::vector<v1::PatchReport> reports(2);
  reports[0].name("thumb");
  reports[0].placed(true);
  reports[0].boundary_count(7);
  reports[1].name("ring");
  reports[1].reason("the hand has no ring finger");
  const idl::Json patches = idl::graspFile({}, solution, reports)["patches"];
  ASSERT_EQ(patches.size(), 2U);
  EXPECT_EQ(patches[0]["diagnosis"]["text"], "too far");
  EXPECT_EQ(patches[0]["boundary_count"], 7);
  EXPECT_EQ(patches[1]["reason"], "the hand has no ring finger");
}

}  // namespace
}  // namespace handgraft
