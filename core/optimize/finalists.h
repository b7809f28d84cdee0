#pragma once

#include <vector>

#include "core/hand/hand_model.h"
#include "core/optimize/local_search.h"
#include "core/optimize/moment_tree.h"

namespace handgraft::optimize {

/// Decides which explored starts of a multi-start go on to their end, and when enough of them
/// ended in the same place. One per multi-start.
///
/// The best by objective go on, but one only of those that lie close together: they end in the
/// same place, most likely, and would keep out searches that are slower and end lower.
/// Distances are measured where the exploration ended.
class Finalists {
 public:
  /// Keeps a reference.
  explicit Finalists(const hand::HandModel& model) : model_(model) {}

  /// Starts that go on now, best first, out of the first `explored` of `results`; at most
  /// `most` in all rounds together. What was chosen before is not chosen again.
  std::vector<int> choose(const std::vector<LocalResult>& results, int explored, int most);

  /// Poses where those chosen stand, best first, at most `most`.
  [[nodiscard]] std::vector<hand::HandPose> best(const std::vector<LocalResult>& results,
                                                 std::size_t most) const;

  /// Enough searches ended in the best place to look no further: three of those chosen, or such
  /// as stand for half of all that were explored.
  [[nodiscard]] bool agree(const std::vector<LocalResult>& results) const;

 private:
  struct Finalist {
    int start = 0;
    hand::HandPose explored;  ///< where its exploration ended
    int alike = 1;            ///< explored starts that ended close to there, itself included
  };

  const hand::HandModel& model_;
  std::vector<Finalist> chosen_;
  int explored_ = 0;
};

/// Within 2 cm and 0.2 rad of the root and 0.2 rad (2 cm where it slides) of every joint.
bool liesClose(const hand::HandModel& model, const hand::HandPose& a, const hand::HandPose& b);

/// The same of the body that carries all that touches, for the root, and of the joints behind
/// it: a forearm may stand anywhere before its wrist.
bool liesCloseBehindTheWrist(const MomentTree& tree,
                             const hand::HandPose& a,
                             const hand::HandPose& b);

}  // namespace handgraft::optimize
