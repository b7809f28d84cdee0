#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/error.h"
#include "core/hand/kinematics.h"
#include "server/store/model_store.h"

namespace handgraft::server {

/// Joints of a hand as a client or a file names them, those of its floating base among them.
class NamedJoints {
 public:
  enum class Followers {
    kRefused,  ///< joints that mimic another one cannot be moved by themselves
    kLeftOut,  ///< they follow: for files that list all joints
  };

  /// Keeps `hand`. Errors: InvalidInput for a joint that the hand lacks, or one named twice.
  NamedJoints(const StoredHand& hand,
              const std::vector<std::string>& joints,
              Followers followers);

  /// Whether the floating base's joints are among them.
  [[nodiscard]] bool tellRoot() const { return !of_root_.empty(); }

  /// Joints of the hand that are not among them, by name.
  [[nodiscard]] std::vector<std::string> missing() const;

  /// `values` in their order (rad, m); joints not named as in `start`, the root at `X_WH`
  /// unless joints tell it. Errors: InvalidInput for a value that is not finite, naming the
  /// joint, and for a root that is told twice (`root_is_given`).
  [[nodiscard]] hand::HandPose poseAt(const Eigen::Ref<const Eigen::VectorXd>& values,
                                      const Eigen::VectorXd& start,
                                      const Pose& X_WH,
                                      bool root_is_given) const;

 private:
  static constexpr int kNone = -1;

  struct Dof {
    int of_hand = kNone;
    int of_root = kNone;
  };

  const StoredHand& hand_;
  std::vector<std::string> names_;
  std::vector<Dof> dofs_;
  std::string of_root_;  ///< the last one of the floating base; empty: none
};

/// One line, of the joints that leave their limits by more than what files round away: the one
/// that goes farthest beyond, with its value there, and the names of the others. Empty if none
/// does. `poses`: of one hand.
std::vector<std::string> beyondLimits(const hand::HandModel& model,
                                      const std::vector<hand::HandPose>& poses);

/// What `make` makes of joints of which `beyond` was noted. Errors: its own; of an InvalidInput
/// the first of the notes is told, too, since it may be why.
template <class Make>
auto tellingWhatIsBeyond(const std::vector<std::string>& beyond, const Make& make) {
  try {
    return make();
  } catch (const InvalidInput& error) {
    if (beyond.empty()) throw;
    rejectInput("{}; {}", error.what(), beyond.front());
  }
}

}  // namespace handgraft::server
