#include "hardware/bridge/bridge.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "core/base/error.h"
#include "hardware/bridge/calibration_keeper.h"
#include "hardware/bridge/command_filter.h"
#include "hardware/bridge/duplicate_bridge_monitor.h"
#include "hardware/bridge/follower_joints.h"
#include "hardware/bridge/hand_choice.h"
#include "hardware/bridge/inbox.h"
#include "hardware/bridge/motion_thread.h"
#include "hardware/bridge/own_refusal.h"
#include "hardware/bridge/passed_over.h"
#include "hardware/bridge/publisher.h"
#include "hardware/bridge/server_watch.h"
#include "hardware/bridge/stream_feed.h"
#include "hardware/bridge/trajectory_feed.h"
#include "hardware/bridge/wake_event.h"
#include "idl/topics.h"

namespace handgraft::bridge {

namespace {

using Clock = std::chrono::steady_clock;
using idl::cyclone::Origin;
using safety::GovernorState;
using safety::HoldCause;

constexpr std::chrono::milliseconds kServerPatience(1500);  // the absence is said within 2 s
// rad: a unit of small hands' encoders, 4096 a turn; the end of a range is rounded inwards by
// one.
// For the first pose of samples to be taken by the motion thread; refused, it is offered again.
constexpr std::chrono::milliseconds kBeginPatience(200);
// What comes and each period's end ring; the rest (patience that ends, a stop) may wait so
// long.
constexpr std::chrono::milliseconds kNap(20);

}  // namespace

struct Bridge::Impl {
  Impl(const idl::cyclone::Participant& on,
       const BridgeOptions& told,
       std::atomic<bool>& estop_flag,
       Report say_to)
      : participant(on),
        options(told),
        estop(estop_flag),
        report(std::move(say_to)),
        filter(told.bridge_id),
        rivals(told.bridge_id),
        feed(told.session,
             told.with_intermediate,
             !told.config && told.arms_itself,
             told.config ? told.config->hand : ""),
        choice(participant),
        trajectories(participant, bell),
        statuses(participant, idl::kStatusTopic, bell),
        commands(participant, idl::kHandCommandTopic, bell),
        heard_statuses(participant, idl::kBridgeStatusTopic, bell),
        publisher(
            participant,
            told.ros_namespace,
            told.bridge_id,
            [this](v1::HandCommandKind kind) {
              obey(kind);
            },
            bell) {
    is_willing = !options.config && options.arms_itself;
    identity.bridge_id = options.bridge_id;
    identity.config = options.config_name;
    identity.period_s = options.config ? options.config->governor.period_s : options.period_s;
    identity.device = "simulated";
    no_hand.trouble.set("no hand yet: waiting for a session");
    if (options.config) beginMotion(*options.config, {});
  }

  // === The hand

  // `start_rad`: of the motors.
  void beginMotion(const config::HandConfig& config, const std::vector<double>& start_rad) {
    motion.reset();  // brakes, and frees the wire
    const MakeDevice make = [start_rad, this](const config::HandConfig& asked) {
      DeviceStack stack = makeDevice(asked, Clock::now, start_rad);
      stack.device->stopWhen([this] {
        return estop.load();
      });
      return stack;
    };
    const auto keep = [this](const config::HandConfig* homed) {
      if (homed != nullptr) {
        calibration.keep(*homed);
      } else {
        calibration.drop(options.config ? options.config->calibration : "");
      }
    };
    motion = std::make_unique<MotionThread>(
        std::make_unique<Motion>(config, make, Clock::now, keep), estop, bell);
    identity.hand = config.hand;
    identity.device = nameOf(config.device);
    identity.joints = config.governor.names;
    identity.sliding.clear();
    for (std::size_t i = 0; i < identity.joints.size(); ++i)
      if (config.governor.limits[i].slides) identity.sliding.push_back(identity.joints[i]);
    identity.motors.clear();
    for (const config::MotorConfig& motor : config.motors)
      identity.motors.push_back(motor.name);
    arrived = false;
  }

  [[nodiscard]] const MotionState& state() const { return motion ? motion->last() : no_hand; }

  // === Once a turn

