#pragma once

#include <memory>

#include <Eigen/Core>

#include "core/hand/skin.h"
#include "core/hand/variant.h"

namespace handgraft::hand {

/// A hand's skin made ready to be bent along with variants of the hand.
///
/// Every vertex is bound to the links around it: it goes where its link's surface goes at the
/// reference pose, and along borders between links, and on sheets over through-holes, to a mean
/// of where its links would take it. Faces and their links stay as they are, so that a place on
/// the skin (a face, barycentric weights) means the same on every variant. No wrap is made:
/// where parts grow into each other, the skin crosses itself (skin_report.h measures).
///
/// Threads: const methods from any thread. Cost: some 20 ms; a variant, some 50 ms.
class SkinBending {
 public:
  SkinBending(std::shared_ptr<const HandModel> model, std::shared_ptr<const Skin> skin);

  /// The variant's skin; the original one if the variant has its shape. `variant` is of the
  /// model given, with its surfaces. A skin point is on a link within epsilon times the largest
  /// stretch of a link.
  [[nodiscard]] std::shared_ptr<const Skin> bent(const HandVariant& variant) const;

 private:
  std::shared_ptr<const HandModel> model_;
  std::shared_ptr<const Skin> skin_;
  Eigen::MatrixXf weights_;  ///< links x vertices; columns sum to 1
};

}  // namespace handgraft::hand
