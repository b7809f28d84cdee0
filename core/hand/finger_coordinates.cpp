#include "core/hand/finger_coordinates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>

#include "core/base/error.h"
#include "core/base/weak_cache.h"

namespace handgraft::hand {

namespace {

using geometry::SurfacePoint;
using geometry::TriangleMesh;

/// A place must face along its ray by this cosine; others are inner walls and edges.
constexpr double kFacing = 0.1;
/// What turning away by 90 degrees costs on the palm, against metres.
constexpr double kPalmTurn = 0.03;  // m
/// A wrist is at most this many palm widths from the knuckles: beyond is a forearm.
constexpr double kLongestPalm = 1.7;
/// Lengths of the segments of a human finger, from the tip, as shares: where a place from a
/// list of names is to be laid on a digit of another number of segments.
constexpr double kHumanDistal = 0.27;
constexpr double kHumanMiddle = 0.27;

/// From the first joint to the tip, of an adult.
constexpr double kHumanFinger = 0.09;  // m
constexpr double kHumanThumb = 0.1;    // m
constexpr const char* kThumb = "thumb";

/// The way to the tip as a share of the digit; where nobody knows, that of a human's place of
/// that name.
double fromTip(const HandLocation& place) {
  if (place.from_tip >= 0.0) return place.from_tip;
  const double rest = 1.0 - place.along;
  if (place.segment == "distal") return kHumanDistal * rest;
  if (place.segment == "middle") return kHumanDistal + kHumanMiddle * rest;
  return kHumanDistal + kHumanMiddle + (1.0 - kHumanDistal - kHumanMiddle) * rest;
}

Eigen::Vector3d centreOf(const TriangleMesh& mesh, int f) {
  const Eigen::Vector3i face = mesh.face(f);
  return (mesh.vertex(face[0]) + mesh.vertex(face[1]) + mesh.vertex(face[2])) / 3.0;
}

/// Twice a face's area.
double sizeOf(const TriangleMesh& mesh, int f) {
  const Eigen::Vector3i face = mesh.face(f);
  const Eigen::Vector3d a = mesh.vertex(face[0]);
  return (mesh.vertex(face[1]) - a).cross(mesh.vertex(face[2]) - a).norm();
}

SurfacePoint middleOf(int face) {
  return {face, Eigen::Vector3d::Constant(1.0 / 3.0)};
}

/// How far along the ray it meets the face, and where (Möller and Trumbore).
std::optional<std::pair<double, SurfacePoint>> met(const TriangleMesh& mesh,
                                                   int f,
                                                   const Eigen::Vector3d& origin,
                                                   const Eigen::Vector3d& direction) {
  const Eigen::Vector3i corners = mesh.face(f);
  const Eigen::Vector3d ab = mesh.vertex(corners[1]) - mesh.vertex(corners[0]);
  const Eigen::Vector3d ac = mesh.vertex(corners[2]) - mesh.vertex(corners[0]);
  const Eigen::Vector3d across = direction.cross(ac);
  const double determinant = ab.dot(across);
  if (std::abs(determinant) < 1e-18) return std::nullopt;
  const Eigen::Vector3d ao = origin - mesh.vertex(corners[0]);
  const double u = ao.dot(across) / determinant;
  const Eigen::Vector3d along = ao.cross(ab);
  const double v = direction.dot(along) / determinant;
  constexpr double kEdge = -1e-9;
  if (u < kEdge || v < kEdge || u + v > 1.0 - kEdge) return std::nullopt;
  const double t = ac.dot(along) / determinant;
  if (t <= 0.0) return std::nullopt;
  return std::pair(t, SurfacePoint{f, {1.0 - u - v, u, v}});
}

}  // namespace

FingerCoordinates::FingerCoordinates(const HandModel& model,
                                     const Skin& skin,
                                     const std::vector<ContactSite>& sites)
    : skin_(skin) {
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skin.qReference(), X_SL);
  anatomy_ = anatomyOf(model, X_SL, sites);
  const auto link_count = static_cast<std::size_t>(model.linkCount());
  parts_.resize(link_count);
  digit_of_link_.assign(link_count, -1);
  segment_of_link_.assign(link_count, -1);
  std::vector<char> is_palm(link_count, 0);
  for (const int link : anatomy_.palm_links) {
    parts_[static_cast<std::size_t>(link)] = {kPalmPart, ""};
    is_palm[static_cast<std::size_t>(link)] = 1;
  }
  for (std::size_t d = 0; d < anatomy_.digits.size(); ++d) {
    const NamedDigit& digit = anatomy_.digits[d];
    for (std::size_t s = 0; s < digit.segments.size(); ++s) {
      for (const int link : digit.segments[s].links) {
        parts_[static_cast<std::size_t>(link)] = {digit.name, digit.segments[s].name};
        digit_of_link_[static_cast<std::size_t>(link)] = static_cast<int>(d);
        segment_of_link_[static_cast<std::size_t>(link)] = static_cast<int>(s);
      }
    }
  }