  void turn(Clock::time_point now) {
    lookForRivals(now);
    takeCommands();
    takeStream(now);
    takeSamples(now);
    passPose(now);
    const MotionState* news = motion ? motion->take() : nullptr;
    seeWhetherArmed();
    armIfWilling(now);
    remark(now);
    publish(news, now);
  }

  // Whoever arms one of two bridges with the same number arms both, knowing of one.
  void lookForRivals(Clock::time_point now) {
    heard_statuses.take([&](const v1::BridgeStatus& status) {
      rivals.see(status, now);
    });
    const std::optional<std::string> found = rivals.rival(now);
    if (found.has_value() == !rival.empty()) return;
    rival = found ? rivalAdvice(options.bridge_id, *found) : "";
    say(found ? rival : "the other bridge of this number is gone");
  }

  // Commands before poses: a stop does not wait for anything.
  void takeCommands() {
    commands.take([this](const v1::HandCommand& command) {
      if (filter.passes(command)) obey(command.kind());
    });
  }

  void obey(v1::HandCommandKind kind) {
    own_refusal.forget();
    const bool moves = kind == v1::COMMAND_ARM || kind == v1::COMMAND_HOME;
    if (moves && !rival.empty()) {
      const std::string why =
          fmt::format("{} refused: {}", kind == v1::COMMAND_ARM ? "ARM" : "HOME", rival);
      own_refusal.note(v1::REFUSAL_RIVAL, why);
      return say(why);
    }
    if (kind == v1::COMMAND_ARM && !misfit.empty()) {
      const std::string why = "ARM refused: " + misfit;
      own_refusal.note(v1::REFUSAL_OTHER_JOINTS, why);
      return say(why);
    }
    is_asked_to_arm = kind == v1::COMMAND_ARM;
    if (kind == v1::COMMAND_DISARM || kind == v1::COMMAND_ESTOP) is_willing = false;
    if (!motion) {
      own_refusal.note(v1::REFUSAL_NO_HAND, "refused: no hand yet");
      say("no hand yet: the command changes nothing");
      return;
    }
    switch (kind) {
      case v1::COMMAND_ARM:
        return motion->request(Request::kArm);
      case v1::COMMAND_DISARM:
        return motion->request(Request::kDisarm);
      case v1::COMMAND_ESTOP:
        return motion->estop();
      case v1::COMMAND_RESET:
        return motion->request(Request::kReset);
      case v1::COMMAND_HOME:
        return motion->request(Request::kHome);
    }
    say(fmt::format("command {} is none", static_cast<int>(kind)));
  }

  void tellPassedOver(const std::string& text) {
    if (passed_over.see(text)) say(text);
  }

  void takeStream(Clock::time_point now) {
    statuses.takeWithOrigin([&](const v1::ServerStatus& status, const Origin& origin) {
      if (status.name() == participant.network().server)
        watch.see(status, now, origin.written_ns);
    });
    const bool is_there = watch.isThere(now);
    if (is_there != server_is_there) say(is_there ? "server found" : "the server is gone");
    if (server_is_there && !is_there) endStream();
    // What was streamed before comes again to a reader that joins: poses answer edits, and the
    // next edit may be far away.
    if (is_there && !server_is_there && has_met_server) {
      sessions.emplace(participant, idl::kSessionTopic, bell);
      solutions.emplace(participant, idl::kSolutionTopic, bell);
    }
    server_is_there = is_there;
    has_met_server = has_met_server || is_there;
    if (!has_met_server && !has_missed_server && now - start >= kServerPatience) {
      has_missed_server = true;
      say(fmt::format("no handgraft-server answers on {}; waiting",
                      describe(participant.network())));
    }
    feed.serverIsThere(is_there);
    sessions->take([this](const v1::SessionState& session) {
      const bool is_ours = feed.see(session);
      const bool is_meant = !options.session || *options.session == session.session_id();
      if (is_meant) trajectories.see(session);
      if (is_ours || !is_meant || session.phase() == v1::PHASE_CLOSED) return;
      tellPassedOver(PassedOver::ofAnotherHand(session.session_id(), session.hand(),
                                               options.config->hand));
    });
    bool is_anew = false;
    solutions->takeWithOrigin([&](const v1::PoseSolution& solution, const Origin& origin) {
      is_anew = is_anew || feed.isAnew(solution);
      if (!is_anew) feed.see(solution, origin.written_ns);
    });
    while (const std::optional<std::uint64_t> kept = feed.takeKept())
      tellPassedOver(PassedOver::asItWasKept(*kept));
    if (!is_anew) return;
    // Gone and back within a moment. What it sent since comes again to readers that join.
    say("the server was started anew");
    endStream();
    feed.serverIsThere(false);
    feed.serverIsThere(is_there);
    sessions.emplace(participant, idl::kSessionTopic, bell);
    solutions.emplace(participant, idl::kSolutionTopic, bell);
  }

