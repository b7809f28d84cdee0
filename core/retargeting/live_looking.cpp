#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "core/optimize/solver.h"
#include "core/placement/posture_finding.h"
#include "core/placement/solids.h"
#include "core/retargeting/live_follower.h"

// Where a hand that follows is searched for: at its beginning, and when it is lost.

namespace handgraft::retargeting {

namespace {

// Lost is a hand that is so far off, for so long; what is found must be nearer by this factor.
constexpr double kLost = 0.012;  // m, on average over the touches
constexpr double kBetter = 0.6;
// Fingers dealt in another way must leave so much less unshown to be worth the way there.
constexpr double kServesMore = 0.75;

}  // namespace

/// How long is looked, and how much the hand is held as the demonstrator's is.
struct LiveFollower::Search {
  int starts = 0;
  int more_starts = 0;  ///< where all that these find is deep in the object
  int slides = 0;
  double held = 1.0;

  /// Where touches leave the hand free: to be a radian off costs as much as 1 mm in four
  /// touches.
  static Search full() { return {16, 64, 10, 1000.0}; }

  /// To tell ways to deal fingers apart: by what they reach.
  static Search trial() { return {4, 0, 3, 1.0}; }
};

/// What a search tries: all is as it was again, unless that is kept.
class LiveFollower::Attempt {
 public:
  explicit Attempt(LiveFollower& follower)
      : follower_(follower),
        parts_(follower.parts_),
        fingers_(follower.fingers_),
        last_O_(follower.last_O_) {}

  ~Attempt() {
    if (is_kept_) return;
    follower_.parts_ = std::move(parts_);
    follower_.fingers_ = std::move(fingers_);
    follower_.last_O_ = std::move(last_O_);
  }

  Attempt(const Attempt&) = delete;
  Attempt& operator=(const Attempt&) = delete;

  void keep() { is_kept_ = true; }

 private:
  LiveFollower& follower_;
  std::vector<TouchingPart> parts_;
  LiveFingers fingers_;
  std::optional<hand::HandPose> last_O_;
  bool is_kept_ = false;
};

/// By short searches, from where the hand is: as sessions deal, which look longer. Of ways that
/// reach as much, the one that leaves fingers for what may touch next.
void LiveFollower::dealAnew(const std::vector<contact::PartDirection>& posture,
                            const Progress& progress) {
  const std::vector<std::string> touching = touchingDigits();
  const std::vector<session::Dealing> ways = fingers_.waysFor(touching);
  const std::optional<hand::HandPose> here_O = last_O_;
  std::vector<std::string> digits;  // the demonstrator's, as far as the posture tells
  for (const contact::PartDirection& part : posture)
    if (const auto place = hand::placeNamed(part.part)) digits.push_back(place->digit);
  const session::Dealing* best = nullptr;
  std::tuple<long, int, std::ptrdiff_t, double> least;
  for (const session::Dealing& way : ways) {
    if (ways.size() == 1) break;
    fingers_.choose(way, touching);
    meetAnew();
    last_O_ = here_O;
    if (problemNow().pairs.empty()) continue;
    search(posture, Search::trial(), progress);
    const Standing now = standing();
    const std::ptrdiff_t renamed = std::count_if(way.begin(), way.end(), [](const auto& dealt) {
      return dealt.first != dealt.second;
    });
    const std::tuple lack(std::lround(now.lack),
                          -session::neighboursServed(coordinates_.anatomy(), digits, way),
                          renamed, now.distance);
    if (best != nullptr && lack >= least) continue;
    best = &way;
    least = lack;
  }
  last_O_ = here_O;
  fingers_.choose(best != nullptr ? *best : ways.front(), touching);
  meetAnew();
}

bool LiveFollower::begin(double time_s,
                         const std::vector<contact::PartDirection>& posture,
                         const Progress& progress) {
  if (!beginning_.isDue(time_s, touches(), partsTouching())) return false;
  Attempt attempt(*this);
  dealAnew(posture, progress);
  if (problemNow().pairs.empty()) return false;
  const double depth = search(posture, Search::full(), progress);
  if (depth > kDeep && beginning_.putOff(time_s)) return false;
  attempt.keep();
  solver_.begin(*last_O_);
  return true;
}

double LiveFollower::search(const std::vector<contact::PartDirection>& posture,
                            const Search& how,
                            const Progress& progress) {
  optimize::PoseProblem problem = problemNow();
  contact::ContactSet shown;
  shown.posture = posture;
  const placement::Posture held = placement::postureFor(hand_, shown);
  const auto hold = [&](optimize::PoseProblem& one) {
    one.prior.q = held.q.cwiseMax(one.lower).cwiseMin(one.upper);
    one.prior_weights = Eigen::VectorXd::Ones(one.dofCount());
    if (!held.R_OH) return;  // what is relaxed holds nobody
    const double weight = how.held * held.sureness;
    one.prior_weights.tail(held.q.size()) *= weight;
    one.prior.X_WH.linear() = *held.R_OH;
    one.prior_weights.head<3>() *= weight;
  };
  hold(problem);
  const std::vector<TouchingPart> parts = parts_;
  std::vector<TouchingPart> best_parts;
  std::optional<hand::HandPose> best_O;
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
      parts_ = parts;
      last_O_ = pose;
      for (int i = 0; i < how.slides; ++i) {
        slide(1.0);
        optimize::PoseProblem one = problemNow();
        hold(one);
        optimize::SolveOptions warm;
        warm.starts = 1;
        last_O_ = optimize::solve(one, warm, progress).pose;
      }
      if (how.more_starts == 0) return 0.0;  // nobody asks how deep it is
      const double depth = depthNow(progress);
      if (depth <= kDeep) return depth;
      if (depth >= least_depth) continue;
      least_depth = depth;
      best_O = last_O_;
      best_parts = parts_;
    }
  }
  last_O_ = best_O;
  parts_ = best_parts;
  return least_depth;
}

