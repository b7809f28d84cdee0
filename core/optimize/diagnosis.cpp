#include "core/optimize/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "core/base/error.h"
#include "core/optimize/align_root.h"
#include "core/optimize/local_search.h"
#include "core/optimize/newton_search.h"

namespace handgraft::optimize {

namespace {

using Eigen::Vector3d;

constexpr int kShortSearch = 24;       // evaluations; five or six do, most of the time
constexpr int kGlance = 10;            // of a patch alone that is reached with the others
constexpr int kLongSearch = 40;        // of a pose that has a way to go
constexpr double kHeadStart = 0.1;     // damping; a tenth of what a search begins with far off
constexpr double kPromise = 1e-6;      // share of the objective that a step must promise
constexpr double kOpened = 5.0;        // steps, of all limits at once
constexpr double kHalf = 0.5;          // of a miss that limits must explain
constexpr double kWorthNaming = 0.02;  // mm
constexpr std::size_t kMostSensitivities = 8;
constexpr std::size_t kMostOfPatch = 3;

/// Mean distances at a pose, mm: of each patch of a report, and over all points.
struct Means {
  std::vector<double> patches;
  double all = 0.0;
};

/// The place of each patch number among the report's patches.
std::map<int, std::size_t> placesOf(const SolveReport& report) {
  std::map<int, std::size_t> places;
  for (std::size_t i = 0; i < report.patches.size(); ++i)
    places[report.patches[i].patch] = i;
  return places;
}

class DistanceMeter {
 public:
  DistanceMeter(const PoseProblem& problem, const SolveReport& report)
      : problem_(problem), counts_(report.patches.size(), 0) {
    const std::map<int, std::size_t> places = placesOf(report);
    for (const PointPair& pair : problem.pairs) {
      const auto place = places.find(pair.patch);
      place_.push_back(place == places.end() ? -1 : static_cast<int>(place->second));
      if (place != places.end()) ++counts_[place->second];
    }
  }

  [[nodiscard]] Means at(const hand::HandPose& pose) const {
    const hand::LinkPoses X_WL = forwardKinematics(*problem_.model, pose);
    Means means;
    means.patches.assign(counts_.size(), 0.0);
    for (std::size_t i = 0; i < problem_.pairs.size(); ++i) {
      const PointPair& pair = problem_.pairs[i];
      const double distance_mm =
          1e3 * (X_WL[static_cast<std::size_t>(pair.link)] * pair.p_L - pair.p_W).norm();
      means.all += distance_mm;
      if (place_[i] >= 0) means.patches[static_cast<std::size_t>(place_[i])] += distance_mm;
    }
    means.all /= std::max<double>(1.0, static_cast<double>(problem_.pairs.size()));
    for (std::size_t k = 0; k < counts_.size(); ++k)
      means.patches[k] /= std::max(1, counts_[k]);
    return means;
  }

 private:
  const PoseProblem& problem_;
  std::vector<int> place_;  ///< per pair; -1: of no patch
  std::vector<int> counts_;
};

/// Searches from one pose with limits moved, one problem's memory for all of them.
class Relaxer {
 public:
  explicit Relaxer(const PoseProblem& problem)
      : prepared_(problem),
        space_(prepared_.space),
        objective_(problem, prepared_.tree),
        search_(problem, space_, objective_) {
    search_.settings.promise = kPromise;
  }

  /// Where a search of so many evaluations from `pose` ends.
  std::pair<hand::HandPose, double> searchFrom(const hand::HandPose& pose,
                                               int evaluations,
                                               double damping) {
    search_.begin(pose, damping);
    while (search_.improve(evaluations) == NewtonSearch::Step::kBetter) {
    }
    return {search_.pose(), search_.terms().objective};
  }

  /// Moves a limit out by `step`; false if nothing can move there.
  bool open(const ActiveLimit& limit, double step) {
    const auto at = std::find(space_.dofs.begin(), space_.dofs.end(), 6 + limit.dof);
    if (at == space_.dofs.end()) return false;
    const auto entry = at - space_.dofs.begin();
    if (limit.upper) {
      space_.upper[entry] += step;
    } else {
      space_.lower[entry] -= step;
    }
    return true;
  }

  void close() {
    space_.lower = prepared_.space.lower;
    space_.upper = prepared_.space.upper;
  }

  [[nodiscard]] Eigen::VectorXd gradientAt(const hand::HandPose& pose) {
    Eigen::VectorXd gradient;
    objective_.evaluate(pose, gradient);
    return gradient;
  }

  [[nodiscard]] const MomentTree& tree() const { return *prepared_.tree; }