  // What comes after a gap may be from anywhere: it moves nothing before somebody says so.
  void endStream() {
    choice.forget();
    if (!is_willing || !has_armed_itself) return;
    is_willing = false;
    say("the server is gone: ARM moves on");
  }

  // After poses: samples are the newer word.
  void takeSamples(Clock::time_point now) {
    trajectories.take(now, [&](std::uint64_t session, const TrajectoryFeed::Message& told) {
      const TrajectoryFeed::Message message = withLed(told);
      const std::int64_t system_ns = systemTimeOf(now).count();
      const std::optional<StreamFeed::Heard> heard = feed.hear(session, system_ns);
      if (!heard) return;
      const bool has_begun = motion && state().stream == heard->stream;
      ReadTrajectory read = readTrajectory(
          message, has_begun ? identity.joints : message.joint_names(), system_ns);
      if (!read.refusal.empty()) {
        own_refusal.note(v1::REFUSAL_POSE, "sample refused: " + read.refusal);
        return say("sample refused: " + read.refusal);
      }
      if (!has_begun) return beginWith(*heard, session, message, read.poses.front(), now);
      arrived = true;  // nothing to arrive at
      for (TimedPose& pose : read.poses) {
        pose.stream = heard->stream;
        pose.arrived = now;
        motion->offer(pose);
      }
    });
    tellOtherPlayers();
  }

  void tellOtherPlayers() {
    const std::optional<std::uint64_t> session = trajectories.takeOther();
    if (!session) return;
    const std::string text = fmt::format(
        "session {} is played by two programs: the one that came first is followed", *session);
    own_refusal.note(v1::REFUSAL_POSE, text);
    say(text);
  }

  [[nodiscard]] TrajectoryFeed::Message withLed(const TrajectoryFeed::Message& told) const {
    TrajectoryFeed::Message message = told;
    if (!options.config) return message;
    const std::vector<LedJoint> led = ledJoints(*options.config, told.joint_names());
    for (auto& point : message.points())
      appendLed(led, told.joint_names().size(), point.positions());
    for (const LedJoint& joint : led)
      message.joint_names().push_back(joint.name);
    return message;
  }

  // A stream begins with a pose, by which its hand is found.
  void beginWith(const StreamFeed::Heard& heard,
                 std::uint64_t session,
                 const TrajectoryFeed::Message& message,
                 const TimedPose& first,
                 Clock::time_point now) {
    if (waiting || (offered_stream == heard.stream && now - offered_at < kBeginPatience))
      return;
    StreamFeed::Pose pose;
    pose.stream = heard.stream;
    pose.pose.session_id = session;
    pose.pose.hand = heard.hand;
    pose.pose.names = message.joint_names();
    pose.pose.joint_rad = first.joint_rad;
    waiting = std::move(pose);
    waiting_since = now;
  }

  void passPose(Clock::time_point now) {
    if (std::optional<StreamFeed::Pose> pose = feed.take(watch.serverTime(now), now)) {
      waiting = std::move(pose);
      waiting_since = now;
    }
    while (const std::optional<std::uint64_t> left = feed.takeLeft())
      tellPassedOver(PassedOver::leftByDemonstrator(*left));
    while (const std::optional<std::uint64_t> beside = feed.takeBeside())
      tellPassedOver(PassedOver::besideAnother(*beside, feed.session()));
    tellWhetherLeft(now);
    if (options.config) {
      compareWithModel();
    } else {
      chooseHand();
    }
    if (waiting && (options.config || choice.isOf(*waiting))) {
      offer(*std::exchange(waiting, std::nullopt));
    }
    const std::optional<std::uint64_t> alive = feed.alive(now);
    if (motion && alive) motion->renew(*alive, now);
  }

