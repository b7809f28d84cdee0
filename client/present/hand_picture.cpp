#include "client/present/hand_picture.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <Eigen/Geometry>

#include "client/link/wire_pose.h"
#include "client/present/picture_parts.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

using Eigen::Vector3d;
using render::Color;

constexpr double kHandOpacity = 0.82;   // what lies behind it shines through
constexpr double kNormalLength = 0.10;  // of the hand's size; likewise the next
constexpr double kDirectionLength = 0.12;
constexpr double kArrowLift = 0.02;  // hollow palms would swallow it
constexpr Color kNoLinkColor{60, 60, 64};

struct PlacedSite {
  std::string name;
  std::string link;
  Vector3d p_S;
  Vector3d n_S;
  Vector3d direction_S;
};

Vector3d vectorOf(const std::array<double, 3>& v) {
  return {v[0], v[1], v[2]};
}

// Poses of the links by name. Errors: TransportError unless there is one for each.
std::map<std::string, Pose> linkPoses(const v1::HandDescription& hand) {
  if (hand.X_SL().size() != hand.links().size()) {
    throw TransportError(fmt::format("the server sent {} link poses for {} links",
                                     hand.X_SL().size(), hand.links().size()));
  }
  std::map<std::string, Pose> X_SL;
  for (std::size_t i = 0; i < hand.links().size(); ++i)
    X_SL[hand.links()[i].name()] = poseOf(hand.X_SL()[i]);
  return X_SL;
}

std::vector<PlacedSite> placedSites(const v1::HandDescription& hand) {
  const std::map<std::string, Pose> X_SL = linkPoses(hand);
  std::vector<PlacedSite> sites;
  for (const v1::SiteInfo& site : hand.sites()) {
    const auto X = X_SL.find(site.link());
    if (X == X_SL.end()) {
      throw TransportError(
          fmt::format("the server put site '{}' on link '{}', which the hand has not",
                      site.name(), site.link()));
    }
    sites.push_back({site.name(), site.link(), X->second * vectorOf(site.p_L_m()),
                     X->second.linear() * vectorOf(site.n_L()),
                     X->second.linear() * vectorOf(site.direction_L())});
  }
  return sites;
}

// Of what is left of `v` beside `axis`; nothing where there is hardly any.
std::optional<Vector3d> unitBeside(const Vector3d& v, const Vector3d& axis) {
  const Vector3d rest = v - v.dot(axis) * axis;
  if (!(rest.norm() > 0.1 * v.norm())) return std::nullopt;
  return rest.normalized();
}

// Pads and palm face the viewer of the first side, fingers point up, and the second side is the
// thumb's.
std::array<render::View, 2> viewsOf(const std::vector<PlacedSite>& sites,
                                    const render::Scene& scene) {
  Vector3d normals = Vector3d::Zero();
  Vector3d wrist = Vector3d::Zero();
  Vector3d middle = Vector3d::Zero();
  std::optional<Vector3d> thumb;
  for (const PlacedSite& site : sites) {
    if (site.name == "thumb") {
      thumb = site.p_S;
      continue;  // it faces the others
    }
    normals += site.n_S;
    wrist += site.direction_S;
    middle += site.p_S / static_cast<double>(std::max<std::size_t>(1, sites.size() - 1));
  }
  const auto count = static_cast<double>(sites.size());
  if (sites.size() < 2 || normals.norm() < 0.2 * count) return render::viewsAllAround(scene);
  const Vector3d front = normals.normalized();
  const Vector3d up = unitBeside(-wrist, front).value_or(front.unitOrthogonal());
  Vector3d aside = up.cross(front);
  if (thumb && aside.dot(*thumb - middle) < 0.0) aside = -aside;
  // Slightly turned: edge-on, pads are hard to make out.
  const Vector3d first = (front + 0.18 * aside + 0.10 * up).normalized();
  const Vector3d second = (aside + 0.28 * front + 0.10 * up).normalized();
  return {{{first, up, "palm side"}, {second, up, thumb ? "thumb side" : "from the side"}}};
}

double sizeOf(const render::Scene& scene) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& p : scene.points()) {
    if (p.allFinite()) box.extend(p);
  }
  return box.isEmpty() ? 0.2 : static_cast<double>(box.diagonal().norm());
}

std::string countedJoints(const v1::HandDescription& hand) {
  return fmt::format("{} joints, {} links, {} sites {}", hand.joints().size(),
                     hand.links().size(), hand.sites().size(),
                     hand.sites_found() ? "found" : "that it brought");
}

