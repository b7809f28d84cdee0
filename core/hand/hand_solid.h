#pragma once

#include <array>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/base/progress.h"
#include "core/geometry/ball_tree.h"
#include "core/geometry/capsule.h"
#include "core/geometry/distance_grid.h"
#include "core/hand/hand_model.h"
#include "core/hand/skin.h"

namespace handgraft::hand {

/// A place on a link's own surface that stands for some of it. Frame L.
struct SurfaceSample {
  Eigen::Vector3d p_L = Eigen::Vector3d::Zero();
  double area_m2 = 0.0;
};

/// Samples side by side, in the order of the balls around them.
struct SampleSet {
  std::vector<SurfaceSample> samples;
  geometry::BallTree tree_L;

  /// Calls `visit(sample)` for those in no ball that `passes(centre_L, radius)`.
  template <class Passes, class Visit>
  void visit(const Passes& passes, const Visit& visit) const {
    tree_L.visit(passes, [&](int begin, int end) {
      for (int i = begin; i < end; ++i)
        visit(samples[static_cast<std::size_t>(i)]);
    });
  }
};

/// What one link takes up.
struct LinkSolid {
  int link = -1;
  SampleSet coarse;                                    ///< for a solver
  SampleSet fine;                                      ///< for a report
  Eigen::Vector3d centre_L = Eigen::Vector3d::Zero();  ///< of a ball around all of it
  double radius = 0.0;
  geometry::Capsule capsule_L;  ///< around all of it, too
  /// Distance to the link's own surface where that is a solid's; else to its part of the skin,
  /// which stands `skin_offset` off the link, with domes over its cuts: the link goes on in
  /// there, under its neighbours' skin. For objects.
  std::shared_ptr<const geometry::DistanceGrid> grid_L;
  /// The same with flat cuts, since domes stand in the neighbours. For other links.
  std::shared_ptr<const geometry::DistanceGrid> for_links_L;
  double skin_offset = 0.0;
  std::vector<geometry::DistanceGrid::Cell> cells_L;  ///< of the link itself

  /// To an object's point, negative inside the link.
  [[nodiscard]] double distance(const Eigen::Vector3d& p_L) const {
    return grid_L->at(p_L) + skin_offset;
  }

  [[nodiscard]] double distance(const Eigen::Vector3d& p_L, Eigen::Vector3d& gradient) const {
    return grid_L->at(p_L, gradient) + skin_offset;
  }
};

struct HandSolidOptions {
  int coarse_samples = 600;
  int fine_samples = 6000;
  int nodes_per_link = 16000;  ///< at least; larger links have them 1.5 mm apart or so
};

/// What it takes long to find of a hand's solid, so that it can be kept (kept_solid.h): values
/// of its links' grids, and which faces of their surfaces are no walls within. An entry a link,
/// empty where nothing is known or there is nothing such.
struct SolidFindings {
  struct OfLink {
    std::vector<float> for_links;
    std::vector<float> for_objects;
    geometry::SignedDistance::Corners outer_faces;
  };

  std::vector<OfLink> links;
};

/// The hand as a solid: samples of its surface, and a distance field a link.
///
/// Samples come from the skin, which looks outwards, and are moved onto the links' own
/// surfaces; corners and edges of those come first, since they stand out from between others.
/// They stand the farther apart the thicker a link is, fine ones by 4 mm at most, and by 1.5 mm
/// along edges, here and there by 3. A field is of the link's own surface where that holds what
/// its skin does: the skin has nothing of a palm beneath the thumb, nor of knuckles between
/// each other. Where it does not (shells, soups, frames full of screws, walls within), the
/// field is that of the skin's part. What of the skin belongs to no link (sheets over holes)
/// counts for nothing. Deterministic. Const and safe from several threads.
class HandSolid {
 public:
  /// `skin` of this `model`. `findings`, if given: those of making the same solid before, which
  /// are believed where they fit; afterwards complete. Errors: Cancelled on wish. Cost: some
  /// 0.6 s on two cores, half of it with findings.
  HandSolid(const HandModel& model,
            const Skin& skin,
            const Progress& progress,
            const HandSolidOptions& options = {},
            SolidFindings* findings = nullptr);

  /// Links that have skin, by number.
  [[nodiscard]] const std::vector<LinkSolid>& links() const { return links_; }

  /// Pairs of entries of `links` that may not meet: not neighbours (one movable joint apart,
  /// none, or several within a centimetre, as at the base of a thumb), and apart at the rest
  /// pose by all but half a millimetre.
  [[nodiscard]] const std::vector<std::array<int, 2>>& collisionPairs() const {
    return collision_pairs_;
  }

 private:
  void findCollisionPairs(const HandModel& model);

  std::vector<LinkSolid> links_;
  std::vector<std::array<int, 2>> collision_pairs_;
};

/// How deep the deepest fine sample of `a` lies inside `b`, 0 if none does.
/// Frames: X_BA takes points of link a to link b. Cost: some microseconds where they are apart.
double depthOf(const LinkSolid& a, const LinkSolid& b, const Pose& X_BA);

}  // namespace handgraft::hand
