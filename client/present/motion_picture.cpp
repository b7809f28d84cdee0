#include "client/present/motion_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "client/link/model_files.h"
#include "client/link/wire_pose.h"
#include "client/present/joint_unit.h"
#include "client/present/picture_parts.h"
#include "client/present/render/plot.h"
#include "client/present/render/two_views.h"
#include "client/present/text_output.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

using render::Color;

constexpr int kColumns = 2;
constexpr render::PictureSize kTile{1000, 620};
constexpr double kPanelHeight = 185.0;  // pixels of a panel of height 1
constexpr double kRoomForNames = 1.2;   // of what they take: they lie nearer to their lines
constexpr int kAboutPanels = 420;       // pixels: headings, gaps and labels of the plot
constexpr double kMostShade = 0.9;      // of a finger's first and last joint
constexpr double kMotionHandOpacity = 0.72;
constexpr double kMotionObjectOpacity = 0.66;  // patches behind it shine through
constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kFewestOfAnArea = 3;
constexpr float kPointRadius = 6.0F;  // pixels
constexpr float kPointLine = 2.0F;
constexpr Color kDark{24, 28, 34};
constexpr Color kItself{150, 156, 165};

/// Recorded points: a dot on the object each, and the way from there to its place on the hand.
void addPoints(render::Scene& scene,
               const std::vector<Eigen::Vector3f>& on_object_W,
               const std::vector<Eigen::Vector3f>& on_hand_W,
               Color color) {
  for (std::size_t i = 0; i < on_object_W.size(); ++i) {
    if (i < on_hand_W.size())
      addCasedLine(scene, on_object_W[i], on_hand_W[i], kPointLine, color);
    addDot(scene, on_object_W[i], kPointRadius, color);
  }
}

/// The hand at the object, which stands in the middle.
render::Scene sceneOf(const MotionResult& result,
                      const v1::MotionFrame& frame,
                      const v1::HandDescription& hand,
                      const v1::ObjectDescription& object) {
  if (frame.X_WL().size() != hand.links().size())
    throw TransportError(fmt::format("frame {} has {} links; the hand has {}", frame.index(),
                                     frame.X_WL().size(), hand.links().size()));
  Pose X_WO = poseOf(frame.X_WO());
  const Eigen::Vector3d middle_W = X_WO.translation();
  X_WO.translation().setZero();
  render::Layer hand_layer{kMotionHandOpacity, {}, {}};
  for (std::size_t i = 0; i < hand.links().size(); ++i) {
    Pose X_WL = poseOf(frame.X_WL()[i]);
    X_WL.translation() -= middle_W;
    hand_layer.meshes.push_back(surface(hand.links()[i].surface_L(), X_WL, kHandColor));
  }
  render::Layer object_layer{
      kMotionObjectOpacity, {surface(object.mesh_O(), X_WO, kObjectColor)}, {}};
  render::Scene scene;
  for (const v1::FramePatch& patch : frame.patches()) {
    std::vector<Eigen::Vector3f> loop = pointsOf(patch.outline_O_m());
    for (Eigen::Vector3f& p : loop)
      p = (X_WO * p.cast<double>()).cast<float>();
    const std::size_t index =
        std::min<std::size_t>(patch.patch(), result.motion.patches().size() - 1);
    Color color = colorOf(result.motion.patches()[index], index);
    // What comes or goes is pale.
    color = render::blend({255, 255, 255}, color, std::clamp(patch.presence(), 0.0, 1.0));
    if (loop.size() < kFewestOfAnArea) {
      std::vector<Eigen::Vector3f> on_hand = pointsOf(patch.hand_W_m());
      for (Eigen::Vector3f& p : on_hand)
        p -= middle_W.cast<float>();
      addPoints(scene, loop, on_hand, color);
    } else {
      object_layer.decals.push_back({std::move(loop), 0.006F, color});
    }
  }
  scene.layers.push_back(std::move(object_layer));
  scene.layers.push_back(std::move(hand_layer));
  return scene;
}

