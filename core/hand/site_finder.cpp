#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>

#include "core/hand/contact_site.h"
#include "core/hand/digits.h"
#include "core/hand/facing.h"
#include "core/hand/kinematics.h"

namespace handgraft::hand {

namespace {

/// A pad's normal leans at most this far from the closing direction (cosine of 60 degrees),
/// and faces well (kFacingWell) where such a place is found.
constexpr double kFacingCosine = 0.5;

// === Places: rays against the skin

struct Place {
  Eigen::Vector3d p_S = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_S = Eigen::Vector3d::Zero();
  LinkPoint link_point;
};

/// The outermost place on one of `links` that a ray from `origin` meets and that faces along
/// it.
std::optional<Place> shoot(const Skin& skin,
                           const Eigen::Vector3d& origin,
                           const Eigen::Vector3d& direction,
                           const std::vector<int>& links) {
  const geometry::TriangleMesh& mesh = skin.mesh();
  std::optional<Place> best;
  double best_t = -std::numeric_limits<double>::infinity();
  for (int f = 0; f < mesh.faceCount(); ++f) {
    if (mesh.faceNormals().col(f).dot(direction) < kFacingCosine) continue;
    // Möller and Trumbore's test, both signs of t: the origin may lie off the solid.
    const Eigen::Vector3i corners = mesh.face(f);
    const Eigen::Vector3d ab = mesh.vertex(corners[1]) - mesh.vertex(corners[0]);
    const Eigen::Vector3d ac = mesh.vertex(corners[2]) - mesh.vertex(corners[0]);
    const Eigen::Vector3d across = direction.cross(ac);
    const double determinant = ab.dot(across);
    if (std::abs(determinant) < 1e-18) continue;
    const Eigen::Vector3d ao = origin - mesh.vertex(corners[0]);
    const double u = ao.dot(across) / determinant;
    const Eigen::Vector3d along = ao.cross(ab);
    const double v = direction.dot(along) / determinant;
    if (u < 0.0 || v < 0.0 || u + v > 1.0) continue;
    const double t = ac.dot(along) / determinant;
    if (t <= best_t) continue;
    const geometry::SurfacePoint point{f, {1.0 - u - v, u, v}};
    Place place;
    place.p_S = origin + t * direction;
    place.n_S = geometry::normalOf(mesh, point);
    const auto projected = skin.project(place.p_S, place.n_S);
    if (!projected || std::find(links.begin(), links.end(), projected->link) == links.end())
      continue;
    place.link_point = *projected;
    best = place;
    best_t = t;
  }
  return best;
}

ContactSite siteAt(const HandModel& model,
                   const LinkPoses& X_SL,
                   const Place& place,
                   const Eigen::Vector3d& towards_wrist_S) {
  ContactSite site;
  const auto link = static_cast<std::size_t>(place.link_point.link);
  site.link = model.links()[link].name;
  site.p_L = place.link_point.p_L;
  site.n_L = place.link_point.n_L;
  const Eigen::Vector3d d_L = X_SL[link].linear().transpose() * towards_wrist_S;
  Eigen::Vector3d tangent = d_L - d_L.dot(site.n_L) * site.n_L;
  if (tangent.norm() < 1e-6) tangent = site.n_L.unitOrthogonal();
  site.direction_L = tangent.normalized();
  return site;
}

/// The pad of a digit: about one fingertip radius behind the tip, on the closing side.
std::optional<ContactSite> findPad(const HandModel& model,
                                   const Skin& skin,
                                   const LinkPoses& X_SL,
                                   const Digit& digit) {
  const double length = (digit.tip - digit.last_joint).norm();
  const Eigen::Vector3d side = digit.outward.cross(digit.closing).normalized();

  // Half the width of the tip, measured over its last part.
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  const double part = std::min(0.4 * length, 0.02);
  for (const int link : digit.tip_links) {
    for (const Shape& shape : model.links()[static_cast<std::size_t>(link)].surface()) {
      for (int v = 0; v < shape.mesh_L.vertexCount(); ++v) {
        const Eigen::Vector3d d =
            X_SL[static_cast<std::size_t>(link)] * shape.mesh_L.vertex(v) - digit.tip;
        if (-d.dot(digit.outward) > part) continue;
        lowest = std::min(lowest, d.dot(side));
        highest = std::max(highest, d.dot(side));
      }
    }
  }
  const double radius = std::clamp(0.5 * (highest - lowest), 0.003, 0.5 * length + 0.003);
  const double middle = 0.5 * (highest + lowest);

  // Farther back on a tip that ends in a face, so that a patch does not reach over its edge,
  // and if the skin there looks elsewhere, as it does on a pointed tip.
  const double inset = digit.tip_radius > 0.5 * radius ? 1.5 * radius : radius;
  std::optional<Place> best;
  double best_facing = kFacingCosine;
  for (const double back : {1.0, 1.25, 1.5, 0.75, 2.0, 2.5}) {
    const double distance = std::min(back * inset, 0.9 * length);
    const auto place = shoot(skin, digit.tip - distance * digit.outward + middle * side,
                             digit.closing, digit.tip_links);
    if (!place) continue;
    const double facing = (X_SL[static_cast<std::size_t>(place->link_point.link)].linear() *
                           place->link_point.n_L)
                              .dot(digit.closing);
    if (facing > kFacingWell) {
      best = place;
      break;
    }
    if (facing > best_facing) {
      best_facing = facing;
      best = place;
    }
  }
  if (!best) return std::nullopt;
  return siteAt(model, X_SL, *best, -digit.outward);
}

// === The palm

// Share of unit vectors' lengths that is left in their sum.
constexpr double kAgreeing = 0.5;

constexpr std::array<std::array<double, 2>, 4> kSides{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};

Eigen::AlignedBox3d boxAround(const HandModel& model,
                              const LinkPoses& X_SL,
                              const std::vector<int>& links) {
  Eigen::AlignedBox3d box;
  for (const int link : links)
    for (const Shape& shape : model.links()[static_cast<std::size_t>(link)].surface())
      for (int v = 0; v < shape.mesh_L.vertexCount(); ++v)
        box.extend(X_SL[static_cast<std::size_t>(link)] * shape.mesh_L.vertex(v));
  return box;
}

/// Whether the skin faces that way and is as high to all sides, where a patch would lie.
bool isFlatAround(const Skin& skin,
                  const Place& place,
                  const Eigen::Vector3d& facing,
                  const Eigen::Vector3d& wristwards,
                  const std::vector<int>& links) {
  constexpr double kReach = 0.008;   // m
  constexpr double kUneven = 0.004;  // m
  const Eigen::Vector3d v = facing.cross(wristwards).normalized();
  const Eigen::Vector3d u = v.cross(facing);
  return std::all_of(kSides.begin(), kSides.end(), [&](const auto& side) {
    const auto beside =
        shoot(skin, place.p_S + kReach * (side[0] * u + side[1] * v), facing, links);
    return beside && beside->n_S.dot(facing) > kFacingWell &&
           std::abs((beside->p_S - place.p_S).dot(facing)) < kUneven;
  });
}

/// Where digits say that the palm is, in S.
struct PalmFrame {
  Eigen::Vector3d bases;   ///< the middle of the digits' bases
  Eigen::Vector3d facing;  ///< where they close to; a unit vector
  Eigen::Vector3d wristwards;
};

std::optional<PalmFrame> palmFrameOf(const Digits& found,
                                     const std::vector<std::string>& names) {
  Eigen::Vector3d facing = Eigen::Vector3d::Zero();
  Eigen::Vector3d outward = Eigen::Vector3d::Zero();
  Eigen::Vector3d closing = Eigen::Vector3d::Zero();
  Eigen::Vector3d along = Eigen::Vector3d::Zero();
  Eigen::Vector3d bases = Eigen::Vector3d::Zero();
  Eigen::Vector3d thumb_base = Eigen::Vector3d::Zero();
  double count = 0.0;
  // Of few digits the thumb bounds the palm, too, as much as all the others together.
  const bool is_surrounded = found.digits.size() <= 3;
  for (std::size_t i = 0; i < found.digits.size(); ++i) {
    const Digit& digit = found.digits[i];
    const bool is_thumb = names[i] == "thumb";
    if (is_thumb) thumb_base = digit.base;
    if (is_thumb && !is_surrounded) continue;
    const double weight =
        is_thumb ? std::max(1.0, static_cast<double>(found.digits.size()) - 1.0) : 1.0;
    facing += weight * digit.bone_closing;
    outward += weight * digit.bone_outward;
    closing += digit.bone_closing;
    along += digit.bone_outward;
    bases += weight * (is_surrounded ? digit.knuckle : digit.base);
    count += weight;
  }
  // Fingers that stand around the palm close against each other: it looks along them.
  const double digits = static_cast<double>(found.digits.size());
  if (is_surrounded && closing.norm() < kAgreeing * digits && along.norm() > kAgreeing * digits)
    facing = along;
  const double least = is_surrounded ? 0.1 : kAgreeing;
  if (count == 0.0 || facing.norm() < least * count) return std::nullopt;
  facing.normalize();
  bases /= count;
  Eigen::Vector3d wristwards = -outward / count;
  wristwards -= wristwards.dot(facing) * facing;
  // Fingers all around the palm: towards the thumb, for want of a wrist.
  if (wristwards.norm() < 0.3) wristwards = thumb_base - bases;
  return PalmFrame{bases, facing, wristwards};
}

std::optional<ContactSite> findPalm(const HandModel& model,
                                    const Skin& skin,
                                    const LinkPoses& X_SL,
                                    const Digits& found,
                                    const std::vector<std::string>& names) {
  const auto frame = palmFrameOf(found, names);
  if (!frame) return std::nullopt;
  const auto& [bases, facing, wristwards] = *frame;
  const std::vector<int> links = palmBodyOf(model, found.palm_link);
  const Eigen::AlignedBox3d box = boxAround(model, X_SL, links);
  if (box.isEmpty()) return std::nullopt;

  // Where the middle is a chamfer, on a flat place if there is one, not in a notch beside it.
  std::optional<Place> best;
  int best_merit = 0;
  for (const double share : {0.5, 0.35, 0.65, 0.2, 0.0, 0.8, 1.0}) {
    const Eigen::Vector3d origin = (1.0 - share) * bases + share * box.center();
    const auto place = shoot(skin, origin, facing, links);
    if (!place) continue;
    const bool is_first = best_merit == 0;
    int merit = 1;
    if (place->n_S.dot(facing) > kFacingWell)
      merit = is_first || isFlatAround(skin, *place, facing, wristwards, links) ? 3 : 2;
    if (merit <= best_merit) continue;
    best = place;
    best_merit = merit;
    if (merit == 3) break;
  }
  if (!best) return std::nullopt;
  ContactSite site = siteAt(model, X_SL, *best, wristwards);
  site.name = "palm";
  return site;
}

}  // namespace

std::vector<ContactSite> findContactSites(const HandModel& model, const Skin& skin) {
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skin.qReference(), X_SL);
  const Digits found = findDigits(model, X_SL);
  const std::vector<std::string> names = nameDigits(found.digits).names;

  std::vector<ContactSite> sites;
  for (std::size_t i = 0; i < found.digits.size(); ++i) {
    if (auto site = findPad(model, skin, X_SL, found.digits[i])) {
      site->name = names[i];
      sites.push_back(std::move(*site));
    }
  }
  if (auto palm = findPalm(model, skin, X_SL, found, names)) sites.push_back(std::move(*palm));

  static constexpr std::array<std::string_view, 6> kOrder{"thumb", "index",  "middle",
                                                          "ring",  "little", "palm"};
  std::stable_sort(sites.begin(), sites.end(), [](const ContactSite& a, const ContactSite& b) {
    const auto rank = [](const std::string& name) {
      return std::find(kOrder.begin(), kOrder.end(), name) - kOrder.begin();
    };
    return rank(a.name) < rank(b.name);
  });
  validate(model, sites);
  return sites;
}

}  // namespace handgraft::hand