 private:
  PreparedProblem prepared_;
  SearchSpace space_;  ///< the prepared one with limits moved
  Objective objective_;
  NewtonSearch search_;
};

double stepOf(const PoseProblem& problem,
              const ActiveLimit& limit,
              const DiagnosisOptions& options) {
  const bool slides = problem.model->dofJoint(limit.dof).type == hand::JointType::kPrismatic;
  return slides ? options.step_m : options.step_rad;
}

/// The mean distance that a patch reaches when nothing else is asked for, mm.
double reachedAlone(const PoseProblem& problem,
                    const SolveReport& report,
                    std::size_t index,
                    double reached_mm) {
  PoseProblem alone = problem;
  alone.avoidance.reset();
  const int patch = report.patches[index].patch;
  std::erase_if(alone.pairs, [patch](const PointPair& pair) {
    return pair.patch != patch;
  });
  Relaxer search(alone);
  const DistanceMeter meter(alone, report);
  const auto mean_from = [&](const hand::HandPose& pose, int evaluations) {
    return meter.at(search.searchFrom(pose, evaluations, 0.0).first).patches[index];
  };
  const bool is_reached = report.patches[index].mean_mm <= reached_mm;
  const double near = mean_from(report.pose, is_reached ? kGlance : kLongSearch);
  if (near <= reached_mm) return near;
  // The root is free: another start, where the closed form wants it, may do better.
  hand::HandPose aligned = report.pose;
  aligned.X_WH = alignRoot(alone, search.tree(), aligned.q);
  return std::min(near, mean_from(aligned, kLongSearch));
}

/// What one open limit brings: its sensitivity over all points, and the change of each patch.
struct Opening {
  LimitSensitivity sensitivity;
  std::vector<double> patches_mm;
};

std::vector<Opening> openEach(const PoseProblem& problem,
                              const SolveReport& report,
                              const DiagnosisOptions& options,
                              const DistanceMeter& meter,
                              Relaxer& relaxer,
                              const Progress& progress) {
  std::vector<Opening> openings;
  // The pose may not be a minimum: what is still to be had there is no merit of a limit.
  const auto [pose, objective] = relaxer.searchFrom(report.pose, kShortSearch, kHeadStart);
  const Means means = meter.at(pose);
  const Eigen::VectorXd gradient = relaxer.gradientAt(pose);
  for (const ActiveLimit& limit : activeLimits(problem, pose)) {
    progress.checkpoint();
    const double slope = (limit.upper ? -1.0 : 1.0) * gradient[6 + limit.dof];
    const double step = stepOf(problem, limit, options);
    // A convex fall is no steeper than at its begin: too little even then.
    if (!(slope * step > options.least_gain * objective)) continue;
    if (!relaxer.open(limit, step)) continue;
    const auto [opened, lower] = relaxer.searchFrom(pose, kShortSearch, kHeadStart);
    relaxer.close();
    Opening opening;
    opening.sensitivity.dof = limit.dof;
    opening.sensitivity.upper = limit.upper;
    opening.sensitivity.limit =
        limit.upper ? problem.upper[limit.dof] : problem.lower[limit.dof];
    opening.sensitivity.slope = slope;
    opening.sensitivity.given = std::clamp(
        (limit.upper ? 1.0 : -1.0) * (opened.q[limit.dof] - opening.sensitivity.limit), 0.0,
        step);
    opening.sensitivity.gain = objective - lower;
    if (opening.sensitivity.gain < options.least_gain * objective) continue;
    const Means after = meter.at(opened);
    opening.sensitivity.gain_mm = means.all - after.all;
    for (std::size_t k = 0; k < means.patches.size(); ++k)
      opening.patches_mm.push_back(means.patches[k] - after.patches[k]);
    openings.push_back(std::move(opening));
  }
  return openings;
}

std::vector<LimitSensitivity> sensitivitiesOfPatch(const std::vector<Opening>& openings,
                                                   std::size_t index) {
  std::vector<LimitSensitivity> sensitivities;
  for (const Opening& opening : openings) {
    if (opening.patches_mm[index] < kWorthNaming) continue;
    sensitivities.push_back(opening.sensitivity);
    sensitivities.back().gain_mm = opening.patches_mm[index];
  }
  std::stable_sort(sensitivities.begin(), sensitivities.end(),
                   [](const auto& a, const auto& b) {
                     return a.gain_mm > b.gain_mm;
                   });
  if (sensitivities.size() > kMostOfPatch) sensitivities.resize(kMostOfPatch);
  return sensitivities;
}

/// Mean distances with all limits that hold the pose moved far out.
Means openAll(const PoseProblem& problem,
              const SolveReport& report,
              const DiagnosisOptions& options,
              const DistanceMeter& meter,
              Relaxer& relaxer) {
  for (const ActiveLimit& limit : report.active_limits)
    relaxer.open(limit, kOpened * stepOf(problem, limit, options));
  const hand::HandPose opened = relaxer.searchFrom(report.pose, kLongSearch, 0.0).first;
  relaxer.close();
  return meter.at(opened);
}

/// Of each patch of the report, over its points.
std::vector<double> weightsOf(const PoseProblem& problem, const SolveReport& report) {
  std::vector<double> weights(report.patches.size(), 0.0);
  const std::map<int, std::size_t> places = placesOf(report);
  for (const PointPair& pair : problem.pairs) {
    if (const auto place = places.find(pair.patch); place != places.end())
      weights[place->second] += pair.weight;
  }
  return weights;
}

}  // namespace

std::string_view nameOf(Verdict verdict) {
  switch (verdict) {
    case Verdict::kNone:
      return "none";
    case Verdict::kReached:
      return "reached";
    case Verdict::kAtLimit:
      return "at_limit";
    case Verdict::kOutOfReach:
      return "out_of_reach";
    case Verdict::kFacingWrong:
      return "normals_in_conflict";
    case Verdict::kNoClearance:
      return "no_clearance";
  }
  HANDGRAFT_REQUIRE(false && "a verdict of the list");
  return {};
}

std::vector<double> facingAngles(const PoseProblem& problem, const SolveReport& report) {
  const std::map<int, std::size_t> places = placesOf(report);
  const hand::LinkPoses X_WL = forwardKinematics(*problem.model, report.pose);
  std::vector<Vector3d> hand_W(report.patches.size(), Vector3d::Zero());
  std::vector<Vector3d> object_W = hand_W;
  for (const PointPair& pair : problem.pairs) {
    const auto place = places.find(pair.patch);
    if (place == places.end()) continue;
    hand_W[place->second] += X_WL[static_cast<std::size_t>(pair.link)].linear() * pair.n_L;
    object_W[place->second] -= pair.n_W;
  }
  std::vector<double> angles;
  for (std::size_t k = 0; k < hand_W.size(); ++k) {
    const double sine = hand_W[k].cross(object_W[k]).norm();
    angles.push_back(std::atan2(sine, hand_W[k].dot(object_W[k])) * 180.0 / std::numbers::pi);
  }
  return angles;
}

std::vector<int> missedPatches(const PoseProblem& problem,
                               const SolveReport& report,
                               const DiagnosisOptions& options) {
  const std::vector<double> weights = weightsOf(problem, report);
  const std::vector<double> facing = facingAngles(problem, report);
  std::vector<int> missed;
  for (std::size_t k = 0; k < report.patches.size(); ++k) {
    const bool is_reached = isReached(report.patches[k].mean_mm, facing[k], options);
    if (weights[k] > 0.0 && !is_reached) missed.push_back(report.patches[k].patch);
  }
  return missed;
}

Diagnosis diagnose(const PoseProblem& problem,
                   const SolveReport& report,
                   const DiagnosisOptions& options,
                   const Progress& progress) {
  HANDGRAFT_REQUIRE(report.pose.q.size() == problem.lower.size());
  Diagnosis diagnosis;
  if (report.outcome == Outcome::kInfeasible) return diagnosis;
  const std::vector<double> weights = weightsOf(problem, report);

  const DistanceMeter meter(problem, report);
  Relaxer relaxer(problem);
  // Of a search that was left before its end, limits would be credited with the rest of the
  // way.
  constexpr int kLook = 8;
  constexpr double kFinished = 1e-3;  // share of the objective
  const bool is_finished = relaxer.searchFrom(report.pose, kLook, 0.0).second >=
                           (1.0 - kFinished) * report.terms.objective;
  std::vector<Opening> openings;
  if (is_finished) openings = openEach(problem, report, options, meter, relaxer, progress);
  for (const Opening& opening : openings)
    diagnosis.sensitivities.push_back(opening.sensitivity);
  std::stable_sort(diagnosis.sensitivities.begin(), diagnosis.sensitivities.end(),
                   [](const auto& a, const auto& b) {
                     return a.gain > b.gain;
                   });
  if (diagnosis.sensitivities.size() > kMostSensitivities)
    diagnosis.sensitivities.resize(kMostSensitivities);

  const std::vector<double> facing = facingAngles(problem, report);
  Means open;  // made when first needed
  for (std::size_t k = 0; k < report.patches.size(); ++k) {
    progress.checkpoint();
    const PatchFit& fit = report.patches[k];
    PatchDiagnosis one;
    one.patch = fit.patch;
    one.facing_deg = facing[k];
    if (weights[k] > 0.0) {
      one.miss_mm = std::max(0.0, fit.mean_mm - options.reached_mm);
      one.alone_mm =
          std::min(fit.mean_mm, reachedAlone(problem, report, k, options.reached_mm));
      one.sensitivities = sensitivitiesOfPatch(openings, k);
      if (fit.mean_mm > options.reached_mm) {
        if (open.patches.empty()) open = openAll(problem, report, options, meter, relaxer);
        const double left = std::max(0.0, open.patches[k] - options.reached_mm);
        one.verdict = left <= kHalf * one.miss_mm ? Verdict::kAtLimit : Verdict::kOutOfReach;
      } else {
        one.verdict =
            facing[k] <= options.facing_deg ? Verdict::kReached : Verdict::kFacingWrong;
      }
    }
    diagnosis.patches.push_back(std::move(one));
  }
  return diagnosis;
}

}  // namespace handgraft::optimize