  void tellWhetherLeft(Clock::time_point now) {
    if (feed.isLeft(now) == is_left) return;
    is_left = !is_left;
    if (!is_left) return;
    const std::string text = PassedOver::leftByDemonstrator(feed.session());
    passed_over.see(text);
    say(text);
  }

  void offer(StreamFeed::Pose pose) {
    if (identity.session_id != pose.pose.session_id)
      say(fmt::format("following session {}", pose.pose.session_id));
    identity.session_id = pose.pose.session_id;
    passed_over.forget();
    if (!pose.is_repeat) {
      arrived = false;
      pose_number = pose.pose.sequence_number;
    }
    StreamPose told;
    told.stream = pose.stream;
    told.sequence = offered = pose.pose.sequence_number;
    offered_stream = pose.stream;
    offered_at = waiting_since;
    // On a busy machine a pose may be long on its way, which a simulated hand may bear.
    told.source_ns = options.config ? pose.pose.stamp_ns : 0;
    told.arrived = waiting_since;
    told.names = std::move(pose.pose.names);
    told.joint_rad = std::move(pose.pose.joint_rad);
    if (options.config) {
      const std::vector<LedJoint> led = ledJoints(*options.config, told.names);
      appendLed(led, told.names.size(), told.joint_rad);
      for (const LedJoint& joint : led)
        told.names.push_back(joint.name);
    }
    motion->offer(std::move(told));
  }

  // === Which hand

  void compareWithModel() {
    const auto compared = choice.compare(identity.session_id, *options.config);
    if (!compared) return;
    warnings = compared->differences;
    misfit = compared->kinds;
    if (!warnings.empty()) say(warnings);
    // Armed in the moment before the server's answer came.
    if (!misfit.empty()) motion->request(Request::kDisarm);
  }

  void chooseHand() {
    const std::string refusal =
        choice.choose(waiting, options.bounds, [this](const HandPlan& wanted) {
          beginMotion(simulatedConfig(wanted, options.period_s), restOfMotors(wanted));
          say(fmt::format("hand {}: {} joints", handgraft::quoted(wanted.hand),
                          wanted.jointCount()));
        });
    if (refusal.empty()) return;
    // Until the next pose there is nothing new to say.
    say(refusal);
    waiting.reset();
  }

  /// An ARM that was obeyed makes it willing again; one that was refused moves nothing later.
  void seeWhetherArmed() {
    if (!is_asked_to_arm || state().state != GovernorState::kArmed) return;
    is_asked_to_arm = false;
    is_willing = !options.config && options.arms_itself;
  }

  void armIfWilling(Clock::time_point now) {
    const std::optional<std::uint64_t> alive = feed.alive(now);
    if (!rival.empty() || !is_willing || !motion || !alive || state().stream != *alive) return;
    const bool rests =
        state().state == GovernorState::kIdle ||
        (state().state == GovernorState::kHolding && state().hold != HoldCause::kDisarmed);
    if (!rests) return;
    has_armed_itself = true;
    motion->request(Request::kArm);
  }

  // === What there is to say

  void remark(Clock::time_point at) {
    if (std::string homed = calibration.takeText(); !homed.empty()) say(std::move(homed));
    const MotionState& now = state();
    if (now.refusals != told_refusals) {
      own_refusal.forget();
      if (!now.last_refusal.view().empty()) say(std::string(now.last_refusal.view()));
    }
    told_refusals = now.refusals;
    std::string reason = bridge::describe(now);
    if (reason != told_reason) {
      say(reason);
      told_reason = std::move(reason);
    }
    if (arrived || now.state != GovernorState::kArmed || now.stream == 0) return;
    const std::optional<std::uint64_t> alive = feed.alive(at);
    if (!alive || now.stream != *alive) return;
    if (now.sequence != offered) return;  // the newest pose was refused, or is on its way
    if (!now.is_at_target) return;
    arrived = true;
    const std::string_view less = now.clamping.view();
    say(less.empty()
            ? fmt::format("session {}: pose {} reached", identity.session_id, pose_number)
            : fmt::format("session {}: pose {} reached as far as the limits permit: {}",
                          identity.session_id, pose_number, less));
  }

