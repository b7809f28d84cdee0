#include "hardware/bridge/motion_words.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "core/base/error.h"

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

Clamping clampingOf(const std::vector<std::string>& names,
                    std::span<const double> asked,
                    std::span<const double> given) {
  Clamping told;
  std::size_t count = 0;
  std::size_t worst = 0;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const double off = std::abs(asked[i] - given[i]);
    if (off <= kClamped) continue;
    ++count;
    if (off <= told.largest_rad) continue;
    told.largest_rad = off;
    worst = i;
  }
  if (count == 0) return told;
  std::array<char, 200> text{};
  auto end = fmt::format_to_n(
      text.data(), text.size(), "'{}' asked for {:.4g} rad, given {:.4g}",
      std::string_view(names[worst]).substr(0, 60), asked[worst], given[worst]);
  std::size_t size = std::min(end.size, text.size());
  if (count > 1) {
    end = fmt::format_to_n(text.data() + size, text.size() - size, "; {} more joints less",
                           count - 1);
    size = std::min(size + end.size, text.size());
  }
  told.text.set({text.data(), size});
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
