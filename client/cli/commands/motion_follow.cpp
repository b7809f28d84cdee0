#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "client/cli/commands/commands.h"
#include "client/link/client.h"
#include "client/link/demonstration.h"
#include "client/link/following.h"
#include "client/link/session_id.h"
#include "client/present/interactive_client.h"
#include "client/present/interruption.h"
#include "client/present/joint_unit.h"
#include "client/present/json_output.h"

namespace handgraft::client {

namespace {

using FollowClock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLastAnswers(300);

/// When frames were sent, and what came of them. From several threads.
class Answers {
 public:
  void sent(double time_s, FollowClock::time_point now) {
    const std::lock_guard lock(mutex_);
    sent_[time_s] = now;
  }

  void came(const v1::PoseSolution& solution, FollowClock::time_point now) {
    if (solution.time_s().empty()) return;
    const std::lock_guard lock(mutex_);
    const auto found = sent_.find(solution.time_s().front());
    if (found == sent_.end()) return;
    latency_ms_.push_back(
        std::chrono::duration<double, std::milli>(now - found->second).count());
    sent_.erase(found);
    double step = 0.0;
    const std::vector<double>& joints = solution.joint_positions();
    for (std::size_t i = 0; i < joints.size() && last_.size() == joints.size(); ++i)
      step = std::max(step, std::abs(joints[i] - last_[i]));
    largest_step_ = std::max(largest_step_, step);
    last_ = joints;
  }

  /// A share of all latencies lies below; NaN without any.
  double latency(double share) {
    const std::lock_guard lock(mutex_);
    if (latency_ms_.empty()) return std::numeric_limits<double>::quiet_NaN();
    std::sort(latency_ms_.begin(), latency_ms_.end());
    const auto last = static_cast<double>(latency_ms_.size() - 1);
    return latency_ms_[static_cast<std::size_t>(share * last)];
  }

  std::size_t count() {
    const std::lock_guard lock(mutex_);
    return latency_ms_.size();
  }

  double largestStep() {
    const std::lock_guard lock(mutex_);
    return largest_step_;
  }

 private:
  std::mutex mutex_;
  std::map<double, FollowClock::time_point> sent_;
  std::vector<double> latency_ms_;
  std::vector<double> last_;
  double largest_step_ = 0.0;
};

}  // namespace

int run(const MotionFollowOptions& options,
        const CommonOptions& common,
        Interruption& interruption) {
  const std::vector<v1::DemonstratorFrame> frames = readDemonstration(options.demonstration);
  Client server(interactiveClient(common.network, Absence::kFail, interruption));
  const std::uint64_t session_id = sessionMeant(server, options.session_id);
  static_cast<void>(server.describeSession(session_id).get());
  Answers answers;
  Listener listener;
  listener.on_solution = [&answers](const v1::PoseSolution& solution) {
    answers.came(solution, FollowClock::now());
  };
  const Following following(server, session_id, listener);
  DemonstratorWriter writer(server, session_id);

  const FollowClock::time_point begin = FollowClock::now();
  const double first_s = frames.front().time_s();
  const double interval_s =
      frames.size() > 1 ? (frames.back().time_s() - first_s) / double(frames.size() - 1) : 1.0;
  double lap_s = 0.0;
  do {
    for (const v1::DemonstratorFrame& frame : frames) {
      const double time_s = lap_s + (frame.time_s() - first_s) / options.speed;
      std::this_thread::sleep_until(begin + std::chrono::duration_cast<FollowClock::duration>(
                                                std::chrono::duration<double>(time_s)));
      if (interruption.requested()) break;
      v1::DemonstratorFrame message = frame;
      message.time_s(time_s);
      answers.sent(time_s, FollowClock::now());
      writer.write(message);
    }
    lap_s += (frames.back().time_s() - first_s + interval_s) / options.speed;
  } while (options.loops && !interruption.requested());
  std::this_thread::sleep_for(kLastAnswers);

  const double p50 = answers.latency(0.5);
  const double p99 = answers.latency(0.99);
  const v1::SessionState state = server.describeSession(session_id).get();
  if (common.json) {
    const auto or_null = [](double value) {
      return std::isfinite(value) ? json::Json(value) : json::Json();
    };
    fmt::print("{}\n", json::written({{"session_id", session_id},
                                      {"frames", writer.count()},
                                      {"answered", answers.count()},
                                      {"latency_p50_ms", or_null(p50)},
                                      {"latency_p99_ms", or_null(p99)},
                                      {"largest_step", answers.largestStep()},
                                      {"message", state.message()}},
                                     2));
  } else {
    const JointUnit unit =
        unitOfLargest(server.describe(v1::MODEL_HAND, state.hand(), false).get().hand());
    fmt::print(
        "{} frames, {} answered by a pose; p50 {:.1f} ms, p99 {:.1f} ms; largest step {:.3g} "
        "{}\n",
        writer.count(), answers.count(), p50, p99, unit.scale * answers.largestStep(),
        unit.name);
    if (!state.message().empty()) fmt::print("{}\n", state.message());
  }
  return 0;
}

}  // namespace handgraft::client
