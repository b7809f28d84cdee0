#include "tests/hardware/emulators/allegro_emulator.h"

#include <cmath>
#include <utility>

namespace handgraft::test {

namespace allegro = protocols::allegro;

AllegroEmulator::AllegroEmulator() {
  for (Joint& joint : joints)
    joint.counts = 2000;
}

void AllegroEmulator::advance(TimePoint now) {
  if (time_ == TimePoint{}) time_ = now;
  const double seconds = secondsOf(now - time_);
  time_ = now;
  for (Joint& joint : joints) {
    const double torque = is_on ? joint.pwm / allegro::kPwmPerNm : 0;
    joint.counts += torque / kOil * seconds / allegro::kRadPerCount;
  }
}

void AllegroEmulator::hear(const protocols::CanFrame& frame, TimePoint now) {
  advance(now);
  using allegro::Command;
  if (frame.id == allegro::idOf(Command::kSystemOn)) is_on = true;
  if (frame.id == allegro::idOf(Command::kSystemOff)) switchOff();
  if (const auto torque = allegro::torqueOf(frame)) {
    for (std::size_t k = 0; k < torque->numbers.size(); ++k)
      joints[torque->finger * allegro::kJointsOfFinger + k].pwm = torque->numbers[k];
  }
  for (std::size_t finger = 0; frame.is_remote && finger < allegro::kFingerCount; ++finger) {
    if (is_broken && finger == 1) continue;
    if (frame.id == allegro::idOf(Command::kFingerPose, finger)) {
      allegro::Numbers counts{};
      for (std::size_t k = 0; k < counts.size(); ++k) {
        counts[k] = static_cast<std::int16_t>(
            std::lround(joints[finger * allegro::kJointsOfFinger + k].counts));
      }
      said_.push_back(allegro::makePose(finger, counts));
    }
    if (frame.id == allegro::idOf(Command::kTemperature, finger))
      said_.push_back(allegro::makeTemperature(finger, {31, 32, 33, 34}));
  }
}

void AllegroEmulator::switchOff() {
  is_on = false;
  for (Joint& joint : joints)
    joint.pwm = 0;
}

std::vector<protocols::CanFrame> AllegroEmulator::takeFrames() {
  return std::exchange(said_, {});
}

}  // namespace handgraft::test
