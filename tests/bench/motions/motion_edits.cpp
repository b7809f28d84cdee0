#include "tests/bench/motions/motion_edits.h"

#include <cstdio>
#include <memory>
#include <string>

#include "core/io/contact_file.h"
#include "core/io/mesh_file.h"
#include "core/manipulation/grasp_interpolation.h"
#include "core/retargeting/edited_motion.h"
#include "core/session/session.h"
#include "core/session/timed_edit.h"

#include "tests/bench/chain_pair.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

constexpr double kRate = 120.0;
constexpr double kEnd = 999.0 / kRate;  // s

/// Off the shelf, then turned.
std::vector<manipulation::ObjectKey> longPath() {
  manipulation::ObjectKey begin{0.0, Pose::Identity()};
  manipulation::ObjectKey middle{0.5 * kEnd, Pose::Identity()};
  middle.X_WO.translation() = Eigen::Vector3d(-0.25, 0.0, 0.02);
  manipulation::ObjectKey end{kEnd, Pose::Identity()};
  end.X_WO.linear() = rotationFromVector({0.0, 0.0, 1.0});
  end.X_WO.translation() = Eigen::Vector3d(-0.3, 0.1, -0.1);
  return {begin, middle, end};
}

}  // namespace

void runMotionEdits(const std::filesystem::path& models, const std::filesystem::path& cache) {
  const io::MeshFile file = io::readMesh(models / "objects/box.obj");
  const auto box_O = std::make_shared<const geometry::TriangleMesh>(file.mesh);
  const contact::ContactSet grasp = io::readContacts(models / "contacts/box_5.json", file);
  manipulation::TwoGraspOptions options;
  options.rate = kRate;
  const auto motion = std::make_shared<const manipulation::Motion>(
      manipulation::interpolateGrasps(*box_O, grasp, grasp, longPath(), options));
  std::printf("| hand | edit | frames anew | ms of the thread |\n|---|---|---|---|\n");
  for (const std::string name : {"human20", "tendon16"}) {
    const hand::Hand hand = readHand(models / "hands" / name / (name + ".urdf"), cache);
    session::Session opened(hand, box_O, retargeting::graspOf(*motion, *box_O),
                            Pose::Identity(), optimize::Weights());
    retargeting::EditedMotion bench(motion, box_O);
    const session::Models known{&hand, box_O, nullptr};
    session::Document document = opened.document();
    const auto solve = [&](const char* what) {
      int anew = 0;
      const double before = threadMilliseconds();
      const auto solved =
          bench.solve(document, hand, retargeting::motionSolving(false), 1, Progress(),
                      [&](const retargeting::SolvedMotion&, retargeting::FrameRange range) {
                        anew += range.end - range.first;
                      });
      std::printf("| %s | %s | %d of %d | %.0f |\n", name.c_str(), what, anew,
                  motion->frameCount(), threadMilliseconds() - before);
      std::fflush(stdout);
      return solved;
    };
    solve("none: from nothing");
    const session::Document first = document;
    const auto at = [&](double share, session::TimedChange change) {
      session::addTimed({{share * kEnd, 0.3}, std::move(change)}, known, document);
    };
    at(0.5, session::PatchWeightEdit{"index", 30.0});
    solve("a weight at a time, 0.3 s of falloff");
    const geometry::SurfacePoint root = grasp.patches[1].interpolation_boundary.front();
    at(0.8, session::PatchRootEdit{grasp.patches[1].name, session::Side::kObject, root});
    solve("a root at another time");
    document = first;
    solve("undone");
    document.patches[0].weight = 3.0;
    solve("a weight of all frames");
    document.joints[5].upper = 0.5 * (document.joints[5].lower + document.joints[5].upper);
    solve("a limit of all frames");
  }
}

}  // namespace handgraft::bench