std::string tileText(const v1::MotionFrame& frame) {
  double mean = 0.0;
  double normal = 0.0;
  double points = 0.0;
  int there = 0;
  int reached = 0;
  for (const PatchThere& patch : patchesThere(frame)) {
    ++there;
    reached += patch.is_reached ? 1 : 0;
    points += patch.points;
    mean += patch.points * patch.mean_mm;
    normal += patch.points * patch.normal_deg;
  }
  if (points == 0.0) return "no contact";
  return fmt::format("{} of {} patches reached, {:.1f} mm, {:.0f} deg, {:.1f} mm deep", reached,
                     there, mean / points, normal / points, 1e3 * frame.max_depth_m());
}

/// The finger that a joint's name begins with or has in it; empty if none.
std::string fingerOf(const std::string& joint) {
  std::string found;
  for (const char* finger : {"thumb", "index", "middle", "ring", "little"}) {
    // `index_middle_flex` is the index's: what comes first counts.
    if (joint.find(finger) == std::string::npos) continue;
    if (found.empty() || joint.rfind(finger, 0) == 0) found = finger;
  }
  return found;
}

/// In the colour of its finger, from dark to light along it; where no joint's name tells one,
/// each in a colour of its own.
std::vector<Color> jointColors(const v1::HandDescription& hand) {
  std::map<std::string, double> joints_of;
  for (const v1::JointInfo& joint : hand.joints())
    joints_of[fingerOf(joint.name())] += 1.0;
  const bool are_fingers_known = joints_of.size() > 1 || joints_of.count("") == 0;
  std::map<std::string, double> before;
  std::vector<Color> colors;
  for (const v1::JointInfo& joint : hand.joints()) {
    const std::string finger = fingerOf(joint.name());
    if (!are_fingers_known) {
      colors.push_back(render::plotColor(colors.size()));
      continue;
    }
    const Color color = finger.empty() ? kItself : colorOf(finger, 0);
    const double shade = (before[finger]++ + 0.5) / joints_of[finger] - 0.5;
    colors.push_back(shade < 0.0 ? render::blend(color, kDark, -kMostShade * shade)
                                 : render::blend(color, {255, 255, 255}, kMostShade * shade));
  }
  return colors;
}

std::vector<render::PlotPanel> panelsOf(const MotionResult& result) {
  const std::size_t frames = result.frames.size();
  std::vector<double> time_s;
  for (const v1::MotionFrame& frame : result.frames)
    time_s.push_back(frame.time_s());

  // === Each patch, where it is there
  render::PlotPanel distance{"distance (mm)", {}, {}, 1.5};
  render::PlotPanel normals{"normals off (deg)", {}, {}, 1.0};
  double highest = 1.0;
  for (std::size_t p = 0; p < result.motion.patches().size(); ++p) {
    render::PlotLine line;
    line.x = time_s;
    line.y.assign(frames, kNothing);
    line.color = colorOf(result.motion.patches()[p], p);
    line.name = result.motion.patches()[p];
    render::PlotLine normal = line;
    bool is_seen = false;
    for (std::size_t k = 0; k < frames; ++k) {
      for (const v1::FramePatch& patch : result.frames[k].patches()) {
        if (patch.patch() != p || patch.presence() < 0.5) continue;
        line.y[k] = patch.mean_mm();
        normal.y[k] = patch.normal_deg();
        highest = std::max(highest, patch.mean_mm());
        is_seen = true;
      }
    }
    if (!is_seen) continue;
    distance.lines.push_back(std::move(line));
    normals.lines.push_back(std::move(normal));
  }
  distance.range = {0.0, highest};

  // === The whole hand
  const std::vector<FrameMeasure> measures = measuresOf(result);
  render::PlotLine mean{time_s, {}, kDark, 3.0, false, "mean"};
  render::PlotLine depth{time_s, {}, kDark, 2.0, false, "in the object"};
  render::PlotLine self_depth{time_s, {}, kItself, 2.0, false, "in itself"};
  render::PlotLine speed{time_s, {}, kDark, 2.0, false, ""};
  double deepest = 1.0;
  for (std::size_t k = 0; k < frames; ++k) {
    mean.y.push_back(measures[k].mean_mm);
    depth.y.push_back(1e3 * result.frames[k].max_depth_m());
    self_depth.y.push_back(1e3 * result.frames[k].self_depth_m());
    speed.y.push_back(measures[k].velocity);
    deepest = std::max({deepest, depth.y.back(), self_depth.y.back()});
  }
  distance.lines.push_back(std::move(mean));

  // === Joints within their ranges
  render::PlotPanel joints{"joints (% of range)", {}, {{0.0, 100.0}}, 1.8, true};
  const std::vector<Color> colors = jointColors(result.hand);
  for (std::size_t i = 0; i < result.hand.joints().size(); ++i) {
    const v1::JointInfo& joint = result.hand.joints()[i];
    const double range = joint.upper() - joint.lower();
    if (!(range > 0.0) || !std::isfinite(range)) continue;
    render::PlotLine line{time_s, {}, colors[i], 1.5, false, joint.name()};
    for (const v1::MotionFrame& frame : result.frames)
      line.y.push_back(100.0 * (frame.joint_positions()[i] - joint.lower()) / range);
    joints.lines.push_back(std::move(line));
  }
  const double names = kRoomForNames * static_cast<double>(joints.lines.size());
  joints.height = std::max(joints.height, names * render::plotNameHeight() / kPanelHeight);
  std::vector<render::PlotPanel> panels{std::move(distance), std::move(normals)};
  panels.push_back(
      {"deepest (mm)", {std::move(self_depth), std::move(depth)}, {{0.0, deepest}}, 0.8});
  panels.push_back({"fastest joint (rad/s)", {std::move(speed)}, {}, 0.8});
  panels.push_back(std::move(joints));
  return panels;
}

