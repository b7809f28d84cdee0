#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/log_map_source.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::geometry {

/// Carries exact polyhedral distances, and the directions in which shortest paths leave the
/// source, over a mesh, nearest first.
///
/// A window is a bundle of straight paths through an unfolded strip of faces. It lives in the
/// plane of its own source, which is the origin: the log map's, or, behind a vertex that bends
/// shortest paths (a saddle, a reflex corner of the surface's edge, the tip where two fans
/// touch), that vertex.
///
/// Source: Chen & Han 1990, "Shortest Paths on a Polyhedron" (one angle, one split); Xin & Wang
/// 2009, "Improving Chen and Han's Algorithm on the Discrete Geodesic Problem" (priority queue,
/// filter). Differs: README of this folder.
class WindowFront {
 public:
  struct Node {
    int vertex = -1;
    int plane = 0;  ///< index of the plane that `p` is in
    double r = std::numeric_limits<double>::infinity();
    Eigen::Vector2d p = Eigen::Vector2d::UnitX();  ///< seen from that plane's origin
    double turn = 0.0;  ///< departure angle, any full turn of it; valid after run()
    /// Where bending vertices are reached from: an angle, measured counter-clockwise from a
    /// halfedge that leaves the vertex.
    int arrival_edge = -1;
    double arrival_angle = 0.0;
    bool bends_paths = false;

    [[nodiscard]] Eigen::Vector2d position() const {
      return {r * std::cos(turn), r * std::sin(turn)};
    }

    /// In (-pi, pi].
    [[nodiscard]] double phi() const;
  };

  WindowFront(const TriangleMesh& mesh, const SourceLayout& source, double radius);

  /// Runs until every vertex within the radius, and those of faces that reach out of it, is
  /// final. Cost: O(n log n) windows in practice in the n faces of the disk; at most 4096 a
  /// face.
  void run();

  /// All vertices touched, those beyond the radius included, in no particular order; r is
  /// infinite where no path came.
  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }

  /// The node of a vertex with a finite r, or null.
  [[nodiscard]] const Node* nodeOf(int vertex) const {
    const int node = node_of_[static_cast<std::size_t>(vertex)];
    return node >= 0 && std::isfinite(nodes_[node].r) ? &nodes_[node] : nullptr;
  }

  /// A face was crossed so often that windows were dropped: distances are upper bounds.
  [[nodiscard]] bool isCutShort() const { return cut_short_; }

 private:
  /// A source or bending vertex at the origin; departure angle = base + scale * (angle there).
  struct Plane {
    double offset;  ///< distance from the log map's source to the origin
    double base;
    double scale;  ///< 0 behind a vertex that bends paths
  };

  /// Seen from the source, `left` is the halfedge's start and `right` its end.
  struct Window {
    int halfedge;  ///< of the face entered
    int plane;
    int left_node;
    int right_node;
    int behind_node;           ///< the corner of the face just left that is not on the edge
    Eigen::Vector2d left;      ///< the edge's end, the window may be narrower
    Eigen::Vector2d along;     ///< unit, from left to right
    Eigen::Vector2d left_ray;  ///< units
    Eigen::Vector2d right_ray;
    /// The window is useless once a corner is nearer than this.
    double left_bound;
    double right_bound;
    double behind_bound;
  };

  /// What a window is made from, before it is known to be useful.
  struct Bundle {
    int halfedge;
    int plane;
    int left_node;
    int right_node;
    double length;
    Eigen::Vector2d left;
    Eigen::Vector2d along;
    Eigen::Vector2d left_ray;
    Eigen::Vector2d right_ray;
  };

  enum class Behind { kNone, kLeftOfPaths, kRightOfPaths };

  /// A face of the disk, laid flat once.
  struct Side {
    double length;
    double apex_x;  ///< the opposite corner, along the side and to its left
    double apex_y;
    /// Chen & Han's split: the window through this side that serves the opposite corner best,
    /// and where its path to it crosses the side.
    double split_distance;
    double split_at;
  };

  struct Face {
    std::array<int, 3> nodes;
    std::array<Side, 3> sides;
    int passes;
  };

  /// A distance, and a window's number or the complement of a node's.
  using Event = std::pair<double, int>;

  int nodeAt(int vertex);
  int faceAt(int face);
  [[nodiscard]] bool bendsPaths(int vertex) const;
  [[nodiscard]] bool isOneFan(int vertex) const;

  void seed(const SourceLayout& source);
  bool reach(int node, double r, int plane, const Eigen::Vector2d& p);
  void arriveAt(int node, int edge, double angle);
  void open(const Bundle& bundle,
            Behind behind,
            int behind_node,
            const Eigen::Vector2d& behind_place);
  [[nodiscard]] bool isUseless(const Window& window) const;
  void advance(double distance, int index);
  void pass(const Window& window);

  [[nodiscard]] double cornerAngle(int h);
  [[nodiscard]] int firstOfFan(int h) const;
  void spread(int node);
  void spreadOverFan(int node, int first, double arrival, bool is_arrival_fan);
  void spreadInto(int plane, int h, double low, double high);

  void push(double distance, int index);

  const TriangleMesh& mesh_;
  double radius_;
  double reach_ = 0.0;  ///< longest edge met: how far beyond the radius faces stretch
  bool cut_short_ = false;
  std::vector<Plane> planes_;
  std::vector<Node> nodes_;
  std::vector<int> node_of_;
  std::vector<Face> faces_;
  std::vector<int> face_of_;
  std::vector<Window> windows_;
  std::vector<int> free_;
  double step_ = 0.0;
  double near_end_ = -1.0;  ///< events up to here are near
  std::vector<Event> near_;
  std::vector<Event> far_;  ///< a heap
};

}  // namespace handgraft::geometry
