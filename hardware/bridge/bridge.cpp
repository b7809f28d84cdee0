#include "hardware/bridge/bridge.h"

#include <chrono>
#include <thread>
#include <utility>

#include "hardware/bridge/hand_describer.h"
#include "hardware/bridge/server_watch.h"
#include "idl/sensor_msgs.h"
#include "idl/topics.h"

namespace handgraft::bridge {

namespace {

using Clock = std::chrono::steady_clock;
using idl::cyclone::Reader;
using idl::cyclone::Writer;
using RosJointState = sensor_msgs::msg::dds_::JointState_;

constexpr std::chrono::milliseconds kServerPatience(1500);  // the absence is said within 2 s
constexpr std::chrono::seconds kBrakingPatience(2);         // at the end of the process

// The system's time at a moment of the steady clock.
std::chrono::nanoseconds systemTimeOf(Clock::time_point moment) {
  const auto age = Clock::now() - moment;
  return std::chrono::system_clock::now().time_since_epoch() - age;
}

}  // namespace

struct Bridge::Impl {
  Impl(const idl::cyclone::Participant& on,
       const BridgeOptions& told,
       MakeDriver make,
       Report say)
      : participant(on),
        options(told),
        make_driver(std::move(make)),
        report(std::move(say)),
        period(std::chrono::duration_cast<Clock::duration>(
            std::chrono::duration<double>(told.period_s))),
        logic(told),
        describer(participant),
        statuses(participant, idl::kStatusTopic),
        sessions(participant, idl::kSessionTopic),
        solutions(participant, idl::kSolutionTopic),
        commands(participant, idl::kHandCommandTopic),
        joint_states(participant, idl::kJointStateTopic),
        ros_joint_states(participant, idl::kRosJointStatesTopic) {}

  // === Once a period

  void turn(Clock::time_point now) {
    takeMessages(now);
    askForHand();
    moveHand();
    publish();
    for (std::string& remark : logic.takeRemarks())
      say(std::move(remark));
  }

  // Commands first: a stop does not wait for anything.
  void takeMessages(Clock::time_point now) {
    commands.take([this](const v1::HandCommand& command) {
      logic.obey(command);
    });
    statuses.take([&](const v1::ServerStatus& status) {
      watch.see(status, now);
    });
    const bool is_there = watch.isThere(now);
    logic.serverIsThere(is_there);
    if (is_there) has_met_server = true;
    if (!has_met_server && !has_missed_server && now - start >= kServerPatience) {
      has_missed_server = true;
      logic.say(fmt::format("no handgraft-server answers on {}; waiting",
                            describe(participant.network())));
    }
    sessions.take([this](const v1::SessionState& state) {
      logic.see(state);
    });
    solutions.take([this](const v1::PoseSolution& solution) {
      logic.see(solution);
    });
  }

  void askForHand() {
    describer.want(logic.question());
    if (std::optional<HandDescriber::Answer> answer = describer.take()) {
      if (answer->description) {
        logic.answer(answer->question, *answer->description);
      } else {
        logic.refuse(answer->question, answer->refusal);
      }
      describer.want(std::nullopt);
    }
  }

  void moveHand() {
    try {
      openDriver();
      if (!driver) return;
      driver->read(reading);
      const MotorOrder order = logic.tick(reading);
      if (order.powered) {
        driver->write(order.positions);
      } else if (is_powered) {
        driver->stop();
      }
      is_powered = order.powered;
    } catch (const DeviceError& error) {
      logic.fail(error.what());
      closeDriver();
    } catch (const InvalidInput& error) {
      logic.fail(error.what());
      closeDriver();
    }
  }

  void openDriver() {
    if (logic.plan() == nullptr || logic.state() == v1::BRIDGE_FAULT) return;
    if (driver && driver_version == logic.planVersion()) return;
    closeDriver();
    driver = make_driver(*logic.plan());
    driver->open();
    driver_version = logic.planVersion();
  }