  faces_.resize(anatomy_.digits.size());
  for (int f = 0; f < skin_.mesh().faceCount(); ++f) {
    const int link = skin_.faceLinks()[static_cast<std::size_t>(f)];
    if (link < 0) continue;
    const int digit = digit_of_link_[static_cast<std::size_t>(link)];
    if (digit >= 0) faces_[static_cast<std::size_t>(digit)].push_back(f);
    if (is_palm[static_cast<std::size_t>(link)] != 0) palm_faces_.push_back(f);
  }
  tubes_.resize(anatomy_.digits.size());
  for (std::size_t d = 0; d < tubes_.size(); ++d) {
    tubes_[d].resize(anatomy_.digits[d].segments.size());
    for (std::size_t s = 0; s < tubes_[d].size(); ++s)
      measure(d, s, tubes_[d][s]);
  }
  findPalm();
}

void FingerCoordinates::measure(std::size_t d, std::size_t s, Tube& tube) const {
  const NamedDigit& digit = anatomy_.digits[d];
  const Segment& segment = digit.segments[s];
  const TriangleMesh& mesh = skin_.mesh();
  tube.bone_S = segment.boneInSkin();
  tube.palmar_S = segment.palmar_S;
  tube.length = segment.length();

  // A thumb's own is the side that a finger in its place would have towards the thumb, so that
  // left and right hands mirror each other.
  tube.thumbward_S = tube.bone_S.cross(tube.palmar_S);
  if (anatomy_.chirality == Chirality::kLeft) tube.thumbward_S = -tube.thumbward_S;

  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double area = 0.0;
  const auto is_own = [&](int f) {
    const int link = skin_.faceLinks()[static_cast<std::size_t>(f)];
    return segment_of_link_[static_cast<std::size_t>(link)] == static_cast<int>(s);
  };
  for (const int f : faces_[d]) {
    if (!is_own(f)) continue;
    const double share = sizeOf(mesh, f);
    sum += share * centreOf(mesh, f);
    area += share;
  }
  tube.base_S = segment.base_S;
  if (area > 0.0) {
    const Eigen::Vector3d off = sum / area - segment.base_S;
    tube.base_S += off - off.dot(tube.bone_S) * tube.bone_S;
  }
  double radii = 0.0;
  double counted = 0.0;
  for (const int f : faces_[d]) {
    if (!is_own(f)) continue;
    const Eigen::Vector3d p = centreOf(mesh, f) - tube.base_S;
    const double height = p.dot(tube.bone_S);
    if (height < 0.2 * tube.length || height > 0.8 * tube.length) continue;
    radii += sizeOf(mesh, f) * (p - height * tube.bone_S).norm();
    counted += sizeOf(mesh, f);
  }
  tube.radius = counted > 0.0 ? radii / counted : 0.25 * tube.length;
  const bool is_last = s + 1 == digit.segments.size();
  tube.ball = is_last ? std::max(tube.length - tube.radius, 0.4 * tube.length) : tube.length;
}

