#include "core/quality/clearance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/error.h"
#include "core/base/pose.h"
#include "core/geometry/surface_point.h"
#include "core/geometry/tangent.h"

namespace handgraft::quality {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kLift = 0.0005;        // m; facets of skins and scans
constexpr double kClear = 0.0001;       // m; a depth that counts as none
constexpr double kThickest = 0.03;      // m; radius beyond which clearance is never missing
constexpr std::size_t kMostBalls = 16;  // more change no answer by 0.1 mm
constexpr std::size_t kMostCandidates = 60;  // places on a link that balls are made at
constexpr double kSlide = 0.002;             // m
constexpr double kStandOff = 0.001;          // m
constexpr double kTurn = std::numbers::pi / 6.0;
constexpr double kTilt = std::numbers::pi / 18.0;

/// Columns: `along`, `out` x `along`, `out`.
Matrix3d contactFrame(const Vector3d& along, const Vector3d& out) {
  Matrix3d R;
  R.col(2) = out.normalized();
  R.col(0) = (along - along.dot(R.col(2)) * R.col(2)).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return R;
}

Pose poseOf(const Matrix3d& R, const Vector3d& p) {
  Pose X = Pose::Identity();
  X.linear() = R;
  X.translation() = p;
  return X;
}

/// How far the balls, their frame at `X_OC`, enter the surface; gives up beyond `enough`.
double depthAt(const geometry::SurfaceLocator& object_O,
               const ContactBody& body,
               const Pose& X_OC,
               double enough) {
  double depth = 0.0;
  for (const Ball& ball : body) {
    depth = std::max(depth, ball.radius - object_O.nearest(X_OC * ball.center).distance);
    if (depth >= enough) break;
  }
  return depth;
}

/// Contacts within the slide: the place itself first.
std::vector<ContactPlace> placesAround(const geometry::SurfaceLocator& object_O,
                                       const ContactPlace& place,
                                       const Matrix3d& R_OC) {
  constexpr int kAround = 6;
  std::vector<ContactPlace> places = {place};
  for (int k = 0; k < kAround; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kAround;
    const Vector3d way = std::cos(angle) * R_OC.col(0) + std::sin(angle) * R_OC.col(1);
    const auto hit = object_O.nearest(place.p_O + kSlide * way);
    const Vector3d n_O = normalOf(object_O.mesh(), hit.point);
    // Round an edge lies another contact.
    if (n_O.dot(place.n_O) < 0.5) continue;
    places.push_back({hit.position, n_O, place.direction_O});
  }
  return places;
}

std::vector<double> turns(bool direction_is_open) {
  if (!direction_is_open) return {0.0, 0.5 * kTurn, -0.5 * kTurn, kTurn, -kTurn};
  std::vector<double> all(12);
  for (std::size_t k = 0; k < all.size(); ++k)
    all[k] = 2.0 * std::numbers::pi * static_cast<double>(k) / 12;
  return all;
}

std::array<Vector3d, 5> tilts() {
  return {Vector3d::Zero(), kTilt * Vector3d::UnitX(), -kTilt * Vector3d::UnitX(),
          kTilt * Vector3d::UnitY(), -kTilt * Vector3d::UnitY()};
}

/// The candidate that reaches farthest out of a body's balls; null if none does.
const Ball* farthestOut(const std::vector<Ball>& candidates, const ContactBody& body) {
  double most = kLift;
  const Ball* best = nullptr;
  for (const Ball& candidate : candidates) {
    double outside = candidate.radius;
    for (const Ball& ball : body) {
      outside = std::min(
          outside, (candidate.center - ball.center).norm() + candidate.radius - ball.radius);
    }
    if (outside <= most) continue;
    most = outside;
    best = &candidate;
  }
  return best;
}

}  // namespace

Ball tangentBall(const geometry::SurfaceLocator& surface,
                 const Eigen::Vector3d& p,
                 const Eigen::Vector3d& n,
                 double most,
                 double lift) {
  constexpr int kMostSteps = 40;
  constexpr double kTouches = 1e-4;  // share of the radius
  const Vector3d from = p + lift * n;
  double radius = most;
  for (int step = 0; step < kMostSteps; ++step) {
    const auto hit = surface.nearest(from + radius * n);
    if (hit.distance >= radius * (1.0 - kTouches)) break;
    const Vector3d way = hit.position - from;
    const double along = way.dot(n);
    if (along <= 0.0) break;
    radius = std::min(radius, way.squaredNorm() / (2.0 * along));
  }
  return {from + radius * n, radius + lift};
}

