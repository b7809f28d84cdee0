// Every sequence of events up to a length, each judged by a shadow that knows nothing of how
// the governor works: only what it promises.

#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "tests/hardware/safety/governor_rig.h"

namespace handgraft::safety {
namespace {

using namespace test;
using State = GovernorState;

enum class Event {
  kPeriod,       ///< a period with a fresh pose
  kFarPose,      ///< the same, a pose far away
  kSilence,      ///< a period without a pose
  kLongSilence,  ///< until any hold is over
  kRubbish,      ///< a period with a pose of NaN
  kOtherStream,  ///< a pose of another stream
  kArm,
  kDisarm,
  kEStop,
  kReset,
  kDeviceFault,  ///< the device reports a fault for one period
  kUnplug,       ///< the device is away for one period
  kPowerLost,    ///< the device's motors go off by themselves
  kSuspended,    ///< one period 2 s late
  kCount,
};

constexpr int kEventCount = static_cast<int>(Event::kCount);

constexpr std::array<const char*, kEventCount> kEventNames{
    "period", "far pose", "silence", "long silence", "rubbish", "other stream", "arm",
    "disarm", "estop",    "reset",   "device fault", "unplug",  "power lost",   "suspended"};

/// What may be seen from outside after one period.
struct Sight {
  State state;
  Power power;
  std::vector<double> sent;
};

/// Judges what was seen against the requests that were made. Empty: nothing to object to.
class Shadow {
 public:
  void obeyed(Event request, Refusal refusal, State before) {
    if (request == Event::kArm) {
      const bool is_latched = before == State::kFault || before == State::kEStop;
      if (refusal == Refusal::kNone && (is_latched || before == State::kDisconnected))
        object("armed from a state that forbids it");
      if (refusal == Refusal::kNone && !pose_is_fresh_) object("armed without a fresh pose");
      if (refusal == Refusal::kNone) may_have_power_ = may_move_ = true;
    }
    if (request == Event::kDisarm || request == Event::kEStop) may_move_ = false;
    if (request == Event::kEStop) must_stop_in_ = kBrakePeriods, latched_ = State::kEStop;
    if (request == Event::kReset && refusal == Refusal::kNone) was_reset_ = true;
  }

  /// A pose of the followed stream counts for 35 ms: three periods after its own.
  void posed() { pose_is_fresh_ = true, fresh_periods_ = 3; }

  void changedStream() { may_move_ = false; }

  void broke() { may_move_ = false; }

  void see(const Sight& now) {
    if (fresh_periods_ == 0) pose_is_fresh_ = may_move_ = false;
    if (fresh_periods_ > 0) --fresh_periods_;
    const bool on = now.power == Power::kOn;
    if (on && !may_have_power_) object("power without an arm request since it was last off");
    if (on && (now.state == State::kIdle || now.state == State::kDisconnected ||
               now.state == State::kFault))
      object("power in a powerless state");
    if (on == now.sent.empty()) object("positions and power disagree");
    if (!on) may_have_power_ = may_move_ = false;
    if (now.state == State::kArmed && !may_move_) object("armed though motion was revoked");
    judgeStop(now, on);
    judgeLatch(now);
    judgeMotion(now, on);
    before_ = now;
  }

  [[nodiscard]] const std::string& objection() const { return objection_; }

 private:
  static constexpr int kBrakePeriods = 10;  // brake_within / period

  void object(const char* what) {
    if (objection_.empty()) objection_ = what;
  }

  void judgeStop(const Sight& now, bool on) {
    if (!must_stop_in_) return;
    if (!on) {
      must_stop_in_.reset();
    } else if ((*must_stop_in_)-- == 0) {
      object("an emergency stop did not end in time");
    }
    (void)now;
  }

  void judgeLatch(const Sight& now) {
    const bool left = latched_ && now.state != *latched_;
    // A fault may turn into an emergency stop; nothing turns an emergency stop into a fault.
    if (left && !was_reset_) object("a latched state was left without a reset");
    if (now.state == State::kFault || now.state == State::kEStop) {
      if (latched_ != now.state) was_reset_ = false;
      latched_ = now.state;
    } else {
      latched_.reset();
      was_reset_ = false;
    }
  }

