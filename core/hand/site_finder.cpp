#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>

#include "core/base/error.h"
#include "core/hand/contact_site.h"
#include "core/hand/digits.h"
#include "core/hand/kinematics.h"

namespace handgraft::hand {

namespace {

constexpr std::array<const char*, 4> kFingerNames{"index", "middle", "ring", "little"};
/// A pad's normal leans at most this far from the closing direction (cosine of 60 degrees).
constexpr double kFacingCosine = 0.5;
/// What a thumb must differ from the other digits to be called one (0 alike, 2 opposed).
constexpr double kThumbContrast = 0.1;

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

  // Farther back if the skin there looks elsewhere, as it does on a pointed tip.
  std::optional<Place> best;
  double best_facing = kFacingCosine;
  for (const double back : {1.0, 1.25, 1.5, 0.75, 2.0, 2.5}) {
    const double distance = std::min(back * radius, 0.9 * length);
    const auto place = shoot(skin, digit.tip - distance * digit.outward + middle * side,
                             digit.closing, digit.tip_links);
    if (!place) continue;
    const double facing = (X_SL[static_cast<std::size_t>(place->link_point.link)].linear() *
                           place->link_point.n_L)
                              .dot(digit.closing);
    if (facing > 0.85) {
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

// === Names

/// The digit that opposes the others: without it, the rest closes most alike, and it closes
/// least like them. -1 if none stands out.
int findThumb(const std::vector<Digit>& digits) {
  for (std::size_t i = 0; i < digits.size(); ++i)
    if (digits[i].hint == "thumb") return static_cast<int>(i);
  if (digits.size() < 2) return -1;
  if (digits.size() == 2) return digits[0].nodes.size() < digits[1].nodes.size() ? 0 : 1;

  int thumb = -1;
  double best = -std::numeric_limits<double>::infinity();
  double contrast = 0.0;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    Eigen::Vector3d others = Eigen::Vector3d::Zero();
    for (std::size_t j = 0; j < digits.size(); ++j)
      if (j != i) others += digits[j].flexion_axis;
    others /= static_cast<double>(digits.size() - 1);
    const double coherence = others.norm();
    const double likeness =
        coherence > 1e-9 ? digits[i].flexion_axis.dot(others) / coherence : 0.0;
    if (coherence - likeness > best + 1e-9) {
      best = coherence - likeness;
      contrast = 1.0 - likeness;
      thumb = static_cast<int>(i);
    }
  }
  return contrast > kThumbContrast ? thumb : -1;
}

/// The other digits, from the one next to the thumb across the palm.
std::vector<int> orderFingers(const std::vector<Digit>& digits, int thumb) {
  std::vector<int> fingers;
  for (int i = 0; i < static_cast<int>(digits.size()); ++i)
    if (i != thumb) fingers.push_back(i);
  const auto baseOf = [&](int i) {
    return digits[static_cast<std::size_t>(i)].base;
  };

  Eigen::Vector3d across = Eigen::Vector3d::Zero();
  for (const int a : fingers)
    for (const int b : fingers)
      if ((baseOf(b) - baseOf(a)).norm() > across.norm() + 1e-9) across = baseOf(b) - baseOf(a);
  if (thumb >= 0) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const int i : fingers)
      centre += baseOf(i) / static_cast<double>(fingers.size());
    if ((baseOf(thumb) - centre).dot(across) > 1e-6 * across.norm()) across = -across;
  }
  std::stable_sort(fingers.begin(), fingers.end(), [&](int a, int b) {
    return baseOf(a).dot(across) < baseOf(b).dot(across) - 1e-12;
  });
  return fingers;
}

std::vector<std::string> nameDigits(const std::vector<Digit>& digits) {
  std::vector<std::string> names(digits.size());
  // Names that the file gives count when every digit has its own.
  std::set<std::string> hints;
  for (const Digit& digit : digits)
    hints.insert(digit.hint);
  if (hints.size() == digits.size() && !hints.contains("")) {
    for (std::size_t i = 0; i < digits.size(); ++i)
      names[i] = digits[i].hint;
    return names;
  }
  const int thumb = findThumb(digits);
  const std::vector<int> fingers = orderFingers(digits, thumb);
  const bool usual = thumb >= 0 && fingers.size() <= kFingerNames.size();
  for (std::size_t rank = 0; rank < fingers.size(); ++rank)
    names[static_cast<std::size_t>(fingers[rank])] =
        usual ? std::string(kFingerNames[rank]) : fmt::format("f{}", rank + 1);
  if (thumb >= 0) names[static_cast<std::size_t>(thumb)] = "thumb";
  return names;
}

// === The palm

std::optional<ContactSite> findPalm(const HandModel& model,
                                    const Skin& skin,
                                    const LinkPoses& X_SL,
                                    const Digits& found,
                                    const std::vector<std::string>& names) {
  Eigen::Vector3d facing = Eigen::Vector3d::Zero();
  Eigen::Vector3d outward = Eigen::Vector3d::Zero();
  Eigen::Vector3d bases = Eigen::Vector3d::Zero();
  Eigen::Vector3d thumb_base = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (std::size_t i = 0; i < found.digits.size(); ++i) {
    const Digit& digit = found.digits[i];
    if (names[i] == "thumb") thumb_base = digit.base;
    if (names[i] == "thumb" && found.digits.size() > 3) continue;
    facing += digit.closing;
    outward += digit.outward;
    bases += digit.base;
    count += 1.0;
  }
  if (count == 0.0 || facing.norm() < 0.1 * count) return std::nullopt;
  facing.normalize();
  bases /= count;
  Eigen::Vector3d wristwards = -outward / count;
  wristwards -= wristwards.dot(facing) * facing;
  // Fingers all around the palm: towards the thumb, for want of a wrist.
  if (wristwards.norm() < 0.3) wristwards = thumb_base - bases;

  const std::vector<int> links = rigidGroupOf(model, found.palm_link);
  Eigen::AlignedBox3d box;
  for (const int link : links)
    for (const Shape& shape : model.links()[static_cast<std::size_t>(link)].surface())
      for (int v = 0; v < shape.mesh_L.vertexCount(); ++v)
        box.extend(X_SL[static_cast<std::size_t>(link)] * shape.mesh_L.vertex(v));
  if (box.isEmpty()) return std::nullopt;

  for (const double share : {0.5, 0.35, 0.65, 0.2, 0.0, 0.8, 1.0}) {
    const Eigen::Vector3d origin = (1.0 - share) * bases + share * box.center();
    if (const auto place = shoot(skin, origin, facing, links)) {
      ContactSite site = siteAt(model, X_SL, *place, wristwards);
      site.name = "palm";
      return site;
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<ContactSite> findContactSites(const HandModel& model, const Skin& skin) {
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skin.qReference(), X_SL);
  const Digits found = findDigits(model, X_SL);
  const std::vector<std::string> names = nameDigits(found.digits);

  std::vector<ContactSite> sites;
  for (std::size_t i = 0; i < found.digits.size(); ++i) {
    if (auto site = findPad(model, skin, X_SL, found.digits[i])) {
      site->name = names[i];
      sites.push_back(std::move(*site));
    }
  }
  if (auto palm = findPalm(model, skin, X_SL, found, names)) sites.push_back(std::move(*palm));

  static const std::array<const char*, 6> kOrder{"thumb", "index",  "middle",
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
