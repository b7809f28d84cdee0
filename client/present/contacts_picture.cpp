#include "client/present/contacts_picture.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "client/link/wire_pose.h"
#include "client/present/picture_parts.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

using render::Color;

constexpr double kHandOpacity = 0.35;
constexpr double kArrowLength = 0.14;  // of the object's size
constexpr float kArrowLift = 0.02F;    // likewise: round objects would swallow it
constexpr float kDecalReach = 0.006F;

// From no contact to full contact; neutral, so that the fingers' colours stand out.
constexpr std::array<Color, 5> kScale = {
    {{246, 238, 222}, {226, 200, 176}, {186, 148, 140}, {126, 96, 112}, {58, 42, 70}}};

Color scaleColor(double value) {
  const double place =
      std::isfinite(value) ? std::clamp(value, 0.0, 1.0) * (kScale.size() - 1) : 0.0;
  const auto below = std::min(static_cast<std::size_t>(place), kScale.size() - 2);
  return render::blend(kScale[below], kScale[below + 1], place - static_cast<double>(below));
}

// Values of other maps than shares of 1 (temperatures, say) are shown between their extremes.
struct Range {
  double low = 0.0;
  double high = 1.0;
};

Range rangeOf(const std::vector<float>& values) {
  Range range;
  bool any = false;
  double low = 0.0;
  double high = 0.0;
  for (const float value : values) {
    if (!std::isfinite(value)) continue;
    low = any ? std::min<double>(low, value) : value;
    high = any ? std::max<double>(high, value) : value;
    any = true;
  }
  if (any && (low < -1e-6 || high > 1.0 + 1e-6)) range = {low, high};
  return range;
}

render::SurfaceMesh coloredMap(const v1::MapInfo& map, render::Caption& caption) {
  render::SurfaceMesh mesh = surface(map.mesh_O(), Pose::Identity(), kObjectColor);
  if (map.value().size() != mesh.vertices_W.size()) {
    throw TransportError(fmt::format("the server sent {} values of a map of {} vertices",
                                     map.value().size(), mesh.vertices_W.size()));
  }
  const Range range = rangeOf(map.value());
  const double span = std::max(range.high - range.low, 1e-300);
  for (const float value : map.value())
    mesh.vertex_colors.push_back(scaleColor((value - range.low) / span));
  for (const double share : {0.0, 0.5, 1.0}) {
    caption.legend.push_back(
        {scaleColor(share), fmt::format("{}{:.3g}", share == 0.0 ? "contact " : "",
                                        range.low + share * (range.high - range.low))});
  }
  return mesh;
}

double sizeOf(const render::SurfaceMesh& mesh) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : mesh.vertices_W) {
    if (p.allFinite()) box.extend(p);
  }
  return box.isEmpty() ? 0.1 : static_cast<double>(box.diagonal().norm());
}

}  // namespace

ContactsPicture pictureOf(const v1::ContactsDescription& contacts,
                          const v1::ObjectDescription& object,
                          const PosedLinks& hand) {
  ContactsPicture picture;
  render::Scene& scene = picture.scene;
  render::Caption shades;
  render::Layer object_layer{1.0, {}, {}};
  object_layer.meshes.push_back(contacts.contact_map().empty()
                                    ? surface(object.mesh_O(), Pose::Identity(), kObjectColor)
                                    : coloredMap(contacts.contact_map().front(), shades));
  const double size = sizeOf(object_layer.meshes.front());

  // === Patches
  bool knows_directions = false;
  render::Scene scouted;  // where the decals are: what the views are chosen by
  scouted.layers.push_back(object_layer);
  for (std::size_t i = 0; i < contacts.patches().size(); ++i) {
    const v1::PatchInfo& patch = contacts.patches()[i];
    const Color color = colorOf(patch.name(), i);
    const std::vector<Eigen::Vector3f> loop = pointsOf(patch.outline_O_m());
    scouted.layers[0].decals.push_back({loop, kDecalReach, color});
    for (std::size_t k = 0; k < loop.size(); ++k)
      addCasedLine(scene, loop[k], loop[(k + 1) % loop.size()], 3.6F, color);
    const MeshPlace root = placeOn(object.mesh_O(), patch.root());
    if (patch.direction_O().size() == 3) {
      knows_directions = true;
      const Eigen::Vector3d direction(patch.direction_O()[0], patch.direction_O()[1],
                                      patch.direction_O()[2]);
      const Eigen::Vector3f way = (kArrowLength * size * direction).cast<float>();
      const Eigen::Vector3f lift = kArrowLift * static_cast<float>(size) * root.n;
      addArrow(scene, root.p, root.p + way + lift, root.n, 3.0F,
               render::blend(color, {0, 0, 0}, 0.25));
    }
    addDot(scene, root.p, 6.0F, color);
    scene.labels.push_back({root.p, patch.name(), color, root.n});
    picture.caption.legend.push_back(
        {color, fmt::format("{} ({} points)", patch.name(), patch.point_count())});
  }
  auto& legend = picture.caption.legend;
  legend.insert(legend.end(), shades.legend.begin(), shades.legend.end());
  picture.views = render::viewsAllAround(scouted);

  scene.layers.push_back(std::move(object_layer));
  if (!hand.surfaces_L.empty()) {
    render::Layer layer{kHandOpacity, {}, {}};
    for (std::size_t i = 0; i < std::min(hand.surfaces_L.size(), hand.X_OL.size()); ++i)
      layer.meshes.push_back(surface(hand.surfaces_L[i], poseOf(hand.X_OL[i]), kHandColor));
    scene.layers.push_back(std::move(layer));
  }

  picture.caption.title = fmt::format("contacts {} on {}", contacts.name(), contacts.object());
  picture.caption.subtitle = fmt::format("{} patches", contacts.patches().size());
  if (!contacts.contact_map().empty()) {
    picture.caption.subtitle +=
        fmt::format(" of contact above {:.3g}", contacts.contact_map().front().threshold());
  }
  picture.caption.subtitle += ": outline and root";
  if (knows_directions) picture.caption.subtitle += ", an arrow towards the wrist";
  return picture;
}

}  // namespace handgraft::client
