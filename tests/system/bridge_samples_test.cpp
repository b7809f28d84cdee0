// A hand that is guided by timed samples over DDS: judged by what it does; what time it took is
// printed.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <random>
#include <thread>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/environment.h"

#include "tests/support/test_domain.h"
#include "tests/system/bridge_bench.h"
#include "tests/system/service.h"

namespace handgraft::test {
namespace {

using std::chrono::microseconds;
using std::chrono::steady_clock;
using std::chrono::system_clock;

constexpr double kRate = 120;  // Hz
const std::vector<std::string> three_joints{"a", "b", "c"};

/// Seconds that a stream lasts: more on demand, for a bench.
double durationOf() {
  const std::string told = environment("HANDGRAFT_STREAM_SECONDS");
  return told.empty() ? 6.0 : std::stod(told);
}

double share(std::vector<double> sorted, double part) {
  if (sorted.empty()) return std::nan("");
  std::sort(sorted.begin(), sorted.end());
  return sorted[static_cast<std::size_t>(part * static_cast<double>(sorted.size() - 1))];
}

class GuidedBridge : public testing::Test {
 protected:
  GuidedBridge() : bench(network(), config()), server(network(), "three", three_joints) {
    bench.startBridge();
  }

  static std::string config() {
    std::string text = directConfig("dynamixel", "three", three_joints, 2.5);
    replace(text, "rate_hz: 20", "rate_hz: 200");
    replace(text, "reply_timeout_ms: 50", "reply_timeout_ms: 5");
    replace(text, "tolerated_misses: 20", "tolerated_misses: 50");
    return text;
  }

  [[nodiscard]] Network network() const { return {domain.number(), "lo"}; }

  struct Streamed {
    std::vector<double> latency_ms;  // from a sample to the target that has come to it
    std::vector<double> step_rad;    // of the first joint's command between two periods
    std::uint64_t sent = 0;
    std::string state;
  };

  /// Sends a ramp of the first joint there and back for `length` seconds, save what is lost.
  Streamed stream(double length, double loss) {
    Streamed result;
    std::mt19937 random(11);
    std::uniform_real_distribution<double> chance(0, 1);

    struct Sent {
      double value;
      std::int64_t stamp_ns;
    };

    std::vector<Sent> sent;
    std::vector<v1::JointState> told;
    const auto take = [&] {
      for (v1::JointState& state : bench.jointStates())
        told.push_back(std::move(state));
    };
    take();
    told.clear();
    auto due = steady_clock::now();
    for (int k = 0; k < length * kRate; ++k) {
      due += microseconds(static_cast<int>(1e6 / kRate));
      std::this_thread::sleep_until(due);
      const double value = 0.3 * (seconds += 1 / kRate);
      const double folded = 0.5 - std::abs(std::fmod(value, 2.0) - 1.0);
      if (chance(random) >= loss) {
        const std::int64_t now_ns =
            system_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
        server.sample({folded, 0.2 * folded, 0.0}, now_ns);
        sent.push_back({folded, now_ns});
      }
      take();
    }
    result.sent = sent.size();
    // A sample is obeyed in the first period whose target lies at it or beyond.
    std::size_t at = 0;
    for (std::size_t k = 1; k + 1 < sent.size(); ++k) {
      const double sign = sent[k + 1].value > sent[k].value ? 1 : -1;
      if ((sent[k].value - sent[k - 1].value) * sign <= 0) continue;  // it turns
      while (at < told.size() && told[at].stamp_ns() < sent[k].stamp_ns)
        ++at;
      std::size_t j = at;
      while (j < told.size() &&
             (told[j].target().empty() || (told[j].target()[0] - sent[k].value) * sign < -1e-9))
        ++j;
      if (j == told.size()) break;
      result.latency_ms.push_back(1e-6 *
                                  static_cast<double>(told[j].stamp_ns() - sent[k].stamp_ns));
    }
    for (std::size_t k = 1; k < told.size(); ++k) {
      if (told[k].command().empty() || told[k - 1].command().empty()) continue;
      if (told[k].sequence_number() != told[k - 1].sequence_number() + 1) continue;
      result.step_rad.push_back(std::abs(told[k].command()[0] - told[k - 1].command()[0]));
    }
    if (!told.empty()) result.state = told.back().message();
    fmt::print(
        "samples at {} Hz, loss {:.0f} %: {} sent, sample to command p50 {:.1f} ms, "
        "p99 {:.1f} ms, largest step {:.4f} rad\n",
        kRate, 100 * loss, result.sent, share(result.latency_ms, 0.5),
        share(result.latency_ms, 0.99), share(result.step_rad, 1));
    return result;
  }

  /// Where the stream begins, and the hand stands armed.
  bool start() {
    server.stream({-0.5, -0.1, 0.0});
    return bench.arrive(
        [] {
          return std::vector<double>{-0.5, -0.1, 0.0};
        },
        0.02);
  }

  TestDomain domain;
  BridgeBench bench;
  StandInServer server;
  double seconds = 0;
};

TEST_F(GuidedBridge, FollowsSamplesAt120HzAndBearsTheLossOfOneInTen) {
  ASSERT_TRUE(start()) << bench.told();
  ASSERT_TRUE(server.isSampled()) << bench.told();
  const Streamed all = stream(durationOf(), 0);
  EXPECT_GT(all.latency_ms.size(), all.sent / 2) << "targets have not come to the samples";
  const auto status = bench.status([&](const v1::BridgeStatus& now) {
    return now.poses_accepted() > all.sent;
  });
  ASSERT_TRUE(status) << "samples were lost: " << bench.told();
  EXPECT_EQ(status->state(), v1::BRIDGE_ARMED) << bench.told();
  EXPECT_EQ(status->fault(), v1::FAULT_NONE);

  const Streamed some = stream(durationOf(), 0.1);
  EXPECT_GT(some.latency_ms.size(), some.sent / 2);
  EXPECT_TRUE(bench.status(v1::BRIDGE_ARMED)) << bench.told();
  // 0.3 rad/s are 0.0015 rad a period; the limit of 2 rad/s would be 0.01.
  EXPECT_LT(share(some.step_rad, 1), 0.006);
}

TEST_F(GuidedBridge, StandsThroughAPauseAndHoldsWhenTheServerIsGone) {
  ASSERT_TRUE(start()) << bench.told();
  stream(1, 0);
  std::this_thread::sleep_for(std::chrono::seconds(2));
  EXPECT_TRUE(bench.status(v1::BRIDGE_ARMED)) << bench.told();
  stream(1, 0);
  EXPECT_TRUE(bench.status(v1::BRIDGE_ARMED)) << bench.told();
  bench.command(v1::COMMAND_ESTOP);
  EXPECT_TRUE(bench.status([](const v1::BridgeStatus& status) {
    return status.state() == v1::BRIDGE_ESTOP && status.power() == v1::POWER_OFF;
  })) << bench.told();
  stream(0.5, 0);
  EXPECT_FALSE(bench.rig().isPowered());
}

TEST_F(GuidedBridge, SamplesOfOtherJointsAreRefusedInWords) {
  ASSERT_TRUE(start()) << bench.told();
  StandInServer other(network(), "three", {"a", "b", "d"});
  for (int i = 0; i < 100 && !other.isSampled(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  other.sample({0.1, 0.1, 0.1}, 5);
  EXPECT_TRUE(bench.status([](const v1::BridgeStatus& status) {
    return status.last_refusal().find("'c' is missing") != std::string::npos;
  })) << bench.told();
}

}  // namespace
}  // namespace handgraft::test
