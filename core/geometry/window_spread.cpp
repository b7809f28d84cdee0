// Vertices that bend paths, and how these go on behind them.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/geometry/exact_geodesics.h"

namespace handgraft::geometry {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::Vector2d unit(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

}  // namespace

void ExactGeodesics::spread(int node) {
  const TriangleMesh& mesh = faces_.mesh();
  const int v = nodes_[node].vertex;
  const auto corner_count =
      static_cast<std::size_t>(mesh.outgoingEnd(v) - mesh.outgoingBegin(v));
  walkFan(nodes_[node].arrival_side);
  spreadOverFan(node, true);
  if (fan_.size() == corner_count) return;
  // === Into every other fan, in all directions
  std::vector<int> taken;
  const auto take = [&] {
    for (const Corner& corner : fan_)
      taken.push_back(corner.side);
  };
  take();
  for (const int* h = mesh.outgoingBegin(v); h != mesh.outgoingEnd(v); ++h) {
    const int side = faces_.sideOf(*h);
    if (std::find(taken.begin(), taken.end(), side) != taken.end()) continue;
    walkFan(side);
    take();
    spreadOverFan(node, false);
  }
}

/// Lists the corners of the fan of `side`, counter-clockwise: all around from `side` on, or
/// from the surface's edge to the surface's edge.
void ExactGeodesics::walkFan(int side) {
  int first = side;
  for (int across = faces_.across(first); across >= 0; across = faces_.across(first)) {
    first = FlatFaces::next(across);
    if (first == side) break;
  }
  fan_.clear();
  double angle = 0.0;
  int at = first;
  do {
    const double begin = angle;
    angle += faces_.cornerAngle(at);
    fan_.push_back({at, begin, angle});
    at = faces_.across(FlatFaces::previous(at));
  } while (at >= 0 && at != first);
  fan_is_closed_ = at == first;
  takeNodes();
}

/// A shortest path goes on where it has at least half a turn on either side of it.
void ExactGeodesics::spreadOverFan(int node, bool is_arrival_fan) {
  const int plane = static_cast<int>(planes_.size());
  const Node& n = nodes_[node];
  const Plane& before = planes_[n.plane];
  double turn = before.base;
  if (before.scale > 0.0) turn += before.scale * std::atan2(n.p.y(), n.p.x());
  planes_.push_back({n.r, turn, 0.0});
  double arrival = n.arrival_angle;
  for (const Corner& corner : fan_) {
    if (corner.side == n.arrival_side) arrival += corner.begin;
  }
  const auto serve = [&](double low, double high) {
    for (const Corner& corner : fan_) {
      if (corner.end >= low && corner.begin <= high) {
        spreadInto(plane, corner, low - corner.begin, high - corner.begin);
      }
    }
  };
  if (!is_arrival_fan) {
    serve(-kInfinity, kInfinity);
  } else if (fan_is_closed_) {
    serve(arrival + kPi - kFlatAngle, arrival + fan_.back().end - kPi + kFlatAngle);
  } else {
    serve(-kInfinity, arrival - kPi + kFlatAngle);
    serve(arrival + kPi - kFlatAngle, kInfinity);
  }
}

/// Through a corner, between two angles measured from its side.
void ExactGeodesics::spreadInto(int plane, const Corner& corner, double low, double high) {
  const double angle = corner.end - corner.begin;
  const double offset = planes_[plane].offset;
  const int next = FlatFaces::next(corner.side);
  const int previous = FlatFaces::previous(corner.side);
  const FlatFaces::Side& right_side = faces_.side(corner.side);
  const FlatFaces::Side& left_side = faces_.side(previous);
  const FlatFaces::Side& ahead = faces_.side(next);
  const int right_node = faces_.startOf(next);
  const int left_node = right_side.apex;
  if (offset <= radius_) nodes_[right_node].is_wanted = nodes_[left_node].is_wanted = true;

  // === The neighbours' paths arrive along the sides
  if (low <= kFlatAngle &&
      reach(right_node, offset + right_side.length, plane, Eigen::Vector2d::UnitX())) {
    arriveAt(right_node, next, faces_.cornerAngle(next));
  }
  if (high >= angle - kFlatAngle &&
      reach(left_node, offset + left_side.length, plane, Eigen::Vector2d::UnitX())) {
    arriveAt(left_node, previous, 0.0);
  }

  // === The paths between
  if (!(right_side.inverse_length > 0.0 && left_side.inverse_length > 0.0)) return;
  const Eigen::Vector2d left(right_side.apex_x, right_side.apex_y);
  const Eigen::Vector2d along(right_side.length - right_side.apex_x, -right_side.apex_y);
  open({left, along * ahead.inverse_length,
        high < angle ? unit(high) : Eigen::Vector2d(left * left_side.inverse_length),
        unit(std::max(0.0, low)), next, plane, left_node, right_node});
}

}  // namespace handgraft::geometry
