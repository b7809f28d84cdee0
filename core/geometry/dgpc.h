#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/log_map_source.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::geometry {

/// Carries geodesic polar coordinates from a source over a mesh, nearest vertices first.
///
/// A vertex is reached through an edge of one of its faces (a window) whose two ends are known:
/// the source is laid flat behind that edge and looked at across it. Where the ends lie on one
/// isometric sheet (plane, cylinder, a strip around the source) their polar coordinates place
/// the source, and the result is exact; elsewhere their distances do, as in DGPC.
///
/// Source: Melvaer & Reimers 2012, sections 3 and 4. Differs: DECISIONS of this folder.
class Dgpc {
 public:
  struct Node {
    double r = 0.0;
    Eigen::Vector2d direction_T = Eigen::Vector2d::UnitX();
    /// What a fitted value has to gain, as a share of r.
    double least_gain = 0.0;
    /// Below this it does, against what the vertex spread last.
    double fitted_limit = std::numeric_limits<double>::infinity();
    int vertex = -1;
    int visits = 0;
    /// Seen along a straight line through an unfolded strip of faces, with nothing fitted.
    bool exact = false;
    bool settled = false;  ///< has spread what it has
    bool waits = false;    ///< improved, and not in the queue yet

    [[nodiscard]] Eigen::Vector2d position() const { return r * direction_T; }

    /// In (-pi, pi].
    [[nodiscard]] double phi() const {
      const double angle = std::atan2(direction_T.y(), direction_T.x());
      return angle == -std::numbers::pi ? std::numbers::pi : angle;
    }
  };

  Dgpc(const TriangleMesh& mesh, const SourceLayout& source, double radius);

  /// Runs until every vertex within the radius, and the corners of faces that reach into it,
  /// are final.
  void run();

  /// All vertices touched, those beyond the radius included, in no particular order.
  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }

  /// The node of a vertex, or null.
  [[nodiscard]] const Node* nodeOf(int vertex) const {
    const int node = node_of_[vertex];
    return node >= 0 ? &nodes_[node] : nullptr;
  }

 private:
  /// An edge with the source laid flat behind it, at the origin of coordinates along the edge.
  struct Window {
    Eigen::Vector2d left_direction_T;
    Eigen::Vector2d right_direction_T;
    Eigen::Vector2d left;
    Eigen::Vector2d right;
  };

  /// A face behind a window: edge lengths, all there is to fit with.
  struct Behind {
    int apex;
    double length;  ///< of the window's own edge
    double left_length;
    double right_length;
  };

  /// What is seen between two rays from a window's origin, entering a face through its
  /// halfedge; `left` and `right` are the halfedge's ends, the rays may be narrower.
  struct Beam {
    int halfedge = -1;
    Eigen::Vector2d left;
    Eigen::Vector2d right;
    Eigen::Vector2d along;  ///< unit, from left to right
    Eigen::Vector2d left_ray;
    Eigen::Vector2d right_ray;
    bool left_known = false;  ///< its node has this very place
    bool right_known = false;
  };

  /// The corner opposite the halfedge through which a beam has come into a face.
  struct Apex {
    int vertex = -1;
    double r = 0.0;
    Eigen::Vector2d place = Eigen::Vector2d::Zero();
    Eigen::Vector2d from_left = Eigen::Vector2d::Zero();  ///< from the beam's left end
    Eigen::Vector2d to_right = Eigen::Vector2d::Zero();   ///< to its right end
    bool beyond_left = false;                             ///< left of the beam's left ray
    bool beyond_right = false;
    bool known = false;  ///< its node has this very place

    [[nodiscard]] bool isSeen() const { return !beyond_left && !beyond_right; }
  };

  /// How a candidate is compared with what a vertex has.
  enum class Kind { kExact, kFitted };

  void spread(int index);
  void spreadInto(const Node& from, int halfedge);
  void alongEdge(const Node& from, int to, double length);
  void queueImproved();
  void throughWindow(int halfedge, const Node& left, const Node& right, const Behind& face);
  void lookThrough(const Node& left, const Node& right, const Behind& face);
  /// False if both ends have exact places, and no fitted value should pass between them.
  [[nodiscard]] bool throughSheet(int halfedge,
                                  const Node& left,
                                  const Node& right,
                                  double length);
  void follow(const Window& window, int halfedge);
  static Apex unfold(const Beam& beam, int vertex, const Eigen::Vector2d& local, double length);
  [[nodiscard]] bool goesPast(const Apex& apex, const Beam& beam, bool is_first_face) const;
  void split(const Beam& beam, const Apex& apex);
  static Eigen::Vector2d directionThrough(const Window& window, const Eigen::Vector2d& p);
  [[nodiscard]] bool reachesIn(const Node& a, const Node* b, double length) const;
  [[nodiscard]] bool isBetter(int vertex, double r, Kind kind) const;
  void offer(int vertex, double r, const Eigen::Vector2d& direction_T, Kind kind);
  [[nodiscard]] bool standsAt(int vertex,
                              const Window& window,
                              const Eigen::Vector2d& p,
                              double r) const;
  /// Straight lines may pass the vertex on either side: no curvature sits in it.
  [[nodiscard]] bool isFlat(int vertex) const;

  const TriangleMesh& mesh_;
  double radius_;
  int source_vertex_;
  double reach_ = 0.0;    ///< longest edge met: how far beyond the radius faces stretch
  bool may_meet_ = true;  ///< vertices that have no node yet
  std::vector<Node> nodes_;
  std::vector<int> node_of_;
  std::vector<int> improved_;
  std::vector<std::pair<double, int>> heap_;
  std::vector<Beam> beams_;
};

}  // namespace handgraft::geometry
