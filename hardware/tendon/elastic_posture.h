#pragma once

#include <span>
#include <vector>

#include "hardware/tendon/tendon_hand.h"

namespace handgraft::tendon {

/// The posture of an elastic hand whose tendons are pulled in: the joints minimise
/// sum K (q - q0)^2 / 2 between their stops, subject to every tendon being as long as it is, or
/// slack.
///
/// With tensions f as multipliers, K_j (q_j - q0_j) = sum_i f_i r_ij(q_j), clamped to the
/// stops, gives q(f) joint by joint; tensions then satisfy
///   sum_j e_ij(q_j(f)) + f_i / k_i = e_i,   lowest_i <= f_i <= highest_i,
/// more excursion than asked for at the lowest tension, less at the highest. The left side
/// grows with f (it is a gradient of a convex function), so tendon after tendon is solved by a
/// safeguarded Newton, in sweeps until nothing changes. Tendons that share no joint need one.
///
/// For constant arms, no stops and no bounds that is q = q0 + K^-1 R^T (R K^-1 R^T)^-1 (e - R
/// q0).
///
/// Differs: adaptive synergies (Catalano et al. 2014) have neither stops nor slack tendons.
///
/// No allocation after construction. Not thread-safe.
class ElasticPosture {
 public:
  /// Requires an elastic hand without `problemsOf` numbers and arms.
  explicit ElasticPosture(const TendonHand& hand);

  enum class Stretch { kNone, kTendons };

  /// Solves for excursions `e_m` (m, one per tendon) and tensions in [lowest, highest] (N).
  /// kNone: tendons do not stretch. The results stand in `posture` and `tensions`. False if
  /// sweeps did not settle; the results are then the best so far.
  bool solve(std::span<const double> e_m,
             std::span<const double> lowest_N,
             std::span<const double> highest_N,
             Stretch stretch);

  [[nodiscard]] const std::vector<double>& posture() const { return q_; }

  [[nodiscard]] const std::vector<double>& tensions() const { return f_; }

  /// What the posture pulls tendon `i` in by, m, stretch aside.
  [[nodiscard]] double excursionOf(std::size_t i) const;

 private:
  struct Pull {
    std::size_t tendon;
    Extension extension;
  };

  void relax(std::size_t joint);
  void pull(std::size_t i, double e_m, double lowest, double highest, double compliance);

  std::vector<TendonJoint> joints_;
  std::vector<std::vector<Crossing>> crossings_;  // of each tendon
  std::vector<std::vector<Pull>> pulls_;          // at each joint
  std::vector<double> compliance_;                // m/N of each tendon
  std::vector<double> q_;
  std::vector<double> give_;  // dq/d(torque) of each joint, rad/Nm; 0 at a stop
  std::vector<double> f_;
};

}  // namespace handgraft::tendon
