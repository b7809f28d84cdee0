#include "tests/bench/motions/live_motions.h"

#include <algorithm>
#include <cstdio>
#include <optional>

#include "core/demonstration/posed_hand_tracker.h"
#include "core/retargeting/live_follower.h"
#include "core/session/session.h"

#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

/// Of all frames that were answered.
struct LiveFigures {
  int answered = 0;
  int touches = 0;
  int reached = 0;
  int places = 0;
  double sum_mm = 0.0;
  double sum_deg = 0.0;
  double deepest_m = 0.0;
  int past = 0;
  double largest_step = 0.0;
  /// How often the hand set out for another pose about the object, how long it was on its
  /// way, and how far that took it.
  int ways = 0;
  int frames_led = 0;
  double led_m = 0.0;
  std::vector<double> ms;

  void add(const retargeting::LiveFollower::Answer& answer) {
    ++answered;
    touches += answer.touches;
    for (const retargeting::LiveFollower::PartFit& fit : answer.parts) {
      ++places;
      reached += fit.reached ? 1 : 0;
      sum_mm += fit.distance_mm;
      sum_deg += fit.facing_deg;
    }
    deepest_m = std::max(deepest_m, answer.depths.object_m);
    past += answer.depths.object_m > 2e-3 ? 1 : 0;
  }
};

}  // namespace

void printLiveHeading() {
  std::printf(
      "| sequence | hand | frames answered | touches reached %% | mean mm | facing deg | "
      "deepest mm | frames past 2 mm | largest step rad | led | frames | mm | first ms | "
      "ms p50 | ms p99 |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
}

void printLive(const contact::ContactSet& contacts,
               const std::vector<demonstration::PosedFrame>& frames,
               const std::shared_ptr<const geometry::TriangleMesh>& object_O,
               const hand::Hand& demonstrator,
               const hand::Hand& hand) {
  const session::Session session(hand, object_O, contacts, Pose::Identity(), {});
  demonstration::PosedHandTracker tracker(demonstrator, object_O, Progress());
  retargeting::LiveFollower follower(session.document(), hand, object_O, Progress());
  LiveFigures figures;
  std::optional<Eigen::VectorXd> before;
  std::optional<Eigen::Vector3d> p_OH;
  bool was_led = false;
  for (const demonstration::PosedFrame& frame : frames) {
    const double begin = threadMilliseconds();
    const auto answer =
        follower.follow(frame.time_s, frame.X_WO, tracker.see(frame.pose, frame.X_WO),
                        tracker.postureOf(frame.pose, frame.X_WO), Progress());
    const double ms = threadMilliseconds() - begin;
    if (!answer) {
      if (follower.touches() >= retargeting::LiveFollower::kTouchesToBegin)
        figures.touches += follower.touches();
      continue;
    }
    figures.ms.push_back(ms);
    figures.add(*answer);
    if (before) {
      figures.largest_step =
          std::max(figures.largest_step, (answer->pose.q - *before).cwiseAbs().maxCoeff());
    }
    before = answer->pose.q;
    const Eigen::Vector3d now = inverse(frame.X_WO) * answer->pose.X_WH.translation();
    if (answer->is_on_its_way) {
      figures.ways += was_led ? 0 : 1;
      ++figures.frames_led;
      if (p_OH) figures.led_m += (now - *p_OH).norm();
    }
    was_led = answer->is_on_its_way;
    p_OH = now;
  }
  const double first = figures.ms.empty() ? 0.0 : figures.ms.front();
  if (!figures.ms.empty()) figures.ms.erase(figures.ms.begin());
  const double places = std::max(1, figures.places);
  std::printf(
      "| %s | %s | %d of %zu | %.1f | %.2f | %.1f | %.2f | %d | %.3f | %d | %d | %.0f | "
      "%.0f | %.2f | %.2f |\n",
      contacts.name.c_str(), hand.model->name().c_str(), figures.answered, frames.size(),
      100.0 * figures.reached / std::max(1, figures.touches), figures.sum_mm / places,
      figures.sum_deg / places, 1e3 * figures.deepest_m, figures.past, figures.largest_step,
      figures.ways, figures.frames_led, 1e3 * figures.led_m, first, quantile(figures.ms, 0.5),
      quantile(figures.ms, 0.99));
  std::fflush(stdout);
}

}  // namespace handgraft::bench
