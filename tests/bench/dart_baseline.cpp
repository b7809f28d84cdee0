#include "tests/bench/dart_baseline.h"

#include <fstream>
#include <limits>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <vector>

#include <dart/dart.hpp>
#include <dart/utils/urdf/urdf.hpp>
#include <nlopt.h>

#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

constexpr int kMostSteps = 1000;

/// The URDF without its shapes, its root floating whatever its name.
std::string kinematicsText(const std::filesystem::path& path) {
  std::ifstream stream(path);
  std::stringstream text;
  text << stream.rdbuf();
  const std::regex shapes("<(visual|collision)[^>]*>[^]*?</\\1>|<(visual|collision)[^>]*/>");
  const std::string bare = std::regex_replace(text.str(), shapes, "");
  return std::regex_replace(bare, std::regex("\"world\""), "\"floating_world\"");
}

}  // namespace

struct DartBaseline::Parts {
  const optimize::PoseProblem& problem;
  dart::dynamics::SkeletonPtr skeleton;
  std::vector<const dart::dynamics::BodyNode*> bodies;  ///< per pair
  std::vector<std::size_t> indices;  ///< DART's number of each of the hand's dofs
  Eigen::VectorXd positions;
  int evaluations = 0;
  int steps = 0;
  double scale = 1.0;

  double evaluate(const double* x) {
    ++evaluations;
    positions.head<6>() = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(x);
    for (std::size_t j = 0; j < indices.size(); ++j)
      positions[static_cast<Eigen::Index>(indices[j])] = x[6 + j];
    skeleton->setPositions(positions);
    double distance = 0.0;
    double normal = 0.0;
    const dart::dynamics::BodyNode* last = nullptr;
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    for (std::size_t i = 0; i < problem.pairs.size(); ++i) {
      const optimize::PointPair& pair = problem.pairs[i];
      if (bodies[i] != last) X = bodies[i]->getWorldTransform();
      last = bodies[i];
      const double miss = 1.0 + (X.linear() * pair.n_L).dot(pair.n_W);
      distance += pair.weight * (X * pair.p_L - pair.p_W).squaredNorm();
      normal += pair.weight * miss * miss;
    }
    const Eigen::Isometry3d X_WH = skeleton->getRootBodyNode()->getWorldTransform();
    const Eigen::Matrix3d turn = problem.prior.X_WH.linear().transpose() * X_WH.linear();
    double prior = dart::math::logMap(turn).squaredNorm();
    prior += (X_WH.translation() - problem.prior.X_WH.translation()).squaredNorm();
    for (std::size_t j = 0; j < indices.size(); ++j) {
      const double difference = x[6 + j] - problem.prior.q[static_cast<Eigen::Index>(j)];
      prior += difference * difference;
    }
    return problem.weights.distance * distance + problem.weights.normal * normal +
           problem.weights.prior * prior;
  }

  static double sample(unsigned count, const double* x, double* gradient, void* data) {
    Parts& parts = *static_cast<Parts*>(data);
    ++parts.steps;
    const double value = parts.scale * parts.evaluate(x);
    if (gradient == nullptr) return value;
    constexpr double kStep = 1e-7;  // about the root of a double's rounding
    std::vector<double> near(x, x + count);
    for (unsigned i = 0; i < count; ++i) {
      near[i] = x[i] + kStep;
      gradient[i] = (parts.scale * parts.evaluate(near.data()) - value) / kStep;
      near[i] = x[i];
    }
    return value;
  }
};

DartBaseline::DartBaseline(const optimize::PoseProblem& problem,
                           const std::filesystem::path& urdf)
    : parts_(new Parts{problem, nullptr, {}, {}, {}}) {
  dart::utils::DartLoader loader;
  parts_->skeleton = loader.parseSkeletonString(kinematicsText(urdf), urdf.string());
  if (parts_->skeleton == nullptr)
    throw std::runtime_error("DART cannot read " + urdf.string());
  for (const optimize::PointPair& pair : problem.pairs) {
    const std::string& name = problem.model->links()[static_cast<std::size_t>(pair.link)].name;
    parts_->bodies.push_back(
        parts_->skeleton->getBodyNode(name == "world" ? "floating_world" : name));
  }
  for (int j = 0; j < problem.model->dofCount(); ++j) {
    const auto* joint = parts_->skeleton->getJoint(problem.model->dofJoint(j).name);
    if (joint == nullptr) throw std::runtime_error("DART lacks a joint of " + urdf.string());
    parts_->indices.push_back(joint->getIndexInSkeleton(0));
  }
  parts_->positions = parts_->skeleton->getPositions();
}

DartBaseline::~DartBaseline() = default;

BaselineRun DartBaseline::solve(BaselineSolver solver, double tolerance) {
  Parts& parts = *parts_;
  const optimize::PoseProblem& problem = parts.problem;
  const auto count = static_cast<unsigned>(problem.dofCount());
  parts.evaluations = 0;
  parts.steps = 0;
  parts.scale = solver == BaselineSolver::kSlsqp ? 0.01 : 1.0;

  // === The start, and bounds
  std::vector<double> x(count);
  std::vector<double> lower(count, -std::numeric_limits<double>::infinity());
  std::vector<double> upper(count, std::numeric_limits<double>::infinity());
  Eigen::Map<Eigen::Matrix<double, 6, 1>>(x.data()) =
      dart::dynamics::FreeJoint::convertToPositions(problem.start.X_WH);
  for (std::size_t j = 0; j < parts.indices.size(); ++j) {
    const auto dof = static_cast<Eigen::Index>(j);
    lower[6 + j] = problem.lower[dof];
    upper[6 + j] = problem.upper[dof];
    x[6 + j] = std::clamp(problem.start.q[dof], lower[6 + j], upper[6 + j]);
  }

  const std::unique_ptr<nlopt_opt_s, decltype(&nlopt_destroy)> handle(
      nlopt_create(solver == BaselineSolver::kMma ? NLOPT_LD_MMA : NLOPT_LD_SLSQP, count),
      &nlopt_destroy);
  nlopt_set_min_objective(handle.get(), Parts::sample, &parts);
  nlopt_set_lower_bounds(handle.get(), lower.data());
  nlopt_set_upper_bounds(handle.get(), upper.data());
  nlopt_set_ftol_rel(handle.get(), tolerance);
  nlopt_set_maxeval(handle.get(), kMostSteps);
  double value = 0.0;
  BaselineRun run;
  const double start = threadMilliseconds();
  nlopt_optimize(handle.get(), x.data(), &value);
  run.ms = threadMilliseconds() - start;

  parts.evaluate(x.data());
  run.pose.X_WH = parts.skeleton->getRootBodyNode()->getWorldTransform();
  run.pose.q = Eigen::Map<const Eigen::VectorXd>(x.data() + 6, problem.model->dofCount());
  run.steps = parts.steps;
  run.evaluations = parts.evaluations;
  return run;
}

}  // namespace handgraft::bench
