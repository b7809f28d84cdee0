#include "tests/bench/motions/box_pull.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <vector>

#include <fmt/format.h>

#include "client/present/render/png_file.h"
#include "client/present/render/two_views.h"
#include "core/hand/finger_coordinates.h"
#include "core/io/contact_file.h"
#include "core/io/mesh_file.h"
#include "core/manipulation/lay_patches.h"
#include "core/manipulation/offline_solver.h"
#include "core/manipulation/patch_path.h"
#include "core/manipulation/two_grasps.h"
#include "core/placement/solids.h"

#include "tests/bench/chain_pair.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

namespace render = client::render;
using render::Color;

constexpr Color kHandColor{222, 190, 160};
constexpr Color kBoxColor{150, 170, 190};
constexpr std::array<Color, 6> kColors{{{214, 39, 40},
                                        {31, 119, 180},
                                        {44, 160, 44},
                                        {255, 127, 14},
                                        {148, 103, 189},
                                        {23, 190, 207}}};
constexpr int kWidth = 1200;
constexpr int kHeight = 560;  // of a frame
constexpr int kShown = 6;     // frames of a strip

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

render::SurfaceMesh surfaceOf(const geometry::TriangleMesh& mesh, const Pose& X, Color color) {
  render::SurfaceMesh result;
  result.color = color;
  for (int v = 0; v < mesh.vertexCount(); ++v)
    result.vertices_W.emplace_back((X * mesh.vertex(v)).cast<float>());
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    result.triangles.push_back({static_cast<std::uint32_t>(face[0]),
                                static_cast<std::uint32_t>(face[1]),
                                static_cast<std::uint32_t>(face[2])});
  }
  return result;
}

/// The hand at a frame, seen from the box, which therefore stands still.
render::Scene sceneAt(const hand::HandModel& model,
                      const hand::HandPose& pose,
                      const geometry::TriangleMesh& box_O,
                      const manipulation::Motion& motion,
                      int frame) {
  render::Layer hand_layer{0.86, {}, {}};
  const hand::LinkPoses X_OL = hand::forwardKinematics(model, pose);
  for (std::size_t i = 0; i < X_OL.size(); ++i)
    for (const hand::Shape& shape : model.links()[i].surface())
      hand_layer.meshes.push_back(surfaceOf(shape.mesh_L, X_OL[i], kHandColor));
  render::Layer box_layer{0.66, {surfaceOf(box_O, Pose::Identity(), kBoxColor)}, {}};
  for (std::size_t t = 0; t < motion.tracks.size(); ++t) {
    const manipulation::PatchTrack& track = motion.tracks[t];
    if (frame < track.begin() || frame >= track.end) continue;
    std::vector<Eigen::Vector3f> loop;
    for (const auto& point : track.keyAt(frame).patch.interpolation_boundary)
      loop.emplace_back(positionOf(box_O, point).cast<float>());
    box_layer.decals.push_back({loop, 0.006F, kColors[t % kColors.size()]});
  }
  render::Scene scene;
  scene.layers = {box_layer, hand_layer};
  return scene;
}

void drawStrip(const std::string& file,
               const hand::HandModel& model,
               const geometry::TriangleMesh& box_O,
               const manipulation::Motion& motion,
               const manipulation::Trajectory& trajectory,
               const std::vector<manipulation::FrameFit>& fits) {
  constexpr int kColumns = 2;
  render::Image whole(kColumns * kWidth, kShown / kColumns * kHeight);
  const auto views =
      render::viewsAllAround(sceneAt(model, trajectory.poses.front(), box_O, motion, 0));
  for (int i = 0; i < kShown; ++i) {
    const int frame = i * (motion.frameCount() - 1) / (kShown - 1);
    const auto index = static_cast<std::size_t>(frame);
    render::Caption caption;
    caption.title = fmt::format("{:.2f} s", motion.time_s[index]);
    caption.subtitle = fmt::format("{} points, {:.1f} mm, {:.0f} deg", fits[index].points,
                                   fits[index].mean_mm, fits[index].normal_deg);
    const render::Image part =
        render::renderTwoViews(sceneAt(model, trajectory.poses[index], box_O, motion, frame),
                               caption, views, {kWidth, kHeight});
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        whole.at(i % kColumns * kWidth + x, i / kColumns * kHeight + y) = part.at(x, y);
  }
  render::writePng(file, whole);
}

}  // namespace

void runBoxPull(const std::filesystem::path& models,
                const std::filesystem::path& cache,
                const std::string& picture,
                const manipulation::MotionOptions& options) {
  const io::MeshFile file = io::readMesh(models / "objects/box.obj");
  const auto box_O = std::make_shared<const geometry::TriangleMesh>(file.mesh);
  const contact::ContactSet first = io::readContacts(models / "contacts/box_5.json", file);
  const manipulation::Motion motion =
      manipulation::joinGrasps(*box_O, first, lastGrasp(*box_O, first), pathOfBox());
  std::printf(
      "| hand | frames | mean mm | normal deg | deepest mm | largest step rad | velocity | "
      "jerk "
      "| ms a frame |\n|---|---|---|---|---|---|---|---|---|\n");
  for (const std::string name : {"human20", "tendon16"}) {
    const hand::Hand hand = readHand(models / "hands" / name / (name + ".urdf"), cache);
    const hand::FingerCoordinates coordinates(*hand.model, *hand.skin, hand.sites);
    const manipulation::LaidMotion laid =
        manipulation::layPatches(motion, transfer::borrowedSurfaces(*box_O, *hand.skin),
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
    const auto fits = manipulation::fitFrames(problem, trajectory.poses);
    const manipulation::FrameFit fit = manipulation::meanFit(fits);
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
    if (picture.empty()) continue;
    std::filesystem::path strip = picture;
    strip.replace_filename(strip.stem().string() + "_" + name + ".png");
    drawStrip(strip.string(), *hand.model, *box_O, motion, trajectory, fits);
  }
}

}  // namespace handgraft::bench