void FingerCoordinates::findPalm() {
  if (!anatomy_.palm) return;
  const Palm& palm = *anatomy_.palm;
  palm_width_ = std::abs((palm.last_knuckle_S - palm.first_knuckle_S).dot(palm.thumb_side_S));
  if (palm_width_ < 1e-3 || palm_faces_.empty()) {
    anatomy_.palm.reset();
    return;
  }
  const Eigen::Vector3d middle = 0.5 * (palm.first_knuckle_S + palm.last_knuckle_S);
  for (const int f : palm_faces_) {
    const double below = -(centreOf(skin_.mesh(), f) - middle).dot(palm.outward_S);
    palm_height_ = std::max(palm_height_, below);
  }
  palm_height_ = std::min(palm_height_, kLongestPalm * palm_width_);
  if (palm_height_ < 1e-3) anatomy_.palm.reset();
}

/// The way over a segment's surface from its base to its end.
double FingerCoordinates::waysOver(const Tube& tube) {
  return tube.ball < tube.length
             ? tube.ball + 0.5 * std::numbers::pi * (tube.length - tube.ball)
             : tube.length;
}

std::optional<HandLocation> FingerCoordinates::placeOf(const SurfacePoint& point_S) const {
  const TriangleMesh& mesh = skin_.mesh();
  const int link = skin_.faceLinks()[static_cast<std::size_t>(point_S.face)];
  if (link < 0) return std::nullopt;
  const Eigen::Vector3d p_S = geometry::positionOf(mesh, point_S);
  const Part& part = parts_[static_cast<std::size_t>(link)];
  if (part.digit.empty()) return std::nullopt;
  HandLocation place;
  place.digit = part.digit;
  const int digit = digit_of_link_[static_cast<std::size_t>(link)];

  if (digit < 0) {
    if (!anatomy_.palm) return std::nullopt;
    const Palm& palm = *anatomy_.palm;
    const Eigen::Vector3d n_S = mesh.faceNormals().col(point_S.face);
    const Eigen::Vector3d middle = 0.5 * (palm.first_knuckle_S + palm.last_knuckle_S);
    place.along = -(p_S - middle).dot(palm.outward_S) / palm_height_;
    place.across = -(p_S - palm.first_knuckle_S).dot(palm.thumb_side_S) / palm_width_;
    place.around_rad = std::atan2(n_S.dot(palm.thumb_side_S), n_S.dot(palm.facing_S));
    return place;
  }

  const auto d = static_cast<std::size_t>(digit);
  const auto s = static_cast<std::size_t>(segment_of_link_[static_cast<std::size_t>(link)]);
  const Tube& tube = tubes_[d][s];
  place.segment = part.segment;
  place.segment_count = static_cast<int>(tubes_[d].size());
  const Eigen::Vector3d from_base = p_S - tube.base_S;
  double way = from_base.dot(tube.bone_S);
  const Eigen::Vector3d radial = from_base - way * tube.bone_S;
  const double ball_radius = tube.length - tube.ball;
  if (ball_radius > 0.0 && way > tube.ball)
    way = tube.ball + ball_radius * std::atan2(way - tube.ball, radial.norm());
  place.along = way / waysOver(tube);
  place.around_rad = std::atan2(radial.dot(tube.thumbward_S), radial.dot(tube.palmar_S));

  double to_tip = (1.0 - place.along) * tube.length;
  for (std::size_t k = s + 1; k < tubes_[d].size(); ++k)
    to_tip += tubes_[d][k].length;
  place.from_tip = std::max(0.0, to_tip / anatomy_.digits[d].length());
  return place;
}