  void closeDriver() {
    if (!driver) return;
    try {
      driver->stop();
    } catch (const DeviceError& error) {
      logic.say(error.what());
    }
    driver.reset();
    is_powered = false;
  }

  void publish() {
    v1::JointState state;
    state.bridge_id(options.bridge_id);
    state.sequence_number(++sequence_number);
    state.state(logic.state());
    state.message(logic.message());
    state.session_id(logic.session());
    auto stamp = systemTimeOf(Clock::now());
    if (driver) {
      stamp = systemTimeOf(reading.time);
      state.names(logic.plan()->names);
      state.position_rad(reading.position);
      state.velocity_rad_s(reading.velocity);
      state.target_rad(logic.target());
    }
    state.stamp_ns(stamp.count());
    try {
      joint_states.write(state);
      if (driver) ros_joint_states.write(rosMessage(stamp));
    } catch (const TransportError& error) {
      logic.say(fmt::format("telemetry: {}", error.what()));
    }
  }

  RosJointState rosMessage(std::chrono::nanoseconds stamp) const {
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(stamp);
    RosJointState message;
    message.header().stamp().sec(static_cast<std::int32_t>(seconds.count()));
    message.header().stamp().nanosec(static_cast<std::uint32_t>((stamp - seconds).count()));
    message.name(logic.plan()->names);
    message.position(reading.position);
    message.velocity(reading.velocity);
    return message;
  }

  void say(std::string remark) {
    BridgeReport now;
    now.message = std::move(remark);
    now.state = logic.state();
    now.session_id = logic.session();
    if (const HandPlan* plan = logic.plan()) {
      now.hand = plan->hand;
      now.names = plan->names;
      if (driver) now.position = reading.position;
      now.target = logic.target();
    }
    report(now);
  }

  // === By absolute deadlines

  void run(const std::atomic<bool>& stop) {
    start = Clock::now();
    Clock::time_point next = start;
    while (!stop) {
      turn(Clock::now());
      wait(next);
    }
    logic.release();
    const auto give_up = Clock::now() + kBrakingPatience;
    while (is_powered && Clock::now() < give_up) {
      moveHand();
      publish();
      wait(next);
    }
    closeDriver();
  }

  void wait(Clock::time_point& next) {
    next += period;
    const auto now = Clock::now();
    if (now > next) {
      missed_periods += static_cast<unsigned long>((now - next) / period) + 1;
      next = now;
    }
    std::this_thread::sleep_until(next);
  }

  idl::cyclone::Participant participant;
  BridgeOptions options;
  MakeDriver make_driver;
  Report report;
  Clock::duration period;
  BridgeLogic logic;
  HandDescriber describer;
  ServerWatch watch;
  Clock::time_point start{};
  bool has_met_server = false;
  bool has_missed_server = false;

  std::unique_ptr<HandDriver> driver;
  unsigned driver_version = 0;
  bool is_powered = false;
  JointReading reading;
  std::uint64_t sequence_number = 0;
  unsigned long missed_periods = 0;

  Reader<v1::ServerStatus> statuses;
  Reader<v1::SessionState> sessions;
  Reader<v1::PoseSolution> solutions;
  Reader<v1::HandCommand> commands;
  Writer<v1::JointState> joint_states;
  Writer<RosJointState> ros_joint_states;
};

Bridge::Bridge(const idl::cyclone::Participant& participant,
               const BridgeOptions& options,
               MakeDriver make_driver,
               Report report) {
  if (!(options.period_s > 0) || !(options.period_s <= 1)) {
    rejectInput("period {} s is not in (0, 1]", options.period_s);
  }
  impl_ =
      std::make_unique<Impl>(participant, options, std::move(make_driver), std::move(report));
}

Bridge::~Bridge() = default;

void Bridge::run(const std::atomic<bool>& stop) {
  impl_->run(stop);
}

unsigned long Bridge::missedPeriods() const {
  return impl_->missed_periods;
}

}  // namespace handgraft::bridge