  // Once motion is revoked, speeds only fall.
  void judgeMotion(const Sight& now, bool on) {
    if (!on || !before_ || before_->power != Power::kOn) {
      speed_.clear();
      return;
    }
    std::vector<double> speed(now.sent.size());
    for (std::size_t i = 0; i < speed.size(); ++i)
      speed[i] = std::abs(now.sent[i] - before_->sent[i]);
    for (std::size_t i = 0; i < speed.size() && !speed_.empty() && !may_move_; ++i) {
      // The average of two lets one more period's speed through.
      if (revoked_periods_ > 1 && speed[i] > speed_[i] + 1e-12)
        object("it sped up after motion was revoked");
    }
    revoked_periods_ = may_move_ ? 0 : revoked_periods_ + 1;
    speed_ = std::move(speed);
  }

  bool may_have_power_ = false;
  bool may_move_ = false;
  bool pose_is_fresh_ = false;
  int fresh_periods_ = 0;
  bool was_reset_ = false;
  int revoked_periods_ = 0;
  std::optional<int> must_stop_in_;
  std::optional<State> latched_;
  std::optional<Sight> before_;
  std::vector<double> speed_;
  std::string objection_;
};

struct Node {
  Rig rig;
  Shadow shadow;

  void period() {
    rig.tick();
    shadow.see({rig.state(), rig.power, rig.sent});
  }

  void pose(double value) {
    if (rig.offer({value, value}) == SampleVerdict::kAccepted) shadow.posed();
  }

  void request(Event event) {
    const State before = rig.state();
    Refusal refusal = Refusal::kNone;
    if (event == Event::kArm) refusal = rig.arm();
    if (event == Event::kDisarm) rig.governor.disarm();
    if (event == Event::kEStop) rig.governor.estop();
    if (event == Event::kReset) refusal = rig.governor.reset();
    shadow.obeyed(event, refusal, before);
  }

  void apply(Event event) {
    switch (event) {
      case Event::kPeriod:
        pose(0.05);
        return period();
      case Event::kFarPose:
        pose(1.2);
        period();
        pose(1.2);
        return period();
      case Event::kSilence:
        return period();
      case Event::kLongSilence:
        for (int i = 0; i < 20; ++i)
          period();
        return;
      case Event::kRubbish:
        rig.offer({std::nan(""), 0});
        return period();
      case Event::kOtherStream:
        rig.stream = 3 - rig.stream;
        pose(0.4);
        shadow.changedStream();
        return period();
      case Event::kArm:
      case Event::kDisarm:
      case Event::kEStop:
      case Event::kReset:
        request(event);
        return period();
      case Event::kDeviceFault:
        shadow.broke();
        rig.fault_code = 7;
        period();
        rig.fault_code = 0;
        return;
      case Event::kUnplug:
        if (rig.power == Power::kOn) shadow.broke();
        rig.connected = false;
        period();
        rig.connected = true;
        return;
      case Event::kPowerLost:
        if (rig.was_reported_on) shadow.broke();  // else it is a device that is slow to begin
        rig.reports_power = false;
        return period();
      case Event::kSuspended:
        rig.now += std::chrono::seconds(2);
        if (rig.power == Power::kOn) shadow.broke();
        return period();
      case Event::kCount:
        break;
    }
  }
};

struct Search {
  std::vector<Event> events;
  long sequences = 0;
  std::array<long, 6> states{};
  std::vector<std::string> objections;
  std::vector<Event> path;