// Links that lie side by side in the list differ most.
Color linkColor(std::size_t link) {
  const double hue = std::fmod(static_cast<double>(link) * 0.618034, 1.0) * 6.0;
  const double value = link % 2 == 0 ? 235.0 : 190.0;
  const auto channel = [&](double shift) {
    const double distance = std::abs(std::fmod(hue + shift, 6.0) - 3.0);
    return static_cast<std::uint8_t>(value *
                                     (0.42 + 0.58 * std::clamp(distance - 1.0, 0.0, 1.0)));
  };
  return {channel(0.0), channel(4.0), channel(2.0)};
}

}  // namespace

HandPicture pictureOfSites(const v1::HandDescription& hand) {
  const std::vector<PlacedSite> sites = placedSites(hand);
  HandPicture picture;
  render::Scene& scene = picture.scene;
  render::Layer layer{kHandOpacity, {}, {}};
  for (std::size_t i = 0; i < hand.links().size(); ++i) {
    layer.meshes.push_back(
        surface(hand.links()[i].surface_L(), poseOf(hand.X_SL()[i]), kHandColor));
  }
  scene.layers.push_back(std::move(layer));
  const double size = sizeOf(scene);
  for (std::size_t i = 0; i < sites.size(); ++i) {
    const PlacedSite& site = sites[i];
    const Color color = colorOf(site.name, i);
    const Eigen::Vector3f p = site.p_S.cast<float>();
    const Eigen::Vector3f n = site.n_S.cast<float>();
    const Eigen::Vector3f tip =
        (site.p_S + size * (kDirectionLength * site.direction_S + kArrowLift * site.n_S))
            .cast<float>();
    addArrow(scene, p, tip, n, 3.0F, render::blend(color, {0, 0, 0}, 0.25));
    addCasedLine(scene, p, (site.p_S + kNormalLength * size * site.n_S).cast<float>(), 4.0F,
                 color);
    addDot(scene, p, 7.5F, color);
    scene.labels.push_back({p, site.name, color});
    picture.caption.legend.push_back({color, fmt::format("{} on {}", site.name, site.link)});
  }
  picture.caption.title = "hand " + hand.name();
  picture.caption.subtitle =
      countedJoints(hand) + ": a dot, its normal, an arrow towards the wrist";
  picture.views = viewsOf(sites, scene);
  return picture;
}

HandPicture pictureOfSkin(const v1::HandDescription& hand) {
  const std::vector<PlacedSite> sites = placedSites(hand);
  const std::vector<std::int32_t>& face_links = hand.skin_face_links();
  render::SurfaceMesh whole = surface(hand.skin_S(), Pose::Identity(), kHandColor);
  if (face_links.size() != whole.triangles.size()) {
    throw TransportError(fmt::format("the server named the links of {} faces; the skin has {}",
                                     face_links.size(), whole.triangles.size()));
  }
  // Corners of their own for each face, so that colours end at edges.
  render::SurfaceMesh mesh;
  std::map<std::int32_t, std::size_t> faces_of;
  for (std::size_t f = 0; f < whole.triangles.size(); ++f) {
    const std::int32_t link = face_links[f];
    const bool known = link >= 0 && static_cast<std::size_t>(link) < hand.links().size();
    ++faces_of[known ? link : -1];
    const auto first = static_cast<std::uint32_t>(mesh.vertices_W.size());
    for (const std::uint32_t corner : whole.triangles[f]) {
      if (corner >= whole.vertices_W.size()) {
        throw TransportError(fmt::format("face {} of the skin names vertex {} of {}", f, corner,
                                         whole.vertices_W.size()));
      }
      mesh.vertices_W.push_back(whole.vertices_W[corner]);
      mesh.vertex_colors.push_back(known ? linkColor(static_cast<std::size_t>(link))
                                         : kNoLinkColor);
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  HandPicture picture;
  picture.scene.layers.push_back({1.0, {std::move(mesh)}, {}});
  for (const auto& [link, count] : faces_of) {
    picture.caption.legend.push_back(
        link < 0 ? render::LegendEntry{kNoLinkColor, "on no link"}
                 : render::LegendEntry{linkColor(static_cast<std::size_t>(link)),
                                       hand.links()[static_cast<std::size_t>(link)].name()});
  }
  picture.caption.title = "skin of " + hand.name();
  picture.caption.subtitle =
      fmt::format("{} vertices, {} faces", whole.vertices_W.size(), whole.triangles.size());
  if (!hand.skin_report().empty()) {
    const v1::SkinReport& report = hand.skin_report().front();
    picture.caption.subtitle += fmt::format(", {} piece{}, genus {}", report.pieces(),
                                            report.pieces() == 1 ? "" : "s", report.genus());
  }
  picture.views = viewsOf(sites, picture.scene);
  return picture;
}

}  // namespace handgraft::client