FingerCoordinates::Ray FingerCoordinates::rayAt(const Tube& tube,
                                                double along,
                                                double around_rad) {
  const Eigen::Vector3d radial =
      std::cos(around_rad) * tube.palmar_S + std::sin(around_rad) * tube.thumbward_S;
  const double way = along * waysOver(tube);
  const double ball_radius = tube.length - tube.ball;
  if (ball_radius <= 0.0 || way <= tube.ball)
    return {tube.base_S + way * tube.bone_S, radial, -tube.bone_S};
  const double angle = std::min((way - tube.ball) / ball_radius, 0.5 * std::numbers::pi);
  return {tube.base_S + tube.ball * tube.bone_S,
          std::cos(angle) * radial + std::sin(angle) * tube.bone_S,
          std::sin(angle) * radial - std::cos(angle) * tube.bone_S};
}

SkinSpot FingerCoordinates::spotOf(const SurfacePoint& root_S,
                                   const Eigen::Vector3d& to_wrist_S) const {
  const Eigen::Vector3d n_S = geometry::normalOf(skin_.mesh(), root_S);
  Eigen::Vector3d tangent = to_wrist_S - to_wrist_S.dot(n_S) * n_S;
  if (tangent.norm() < 1e-3) tangent = n_S.unitOrthogonal();
  return {root_S, tangent.normalized()};
}

FingerCoordinates::Height FingerCoordinates::heightBySegment(const NamedDigit& digit,
                                                             const HandLocation& place) {
  const bool is_alike = place.segment_count == static_cast<int>(digit.segments.size()) ||
                        (place.segment_count == 0 && digit.segments.size() == 3);
  for (std::size_t s = 0; is_alike && s < digit.segments.size(); ++s)
    if (digit.segments[s].name == place.segment) return {s, place.along};
  double to_tip = fromTip(place) * digit.length();
  std::size_t s = digit.segments.size() - 1;
  while (s > 0 && to_tip > digit.segments[s].length())
    to_tip -= digit.segments[s--].length();
  return {s, 1.0 - to_tip / digit.segments[s].length()};
}

FingerCoordinates::Height FingerCoordinates::heightByLength(const NamedDigit& digit,
                                                            const HandLocation& place) {
  double from_base =
      (1.0 - fromTip(place)) * (place.digit == kThumb ? kHumanThumb : kHumanFinger);
  std::size_t s = 0;
  while (s + 1 < digit.segments.size() && from_base > digit.segments[s].length())
    from_base -= digit.segments[s++].length();
  return {s, std::min(1.0, from_base / digit.segments[s].length())};
}

std::optional<SkinSpot> FingerCoordinates::spotOnDigit(std::size_t d,
                                                       const Height& height,
                                                       double around_rad) const {
  if (faces_[d].empty()) return std::nullopt;

  // === The outermost place on the ray, or the nearest to where it would be
  const Tube& tube = tubes_[d][height.segment];
  const Ray ray = rayAt(tube, height.along, around_rad);
  const TriangleMesh& mesh = skin_.mesh();
  const double farthest = 3.0 * std::max(tube.radius, 0.004);
  std::optional<SurfacePoint> best;
  double best_t = 0.0;
  for (const int f : faces_[d]) {
    if (mesh.faceNormals().col(f).dot(ray.direction_S) < kFacing) continue;
    const auto hit = met(mesh, f, ray.origin_S, ray.direction_S);
    if (!hit || hit->first <= best_t || hit->first > farthest) continue;
    best_t = hit->first;
    best = hit->second;
  }
  if (!best) {
    const Eigen::Vector3d wanted = ray.origin_S + tube.radius * ray.direction_S;
    double nearest = std::numeric_limits<double>::infinity();
    for (const int f : faces_[d]) {
      if (mesh.faceNormals().col(f).dot(ray.direction_S) < kFacing) continue;
      const double distance = (centreOf(mesh, f) - wanted).squaredNorm();
      if (distance >= nearest) continue;
      nearest = distance;
      best = middleOf(f);
    }
  }
  if (!best) return std::nullopt;
  return spotOf(*best, ray.to_wrist_S);
}

