#include "hardware/devices/dynamixel_hand.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"

namespace handgraft::devices {

namespace dxl = protocols::dynamixel;
using protocols::numberAt;

namespace {

constexpr int kAttempts = 3;
constexpr std::chrono::milliseconds kRebootTime(500);
constexpr int kLongestReturnDelayUs = 508;
constexpr int kHighestCurrentMilliamp = 6000;  // of the strongest model
constexpr double kHighestProfile = 32767;      // register 112

// The bytes that each cycle reads, and where they lie among the indirect data.
constexpr std::array<std::uint8_t, 14> kBlockBytes = {126, 127, 128, 129, 130, 131, 132,
                                                      133, 134, 135, 70,  146, 98,  64};
constexpr std::size_t kCurrentAt = 0, kVelocityAt = 2, kPositionAt = 6, kErrorAt = 10,
                      kTemperatureAt = 11, kWatchdogAt = 12, kTorqueAt = 13;
static_assert(kBlockBytes.size() <= dxl::kIndirectCount);

struct Registers {
  const dxl::Register& torque = dxl::registerNamed("torque_enable");
  const dxl::Register& watchdog = dxl::registerNamed("bus_watchdog");
  const dxl::Register& goal_position = dxl::registerNamed("goal_position");
  const dxl::Register& goal_current = dxl::registerNamed("goal_current");
};

const Registers& registers() {
  static const Registers register_map;
  return register_map;
}

void validateMotors(const std::vector<DynamixelMotor>& motors) {
  if (motors.empty()) rejectInput("a Dynamixel hand without motors");
  std::array<bool, 256> is_taken{};
  for (const DynamixelMotor& motor : motors) {
    const std::string name = fmt::format("id {}", motor.id);
    if (motor.id > dxl::kHighestId)
      rejectInput("motor {} is outside 0 to {}", name, dxl::kHighestId);
    if (std::exchange(is_taken[motor.id], true)) rejectInput("motor {} is there twice", name);
    validate(motor.scale, name, -dxl::kFarthestGoal, dxl::kFarthestGoal);
    if (motor.current_limit_milliamp < 1 ||
        motor.current_limit_milliamp > kHighestCurrentMilliamp) {
      rejectInput("motor {}: current limit {} mA is outside 1 to {}", name,
                  motor.current_limit_milliamp, kHighestCurrentMilliamp);
    }
  }
}

}  // namespace

DynamixelHand::DynamixelHand(DynamixelConfig config, ByteChannel& bytes, Clock clock)
    : config_(std::move(config)),
      clock_(clock),
      bytes_(bytes),
      bus_(bytes, std::move(clock), config_.reply_timeout),
      watchdog_units_(static_cast<int>((config_.watchdog.count() + dxl::kWatchdogUnitMs - 1) /
                                       dxl::kWatchdogUnitMs)) {
  validateMotors(config_.motors);
  if (watchdog_units_ < 1 || watchdog_units_ > dxl::kLongestWatchdog) {
    rejectInput("Dynamixel watchdog of {} ms is outside 20 to {}", config_.watchdog.count(),
                dxl::kLongestWatchdog * dxl::kWatchdogUnitMs);
  }
  if (config_.reply_timeout <= Duration::zero() || config_.tolerated_misses < 0)
    rejectInput("Dynamixel reply timeout and tolerated misses have to be positive");
  if (config_.return_delay_us < 0 || config_.return_delay_us > kLongestReturnDelayUs) {
    rejectInput("Dynamixel return delay of {} us is outside 0 to {}", config_.return_delay_us,
                kLongestReturnDelayUs);
  }
  for (const DynamixelMotor& motor : config_.motors)
    ids_.push_back(motor.id);
  blocks_.resize(ids_.size());
  goals_.resize(ids_.size());
  current_units_milliamp_.resize(ids_.size(), 1.0);
}

void DynamixelHand::doOpen() {
  bytes_.open();
  expects_power_ = false;
  std::fill(blocks_.begin(), blocks_.end(), Block{});
  bus_.writeAll(ids_, registers().torque, 0);
  bus_.writeAll(ids_, dxl::registerNamed("status_return_level"), 2);
  for (std::size_t i = 0; i < config_.motors.size(); ++i)
    setUp(i);
  if (!readBlocksSurely()) throw DeviceError("a Dynamixel motor does not tell its state");
  for (const Block& block : blocks_) {
    if (block.torque != 0) throw DeviceError("a Dynamixel motor does not switch off");
  }
  findFaults();
}

void DynamixelHand::setUp(std::size_t index) {
  const DynamixelMotor& motor = config_.motors[index];
  const auto number = bus_.ping(motor.id);
  if (!number) throw DeviceError(fmt::format("Dynamixel motor {}: no answer", motor.id));
  const auto model = dxl::modelNumbered(*number);
  if (!model) {
    throw DeviceError(
        fmt::format("Dynamixel motor {}: model {} is not supported", motor.id, *number));
  }
  if (model->current_unit_milliamp == 0) {
    throw DeviceError(fmt::format(
        "Dynamixel motor {}: {} does not limit its current, so nothing bounds its force",
        motor.id, model->name));
  }
  if (index > 0 && indirect_data_ != model->indirect_data) {
    throw DeviceError(fmt::format(
        "Dynamixel motor {}: {} cannot be read together with motor {}: one is of the 330 "
        "series, the other is not",
        motor.id, model->name, config_.motors[0].id));
  }
  indirect_data_ = model->indirect_data;
  current_units_milliamp_[index] = model->current_unit_milliamp;
  const std::int64_t current = currentLimit(index);
  if (model->highest_current > 0 && current > model->highest_current) {
    throw DeviceError(fmt::format(
        "Dynamixel motor {}: {} bears at most {:.0f} mA, not {}", motor.id, model->name,
        std::floor(model->highest_current * model->current_unit_milliamp),
        motor.current_limit_milliamp));
  }
  const auto ensure = [&](const char* name, std::int64_t value) {
    bus_.ensure(motor.id, dxl::registerNamed(name), value);
  };
  bus_.write(motor.id, registers().torque, 0);
  bus_.write(motor.id, registers().watchdog, 0);  // also ends a watchdog that fired
  ensure("return_delay", config_.return_delay_us / 2);
  // Among its bits: counts run backwards; and torque on by any new goal.
  ensure("drive_mode", 0);
  ensure("operating_mode", dxl::kCurrentBasedPositionMode);
  ensure("startup_configuration", 0);  // otherwise it may switch itself on
  ensure("current_limit", current);
  bus_.write(motor.id, registers().goal_current, current);
  const auto& shutdown = dxl::registerNamed("shutdown");
  const std::int64_t errors = bus_.read(motor.id, shutdown);
  if ((errors & model->shutdown_errors) != model->shutdown_errors)
    bus_.write(motor.id, shutdown, errors | model->shutdown_errors);
  // The motion is shaped before it comes here.
  ensure("profile_acceleration", 0);
  const double profile = std::ceil(motor.velocity_limit_rad_s / dxl::kVelocityUnit);
  ensure("profile_velocity",
         static_cast<std::int64_t>(std::clamp(profile, 0.0, kHighestProfile)));
  if (motor.gains) {
    ensure("position_p_gain", motor.gains->position_p);
    ensure("position_i_gain", motor.gains->position_i);
    ensure("position_d_gain", motor.gains->position_d);
  }
  protocols::ByteBuffer addresses;
  for (const std::uint8_t address : kBlockBytes)
    addresses.put(std::uint16_t{address});
  bus_.writeBytes(motor.id, dxl::kIndirectAddresses, addresses.bytes());
}

std::int64_t DynamixelHand::currentLimit(std::size_t index) const {
  const double counts =
      config_.motors[index].current_limit_milliamp / current_units_milliamp_[index];
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(counts));
}

