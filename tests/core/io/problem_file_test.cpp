#include "core/io/problem_file.h"

#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/shared_data.h"

namespace handgraft::io {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kUrdf = R"(<robot name="two">
  <link name="palm"/><link name="finger"/><link name="tip"/>
  <joint name="base" type="revolute"><parent link="palm"/><child link="finger"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="2" effort="1" velocity="1"/></joint>
  <joint name="slide" type="prismatic"><parent link="finger"/><child link="tip"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="0.1" effort="1" velocity="1"/></joint>
</robot>)";

// The dofs in an order of their own.
constexpr const char* kProblem = R"({"format":"handgraft-problem/1",
 "hand":{"urdf":"two.urdf","packages":{}},
 "dofs":["slide","root_rx","root_ry","root_rz","base","root_tx","root_ty","root_tz"],
 "start":[0.05,0.1,0.2,0.3,1.5,1,2,3],
 "prior":[0.01,0,0,7,0.5,4,5,6],
 "lower":[0,null,null,null,-0.5,-10,null,null],
 "upper":[0.08,null,null,null,1.75,null,20,null],
 "weights":{"distance":100,"normal":2,"prior":0.5},
 "prior_weights":[8,1,2,3,7,4,5,6],
 "locked":["base","root_tz"],
 "correspondences":[{"link":"tip","p_hand":[1,2,3],"n_hand":[0,0,1],"p_object":[4,5,6],
   "n_object":[0,1,0],"weight":0.25},
  {"link":"palm","p_hand":[0,0,0],"n_hand":[1,0,0],"p_object":[0,0,0],"n_object":[-1,0,0]}]})";