ContactBody bodyBehind(const hand::Skin& skin, const transfer::PatchPlacement& placement) {
  const geometry::TriangleMesh& mesh_S = skin.mesh();
  const Vector3d root_S = positionOf(mesh_S, placement.root_S);
  const Vector3d n_S = normalOf(mesh_S, placement.root_S);
  const auto on_link = skin.project(root_S, n_S);
  if (!on_link) return {};
  const Matrix3d R_SC = contactFrame(placement.direction_S, -n_S);
  // The skin stands off its links by so much, and its balls are too large by it.
  const double offset = on_link->distance_m;
  const Pose X_CS = inverse(poseOf(R_SC, root_S - offset * n_S));
  const auto take = [&](const Vector3d& p_S, const Vector3d& out_S, double most) {
    const Ball ball = tangentBall(skin.locator(), p_S, -out_S, most, kLift);
    // Inside the hand for certain: without what the lift lets it enter.
    return Ball{X_CS * ball.center, ball.radius - kLift - offset};
  };

  const Ball own = take(root_S, n_S, kThickest);
  std::vector<int> near;
  std::vector<char> seen(static_cast<std::size_t>(mesh_S.vertexCount()), 0);
  for (int face = 0; face < mesh_S.faceCount(); ++face) {
    if (skin.faceLinks()[static_cast<std::size_t>(face)] != on_link->link) continue;
    for (const int vertex : mesh_S.face(face)) {
      char& known = seen[static_cast<std::size_t>(vertex)];
      if (known != 0) continue;
      known = 1;
      const Vector3d p_C = X_CS * mesh_S.vertex(vertex);
      if ((p_C - own.center).norm() <= own.radius + kBodyReach) near.push_back(vertex);
    }
  }
  std::sort(near.begin(), near.end());
  std::vector<Ball> candidates;
  const std::size_t stride = near.size() / kMostCandidates + 1;
  for (std::size_t i = 0; i < near.size(); i += stride) {
    const Ball ball = take(mesh_S.vertex(near[i]), mesh_S.vertexNormals().col(near[i]),
                           own.radius + kBodyReach);
    if ((ball.center - own.center).norm() <= kBodyReach && ball.radius > 0.0)
      candidates.push_back(ball);
  }

  ContactBody body = {own};
  while (body.size() < kMostBalls) {
    const Ball* best = farthestOut(candidates, body);
    if (best == nullptr) break;
    body.push_back(*best);
  }
  return body;
}

bool isOpen(const geometry::SurfaceLocator& object_O, const ContactPlace& place) {
  const Ball ball = tangentBall(object_O, place.p_O, place.n_O, kThickest, kLift);
  return ball.radius >= kThickest;
}

double missingClearance(const geometry::SurfaceLocator& object_O,
                        const ContactBody& body,
                        const ContactPlace& place) {
  if (body.empty()) return 0.0;
  const Vector3d along = place.direction_O.value_or(place.n_O.unitOrthogonal());
  const Matrix3d R_OC = contactFrame(along, place.n_O);
  double least = std::numeric_limits<double>::infinity();
  for (const ContactPlace& at : placesAround(object_O, place, R_OC)) {
    const Matrix3d upright = contactFrame(along, at.n_O);
    for (const double turn : turns(!place.direction_O)) {
      const Matrix3d turned = upright * rotationFromVector(turn * Vector3d::UnitZ());
      for (const Vector3d& tilt : tilts()) {
        const Matrix3d R = turned * rotationFromVector(tilt);
        for (const double gap : {0.0, kStandOff}) {
          const double depth = depthAt(object_O, body, poseOf(R, at.p_O + gap * at.n_O), least);
          least = std::min(least, depth);
          if (least <= kClear) return 0.0;
        }
      }
    }
  }
  return least;
}

}  // namespace handgraft::quality
