/// The core without a server: a hand is read, told where four of its points shall be, and
/// solved for the pose that brings them there. Takes the hand's URDF and a mesh, and prints how
/// far the points are off and how long a way on the mesh is.

#include <cstdio>
#include <exception>
#include <memory>

#include <handgraft/core.h>

namespace geometry = handgraft::geometry;
namespace hand = handgraft::hand;
namespace io = handgraft::io;
namespace optimize = handgraft::optimize;

namespace {

/// Pairs each moving link's frame, and a normal along its x axis, with where they are in
/// `goal`.
optimize::PoseProblem problemThatReaches(const std::shared_ptr<const hand::HandModel>& model,
                                         const hand::HandPose& goal) {
  optimize::PoseProblem problem = optimize::makeProblem(model);
  const hand::LinkPoses X_WL = hand::forwardKinematics(*model, goal);
  for (std::size_t link = 0; link < X_WL.size(); ++link) {
    optimize::PointPair pair;
    pair.link = static_cast<int>(link);
    pair.p_L = {0.0, 0.0, 0.01};
    pair.n_L = Eigen::Vector3d::UnitX();
    pair.p_W = X_WL[link] * pair.p_L;
    pair.n_W = -(X_WL[link].linear() * pair.n_L);  // contact is face to face
    pair.patch = 0;
    problem.pairs.push_back(pair);
  }
  return problem;
}

}  // namespace

namespace {

int run(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: %s HAND.urdf OBJECT.obj\n", argv[0]);
    return 2;
  }
  // A pose to find again: the root turned and moved, each joint a third up its range.
  const auto model = std::make_shared<hand::HandModel>(io::readUrdfKinematics(argv[1]));
  const optimize::PoseProblem empty = optimize::makeProblem(model);
  hand::HandPose goal = empty.start;
  goal.q = empty.lower + (empty.upper - empty.lower) / 3.0;
  goal.X_WH.translation() = Eigen::Vector3d(0.1, -0.2, 0.3);
  goal.X_WH.rotate(Eigen::AngleAxisd(1.0, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()));

  const optimize::PoseProblem problem = problemThatReaches(model, goal);
  const optimize::SolveReport report = optimize::solve(problem, {}, handgraft::Progress());
  std::printf("%d joints, %zu pairs: %s, %.3f mm off, joints %.2g rad off\n", model->dofCount(),
              problem.pairs.size(), std::string(optimize::nameOf(report.outcome)).c_str(),
              report.patches.at(0).mean_mm, (report.pose.q - goal.q).cwiseAbs().maxCoeff());

  // How far it is, along an object's surface, to what lies within 20 mm of its first vertex.
  const geometry::TriangleMesh mesh = io::readMesh(argv[2]).mesh;
  const geometry::LogMap map = geometry::computeLogMap(
      mesh, geometry::surfacePointAtVertex(mesh, 0), Eigen::Vector3d(0.3, 0.5, 0.8), 0.02,
      geometry::LogMapMethod::kFast);
  std::printf("%zu vertices within 20 mm, the last at %.1f mm\n", map.vertices.size(),
              1e3 * map.r[map.vertices.back()]);
  return report.patches.at(0).mean_mm < 0.1 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
