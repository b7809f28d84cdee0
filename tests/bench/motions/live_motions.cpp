#include "tests/bench/motions/live_motions.h"

#include <algorithm>
#include <cstdio>
#include <optional>

#include "core/demonstration/posed_hand_tracker.h"
#include "core/session/session.h"

#include "tests/bench/timing.h"

namespace handgraft::bench {

void LiveFigures::add(const retargeting::LiveFollower::Answer& answer) {
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

namespace {

LiveFrame shownBy(const retargeting::LiveFollower::Answer& answer,
                  const hand::HandPose& pose_O) {
  LiveFrame frame;
  frame.pose_O = pose_O;
  frame.touches = answer.touches;
  frame.is_led = answer.is_on_its_way;
  for (const retargeting::LiveFollower::PartFit& fit : answer.parts) {
    frame.reached += fit.reached ? 1 : 0;
    frame.mean_mm += fit.distance_mm / static_cast<double>(answer.parts.size());
  }
  return frame;
}

}  // namespace

void printLiveHeading() {
  std::printf(
      "| sequence | hand | frames answered | touches reached %% | mean mm | facing deg | "
      "deepest mm | frames past 2 mm | largest step rad | led | frames | mm | first ms | "
      "ms p50 | ms p99 |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
}

std::vector<LiveFrame> followLive(const contact::ContactSet& contacts,
                                  const std::vector<demonstration::PosedFrame>& frames,
                                  const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                                  const hand::Hand& demonstrator,
                                  const hand::Hand& hand,
                                  LiveFigures& figures) {
  const session::Session session(hand, object_O, contacts, Pose::Identity(), {});
  demonstration::PosedHandTracker tracker(demonstrator, object_O, Progress());
  retargeting::LiveFollower follower(session.document(), hand, object_O, Progress());
  std::vector<LiveFrame> shown;
  std::optional<hand::HandPose> before_O;
  bool was_led = false;
  for (const demonstration::PosedFrame& frame : frames) {
    ++figures.frames;
    const double begin = threadMilliseconds();
    const auto answer =
        follower.follow(frame.time_s, frame.X_WO, tracker.see(frame.pose, frame.X_WO),
                        tracker.shownBy(frame.pose, frame.X_WO), Progress());
    const double ms = threadMilliseconds() - begin;
    shown.emplace_back();
    if (!answer) {
      if (follower.touches() >= retargeting::LiveFollower::kTouchesToBegin)
        figures.touches += follower.touches();
      continue;
    }
    (before_O ? figures.ms : figures.first_ms).push_back(ms);
    figures.add(*answer);
    const hand::HandPose now_O{inverse(frame.X_WO) * answer->pose.X_WH, answer->pose.q};
    if (before_O) {
      figures.largest_step =
          std::max(figures.largest_step, (now_O.q - before_O->q).lpNorm<Eigen::Infinity>());
    }
    if (answer->is_on_its_way) {
      figures.ways += was_led ? 0 : 1;
      ++figures.frames_led;
      if (before_O)
        figures.led_m += (now_O.X_WH.translation() - before_O->X_WH.translation()).norm();
    }
    was_led = answer->is_on_its_way;
    before_O = now_O;
    shown.back() = shownBy(*answer, now_O);
  }
  return shown;
}

void printLiveRow(const std::string& name, const hand::Hand& hand, const LiveFigures& figures) {
  const double places = std::max(1, figures.places);
  std::printf(
      "| %s | %s | %d of %d | %.1f | %.2f | %.1f | %.2f | %d | %.3f | %d | %d | %.0f | "
      "%.0f | %.2f | %.2f |\n",
      name.c_str(), hand.model->name().c_str(), figures.answered, figures.frames,
      100.0 * figures.reached / std::max(1, figures.touches), figures.sum_mm / places,
      figures.sum_deg / places, 1e3 * figures.deepest_m, figures.past, figures.largest_step,
      figures.ways, figures.frames_led, 1e3 * figures.led_m,
      figures.first_ms.empty() ? 0.0 : quantile(figures.first_ms, 0.5),
      quantile(figures.ms, 0.5), quantile(figures.ms, 0.99));
  std::fflush(stdout);
}

}  // namespace handgraft::bench
