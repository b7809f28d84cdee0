#pragma once

#include <array>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "core/optimize/avoidance.h"
#include "core/optimize/moment_tree.h"
#include "core/optimize/near_samples.h"

namespace handgraft::optimize {

/// A sample that lies where it should not. Directions in W, places from the root's origin.
struct PenetratingSample {
  int body = 0;
  int other = -1;  ///< the body it lies in; -1: the object
  Eigen::Vector3d arm_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d slope_W = Eigen::Vector3d::Zero();  ///< of the distance by the sample's place
  double depth = 0.0;                                 ///< m, above 0
  double weight = 0.0;                                ///< times lambda
};

/// The charge of Avoidance at a pose of the tree's bodies. Keeps scratch memory: one a thread.
class AvoidanceTerm {
 public:
  /// Keeps references to what `avoidance` shares. `tree` was made of a problem that has it.
  AvoidanceTerm(const Avoidance& avoidance, const MomentTree& tree);

  /// From the next evaluation on.
  void level(const AvoidanceLevel& level) { level_ = level; }

  /// The sum, without lambda: m^2. Notes what touches.
  /// Cost: some 3 us where nothing is near; some 15 us a grasp in small steps, twice that
  /// after a leap; half by few samples.
  double evaluate(const Eigen::Vector3d& p_WH, const std::vector<BodyPlace>& bodies);

  /// Puts in what another term of the same hand and object has listed, or nothing, and takes
  /// out what this one has: for who evaluates many poses in turns. Values stay the same.
  void swapNear(NearLists& near) { std::swap(near_, near); }

  /// Of the pose evaluated last.
  [[nodiscard]] const std::vector<PenetratingSample>& touches() const { return touches_; }

  /// What the objective has of it: lambda times the sum.
  [[nodiscard]] double weight() const { return level_.share * avoidance_.weight; }

 private:
  [[nodiscard]] const hand::SampleSet& samplesOf(const hand::LinkSolid& solid) const {
    return level_.fine ? solid.fine : solid.coarse;
  }

  void chargeObject(const Eigen::Vector3d& p_WH);
  void chargeWalls(std::size_t link, const Pose& X_OL, const Eigen::Vector3d& centre_O);
  void chargeItself();
  void charge(int a, int b, NearSamples& near);

  /// A link's pose from the root's origin, in W.
  struct Place {
    Eigen::Matrix3d R_WL = Eigen::Matrix3d::Identity();
    Eigen::Vector3d arm_W = Eigen::Vector3d::Zero();
    Eigen::Vector3d centre_W = Eigen::Vector3d::Zero();  ///< of the ball around it
    Eigen::Vector3d a_W = Eigen::Vector3d::Zero();       ///< ends of the capsule around it
    Eigen::Vector3d b_W = Eigen::Vector3d::Zero();
  };

  Avoidance avoidance_;
  AvoidanceLevel level_;
  Pose X_OW_;
  std::vector<int> bodies_;  ///< per solid link
  std::vector<Pose> X_BL_;
  std::vector<Place> places_;
  std::vector<PenetratingSample> touches_;
  NearLists near_;
};

}  // namespace handgraft::optimize