void DynamixelHand::doArm() {
  if (!readBlocksSurely()) throw DeviceError("a Dynamixel motor does not tell its position");
  findFaults();
  if (fault()) throw DeviceError("cannot arm: " + describe(fault()));
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    yieldToStop();
    // A goal of long ago would be run to at once.
    bus_.write(ids_[i], registers().goal_position, blocks_[i].position);
    bus_.write(ids_[i], registers().goal_current, currentLimit(i));
    bus_.write(ids_[i], registers().watchdog, watchdog_units_);
  }
  yieldToStop();
  bus_.writeAll(ids_, registers().torque, 1);
  if (!readBlocksSurely()) throw DeviceError("a Dynamixel motor does not say if it is on");
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    if (blocks_[i].torque == 0 || blocks_[i].watchdog != watchdog_units_) {
      throw DeviceError(fmt::format("Dynamixel motor {}: torque {}, watchdog {} after arming",
                                    ids_[i], blocks_[i].torque, blocks_[i].watchdog));
    }
  }
  expects_power_ = true;
}

void DynamixelHand::doRead(DeviceState& state) {
  readBlocks();
  state.time = TimePoint::max();
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Block& block = blocks_[i];
    const MotorScale& scale = config_.motors[i].scale;
    if (!block.is_known) continue;
    state.time = std::min(state.time, block.time);
    state.position[i] = scale.angle(block.position);
    state.velocity[i] = scale.direction * dxl::kVelocityUnit * block.velocity;
    state.current[i] = scale.direction * 1e-3 * current_units_milliamp_[i] * block.current;
    state.temperature[i] = block.temperature;
  }
  findFaults();
}