double LiveFollower::depthNow(const Progress& progress) const {
  if (!problem_.avoidance) return 0.0;
  return placement::deepestOf(hand_.model, hand_.skin, object_O_, *last_O_, progress);
}

LiveFollower::Standing LiveFollower::standing() const {
  Standing standing;
  const std::vector<PartFit> fits = fitsOf(seen_, Pose::Identity());
  standing.lack = static_cast<double>(seen_.size() - fits.size());
  double sum_mm = 0.0;
  for (const PartFit& fit : fits) {
    if (parts_[static_cast<std::size_t>(fit.part)].presence < 1.0) continue;
    standing.lack += 1.0 - trustIn(1e-3 * fit.distance_mm);
    sum_mm += fit.distance_mm;
    ++standing.shown;
  }
  if (standing.shown > 0) standing.distance = 1e-3 * sum_mm / standing.shown;
  return standing;
}

void LiveFollower::lookAnew(double time_s,
                            double step_s,
                            const std::vector<contact::PartDirection>& posture,
                            const Progress& progress) {
  const Standing before = standing();
  const std::vector<std::string> touching = touchingDigits();
  const bool may_begin = touches() >= kTouchesToBegin;
  const bool is_lost = may_begin && (before.distance > kLost || depth_ > kDeep);
  const bool is_unserved =
      may_begin && fingers_.lacksOneFor(touching) && !fingers_.isChosenFor(touching);
  searches_.see(step_s, is_lost, is_unserved);
  if (!fingers_.isChosenFor(touching)) searches_.touchesChanged();
  if (way_ || !searches_.isDue(time_s)) return;
  const session::Dealing dealing = fingers_.dealing();
  const hand::HandPose here_O = *last_O_;
  {
    Attempt attempt(*this);
    if (fingers_.isChosenFor(touching)) {
      meetAnew();
    } else {
      dealAnew(posture, progress);
    }
    const double depth = search(posture, Search::full(), progress);
    const Standing after = standing();
    const bool serves_more =
        fingers_.dealing() != dealing && after.lack < kServesMore * before.lack;
    const bool is_nearer =
        after.shown >= before.shown && after.distance < kBetter * before.distance;
    const bool is_freed = depth_ > kDeep && depth <= kDeep;
    const bool is_caught = depth > kDeep && depth > depth_;
    if (!is_caught && (serves_more || is_nearer || is_freed)) {
      attempt.keep();
      way_.emplace(here_O, *last_O_, middle_O_, time_s);
      searches_.found(way_->end());
      last_O_ = here_O;
      return;
    }
  }
  searches_.foundNothing(time_s);
  fingers_.choose(dealing, touching);  // nothing better is known
}

}  // namespace handgraft::retargeting
