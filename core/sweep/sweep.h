#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/progress.h"
#include "core/contact/contact_set.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/variant.h"
#include "core/manipulation/motion.h"
#include "core/optimize/solve_report.h"
#include "core/quality/penetration.h"
#include "core/session/session.h"
#include "core/session/solver_settings.h"

namespace handgraft::sweep {

/// One grasp of a study: contacts on an object, whose frame is the world; or a motion.
struct SweepGrasp {
  std::shared_ptr<const geometry::TriangleMesh> object_O;
  contact::ContactSet contacts;
  std::shared_ptr<const manipulation::Motion> motion = nullptr;  ///< instead of contacts
};

/// One property of the hand and the values that it takes.
struct SweepAxis {
  hand::HandProperty property = hand::HandProperty::kUpper;
  std::string target;          ///< joint or link; empty: the whole hand's size
  std::vector<double> values;  ///< rad or m, or factors
};

struct SweepOptions {
  session::SolverSettings solving;
  optimize::Weights weights;
  transfer::TransferOptions transfer;
  int threads = 1;
};

/// A joint that stands at one of its limits.
struct LimitedJoint {
  std::string joint;
  bool upper = false;

  bool operator==(const LimitedJoint&) const = default;
};

/// In how many frames of a motion a patch is there, by half at least, and in how many of these
/// it is reached.
struct SweepPatch {
  std::string name;
  int frames = 0;
  int reached = 0;
  int point_count = 0;  ///< over all these frames, likewise the means
  double mean_mm = 0.0;
  double max_mm = 0.0;  ///< largest mean of a frame
  double normal_deg = 0.0;
};

/// One grasp, or motion, by one variant of the hand.
struct SweepRow {
  int grasp = 0;               ///< index into those asked for
  std::vector<double> values;  ///< one per axis
  std::string error;           ///< why there is no answer; the rest is 0 then
  optimize::Outcome outcome = optimize::Outcome::kStalled;
  optimize::Terms terms;
  int point_count = 0;
  double mean_mm = 0.0;  ///< over all points of patches that count
  double max_mm = 0.0;
  double normal_deg = 0.0;
  quality::Depths
      depths;           ///< also where penetration costs nothing; of a motion's deepest frames
  int patch_count = 0;  ///< of those that have a place on the hand and count
  int reached_count = 0;  ///< of those, as optimize/diagnosis.h has it; in all their frames
  std::vector<LimitedJoint> joints_at_limit;  ///< in half of a motion's frames at least
  Eigen::VectorXd q;                          ///< of a grasp
  std::vector<SweepPatch> patches;            ///< of a motion, in the order of patchNames
  int frame_count = 0;     ///< of a motion: those in which a patch is there, by half at least
  int frames_reached = 0;  ///< of those: in which all that are there are reached
  double solve_ms = 0.0;   ///< not part of the promise below
};

struct SweepResult {
  std::vector<SweepRow> rows;  ///< by combination, the first axis slowest, grasps fastest
  std::vector<std::vector<std::string>> notes;  ///< of each grasp on the hand as it is
};

inline constexpr std::size_t kMostSweepRows = 100'000;

/// Solves every grasp with every combination of values.
///
/// A row is the better of two answers. One is that of a session opened on the variant: fingers
/// dealt, places found and searched as ever. The other keeps where the grasp's patches lie on
/// the skin of the hand as it is, and which way: on other limits the correspondences, on
/// another shape the same places of its bent skin (hand/skin_bending.h), on charts of the
/// object that are kept; it starts from the pose on the hand as it is (and from the starts of
/// `solving`), with the prior that a fresh session has there. It stands unless the first one
/// reaches more, or costs a hundredth less: below that, searches differ by themselves. So a row
/// depends on its grasp and values alone: it is the same in every sweep, in any order, on any
/// number of threads.
///
/// A motion is followed offline, from what its base does and from nothing; the better of both.
/// Distances of a motion are means over all its frames, `terms` the sum's objective alone.
///
/// An InvalidInput of one row (limits that cross) or grasp is told in its rows' `error`.
/// Errors: InvalidInput for no grasp, an axis without values, with values out of range or
///   without such a joint or link, one varied twice, more than kMostSweepRows rows, options out
///   of range. Cancelled on wish.
/// Cost: a session's opening and solve a grasp, and a row (some 0.1 s; of a motion 5 ms a
///   frame); 50 ms a variant of another shape, its solid some 0.3 s, and about a millisecond a
///   patch laid on it.
SweepResult sweep(const hand::Hand& hand,
                  const std::vector<SweepGrasp>& grasps,
                  const std::vector<SweepAxis>& axes,
                  const SweepOptions& options,
                  const Progress& progress);

}  // namespace handgraft::sweep
