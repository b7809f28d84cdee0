#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "core/geometry/surface_locator.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/link_surfaces.h"

namespace handgraft::hand {

/// The surfaces of a hand's links at one pose, each to be asked by itself. Frame S.
///
/// Queries are const and may run on several threads.
class LinkLocators {
 public:
  /// `link_count` links, of which some may have no face. Cost: O(F log F).
  LinkLocators(const LinkSurfaces& surfaces_S, int link_count);

  struct Hit {
    int link = -1;
    Eigen::Vector3d position_S = Eigen::Vector3d::Zero();
    Eigen::Vector3d n_S = Eigen::Vector3d::Zero();  ///< of the face hit; zero without area
    double distance_m = 0.0;
  };

  /// A link's own surface; null if it has no face.
  [[nodiscard]] const geometry::TriangleMesh* surfaceOf(int link) const;

  /// The nearest place of one link, or nothing beyond `reach_m`.
  [[nodiscard]] std::optional<Hit> nearestOf(int link,
                                             const Eigen::Vector3d& p_S,
                                             double reach_m) const;
  /// The nearest place of any link, or nothing beyond `reach_m`; ties go to the lower link.
  [[nodiscard]] std::optional<Hit> nearest(const Eigen::Vector3d& p_S, double reach_m) const;
  /// The nearest places of all links within `reach_m`, by link.
  [[nodiscard]] std::vector<Hit> within(const Eigen::Vector3d& p_S, double reach_m) const;

 private:
  std::vector<Eigen::AlignedBox3d> boxes_S_;
  std::vector<std::unique_ptr<geometry::SurfaceLocator>> locators_;
};

/// How badly a link suits a place of the skin, in metres: its distance, up to twice that where
/// the link's surface lies above the skin (whose unit normal is `n_S`) instead of beneath.
double misfit(const LinkLocators::Hit& hit,
              const Eigen::Vector3d& p_S,
              const Eigen::Vector3d& n_S);

/// The link that each face of a skin belongs to; -1 where none is within `epsilon_m`.
///
/// Decided once, at the pose of `links`: the link of least misfit; then neighbours agree (a
/// face changes its link for at most 0.3 mm a neighbour), and splinters of a link's area go to
/// what surrounds them. Cost: about 10 us a face.
std::vector<int> linksOfFaces(const geometry::TriangleMesh& skin_S,
                              const LinkLocators& links,
                              double epsilon_m);

}  // namespace handgraft::hand
