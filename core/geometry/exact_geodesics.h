#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/bucket_queue.h"
#include "core/geometry/flat_faces.h"
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
/// filter). Differs: DECISIONS of this folder.
class ExactGeodesics {
 public:
  struct Node {
    int vertex = -1;
    int plane = 0;  ///< index of the plane that `p` is in
    double r = std::numeric_limits<double>::infinity();
    Eigen::Vector2d p = Eigen::Vector2d::UnitX();  ///< seen from that plane's origin
    double turn = 0.0;  ///< departure angle, any full turn of it; valid after run()
    double arrival_angle = 0.0;
    /// Where bending vertices are reached from: an angle, measured counter-clockwise from a
    /// side that starts at the vertex.
    int arrival_side = -1;
    bool bends_paths = false;
    bool is_wanted = false;  ///< corner of a face that the disk reaches into

    [[nodiscard]] Eigen::Vector2d position() const {
      return {r * std::cos(turn), r * std::sin(turn)};
    }

    /// In (-pi, pi].
    [[nodiscard]] double phi() const;
  };

  ExactGeodesics(const TriangleMesh& mesh, const SourceLayout& source, double radius);

  /// Runs until every vertex within the radius, and those of faces that reach out of it, is
  /// final. Cost: O(n^1.5) windows in practice in the n faces of the disk, a few dozen
  /// nanoseconds each, whatever the size of the mesh; at most 4096 windows a side of a face.
  void run();

  /// All vertices touched, those beyond the radius included, in no particular order; r is
  /// infinite where no path came that is known to be shortest.
  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }

  /// The node of a vertex with a finite r, or null.
  [[nodiscard]] const Node* nodeOf(int vertex) const {
    const int node = faces_.vertices().find(vertex);
    return node >= 0 && std::isfinite(nodes_[node].r) ? &nodes_[node] : nullptr;
  }

  /// A face was crossed so often that windows were dropped: distances are upper bounds.
  [[nodiscard]] bool isCutShort() const { return cut_short_; }

 private:
  // Flatter vertices bend no path: whatever lies in their shadow counts as seen past them.
  static constexpr double kFlatAngle = 1e-9;  // rad

  /// A source or bending vertex at the origin; departure angle = base + scale * (angle there).
  struct Plane {
    double offset;  ///< distance from the log map's source to the origin
    double base;
    double scale;  ///< 0 behind a vertex that bends paths
  };

  /// Paths on their way out of a face. Seen from the source, the side ahead runs from left to
  /// right.
  struct Window {
    Eigen::Vector2d left;      ///< the side's end, the window may be narrower
    Eigen::Vector2d along;     ///< unit, from left to right
    Eigen::Vector2d left_ray;  ///< units
    Eigen::Vector2d right_ray;
    int side = -1;  ///< of the face behind
    int plane = -1;
    int left_node = -1;
    int right_node = -1;
    double nearest = 0.0;  ///< least distance of all of its paths' places on the side
  };

  /// The corner of the face behind a window that is not on the side ahead.
  struct Behind {
    int node = -1;  ///< none
    bool is_left = false;
    Eigen::Vector2d place = Eigen::Vector2d::Zero();
  };

  /// The corner opposite the side through which a window has come into a face.
  struct Apex {
    Eigen::Vector2d place;
    Eigen::Vector2d from_left;  ///< from the side's left end
    double squared = 0.0;       ///< distance
    double beyond_left = 0.0;   ///< > 0 left of the window's left ray
    double beyond_right = 0.0;
  };

  /// What of a window goes on to the left and to the right of an apex.
  struct Split {
    Window left;
    Window right;
    bool goes_left = false;
    bool goes_right = false;
  };

  /// Of the face at a vertex, counter-clockwise of `side`, which starts there.
  struct Corner {
    int side;
    double begin;  ///< angle from the fan's first side
    double end;
  };

  void takeNodes();
  [[nodiscard]] bool bendsPaths(int vertex) const;
  [[nodiscard]] bool isOneFan(int vertex) const;

  void seed(const SourceLayout& source);
  bool reach(int node, double r, int plane, const Eigen::Vector2d& p);
  void arriveAt(int node, int side, double angle);

  [[nodiscard]] bool comesFirst(const Behind& behind,
                                const Eigen::Vector2d& place,
                                double known) const;
  bool measure(Window& window, const Behind& behind) const;
  static bool isWide(const Window& window);
  void open(Window window);
  void wait(const Window& window);
  static Apex unfold(const Window& window, const FlatFaces::Side& side);
  static bool isSeen(const Apex& apex);
  void serve(const Window& window, int s, const Apex& apex, Split& split);
  bool goOnRight(const Window& window, int s, const Apex& apex, Window& right) const;
  bool goOnLeft(const Window& window, int s, Window& left) const;
  void carry(Window window);
  void tightenLimit();

  void spread(int node);
  void walkFan(int side);
  void spreadOverFan(int node, bool is_arrival_fan);
  void spreadInto(int plane, const Corner& corner, double low, double high);

  FlatFaces faces_;
  double radius_;
  double limit_;  ///< what lies beyond makes no wanted vertex nearer
  bool cut_short_ = false;
  std::vector<Plane> planes_;
  std::vector<Node> nodes_;
  std::vector<Window> windows_;
  std::vector<int> free_;
  BucketQueue queue_;  ///< a window's number, or the complement of a node's

  std::vector<Corner> fan_;  ///< of the vertex that spreads
  bool fan_is_closed_ = false;
};

}  // namespace handgraft::geometry
