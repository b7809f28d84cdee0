// Objective and link poses against DART, which shares no code with ours but Eigen.

#include <fstream>
#include <regex>
#include <sstream>

#include <dart/dart.hpp>
#include <dart/utils/urdf/urdf.hpp>
#include <gtest/gtest.h>

#include "core/io/urdf_file.h"
#include "core/optimize/objective.h"

#include "tests/core/optimize/problems.h"
#include "tests/support/shared_data.h"

namespace handgraft::optimize {
namespace {

/// The URDF without its shapes: DART would look for their meshes.
std::string kinematicsText(const std::filesystem::path& path) {
  std::ifstream stream(path);
  std::stringstream text;
  text << stream.rdbuf();
  const std::regex shapes("<(visual|collision)[^>]*>[^]*?</\\1>|<(visual|collision)[^>]*/>");
  const std::string bare = std::regex_replace(text.str(), shapes, "");
  // DART nails a root of the name "world" (MANO's) to the world, instead of letting it float.
  return std::regex_replace(bare, std::regex("\"world\""), "\"floating_world\"");
}

const dart::dynamics::BodyNode* bodyOf(const dart::dynamics::Skeleton& skeleton,
                                       const hand::HandModel& model,
                                       int link) {
  const std::string& name = model.links()[static_cast<std::size_t>(link)].name;
  return skeleton.getBodyNode(name == "world" ? "floating_world" : name);
}

/// DART puts a free joint of its own above the root.
void place(dart::dynamics::Skeleton& skeleton,
           const hand::HandModel& model,
           const hand::HandPose& pose) {
  auto* root = dynamic_cast<dart::dynamics::FreeJoint*>(skeleton.getRootJoint());
  ASSERT_NE(root, nullptr);
  root->setPositions(dart::dynamics::FreeJoint::convertToPositions(pose.X_WH));
  for (int j = 0; j < model.dofCount(); ++j) {
    auto* joint = skeleton.getJoint(model.dofJoint(j).name);
    ASSERT_NE(joint, nullptr) << model.dofJoint(j).name;
    joint->setPosition(0, pose.q[j]);
  }
}

/// Eq. 2-5 from DART's link poses and its own logarithm.
double objectiveByDart(const PoseProblem& problem,
                       dart::dynamics::Skeleton& skeleton,
                       const hand::HandPose& pose) {
  double distance = 0.0;
  double normal = 0.0;
  for (const PointPair& pair : problem.pairs) {
    const Eigen::Isometry3d X =
        bodyOf(skeleton, *problem.model, pair.link)->getWorldTransform();
    const double miss = 1.0 + (X.linear() * pair.n_L).dot(pair.n_W);
    distance += pair.weight * (X * pair.p_L - pair.p_W).squaredNorm();
    normal += pair.weight * miss * miss;
  }
  const Eigen::Matrix3d turn = problem.prior.X_WH.linear().transpose() * pose.X_WH.linear();
  const Eigen::VectorXd& w = problem.prior_weights;
  double prior = w.head<3>().mean() * dart::math::logMap(turn).squaredNorm();
  const Eigen::Vector3d shift = pose.X_WH.translation() - problem.prior.X_WH.translation();
  prior += w.segment<3>(3).dot(shift.cwiseAbs2());
  prior += w.tail(pose.q.size()).dot((pose.q - problem.prior.q).cwiseAbs2());
  return problem.weights.distance * distance + problem.weights.normal * normal +
         problem.weights.prior * prior;
}

TEST(Objective, AgreesWithDartOnHandsWithoutMimicJoints) {
  HANDGRAFT_NEEDS_SHARED_DATA("hands");
  std::mt19937 random(21);
  int hands = 0;
  for (const std::string& file : test::realHands()) {
    const std::filesystem::path path = test::sharedData(file);
    const auto model = std::make_shared<const hand::HandModel>(io::readUrdfKinematics(path));
    if (model->mimicCount() > 0) continue;
    dart::utils::DartLoader loader;
    const auto skeleton = loader.parseSkeletonString(kinematicsText(path), path.string());
    ASSERT_NE(skeleton, nullptr) << file;
    const PoseProblem problem = test::randomProblem(model, 80, random);
    Objective objective(problem);
    for (int k = 0; k < 30; ++k) {
      const hand::HandPose pose = test::randomPose(*model, random);
      place(*skeleton, *model, pose);
      const hand::LinkPoses X_WL = forwardKinematics(*model, pose);
      for (int link = 0; link < model->linkCount(); ++link) {
        const auto index = static_cast<std::size_t>(link);
        const auto* body = bodyOf(*skeleton, *model, link);
        ASSERT_NE(body, nullptr);
        const Eigen::Matrix4d expected = body->getWorldTransform().matrix();
        EXPECT_LE((X_WL[index].matrix() - expected).cwiseAbs().maxCoeff(), 1e-9) << file;
      }
      const double expected = objectiveByDart(problem, *skeleton, pose);
      EXPECT_NEAR(objective.evaluate(pose).objective, expected, 1e-9 * expected) << file;
    }
    ++hands;
  }
  EXPECT_GE(hands, 5);
}

}  // namespace
}  // namespace handgraft::optimize