fs::path write(const std::string& name, const std::string& text) {
  const fs::path path = test::scratchDirectory() / name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

fs::path writeProblem(const std::string& text) {
  write("two.urdf", kUrdf);
  return write("problem.json", text);
}

std::string replaced(const std::string& from, const std::string& to) {
  std::string text = kProblem;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(ProblemFile, TakesDofsByNameInAnyOrder) {
  const ProblemFile file = readProblemFile(writeProblem(kProblem));
  const optimize::PoseProblem& p = file.problem;
  EXPECT_EQ(file.order, (std::vector<int>{7, 0, 1, 2, 6, 3, 4, 5}));
  EXPECT_EQ(p.start.q, Eigen::Vector2d(1.5, 0.05));
  EXPECT_EQ(p.start.X_WH.translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(p.start.X_WH.linear().isApprox(rotationFromVector({0.1, 0.2, 0.3}), 1e-15));
  EXPECT_EQ(p.prior.q, Eigen::Vector2d(0.5, 0.01));
  EXPECT_EQ(p.lower, Eigen::Vector2d(-0.5, 0.0));
  EXPECT_EQ(p.upper, Eigen::Vector2d(1.75, 0.08));
  EXPECT_EQ(p.root_lower[0], -10.0);
  EXPECT_EQ(p.root_upper[1], 20.0);
  EXPECT_EQ(p.root_upper[0], std::numeric_limits<double>::infinity());
  EXPECT_EQ(p.weights.distance, 100.0);
  EXPECT_EQ(p.prior_weights[7], 8.0);
  EXPECT_EQ(p.prior_weights[6], 7.0);
  EXPECT_TRUE(p.locked[6]);
  EXPECT_TRUE(p.locked[5]);
  EXPECT_FALSE(p.locked[7]);
  ASSERT_EQ(p.pairs.size(), 2U);
  EXPECT_EQ(p.pairs[0].weight, 0.25);
  EXPECT_EQ(p.pairs[1].weight, 1.0);
  EXPECT_EQ(p.model->links()[static_cast<std::size_t>(p.pairs[0].link)].name, "tip");
}

TEST(ProblemFile, AcceptsRotationVectorsOfAnyMagnitude) {
  const optimize::PoseProblem p = readProblem(writeProblem(kProblem));
  const Eigen::VectorXd theta = thetaOf(p.prior);
  EXPECT_NEAR(theta[2], 7.0 - 2.0 * std::numbers::pi, 1e-12);
}

TEST(ProblemFile, ReadsWhatItWroteToTheSameBits) {
  const optimize::PoseProblem before = readProblem(writeProblem(kProblem));
  const std::string text = problemText(before, "two.urdf", {{"two", "/somewhere"}});
  const optimize::PoseProblem after = readProblem(writeProblem(text));
  EXPECT_EQ(after.start.q, before.start.q);
  EXPECT_EQ(after.prior.X_WH.translation(), before.prior.X_WH.translation());
  EXPECT_TRUE(after.prior.X_WH.linear().isApprox(before.prior.X_WH.linear(), 1e-15));
  EXPECT_EQ(after.lower, before.lower);
  EXPECT_EQ(after.root_upper, before.root_upper);
  EXPECT_EQ(after.prior_weights, before.prior_weights);
  EXPECT_EQ(after.locked, before.locked);
  ASSERT_EQ(after.pairs.size(), before.pairs.size());
  for (std::size_t i = 0; i < after.pairs.size(); ++i) {
    EXPECT_EQ(after.pairs[i].p_W, before.pairs[i].p_W);
    EXPECT_EQ(after.pairs[i].n_L, before.pairs[i].n_L);
    EXPECT_EQ(after.pairs[i].weight, before.pairs[i].weight);
  }
}

TEST(ProblemFile, CarriesPairsWithoutNormals) {
  const std::string spelt = replaced(
      R"("n_hand":[1,0,0],"p_object":[0,0,0],"n_object":[-1,0,0])", R"("p_object":[0,0,0])");
  const optimize::PoseProblem before = readProblem(writeProblem(spelt));
  ASSERT_EQ(before.pairs.size(), 2u);
  EXPECT_TRUE(before.pairs[0].has_normals);
  EXPECT_FALSE(before.pairs[1].has_normals);
  const std::string text = problemText(before, "two.urdf", {});
  const optimize::PoseProblem after = readProblem(writeProblem(text));
  EXPECT_FALSE(after.pairs[1].has_normals);
  EXPECT_THROW(readProblem(writeProblem(replaced(R"("n_object":[-1,0,0])", R"("weight":1)"))),
               InvalidInput)
      << "one normal of two";
}

TEST(ProblemFile, CarriesTheFormOfTheNormalsWhereItIsNotThePapers) {
  optimize::PoseProblem problem = readProblem(writeProblem(kProblem));
  EXPECT_EQ(problem.normal_form, optimize::NormalForm::kCosine);
  EXPECT_THAT(problemText(problem, "two.urdf", {}), Not(HasSubstr("normal_form")));
  problem.normal_form = optimize::NormalForm::kSum;
  const optimize::PoseProblem after =
      readProblem(writeProblem(problemText(problem, "two.urdf", {})));
  EXPECT_EQ(after.normal_form, optimize::NormalForm::kSum);
  const std::string spelt =
      replaced("\"prior_weights\"", "\"normal_form\":\"cosine\",\"prior_weights\"");
  EXPECT_EQ(readProblem(writeProblem(spelt)).normal_form, optimize::NormalForm::kCosine);
}

TEST(ProblemFile, ReadsItsOwnNotes) {
  const optimize::PoseProblem problem = readProblem(writeProblem(kProblem));
  const std::string text = problemText(problem, "two.urdf", {}, {"depth was charged, too"});
  EXPECT_THAT(text, HasSubstr("\"notes\":[\"depth was charged, too\"]"));
  EXPECT_EQ(readProblem(writeProblem(text)).pairs.size(), problem.pairs.size());
}

struct Fault {
  const char* name;
  const char* from;
  const char* to;
  const char* message;
};

class DamagedProblem : public testing::TestWithParam<Fault> {};

TEST_P(DamagedProblem, NamesFileAndField) {
  const fs::path path = writeProblem(replaced(GetParam().from, GetParam().to));
  try {
    readProblem(path);
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr(path.string()));
    EXPECT_THAT(error.what(), testing::HasSubstr(GetParam().message));
    EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("\n")));
  }
}

