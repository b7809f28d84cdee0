#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/base/progress.h"
#include "core/geometry/ball_tree.h"
#include "core/geometry/signed_distance.h"

namespace handgraft::geometry {

/// A place of an object's surface that points inside the object do not speak for: of a thin
/// wall, of a sheet, of an edge.
struct WallSample {
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d n = Eigen::Vector3d::Zero();  ///< outwards; of a sheet one side's
  double area_m2 = 0.0;
  double thickness_m = 0.0;  ///< of the wall beneath; 0: a sheet; infinite: no thin wall
};

/// Where an object is so thin or so sharp that its inside does not say how deep another body
/// lies in it: samples of its surface, to be looked for in that body.
///
/// A wall is thin below kThin; edges count where faces meet at more than kSharp, corners and
/// tips where the faces around them leave out as much of a full turn.
/// Deterministic; const and safe from several threads.
class Walls {
 public:
  static constexpr double kThin = 0.012;  // m; about a finger
  static constexpr double kSharp = 0.6;   // rad

  struct Options {
    double spacing_m = 2.5e-3;  ///< of the samples; more where they would be too many
    int most_samples = 8000;    ///< about
  };

  /// Errors: Cancelled on wish. Cost: some 20 ms.
  Walls(const SignedDistance& exact, const Options& options, const Progress& progress);

  [[nodiscard]] const std::vector<WallSample>& samples() const { return samples_; }

  /// Calls `visit(sample)` for those in no ball that `passes(centre, radius)`.
  template <class Passes, class Visit>
  void visit(const Passes& passes, const Visit& visit) const {
    tree_.visit(passes, [&](int begin, int end) {
      for (int k = begin; k < end; ++k)
        visit(samples_[static_cast<std::size_t>(k)]);
    });
  }

  /// The same for all samples within `radius` of `centre`, and some more.
  template <class Visit>
  void visitNear(const Eigen::Vector3d& centre, double radius, const Visit& visit) const {
    const auto is_far = [&](const Eigen::Vector3d& ball, double ball_radius) {
      const double reach = ball_radius + radius;
      return (ball - centre).squaredNorm() > reach * reach;
    };
    this->visit(is_far, visit);
  }

 private:
  std::vector<WallSample> samples_;
  BallTree tree_;
};

}  // namespace handgraft::geometry