  void run(const Node& from, int depth) {
    if (depth == 0) {
      ++sequences;
      return;
    }
    for (const Event event : events) {
      if (objections.size() >= 5) return;
      Node next = from;
      path.push_back(event);
      next.apply(event);
      ++states[static_cast<std::size_t>(next.rig.state())];
      if (next.shadow.objection().empty()) {
        run(next, depth - 1);
      } else {
        std::string told = next.shadow.objection() + ":";
        for (const Event done : path)
          told += std::string(" ") + kEventNames[static_cast<std::size_t>(done)];
        objections.push_back(told);
      }
      path.pop_back();
    }
  }
};

std::vector<Event> everyEvent() {
  std::vector<Event> events;
  for (int e = 0; e < kEventCount; ++e)
    events.push_back(static_cast<Event>(e));
  return events;
}

void expectAllKept(const Node& start, int depth, std::vector<Event> events = everyEvent()) {
  Search search;
  search.events = std::move(events);
  search.run(start, depth);
  for (const std::string& objection : search.objections)
    ADD_FAILURE() << objection;
  EXPECT_EQ(search.sequences,
            std::lround(std::pow(static_cast<double>(search.events.size()), depth)));
  for (std::size_t i = 0; i < search.states.size(); ++i)
    EXPECT_GT(search.states[i], 0) << "never reached: " << toString(static_cast<State>(i));
}

TEST(GovernorModel, KeepsItsPromisesOverEverySequenceFromTheStart) {
  Node start;
  start.rig.connected = false;
  start.period();
  start.rig.connected = true;
  expectAllKept(start, 5);
}

TEST(GovernorModel, KeepsItsPromisesOverEveryLongerSequenceOfWhatMattersMost) {
  Node start;
  start.period();
  expectAllKept(
      start, 6,
      {Event::kPeriod, Event::kFarPose, Event::kLongSilence, Event::kOtherStream, Event::kArm,
       Event::kDisarm, Event::kEStop, Event::kReset, Event::kDeviceFault, Event::kUnplug});
}

TEST(GovernorModel, KeepsItsPromisesOverEverySequenceFromMotion) {
  Node start;
  start.apply(Event::kPeriod);
  start.apply(Event::kArm);
  for (int i = 0; i < 6; ++i)
    start.apply(Event::kFarPose);
  ASSERT_EQ(start.rig.state(), State::kArmed);
  expectAllKept(start, 5);
}

TEST(GovernorModel, KeepsItsPromisesWhenItsHandIsCut) {
  GovernorOptions options = quickOptions();
  options.stop_mode = StopMode::kCut;
  Node start{Rig(options), {}};
  start.apply(Event::kPeriod);
  start.apply(Event::kArm);
  start.apply(Event::kFarPose);
  expectAllKept(start, 4);
}

// === The shadow itself: a judge that never objects proves nothing

Sight sight(State state, Power power, std::vector<double> sent = {}) {
  return {state, power, std::move(sent)};
}

TEST(GovernorModel, TheShadowObjectsToPowerNobodyAskedFor) {
  Shadow shadow;
  shadow.posed();
  shadow.see(sight(State::kArmed, Power::kOn, {0}));
  EXPECT_NE(shadow.objection(), "");
}

TEST(GovernorModel, TheShadowObjectsToMotionThatAReturningStreamResumes) {
  Shadow shadow;
  shadow.posed();
  shadow.obeyed(Event::kArm, Refusal::kNone, State::kIdle);
  for (int i = 0; i < 4; ++i)
    shadow.see(sight(i < 3 ? State::kArmed : State::kHolding, Power::kOn, {0.1 * i}));
  EXPECT_EQ(shadow.objection(), "") << "fresh for three periods";
  shadow.see(sight(State::kHolding, Power::kOn, {0.4}));
  shadow.posed();
  shadow.see(sight(State::kArmed, Power::kOn, {0.4}));
  EXPECT_NE(shadow.objection(), "");
}

TEST(GovernorModel, TheShadowObjectsToALatchThatOpensByItself) {
  Shadow shadow;
  shadow.see(sight(State::kFault, Power::kOff));
  shadow.see(sight(State::kIdle, Power::kOff));
  EXPECT_NE(shadow.objection(), "");
}

TEST(GovernorModel, TheShadowObjectsToAStopThatDoesNotEnd) {
  Shadow shadow;
  shadow.posed();
  shadow.obeyed(Event::kArm, Refusal::kNone, State::kIdle);
  shadow.see(sight(State::kArmed, Power::kOn, {0}));
  shadow.obeyed(Event::kEStop, Refusal::kNone, State::kArmed);
  for (int i = 0; i < 20; ++i)
    shadow.see(sight(State::kEStop, Power::kOn, {0}));
  EXPECT_NE(shadow.objection(), "");
}

TEST(GovernorModel, TheShadowObjectsToAnArmThatALatchForbids) {
  Shadow shadow;
  shadow.posed();
  shadow.obeyed(Event::kArm, Refusal::kNone, State::kEStop);
  EXPECT_NE(shadow.objection(), "");
}

}  // namespace
}  // namespace handgraft::safety