bool DynamixelHand::readBlocks() {
  for (Block& block : blocks_)
    ++block.misses;
  bus_.readAll(ids_, indirect_data_, kBlockBytes.size(),
               [&](std::size_t i, const dxl::Status& status) {
                 if (status.error != dxl::Error::kNone) return;
                 Block& block = blocks_[i];
                 block.current = numberAt<std::int16_t>(status.data, kCurrentAt);
                 block.velocity = numberAt<std::int32_t>(status.data, kVelocityAt);
                 block.position = numberAt<std::int32_t>(status.data, kPositionAt);
                 block.error = status.data[kErrorAt];
                 block.temperature = status.data[kTemperatureAt];
                 block.watchdog = status.data[kWatchdogAt];
                 block.torque = status.data[kTorqueAt];
                 block.alert = status.alert;
                 block.time = clock_();
                 block.misses = 0;
                 block.is_known = true;
               });
  counters_ = bus_.counters();
  return std::all_of(blocks_.begin(), blocks_.end(), [](const Block& block) {
    return block.misses == 0;
  });
}

bool DynamixelHand::readBlocksSurely() {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (readBlocks()) return true;
  }
  return false;
}

void DynamixelHand::findFaults() {
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    const Block& block = blocks_[i];
    const int motor = static_cast<int>(i);
    if (block.alert || block.error != 0) latch({Fault::Kind::kHardware, motor, block.error});
    // A hiccup of a hand without power endangers nobody.
    const bool is_silent = expects_power_ || clock_() - block.time > kIdlePatience;
    if (block.misses > config_.tolerated_misses && is_silent)
      latch({Fault::Kind::kSilent, motor, 0});
    if (!expects_power_) continue;
    if (block.watchdog == dxl::kWatchdogTripped) latch({Fault::Kind::kWatchdog, motor, 0});
    if (block.torque == 0) latch({Fault::Kind::kPowerLost, motor, 0});
  }
}

std::string DynamixelHand::meaningOf(std::uint32_t code) const {
  static constexpr std::array<ErrorBit, 5> kBits = {
      {{dxl::kInputVoltage, "input voltage"},
       {dxl::kOverheating, "overheating"},
       {dxl::kEncoder, "encoder"},
       {dxl::kElectricalShock, "electrical shock"},
       {dxl::kOverload, "overload"}}};
  return wordsOf(code, kBits);
}

void DynamixelHand::doWrite(std::span<const double> targets) {
  for (std::size_t i = 0; i < goals_.size(); ++i) {
    goals_[i] =
        config_.motors[i].scale.wholeUnits(targets[i], -dxl::kFarthestGoal, dxl::kFarthestGoal);
  }
  bus_.writeEach(ids_, registers().goal_position, goals_);
}

bool DynamixelHand::doDisarm() {
  expects_power_ = false;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    bus_.writeAll(ids_, registers().torque, 0);
    const bool has_all = readBlocks();
    const bool is_off = std::all_of(blocks_.begin(), blocks_.end(), [](const Block& block) {
      return block.torque == 0;
    });
    if (!has_all || !is_off) continue;
    bus_.writeAll(ids_, registers().watchdog, 0);
    return true;
  }
  return false;
}

void DynamixelHand::doStop() {
  expects_power_ = false;
  bus_.writeAll(ids_, registers().torque, 0);
}

void DynamixelHand::doHeal() {
  expects_power_ = false;
  bus_.writeAll(ids_, registers().torque, 0);
  const auto& error = dxl::registerNamed("hardware_error");
  bool has_rebooted = false;
  for (const std::uint8_t id : ids_) {
    try {
      if (bus_.read(id, error) == 0) continue;
    } catch (const DeviceError&) {
      // Silent, or so broken that it cannot tell: a restart is worth a try.
    }
    bus_.reboot(id);
    has_rebooted = true;
  }
  if (has_rebooted) bus_.wait(kRebootTime);
}

}  // namespace handgraft::devices
