#include "hardware/bridge/motion_words.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "core/base/error.h"
#include "hardware/bridge/device_factory.h"

namespace handgraft::bridge {

namespace {

constexpr double kClamped = 1e-3;  // rad: a margin inside the limits is no news

}  // namespace

v1::BridgeRefusal codeOf(safety::Refusal refusal) {
  using safety::Refusal;
  switch (refusal) {
    case Refusal::kNone:
    case Refusal::kCount:
      return v1::REFUSAL_NONE;
    case Refusal::kNotConnected:
      return v1::REFUSAL_NO_DEVICE;
    case Refusal::kEStop:
      return v1::REFUSAL_ESTOP;
    case Refusal::kFault:
      return v1::REFUSAL_FAULT;
    case Refusal::kNoFreshStream:
      return v1::REFUSAL_NO_FRESH_POSE;
    case Refusal::kNotMeasured:
      return v1::REFUSAL_NOT_MEASURED;
    case Refusal::kOutOfRange:
      return v1::REFUSAL_OUT_OF_RANGE;
    case Refusal::kMotorsOutside:
      return v1::REFUSAL_MOTORS_OUTSIDE;
    case Refusal::kMotorsOn:
      return v1::REFUSAL_MOTORS_ON;
    case Refusal::kNothingToReset:
      return v1::REFUSAL_NOTHING_TO_RESET;
  }
  return v1::REFUSAL_NONE;
}

Clamping clampingOf(const safety::GovernorOptions& options,
                    std::span<const double> asked,
                    std::span<const double> given) {
  Clamping told;
  std::size_t count = 0;
  std::size_t worst = 0;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const double off = std::abs(asked[i] - given[i]) / options.limits[i].travel;
    if (off <= kClamped) continue;
    ++count;
    if (off <= told.largest_rad) continue;
    told.largest_rad = off;
    worst = i;
  }
  if (count == 0) return told;
  std::array<char, 200> text{};
  auto end =
      fmt::format_to_n(text.data(), text.size(), "'{}' asked for {:.4g} {}, given {:.4g}",
                       std::string_view(options.names[worst]).substr(0, 60), asked[worst],
                       safety::unitOf(options.limits[worst]), given[worst]);
  std::size_t size = std::min(end.size, text.size());
  if (count > 1) {
    end = fmt::format_to_n(text.data() + size, text.size() - size, "; {} more joints less",
                           count - 1);
    size = std::min(size + end.size, text.size());
  }
  told.text.set({text.data(), size});
  return told;
}

std::string lostText(safety::FaultCause cause, const config::DeviceConfig& device) {
  std::string text = fmt::format("{}: {}; whether its motors are off is not known",
                                 toString(cause), nameOf(device));
  // One that is heard of no more hears of us no more either; one that is silent still may.
  if (cause != safety::FaultCause::kDeviceLost) return text + ": cut their power";
  if (!config::traitsOf(device.kind).has_watchdog)
    return text + ": it has no watchdog, cut their power";
  return text +
         fmt::format(
             ": its own watchdog stops them {} ms after the last command; if they go on, "
             "cut their power",
             device.watchdog.count());
}

FixedText outsideText(const safety::GovernorOptions& options,
                      std::span<const double> measured) {
  FixedText told;
  double worst = 1.0;
  std::array<char, 200> text{};
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const safety::JointLimits& limits = options.limits[i];
    const double beyond = std::max(limits.lower - measured[i], measured[i] - limits.upper) /
                          options.outside.of(limits);
    if (!(beyond > worst)) continue;
    worst = beyond;
    const auto end = fmt::format_to_n(
        text.data(), text.size(), "joint '{}' is at {:.4g} {}, its limits {:.4g} to {:.4g}",
        std::string_view(options.names[i]).substr(0, 60), measured[i], safety::unitOf(limits),
        limits.lower, limits.upper);
    told.set({text.data(), std::min(end.size, text.size())});
  }
  return told;
}

std::string faultText(const devices::Device& device,
                      const config::HandConfig& config,
                      const std::vector<std::size_t>& joint_of_motor) {
  const devices::Fault& fault = device.fault();
  std::string text = devices::describe(fault.kind);
  if (fault.code != 0) {
    const std::string meaning = device.meaningOf(fault.code);
    text += meaning.empty() ? fmt::format(" (code 0x{:X})", fault.code)
                            : fmt::format(": {} (code 0x{:X})", meaning, fault.code);
  }
  if (fault.kind == devices::Fault::Kind::kSilent)
    text += "; whether it is off is not known: cut its power";
  if (fault.motor < 0) return text;
  const auto index = static_cast<std::size_t>(fault.motor);
  const config::MotorConfig& motor = config.motors[index];
  const std::string joint = index < joint_of_motor.size()
                                ? config.governor.names[joint_of_motor[index]]
                                : std::string();
  return fmt::format("motor {} (id {}{}): {}", quoted(motor.name), motor.id,
                     joint.empty() || joint == motor.name ? "" : ", joint " + quoted(joint),
                     text);
}

}  // namespace handgraft::bridge