  void say(std::string text) {
    if (text == last_said) return;
    last_said = text;
    BridgeReport told;
    told.message = std::move(text);
    told.state = wireState(state().state);
    told.session_id = identity.session_id;
    told.hand = identity.hand;
    told.names = identity.joints;
    if (state().is_connected) told.position = state().position;
    if (state().stream != 0) told.target = state().target;
    report(told);
  }

  // === Telemetry

  void publish(const MotionState* news, Clock::time_point now) {
    v1::BridgeStatus status = bridgeStatus(identity, state(), systemTimeOf(now));
    if (!rival.empty()) status.reason(status.reason() + "; " + rival);
    own_refusal.addTo(status);
    status.warnings(warnings);
    // The motion never hears of sessions that are not for it.
    const bool lacks_pose = status.refusal() == v1::REFUSAL_NO_FRESH_POSE;
    if (lacks_pose && !passed_over.last().empty())
      status.last_refusal(status.last_refusal() + ": " + passed_over.last());
    if (publisher.isDue(status, now)) rivals.noteOwn(status.stamp_ns());
    try {
      publisher.publish(identity, state(), news, status, now);
    } catch (const TransportError& error) {
      say(fmt::format("telemetry: {}", error.what()));
    }
  }

  void run(const std::atomic<bool>& stop) {
    start = Clock::now();
    while (!stop) {
      turn(Clock::now());
      bell->wait(kNap);
    }
    overruns = state().overruns;
    motion.reset();
  }

  idl::cyclone::Participant participant;
  BridgeOptions options;
  std::atomic<bool>& estop;
  Report report;
  const std::shared_ptr<WakeEvent> bell = std::make_shared<WakeEvent>();
  CommandFilter filter;
  DuplicateBridgeMonitor rivals;
  StreamFeed feed;
  ServerWatch watch;
  HandChoice choice;
  TrajectoryFeed trajectories;
  CalibrationKeeper calibration;
  BridgeIdentity identity;
  MotionState no_hand;
  Clock::time_point start{};

  bool server_is_there = false, has_met_server = false, has_missed_server = false;
  bool is_willing = false;       // to arm by itself
  bool is_asked_to_arm = false;  // by the last command
  bool has_armed_itself = false;
  bool is_left = false;                     // by a demonstrator who was followed
  bool arrived = false;                     // at the newest pose, and said so
  std::uint64_t offered = 0;                // number of the pose that was handed over last
  std::uint64_t pose_number = 0;            // of the newest pose, before it was diagnosed
  std::optional<StreamFeed::Pose> waiting;  // for its hand's description
  Clock::time_point waiting_since{};
  std::uint64_t offered_stream = 0;  // of the pose that was handed over last, and when it came
  Clock::time_point offered_at{};

  std::string rival;  // of the same number, and what to do about it; empty: none
  PassedOver passed_over;
  OwnRefusal own_refusal;
  std::string warnings;  // how the config differs from the hand's model; empty: it does not
  std::string misfit;    // of that, what keeps it from being moved
  std::string last_said, told_reason;
  std::uint64_t told_refusals = 0, overruns = 0;

  Inbox<v1::ServerStatus> statuses;
  std::optional<Inbox<v1::SessionState>> sessions{std::in_place, participant,
                                                  idl::kSessionTopic, bell};
  std::optional<Inbox<v1::PoseSolution>> solutions{std::in_place, participant,
                                                   idl::kSolutionTopic, bell};
  Inbox<v1::HandCommand> commands;
  Inbox<v1::BridgeStatus> heard_statuses;
  Publisher publisher;

  // Last, so that it ends first: it uses what stands above.
  std::unique_ptr<MotionThread> motion;
};

Bridge::Bridge(const idl::cyclone::Participant& participant,
               const BridgeOptions& options,
               std::atomic<bool>& estop,
               Report report) {
  if (!(options.period_s > 0) || !(options.period_s <= 1)) {
    rejectInput("period {} s is not in (0, 1]", options.period_s);
  }
  impl_ = std::make_unique<Impl>(participant, options, estop, std::move(report));
}

Bridge::~Bridge() = default;

void Bridge::run(const std::atomic<bool>& stop) {
  impl_->run(stop);
}

std::uint64_t Bridge::overruns() const {
  return impl_->overruns;
}

}  // namespace handgraft::bridge
