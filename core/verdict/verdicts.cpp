#include "core/verdict/verdicts.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/error.h"
#include "core/optimize/solver.h"
#include "core/placement/solids.h"
#include "core/session/derived_state.h"
#include "core/session/patch_matching.h"
#include "core/session/pinned_points.h"

namespace handgraft::verdict {

namespace {

using optimize::LimitSensitivity;
using optimize::PatchDiagnosis;
using optimize::Verdict;

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr int kManyPatches = 3;      // fewer are had by a hand of either side
constexpr double kHardlyAny = 0.05;  // mm; what is printed as 0.0

const std::string& nameOfPatch(const session::Session& session, int patch) {
  const auto index = static_cast<std::size_t>(patch);
  HANDGRAFT_REQUIRE(patch >= 0 && index < session.patches().size());
  return session.patches()[index].patch.name;
}

std::string sensitivityText(const hand::HandModel& model, const LimitSensitivity& sensitivity) {
  const bool slides = model.dofJoint(sensitivity.dof).type == hand::JointType::kPrismatic;
  const std::string given = slides ? fmt::format("{:.1f} mm", 1e3 * sensitivity.given)
                                   : fmt::format("{:.1f} deg", kDegrees * sensitivity.given);
  return fmt::format("{} by {}: {:.1f} mm nearer", nameOf(model, sensitivity), given,
                     sensitivity.gain_mm);
}

std::string atLimitText(const hand::HandModel& model,
                        const PatchDiagnosis& patch,
                        double mean_mm) {
  std::string text = fmt::format("{:.1f} mm off, {:.1f} too far; joint limits keep it away",
                                 mean_mm, patch.miss_mm);
  for (const LimitSensitivity& sensitivity : patch.sensitivities) {
    if (sensitivity.gain_mm < kHardlyAny) continue;
    text += "; " + sensitivityText(model, sensitivity);
  }
  return text;
}

std::string outOfReachText(const PatchDiagnosis& patch,
                           double mean_mm,
                           const std::string& held) {
  const std::string text = fmt::format("{:.1f} mm off, {:.1f} too far", mean_mm, patch.miss_mm);
  if (patch.miss_mm + patch.alone_mm <= mean_mm) {
    return fmt::format("{}; alone it would come to {:.1f} mm: {}", text, patch.alone_mm,
                       held.empty() ? "the other patches keep it away"
                                    : fmt::format("what is held at {} keeps it away", held));
  }
  return fmt::format("{}; even alone {:.1f} mm would remain", text, patch.alone_mm);
}

/// The mean distance that a patch comes to when nothing is asked for but it and what is held,
/// mm.
double besideWhatIsHeld(const optimize::PoseProblem& problem,
                        const optimize::SolveReport& report,
                        int patch,
                        const Progress& progress) {
  optimize::PoseProblem both = problem;
  both.avoidance.reset();
  std::erase_if(both.pairs, [patch](const optimize::PointPair& pair) {
    return pair.patch != patch && pair.patch >= 0;
  });
  both.start = report.pose;
  optimize::SolveOptions options;
  options.starts = 1;
  for (const optimize::PatchFit& fit : optimize::solve(both, options, progress).patches)
    if (fit.patch == patch) return fit.mean_mm;
  return 0.0;
}

/// The links at which the hand is held, if it is that what keeps a patch away which alone would
/// be reached: it misses most of what it does when nothing else is asked for, either.
std::string heldAgainst(const session::Session& session,
                        const optimize::PoseProblem& problem,
                        const optimize::SolveReport& report,
                        const PatchDiagnosis& patch,
                        double mean_mm,
                        const Progress& progress) {
  const std::vector<std::string> links = session::heldLinks(session.document());
  if (links.empty() || patch.verdict != Verdict::kOutOfReach) return "";
  const double beside_mm = besideWhatIsHeld(problem, report, patch.patch, progress);
  if (beside_mm < 0.5 * (patch.alone_mm + mean_mm)) return "";
  return fmt::format("{}", fmt::join(links, ", "));
}

std::string textOf(const hand::HandModel& model,
                   const PatchDiagnosis& patch,
                   double mean_mm,
                   const std::string& held) {
  switch (patch.verdict) {
    case Verdict::kNone:
      return "switched off";
    case Verdict::kReached:
      return fmt::format("{:.1f} mm off on average, mean normals {:.0f} degrees apart", mean_mm,
                         patch.facing_deg);
    case Verdict::kAtLimit:
      return atLimitText(model, patch, mean_mm);
    case Verdict::kOutOfReach:
      return outOfReachText(patch, mean_mm, held);
    case Verdict::kFacingWrong:
      return fmt::format("near, {:.1f} mm off, but turned away by {:.0f} degrees", mean_mm,
                         patch.facing_deg);
    case Verdict::kNoClearance:
      break;  // known before the pose: clearanceText
  }
  throw BrokenContract("a verdict that does not exist");
}

std::string clearanceText(double missing_m) {
  return fmt::format("no clearance: the finger is too thick by at least {:.1f} mm",
                     1e3 * missing_m);
}

// Patches that are asked for and laid, none of whose points came onto the hand: nothing of the
// problem knows them. Those that this hand has no place for (`dropped`) are not asked of it.
std::vector<std::string> patchesWithoutPoints(const session::Session& session,
                                              const optimize::Diagnosis& diagnosis) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < session.patches().size(); ++i) {
    const session::SessionPatch& patch = session.patches()[i];
    if (!patch.placement || patch.patch.weight == 0.0) continue;
    const bool is_judged = std::any_of(diagnosis.patches.begin(), diagnosis.patches.end(),
                                       [&](const PatchDiagnosis& judged) {
                                         return judged.patch == static_cast<int>(i);
                                       });
    if (!is_judged) names.push_back(patch.patch.name);
  }
  return names;
}

