#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "hardware/config/hand_config.h"
#include "idl/cyclone/participant.h"
#include "idl/hardware.h"
#include "idl/ros2.h"
#include "idl/service.h"
#include "idl/sessions.h"

#include "tests/hardware/emulators/hand_rig.h"
#include "tests/support/process.h"

namespace handgraft::test {

/// What a bridge hears of a server with one session: it lives, and streams poses.
class StandInServer {
 public:
  StandInServer(const Network& network,
                const std::string& hand,
                const std::vector<std::string>& joint_names);
  /// Says that it stops.
  ~StandInServer();

  void stream(const std::vector<double>& joint_rad);

  /// A timed sample of the session, for now; `stamp_ns` of the system's clock.
  void sample(const std::vector<double>& joint_rad, std::int64_t stamp_ns);

  [[nodiscard]] bool isSampled() const { return samples_.readers() > 0; }

  /// It says nothing, as if it were suspended, until it is told to go on.
  void pause(bool is_paused) { is_paused_ = is_paused; }

  /// The session takes a hand of this name by an edit; poses from now on are of it.
  void take(const std::string& hand);

  static constexpr std::uint64_t kSession = 11;

 private:
  void say(bool stops);

  idl::cyclone::Participant participant_;
  idl::cyclone::Writer<v1::ServerStatus> statuses_;
  idl::cyclone::Writer<v1::SessionState> sessions_;
  idl::cyclone::Writer<v1::PoseSolution> solutions_;
  std::string sample_topic_;
  idl::cyclone::Writer<trajectory_msgs::msg::dds_::JointTrajectory_> samples_;
  v1::SessionState state_;
  std::uint64_t number_ = 0;
  std::atomic<bool> is_ending_{false};
  std::atomic<bool> is_paused_{false};
  std::thread life_;
};

/// `handgraft-bridge` as a process, with an emulated device on a pty at its end.
class BridgeBench {
 public:
  /// `config_text` is that of a config file. Its port does not matter: the bridge is told that
  /// of the emulated device.
  BridgeBench(const Network& network, const std::string& config_text);

  void startBridge(const std::vector<std::string>& more = {});
  /// Arguments to start `handgraft-bridge` on the same device under another number.
  [[nodiscard]] std::vector<std::string> argumentsOf(int bridge_id) const;
  /// Ends it as by SIGTERM, and waits; its exit code.
  int stopBridge();

  Process& bridge() { return *bridge_; }

  HandRig& rig() { return *rig_; }

  [[nodiscard]] const config::HandConfig& config() const { return config_; }

  void command(v1::HandCommandKind kind);
  /// As above, whether anybody hears it or not.
  void shout(v1::HandCommandKind kind);

  /// The newest of what the bridge told of its joints since this was last asked, oldest first.
  std::vector<v1::JointState> jointStates();

  /// The first status, from now on, for which `wanted` holds; nothing after a minute.
  std::optional<v1::BridgeStatus> status(
      const std::function<bool(const v1::BridgeStatus&)>& wanted);
  std::optional<v1::BridgeStatus> status(v1::BridgeState state);

  /// Arms until the hand is armed and under power. On a busy machine a device may wait for too
  /// long, which is a fault, and rightly so: it is reset then. False if it does not come.
  bool arm();

  /// Waits until every motor stands within `tolerance_rad` of where it is told to be by
  /// `goals`; arms again as `arm` does. False after a minute.
  bool arrive(const std::function<std::vector<double>()>& goals, double tolerance_rad);

  /// What the bridge wrote.
  [[nodiscard]] std::string told() const { return bridge_ ? bridge_->err() : ""; }

 private:
  Network network_;
  config::HandConfig config_;
  std::unique_ptr<HandRig> rig_;
  std::string config_path_;
  std::unique_ptr<Process> bridge_;
  idl::cyclone::Participant participant_;
  idl::cyclone::Writer<v1::HandCommand> commands_;
  idl::cyclone::Reader<v1::BridgeStatus> statuses_;
  idl::cyclone::Reader<v1::JointState> joint_states_;
  std::uint64_t command_id_ = 0;
};

/// An example config as it is shipped, its rate included, but patient: it meets real time on a
/// busy machine.
std::string patientExample(const std::string& name);

/// Replaces the one place of `what` in `text`; throws if there is none.
void replace(std::string& text, const std::string& what, const std::string& by);

/// A config of `joints` by direct drive over [-limit, limit]; patient, since it meets real time
/// on a busy machine. Of an ability_hand, joints beyond the sixth follow the first ones.
std::string directConfig(const std::string& device,
                         const std::string& hand,
                         const std::vector<std::string>& joints,
                         double limit_rad);

}  // namespace handgraft::test