void copyInto(render::Image& whole, const render::Image& part, int left, int top) {
  for (int y = 0; y < part.height(); ++y)
    for (int x = 0; x < part.width(); ++x)
      whole.at(left + x, top + y) = part.at(x, y);
}

}  // namespace

render::Image motionPicture(const MotionResult& result,
                            const std::vector<v1::MotionFrame>& shown,
                            const v1::HandDescription& hand,
                            const v1::ObjectDescription& object) {
  requireConsistent(result);
  HANDGRAFT_REQUIRE(!shown.empty());
  std::vector<render::PlotPanel> panels = panelsOf(result);
  double height = 0.0;
  for (const render::PlotPanel& panel : panels)
    height += panel.height;
  const render::PictureSize plot_size{kColumns * kTile.width,
                                      kAboutPanels + static_cast<int>(kPanelHeight * height)};
  const int rows = (static_cast<int>(shown.size()) + kColumns - 1) / kColumns;
  render::Image whole(plot_size.width, rows * kTile.height + plot_size.height);
  // All frames from the same sides, which show the fullest best.
  const auto fullest = std::max_element(shown.begin(), shown.end(),
                                        [](const v1::MotionFrame& a, const v1::MotionFrame& b) {
                                          return a.patches().size() < b.patches().size();
                                        });
  const auto views = render::viewsAroundUp(sceneOf(result, *fullest, hand, object));
  for (std::size_t i = 0; i < shown.size(); ++i) {
    render::Caption caption;
    caption.title = fmt::format("{:.2f} s", shown[i].time_s());
    caption.subtitle = tileText(shown[i]);
    const int at = static_cast<int>(i);
    copyInto(
        whole,
        render::renderTwoViews(sceneOf(result, shown[i], hand, object), caption, views, kTile),
        at % kColumns * kTile.width, at / kColumns * kTile.height);
  }
  const v1::MotionSummary& summary = result.summary;
  const JointUnit unit = unitOfLargest(result.hand);
  const render::Plot plot{
      fmt::format("{}: {}", text::titleOf(result.session, result.hand, "on"),
                  nameCalled(result.motion.name())),
      fmt::format("{} frames: {:.2f} mm and {:.0f} deg off in the mean, {:.2f} mm deep at "
                  "most, {:.2f} in "
                  "itself, largest step of a joint {:.3g} {}",
                  summary.frame_count(), summary.mean_mm(), summary.normal_deg(),
                  1e3 * summary.max_depth_m(), 1e3 * summary.self_depth_m(),
                  unit.scale * summary.max_step(), unit.name),
      "time (s)", std::move(panels)};
  copyInto(whole, render::drawPlot(plot, plot_size), 0, rows * kTile.height);
  return whole;
}

}  // namespace handgraft::client
