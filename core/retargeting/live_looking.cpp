#include "core/retargeting/live_looking.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>
#include <tuple>
#include <utility>

#include "core/hand/hand_location.h"
#include "core/optimize/solver.h"
#include "core/placement/posture_finding.h"
#include "core/placement/solids.h"

namespace handgraft::retargeting {

namespace {

/// How long is looked, and how much the hand is held as the demonstrator's is.
struct Search {
  int starts = 0;
  int more_starts = 0;  ///< where all that these find is deep in the object
  int slides = 0;
  double held = 1.0;
};

/// Where touches leave the hand free: to be a radian off costs as much as 1 mm in four touches.
constexpr Search kFull{16, 64, 10, 1000.0};

/// To tell ways to deal fingers apart: by what they reach.
constexpr Search kTrial{4, 0, 3, 1.0};

double depthOf(const LiveGrasp& grasp, const Progress& progress) {
  const LiveSetting& setting = grasp.setting();
  if (!setting.problem.avoidance) return 0.0;
  return placement::deepestOf(setting.hand.model, setting.hand.skin, setting.object_O,
                              *grasp.pose_O, progress);
}

/// How deep what it finds is in the object, m.
double search(const std::vector<contact::PartDirection>& posture,
              const Search& how,
              LiveGrasp& grasp,
              const Progress& progress) {
  contact::ContactSet shown;
  shown.posture = posture;
  const placement::Posture held = placement::postureFor(grasp.setting().hand, shown);
  const auto held_problem = [&](const LiveGrasp& one) {
    optimize::PoseProblem problem = one.problem();
    problem.prior.q = held.q.cwiseMax(problem.lower).cwiseMin(problem.upper);
    problem.prior_weights = Eigen::VectorXd::Ones(problem.dofCount());
    if (!held.R_OH) return problem;  // what is relaxed holds nobody
    const double weight = how.held * held.sureness;
    problem.prior_weights.tail(held.q.size()) *= weight;
    problem.prior.X_WH.linear() = *held.R_OH;
    problem.prior_weights.head<3>() *= weight;
    return problem;
  };
  const optimize::PoseProblem problem = held_problem(grasp);
  const LiveGrasp from = grasp;
  double least_depth = std::numeric_limits<double>::infinity();
  for (const int starts : {how.starts, how.more_starts}) {
    optimize::SolveOptions solving;
    solving.starts = starts;
    const optimize::SolveReport report = optimize::solve(problem, solving, progress);
    std::vector<hand::HandPose> poses;
    for (const optimize::Minimum& minimum : report.minima)
      poses.push_back(minimum.pose);
    if (poses.empty()) poses.push_back(report.pose);
    for (const hand::HandPose& pose : poses) {
      LiveGrasp one = from;
      one.pose_O = pose;
      for (int i = 0; i < how.slides; ++i) {
        one.slide(1.0);
        optimize::SolveOptions warm;
        warm.starts = 1;
        one.pose_O = optimize::solve(held_problem(one), warm, progress).pose;
      }
      const bool nobody_asks = how.more_starts == 0;
      const double depth = nobody_asks ? 0.0 : depthOf(one, progress);
      if (depth < least_depth || depth <= kDeep) {
        least_depth = depth;
        grasp = std::move(one);
      }
      if (depth <= kDeep) return depth;
    }
  }
  return least_depth;
}

/// By short searches, from where the hand is: as sessions deal, which look longer.
void dealAnew(const std::vector<contact::PartDirection>& posture,
              LiveGrasp& grasp,
              const Progress& progress) {
  const std::vector<session::Dealing> ways = grasp.fingers().waysFor(grasp.touchingDigits());
  std::vector<std::string> digits;  // the demonstrator's, as far as the posture tells
  for (const contact::PartDirection& part : posture)
    if (const auto place = hand::placeNamed(part.part)) digits.push_back(place->digit);
  const hand::Anatomy& anatomy = grasp.setting().coordinates->anatomy();
  const session::Dealing* best = nullptr;
  std::tuple<long, int, std::ptrdiff_t, double> least;
  for (const session::Dealing& way : ways) {
    if (ways.size() == 1) break;
    LiveGrasp one = grasp;
    one.deal(way);
    if (one.problem().pairs.empty()) continue;
    search(posture, kTrial, one, progress);
    const LiveGrasp::Standing now = one.standing();
    const std::ptrdiff_t renamed = std::count_if(way.begin(), way.end(), [](const auto& dealt) {
      return dealt.first != dealt.second;
    });
    const std::tuple lack(std::lround(now.lack),
                          -session::neighboursServed(anatomy, digits, way), renamed,
                          now.distance);
    if (best != nullptr && lack >= least) continue;
    best = &way;
    least = lack;
  }
  grasp.deal(best != nullptr ? *best : ways.front());
}

}  // namespace

std::optional<LookedFor> lookFor(LiveGrasp from,
                                 bool deals_anew,
                                 const std::vector<contact::PartDirection>& posture,
                                 const Progress& progress) {
  LookedFor looked{std::move(from)};
  if (deals_anew)
    dealAnew(posture, looked.grasp, progress);
  else
    looked.grasp.meetAnew();
  if (looked.grasp.problem().pairs.empty()) return std::nullopt;
  looked.depth = search(posture, kFull, looked.grasp, progress);
  return looked;
}

}  // namespace handgraft::retargeting
