#include "client/present/grasp_picture.h"

#include <set>
#include <string>

#include <Eigen/Geometry>

#include <fmt/format.h>

#include "client/link/model_files.h"
#include "client/link/wire_pose.h"
#include "client/present/picture_parts.h"
#include "client/present/text_output.h"
#include "idl/fields.h"

namespace handgraft::client {

namespace {

using render::Color;

constexpr Color kDroppedColor{120, 120, 120};
constexpr Color kLostColor{215, 20, 30};
constexpr Color kDistanceColor{30, 32, 36};
constexpr float kFramedAbout = 0.12F;  // m; about the object: a hand without its forearm
constexpr double kHandOpacity = 0.86;
constexpr double kObjectOpacity = 0.66;  // patches behind it shine through

void addOutline(render::Scene& scene, const std::vector<Eigen::Vector3f>& loop, Color color) {
  for (std::size_t i = 0; i < loop.size(); ++i) {
    scene.segments.push_back({loop[i], loop[(i + 1) % loop.size()], 2.4F, color});
  }
}

void addFit(GraspPicture& picture,
            render::Layer& hand,
            render::Layer& object,
            const v1::PatchFit& fit,
            const v1::PatchReport* report,
            Color color) {
  render::Scene& scene = picture.scene;
  const std::vector<Eigen::Vector3f> on_hand = pointsOf(fit.hand_W_m());
  const std::vector<Eigen::Vector3f> on_object = pointsOf(fit.object_W_m());
  // What lies inside the boundary is no part of the outline.
  const std::size_t outline_count =
      report == nullptr ? on_hand.size()
                        : std::min<std::size_t>(report->boundary_count(), on_hand.size());
  const auto outline_of = [&](const std::vector<Eigen::Vector3f>& points) {
    return std::vector<Eigen::Vector3f>(
        points.begin(), points.begin() + static_cast<std::ptrdiff_t>(outline_count));
  };
  hand.decals.push_back({outline_of(on_hand), 0.006F, color});
  object.decals.push_back({outline_of(on_object), 0.006F, color});
  addOutline(scene, outline_of(on_hand), render::blend(color, {255, 255, 255}, 0.35));
  addOutline(scene, outline_of(on_object), render::blend(color, {0, 0, 0}, 0.25));
  for (std::size_t i = 0; i < std::min(on_hand.size(), on_object.size()); ++i) {
    scene.segments.push_back({on_hand[i], on_object[i], 1.2F, kDistanceColor});
    scene.markers.push_back({on_object[i], 2.2F, render::blend(color, {0, 0, 0}, 0.35)});
  }
  const v1::Verdict verdict = fit.diagnosis().verdict();
  const bool is_missed = verdict != v1::VERDICT_REACHED && verdict != v1::VERDICT_NONE;
  picture.caption.legend.push_back(
      {color, fmt::format("{} {:.1f} mm (max {:.1f}){}", fit.name(), fit.mean_mm(),
                          fit.max_mm(), is_missed ? " not reached" : "")});
}

/// Where the hand has no place for a point of the patch.
void addLosses(GraspPicture& picture,
               const v1::PatchReport& report,
               const v1::PatchInfo& patch,
               const Pose& X_WO) {
  const std::vector<Eigen::Vector3f> outline_O = pointsOf(patch.outline_O_m());
  for (const v1::LostPoint& lost : report.lost()) {
    if (lost.ring() != 0 || lost.index() >= outline_O.size()) continue;
    const Eigen::Vector3d p_W = X_WO * outline_O[lost.index()].cast<double>();
    picture.scene.markers.push_back({p_W.cast<float>(), 3.0F, kLostColor});
  }
}

/// Digits, and where palms are: what people want to see of a hand, without its forearm.
std::vector<const render::SurfaceMesh*> graspingMeshes(const v1::HandDescription& hand,
                                                       const render::Layer& links) {
  std::set<std::string> names;
  for (const v1::DigitInfo& digit : hand.digits())
    for (const v1::SegmentInfo& segment : digit.segments())
      names.insert(segment.link());
  for (const v1::SiteInfo& site : hand.sites())
    names.insert(site.link());
  std::vector<const render::SurfaceMesh*> meshes;
  for (std::size_t i = 0; i < hand.links().size(); ++i)
    if (names.contains(hand.links()[i].name())) meshes.push_back(&links.meshes[i]);
  return meshes;
}

}  // namespace

GraspPicture pictureOf(const GraspResult& result,
                       const v1::ObjectDescription& object,
                       const v1::ContactsDescription& contacts) {
  requireConsistent(result);
  const v1::PoseSolution& solution = result.solution;
  GraspPicture picture;

  // === Surfaces
  render::Layer hand_layer{kHandOpacity, {}, {}};
  for (std::size_t i = 0; i < result.hand.links().size(); ++i) {
    hand_layer.meshes.push_back(
        surface(result.hand.links()[i].surface_L(), poseOf(solution.X_WL()[i]), kHandColor));
  }
  const Pose X_WO = poseOf(solution.X_WO());
  render::Layer object_layer{
      kObjectOpacity, {surface(object.mesh_O(), X_WO, kObjectColor)}, {}};

  // === Patches that were solved, then those that were dropped
  std::size_t lost_count = 0;
  for (std::size_t i = 0; i < solution.patches().size(); ++i) {
    const v1::PatchFit& fit = solution.patches()[i];
    const v1::PatchReport* report = reportOf(result, fit.name());
    const Color color = colorOf(fit.name(), i);
    addFit(picture, hand_layer, object_layer, fit, report, color);
    for (const v1::PatchInfo& patch : contacts.patches()) {
      if (report == nullptr || patch.name() != fit.name()) continue;
      addLosses(picture, *report, patch, X_WO);
      lost_count += report->lost().size();
    }
  }
  for (const v1::PatchReport& report : result.transfer.patches()) {
    if (report.placed()) continue;
    for (const v1::PatchInfo& patch : contacts.patches()) {
      if (patch.name() != report.name()) continue;
      std::vector<Eigen::Vector3f> outline = pointsOf(patch.outline_O_m());
      for (Eigen::Vector3f& p : outline)
        p = (X_WO * p.cast<double>()).cast<float>();
      object_layer.decals.push_back({outline, 0.006F, kDroppedColor});
    }
    picture.caption.legend.push_back({kDroppedColor, report.name() + " dropped"});
  }
  if (lost_count > 0) {  // one entry for all: the line is short
    picture.caption.legend.push_back({kLostColor, fmt::format("lost: {}", lost_count)});
  }
  picture.scene.layers.push_back(std::move(object_layer));
  picture.scene.layers.push_back(std::move(hand_layer));
  picture.scene.frameAbout(picture.scene.layers.front().meshes.front(), kFramedAbout,
                           graspingMeshes(result.hand, picture.scene.layers.back()));

  picture.caption.title = text::titleOf(result.session, result.hand, "grasps");
  picture.caption.subtitle =
      fmt::format("contacts {}: {}, objective {:.4g}", nameCalled(result.session.contacts()),
                  text::reachedText(solution), solution.terms().objective());
  return picture;
}

}  // namespace handgraft::client
