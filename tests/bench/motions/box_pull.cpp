#include "tests/bench/motions/box_pull.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "core/hand/finger_coordinates.h"
#include "core/io/contact_file.h"
#include "core/io/mesh_file.h"
#include "core/manipulation/grasp_interpolation.h"
#include "core/manipulation/offline_solver.h"
#include "core/manipulation/patch_path.h"
#include "core/manipulation/transfer_patches.h"
#include "core/placement/solids.h"

#include "tests/bench/chain_pair.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

/// Pulled 25 cm off the shelf, turned, put down lower.
std::vector<manipulation::ObjectKey> pathOfBox() {
  const auto key = [](double time_s, const Eigen::Vector3d& p, const Eigen::Vector3d& turn) {
    manipulation::ObjectKey result{time_s, Pose::Identity()};
    result.X_WO.linear() = rotationFromVector(turn);
    result.X_WO.translation() = p;
    return result;
  };
  return {key(0.0, {0.0, 0.0, 0.3}, {0, 0, 0}), key(1.0, {-0.25, 0.0, 0.32}, {0, 0, 0}),
          key(2.0, {-0.3, 0.1, 0.2}, {0, 0, 1.0}), key(2.5, {-0.3, 0.1, 0.1}, {0, 0, 1.0})};
}

/// Index and middle slide 12 mm along, the little finger lets go.
contact::ContactSet lastGrasp(const geometry::TriangleMesh& box_O,
                              const contact::ContactSet& first) {
  contact::ContactSet last = first;
  std::erase_if(last.patches, [](const contact::Patch& patch) {
    return patch.name == "little";
  });
  for (contact::Patch& patch : last.patches)
    if (patch.name == "index" || patch.name == "middle")
      patch = manipulation::slid(box_O, patch, {-0.012, 0.0});
  return last;
}

}  // namespace

void runBoxPull(const std::filesystem::path& models,
                const std::filesystem::path& cache,
                const manipulation::MotionOptions& options) {
  const io::MeshFile file = io::readMesh(models / "objects/box.obj");
  const auto box_O = std::make_shared<const geometry::TriangleMesh>(file.mesh);
  const contact::ContactSet first = io::readContacts(models / "contacts/box_5.json", file);
  const manipulation::Motion motion =
      manipulation::interpolateGrasps(*box_O, first, lastGrasp(*box_O, first), pathOfBox());
  std::printf(
      "| hand | frames | mean mm | normal deg | deepest mm | largest step rad | velocity | "
      "jerk "
      "| ms a frame |\n|---|---|---|---|---|---|---|---|---|\n");
  for (const std::string name : {"human20", "tendon16"}) {
    const hand::Hand hand = readHand(models / "hands" / name / (name + ".urdf"), cache);
    const hand::FingerCoordinates coordinates(*hand.model, *hand.skin, hand.sites);
    const manipulation::TransferredMotion laid =
        manipulation::transferPatches(motion, transfer::borrowedSurfaces(*box_O, *hand.skin),
                                      *hand.model, hand.sites, coordinates, {}, Progress());
    manipulation::MotionProblem problem =
        manipulation::makeMotionProblem(hand.model, motion.time_s);
    problem.tracks = laid.tracks;
    problem.avoidance =
        placement::avoidanceOf(hand.model, hand.skin, box_O, Pose::Identity(), Progress());
    const double before = threadMilliseconds();
    const manipulation::Trajectory trajectory =
        manipulation::solveOffline(problem, options, Progress());
    const double ms = (threadMilliseconds() - before) / motion.frameCount();
    const manipulation::FrameFit fit =
        manipulation::meanFit(manipulation::fitFrames(problem, trajectory.poses));
    const manipulation::Smoothness smoothness =
        manipulation::measureSmoothness(problem, trajectory.poses);
    double depth = 0.0;
    for (const hand::HandPose& pose : trajectory.poses) {
      depth = std::max(depth, placement::penetrationOf(hand.model, hand.skin, box_O,
                                                       Pose::Identity(), pose, {}, Progress())
                                  .max_depth_m);
    }
    std::printf("| %s | %d | %.2f | %.1f | %.2f | %.4f | %.2f | %.0f | %.2f |\n", name.c_str(),
                motion.frameCount(), fit.mean_mm, fit.normal_deg, 1e3 * depth,
                smoothness.max_step, smoothness.max_velocity, smoothness.rms_jerk, ms);
    for (const std::string& note : laid.notes)
      std::printf("%s: %s\n", name.c_str(), note.c_str());
  }
}

}  // namespace handgraft::bench
