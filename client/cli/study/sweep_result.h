#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/study/study_axis.h"
#include "client/cli/study/study_files.h"
#include "client/present/render/image.h"
#include "idl/studies.h"

/// What a sweep brought: as a table, as lines for people, as JSON and as a picture.
namespace handgraft::client {

struct SweepResult {
  std::string hand;
  std::vector<StudyGrasp> grasps;  ///< a motion is followed by its patches
  std::vector<StudyAxis> axes;
  /// Unit of each axis for people: rad, deg, m, or none for factors.
  std::vector<std::string> units;
  std::vector<std::string> notes;  ///< on the axes
  v1::SweepReply reply;
};

/// A motion, and behind it each of its patches.
std::vector<StudyGrasp> withPatches(const StudyGrasp& motion,
                                    const std::vector<std::string>& patches);

/// One combination of values, all grasps and motions together.
struct SweepPoint {
  std::vector<double> values;  ///< one per axis, as in the reply
  int solved = 0;           ///< grasps and motions with an answer; the rest counts these alone
  double mean_mm = 0.0;     ///< mean over grasps
  double worst_mm = 0.0;    ///< largest mean of a grasp
  double deepest_mm = 0.0;  ///< of any grasp inside its object
  double self_mm = 0.0;     ///< of any grasp's hand in itself
  int patches = 0;
  /// Of a motion's patches the shares of the frames in which they are reached.
  double reached = 0.0;
};

/// Grasps and motions: the entries that are no patch of a motion.
int studiedCount(const SweepResult& result);

/// Patches that a row speaks of, and reaches: of a motion's patch 1, if it is there at all, and
/// the share of its frames; of a motion's other row none.
double patchesOf(const StudyGrasp& grasp, const v1::SweepRow& row);
double reachedBy(const StudyGrasp& grasp, const v1::SweepRow& row);

/// `12`, or `12.4`.
std::string countText(double count);

/// `3.92`, or `-` for none.
std::string millimetresText(double value_mm);

/// `3 grasps and 1 motion`.
std::string studiedText(const SweepResult& result);

/// Patches that a row reaches of those that it has; of a motion frames. NaN if it has none.
double percentReached(const v1::SweepRow& row);

/// Checks that the reply answers what was asked. Errors: TransportError.
void requireConsistent(const SweepResult& result);

/// In the order of the combinations. NaN distances where no grasp has an answer.
std::vector<SweepPoint> pointsOf(const SweepResult& result);

/// Whether a point stands before another: by its answers, then by the patches that it reaches
/// as people are shown them, then by its mean distance.
bool isBetter(const SweepPoint& a, const SweepPoint& b);

/// The one that no other is better than; the first of equals.
std::size_t bestOf(const std::vector<SweepPoint>& points);

/// The other points that cannot be told from the best one by what people are shown: answers,
/// mean distance and patches reached.
std::vector<std::size_t> asGoodAs(std::size_t best, const std::vector<SweepPoint>& points);

/// Where a patch fewer is reached than at the best point (of motions: one in half of its
/// frames), next to it on either side. One axis
/// alone; its values need not be in order.
struct FirstLoss {
  std::optional<std::size_t> below;  ///< index of a point
  std::optional<std::size_t> above;
};

FirstLoss firstLossOf(const std::vector<SweepPoint>& points, std::size_t best);

/// `thumb_mcp.upper (rad)`.
std::string axisLabel(const SweepResult& result, std::size_t axis);

namespace text {
std::string sweep(const SweepResult& result);
}  // namespace text

namespace json {
/// "format": "handgraft-sweep/1".
std::string sweep(const SweepResult& result, int indent = 2);
}  // namespace json

/// Comma-separated, a header and a row a grasp and combination; COMMANDS.md names the columns.
std::string csvOf(const SweepResult& result);

/// One axis: a curve a grasp, thin, and their mean, and of each of the first motions in how
/// many frames its patches are reached; two: a map of the mean.
/// Errors: InvalidInput for another number of axes.
render::Image pictureOf(const SweepResult& result);

}  // namespace handgraft::client