std::optional<SkinSpot> FingerCoordinates::spotOnPalm(const HandLocation& place) const {
  if (!anatomy_.palm) return std::nullopt;
  const Palm& palm = *anatomy_.palm;
  const TriangleMesh& mesh = skin_.mesh();
  const Eigen::Vector3d middle = 0.5 * (palm.first_knuckle_S + palm.last_knuckle_S);
  const Eigen::Vector3d facing = std::cos(place.around_rad) * palm.facing_S +
                                 std::sin(place.around_rad) * palm.thumb_side_S;
  std::optional<SurfacePoint> best;
  double least = std::numeric_limits<double>::infinity();
  for (const int f : palm_faces_) {
    const Eigen::Vector3d p = centreOf(mesh, f);
    const double along = -(p - middle).dot(palm.outward_S) - place.along * palm_height_;
    const double across =
        -(p - palm.first_knuckle_S).dot(palm.thumb_side_S) - place.across * palm_width_;
    const double cosine = mesh.faceNormals().col(f).dot(facing);
    const double cost =
        along * along + across * across + kPalmTurn * kPalmTurn * (1.0 - cosine);
    if (cost >= least) continue;
    least = cost;
    best = middleOf(f);
  }
  if (!best) return std::nullopt;
  return spotOf(*best, -palm.outward_S);
}

std::optional<SkinSpot> FingerCoordinates::spotAt(const HandLocation& place) const {
  if (place.digit == kPalmPart) return spotOnPalm(place);
  const int d = digitNamed(place.digit);
  if (d < 0) return std::nullopt;
  const auto at = static_cast<std::size_t>(d);
  return spotOnDigit(at, heightBySegment(anatomy_.digits[at], place), place.around_rad);
}

std::optional<SkinSpot> FingerCoordinates::spotByLength(const HandLocation& place) const {
  const int d = digitNamed(place.digit);
  if (d < 0) return std::nullopt;
  const auto at = static_cast<std::size_t>(d);
  return spotOnDigit(at, heightByLength(anatomy_.digits[at], place), place.around_rad);
}

int FingerCoordinates::digitNamed(const std::string& name) const {
  for (std::size_t d = 0; d < anatomy_.digits.size(); ++d)
    if (anatomy_.digits[d].name == name) return static_cast<int>(d);
  return -1;
}

std::optional<Eigen::Vector3d> FingerCoordinates::towardsWrist(
    const SurfacePoint& point_S) const {
  const auto place = placeOf(point_S);
  if (!place) return std::nullopt;
  if (place->digit == kPalmPart) return spotOf(point_S, -anatomy_.palm->outward_S).direction_S;
  const int link = skin_.faceLinks()[static_cast<std::size_t>(point_S.face)];
  const Tube& tube =
      tubes_[static_cast<std::size_t>(digit_of_link_[static_cast<std::size_t>(link)])]
            [static_cast<std::size_t>(segment_of_link_[static_cast<std::size_t>(link)])];
  return spotOf(point_S, rayAt(tube, place->along, place->around_rad).to_wrist_S).direction_S;
}

std::shared_ptr<const FingerCoordinates> coordinatesOf(const Hand& hand) {
  struct Made {
    std::shared_ptr<const HandModel> model;
    std::vector<ContactSite> sites;
    FingerCoordinates coordinates;
  };

  const auto make = [&] {
    return std::make_shared<const Made>(
        Made{hand.model, hand.sites, FingerCoordinates(*hand.model, *hand.skin, hand.sites)});
  };
  static WeakCache<Skin, Made> memory;
  std::shared_ptr<const Made> made = memory.get(hand.skin, Progress(), make);
  // Another session's sites may be others.
  if (made->model != hand.model || made->sites != hand.sites) made = make();
  return {made, &made->coordinates};
}

}  // namespace handgraft::hand
