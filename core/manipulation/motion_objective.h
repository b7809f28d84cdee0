#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "core/manipulation/band_system.h"
#include "core/manipulation/motion_problem.h"
#include "core/optimize/objective.h"
#include "core/optimize/worker_pool.h"

namespace handgraft::manipulation {

/// All frames of a motion at once: Eq. 2 of each, plus smoothness times |second difference|^2
/// (and, far weaker, |first difference|^2: what nothing holds rests over the object), plus what
/// velocities and accelerations beyond their limits cost.
///
/// A second difference is an acceleration times the square of 1/120 s, so that the rate of the
/// frames does not matter; the root's rotation is on the manifold: the turn from frame to
/// frame, and its change.
///
/// Deterministic, whatever the number of threads: each frame is summed by itself, then all in
/// their order. Cost of an evaluation: that of a single frame, times the frames.
class MotionObjective {
 public:
  /// Of these frames of the motion, which rise. Keeps references but to `problems`, `frames`.
  /// Memory: some 20 kB a frame whose contacts differ from the last one's.
  MotionObjective(const MotionProblem& problem,
                  const FrameProblems& problems,
                  const MotionOptions& options,
                  optimize::WorkerPool& pool,
                  const std::vector<int>& frames);

  /// Of all of them.
  MotionObjective(const MotionProblem& problem,
                  const MotionOptions& options,
                  optimize::WorkerPool& pool);

  using Poses = std::vector<hand::HandPose>;

  /// How penetration is looked for from now on.
  void level(const optimize::AvoidanceLevel& level) { level_ = level; }

  /// Shares of smoothness, and of the charge for what lies beyond limits of velocity and
  /// acceleration, from now on: all of it at once is stuck at once.
  void join(double smoothness, double limits);

  double evaluate(const Poses& poses);

  /// What joins frames alone.
  [[nodiscard]] double joining(const Poses& poses) const;

  /// The same, and in passing what `expand` needs of these poses: most trials are accepted.
  double evaluateToExpand(const Poses& poses);

  /// Eq. 2 of each frame at the poses evaluated last.
  [[nodiscard]] const std::vector<double>& frames() const { return frames_; }

  /// Models from now on are those of the poses that `evaluateToExpand` saw last. Frames whose
  /// exact Hessian is positive definite have that, others their Gauss-Newton matrix.
  void takeModels() { std::swap(models_, seen_); }

  /// Gradient (as `right`, its sign turned) and Hessian about the poses of the models; what
  /// joins frames is Gauss-Newton.
  void expand(const Poses& poses, BandSystem& system);

  /// A frame's Eq. 2 alone.
  struct FrameModel {
    Eigen::VectorXd gradient;
    Eigen::MatrixXd hessian;
    Eigen::VectorXd scale;  ///< of the Gauss-Newton matrix: what damping is a share of

    /// What a step changes.
    [[nodiscard]] double changeBy(const Eigen::VectorXd& step) const {
      return gradient.dot(step) + 0.5 * step.dot(hessian * step);
    }
  };

  /// Of the poses whose models were taken last.
  [[nodiscard]] const std::vector<FrameModel>& models() const { return models_; }

  [[nodiscard]] int dofCount() const { return 6 + problem_.model->dofCount(); }

 private:
  double evaluate(const Poses& poses, bool to_expand);
  void modelFrame(optimize::Objective& objective, FrameModel& own) const;
  void addFirstDifferences(const Poses& poses, BandSystem& system) const;
  void addSecondDifferences(const Poses& poses, BandSystem& system) const;

  const MotionProblem& problem_;
  std::vector<double> time_s_;  ///< of the frames that count
  optimize::WorkerPool& pool_;
  optimize::AvoidanceLevel level_;
  double limit_share_ = 1.0;
  /// Frames without their pairs: one for all that have nothing of their own.
  std::vector<std::shared_ptr<const optimize::PoseProblem>> bare_;
  std::vector<std::shared_ptr<const optimize::MomentTree>> trees_;
  Eigen::VectorXd whole_smoothness_;  ///< of each degree of freedom
  Eigen::VectorXd smoothness_;        ///< the share of it that counts now
  std::vector<double> frames_;
  std::vector<FrameModel> models_;
  std::vector<FrameModel> seen_;  ///< by evaluateToExpand
  std::vector<optimize::NearLists> near_;
};

/// A step of each of these frames of the motion: the root's turn by exp(w) R, all else added,
/// joints kept within their limits.
void moveBy(const MotionProblem& problem,
            const std::vector<int>& frames,
            const std::vector<Eigen::VectorXd>& steps,
            const std::vector<hand::HandPose>& from,
            std::vector<hand::HandPose>& to);

}  // namespace handgraft::manipulation