/// Not reached whatever the pose says.
std::vector<int> withoutClearance(const FitFindings& findings) {
  std::vector<int> patches;
  for (const MissingClearance& clearance : findings.clearances)
    patches.push_back(clearance.patch);
  return patches;
}

/// Less of a patch's points than this is no account of it.
constexpr double kFewPoints = 0.25;

/// What is to be known of a patch beside how near it comes: the rest of its points counts for
/// nothing, and a root beside it lays it elsewhere. Empty: nothing.
std::string remarkOn(const session::SessionPatch& patch) {
  const transfer::PatchTransfer& laid = patch.transferred;
  const std::size_t points = laid.correspondences.size();
  const std::size_t all = points + laid.lost.size();
  std::string remark;
  if (static_cast<double>(points) < kFewPoints * static_cast<double>(all)) {
    remark = fmt::format("only {} of its {} points {} on the hand", points, all,
                         points == 1 ? "lies" : "lie");
  }
  if (laid.root_is_outside) {
    remark +=
        fmt::format("{}its root lies outside of its boundary", remark.empty() ? "" : ", and ");
  }
  return remark;
}

std::string spanText(const session::Session& session, const optimize::SpanMisfit& span) {
  return fmt::format("{} and {}: {:.0f} mm apart, the hand's places {} {:.0f}",
                     nameOfPatch(session, span.patch_a), nameOfPatch(session, span.patch_b),
                     1e3 * span.object_m, span.lack() > 0.0 ? "at most" : "at least",
                     1e3 * span.hand_m);
}

// Dry skin and rubber hold so much across for what they press.
constexpr double kFriction = 0.5;

/// Whether the patches that are reached all press to one side: then no forces within their
/// friction cones add up to none, and what they touch is pushed away.
bool pressToOneSide(const optimize::PoseProblem& problem,
                    const optimize::Diagnosis& diagnosis) {
  std::vector<Eigen::Vector3d> normals_W;
  for (const PatchDiagnosis& patch : diagnosis.patches) {
    if (patch.verdict != Verdict::kReached) continue;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const optimize::PointPair& pair : problem.pairs)
      if (pair.patch == patch.patch && pair.has_normals) sum += pair.n_W;
    if (sum.isZero()) return false;  // nobody knows
    normals_W.push_back(sum.normalized());
  }
  if (normals_W.size() < 2) return false;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& n_W : normals_W)
    mean += n_W;
  mean.normalize();
  const double cone = std::sin(std::atan(kFriction));
  return std::all_of(normals_W.begin(), normals_W.end(), [&](const Eigen::Vector3d& n_W) {
    return n_W.dot(mean) > cone;
  });
}

}  // namespace

std::string nameOf(const hand::HandModel& model, const LimitSensitivity& sensitivity) {
  return model.dofJoint(sensitivity.dof).name + (sensitivity.upper ? " upper" : " lower");
}

std::string lineOf(const session::Session& session, const FitFindings& findings) {
  std::string large;
  std::string small;
  const auto add = [](std::string& list, const std::string& item) {
    list += (list.empty() ? "" : ", ") + item;
  };
  for (const MissingClearance& clearance : findings.clearances) {
    add(large, fmt::format("{} (by {:.1f} mm)", nameOfPatch(session, clearance.patch),
                           1e3 * clearance.missing_m));
  }
  for (const optimize::SpanMisfit& span : findings.spans)
    add(span.lack() > 0.0 ? small : large, spanText(session, span));
  std::string line;
  if (!large.empty()) line = "too large for " + large;
  if (!small.empty()) line += (line.empty() ? "" : "; ") + ("too small for " + small);
  return line;
}