INSTANTIATE_TEST_SUITE_P(
    ProblemFile,
    DamagedProblem,
    testing::Values(
        Fault{"NotJson", "\"format\"", "\"format", "not JSON"},
        Fault{"OtherFormat", "problem/1", "problem/2", "handgraft-problem/2"},
        Fault{"MissingUrdf", "two.urdf", "three.urdf", "three.urdf"},
        Fault{"UnknownJoint", "\"slide\"", "\"slip\"", "'slip'"},
        Fault{"TwiceNamed", "\"root_rx\"", "\"root_ry\"", "twice"},
        Fault{"MissingDof", "\"slide\",", "", "lacks 'slide'"},
        Fault{"ShortStart", "[0.05,0.1,", "[0.1,", "'start'"},
        Fault{"TextInPrior", "[0.01,0,0,7", "[0.01,\"x\",0,7", "'prior[1]'"},
        Fault{"NullInStart", "[0.05,", "[null,", "'start[0]'"},
        Fault{"NanInStart", "[0.05,", "[NaN,", "not JSON"},
        Fault{"HugeNumber", "[0.05,", "[1e999,", "not JSON"},
        Fault{"RotationBound", "[0,null,", "[0,-1,", "'lower[1]'"},
        Fault{"StartOutside", "0.05,0.1,", "0.09,0.1,", "slide"},
        Fault{"NoWeights", "\"weights\":{\"distance\":100,\"normal\":2,\"prior\":0.5},", "",
              "'weights'"},
        Fault{"MisspeltWeights", "\"weights\"", "\"wights\"",
              "field 'wights' is unknown; permitted are format hand"},
        Fault{"UnknownNormalForm", "\"prior_weights\"",
              "\"normal_form\":\"sine\",\"prior_weights\"", "'normal_form': is 'sine'"},
        Fault{"NotesOfNoText", "\"prior_weights\"", "\"notes\":[3],\"prior_weights\"",
              "'notes[0]'"},
        Fault{"MisspeltOption", "\"prior_weights\"", "\"prior_weight\"", "'prior_weight'"},
        Fault{"MisspeltInWeights", "\"normal\":2", "\"normal\":2,\"normals\":3",
              "'weights': field 'normals'"},
        Fault{"MisspeltInHand", "\"packages\"", "\"package\"", "'hand': field 'package'"},
        Fault{"MisspeltInPair", "\"weight\":0.25", "\"wieght\":0.25",
              "'correspondences[0]': field 'wieght' is unknown; permitted are link p_hand "
              "n_hand p_object n_object weight"},
        Fault{"NegativeWeight", "\"normal\":2", "\"normal\":-2", "weights.normal"},
        Fault{"UnknownLink", "\"tip\"", "\"tap\"", "'tap'"},
        Fault{"LongNormal", "[0,0,1]", "[0,0,1.1]", "correspondences[0].n_hand"},
        Fault{"TwoCoordinates", "[4,5,6]", "[4,5]", "correspondences[0].p_object"},
        Fault{"UnknownLock", "\"base\",\"root_tz\"]", "\"bass\"]", "'bass'"},
        Fault{"ListOfNothing", "[-1,0,0]}]}", "[-1,0,0]}],\"correspondences\":3}",
              "'correspondences'"}),
    [](const auto& test) {
      return test.param.name;
    });

TEST(ProblemFile, RefusesFilesThatAreNone) {
  EXPECT_THROW(readProblem(test::scratchDirectory()), InvalidInput);
  EXPECT_THROW(readProblem(test::scratchDirectory() / "absent.json"), InvalidInput);
  EXPECT_THROW(readProblem(writeProblem("[]")), InvalidInput);
  EXPECT_THROW(readProblem(writeProblem("")), InvalidInput);
}

TEST(ProblemFile, DeepNestingIsAnErrorAndNoCrash) {
  EXPECT_THROW(readProblem(writeProblem(std::string(1000000, '['))), InvalidInput);
}

TEST(ProblemFile, ReadsTheRealProblems) {
  HANDGRAFT_NEEDS_SHARED_DATA("problems");
  int count = 0;
  for (const auto& entry : fs::directory_iterator(test::sharedData("problems"))) {
    const fs::path& path = entry.path();
    if (path.extension() != ".json" || path.stem() == "reference") continue;
    EXPECT_GE(readProblem(path).pairs.size(), 12U) << path;
    ++count;
  }
  EXPECT_EQ(count, 27);
}

}  // namespace
}  // namespace handgraft::io