Verdicts verdictsOf(const session::Session& session,
                    const optimize::PoseProblem& problem,
                    const optimize::SolveReport& report,
                    const FitFindings& findings,
                    const Progress& progress) {
  Verdicts verdicts;
  verdicts.diagnosis = diagnose(problem, report, {}, progress);
  verdicts.too_large = findings.tooLarge();
  int asked = 0;
  int reached = 0;
  std::string remarks;
  for (std::size_t k = 0; k < verdicts.diagnosis.patches.size(); ++k) {
    PatchDiagnosis& patch = verdicts.diagnosis.patches[k];
    const auto clearance = std::find_if(findings.clearances.begin(), findings.clearances.end(),
                                        [&](const MissingClearance& one) {
                                          return one.patch == patch.patch;
                                        });
    const double mean_mm = report.patches[k].mean_mm;
    std::string text = textOf(*problem.model, patch, mean_mm,
                              heldAgainst(session, problem, report, patch, mean_mm, progress));
    if (clearance != findings.clearances.end() && patch.verdict != Verdict::kNone) {
      patch.verdict = Verdict::kNoClearance;
      patch.missing_clearance_m = clearance->missing_m;
      patch.miss_mm = std::max(patch.miss_mm, 1e3 * clearance->missing_m);
      text = clearanceText(clearance->missing_m);
    }
    if (patch.verdict != Verdict::kNone) {
      const auto index = static_cast<std::size_t>(patch.patch);
      const std::string& name = nameOfPatch(session, patch.patch);
      const std::string remark = remarkOn(session.patches()[index]);
      if (!remark.empty()) {
        text += "; " + remark;
        remarks += fmt::format("; {}: {}", name, remark);
      }
    }
    verdicts.texts.push_back(std::move(text));
    if (patch.verdict != Verdict::kNone) ++asked;
    if (patch.verdict == Verdict::kReached) ++reached;
  }
  verdicts.in_the_way =
      session::patchInTheWay(session, problem, report, withoutClearance(findings), 1, progress);
  std::string without;
  if (const session::PatchInTheWay& one = verdicts.in_the_way; one.patch >= 0) {
    // What follows an edit is a short search, which may not come as far.
    without = fmt::format("; solved without {} {} of {} would be",
                          nameOfPatch(session, one.patch), one.reached, one.others);
  }
  const std::vector<std::string> pointless = patchesWithoutPoints(session, verdicts.diagnosis);
  asked += static_cast<int>(pointless.size());
  verdicts.line = report.outcome == optimize::Outcome::kInfeasible
                      ? "joint limits contradict each other"
                      : fmt::format("{} of {} patches reached", reached, asked) + without;
  if (!pointless.empty()) {
    verdicts.line += fmt::format("; {} {} no point on the hand", fmt::join(pointless, ", "),
                                 pointless.size() == 1 ? "has" : "have");
  }
  const auto dropped = std::count_if(session.patches().begin(), session.patches().end(),
                                     [](const session::SessionPatch& item) {
                                       return !item.dropped.empty();
                                     });
  if (dropped > 0) verdicts.line += fmt::format("; {} more dropped", dropped);
  verdicts.one_sided = pressToOneSide(problem, verdicts.diagnosis);
  if (verdicts.one_sided)
    verdicts.line += "; what is reached presses to one side: nothing holds the object there";
  // A note says so in any case; where hardly anything fits it is the first that one must know.
  if (2 * reached <= asked) {
    const session::Sides sides = session::sidesOf(session.models());
    if (sides.differ()) {
      verdicts.line += fmt::format("; a {} hand touched, and this is a {} one",
                                   nameOf(sides.touched), nameOf(sides.own));
    } else if (sides.isHalfKnown() && asked >= kManyPatches) {
      verdicts.line += fmt::format(
          "; which hand touched is not known: if it was a {} one, this one's mirror may reach "
          "more",
          sides.own == hand::Chirality::kLeft ? "right" : "left");
    }
  }
  verdicts.line += remarks;
  const std::string sizes = lineOf(session, findings);
  if (!sizes.empty()) verdicts.line += "; " + sizes;
  return verdicts;
}

quality::Penetration penetrationOf(const session::Session& session,
                                   const hand::HandPose& pose,
                                   const Progress& progress) {
  return placement::penetrationOf(session.hand().model, session.hand().skin,
                                  session.sharedObject(), session.objectPose(), pose,
                                  session::contactSides(session.patches()), progress);
}

}  // namespace handgraft::verdict
