// ODrive's messages as the vendor's headers give them, and SLCAN lines, both ways.

#include <array>
#include <map>
#include <string>

#include "hardware/protocols/odrive_can.h"
#include "hardware/protocols/slcan.h"
#include "hardware/protocols/socket_can_frame.h"

#include "tests/hardware/protocols/shared_vectors.h"
#include "tests/hardware/protocols/stream_checks.h"

namespace handgraft::protocols {
namespace {

using test::ByteVector;
using test::toHex;

/// Name, id and data of each of ODrive's vectors.
std::map<std::string, CanFrame> odriveFrames() {
  std::map<std::string, CanFrame> frames;
  const auto vectors = test::sharedVectors();
  for (const auto& entry : vectors.at("odrive").at("frames")) {
    const auto [name, id, data] = entry.get<std::array<std::string, 3>>();
    frames[name] = makeCanFrame(static_cast<std::uint32_t>(std::stoul(id, nullptr, 16)),
                                test::fromHex(data));
  }
  return frames;
}

std::vector<ByteVector> slcanLines() {
  std::vector<ByteVector> lines;
  const auto vectors = test::sharedVectors();
  for (const auto& line : vectors.at("slcan").at("lines").get<std::vector<std::string>>())
    lines.push_back(test::bytesOf(line + "\r"));
  return lines;
}

TEST(ODriveVectors, MessagesAreEncodedFromTheirMeaning) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  using namespace odrive;  // NOLINT(google-build-using-namespace): one test's names
  Heartbeat ok, expired;
  ok.state = AxisState::kClosedLoop;
  expired.error = kWatchdogExpired;
  expired.state = AxisState::kIdle;
  expired.procedure_result = 3;
  expired.is_trajectory_done = true;
  const std::map<std::string, CanFrame> ours = {
      {"set_axis_state 8", setAxisState(1, AxisState::kClosedLoop)},
      {"set_axis_state 1", setAxisState(1, AxisState::kIdle)},
      {"controller_mode 3 1",
       setControllerMode(1, ControlMode::kPosition, InputMode::kPassthrough)},
      {"input_pos 0.5 1.0 -0.25", setInputPosition(1, 0.5f, 1.0, -0.25)},
      {"input_vel 2.0 0.1", setInputVelocity(1, 2.0f, 0.1f)},
      {"limits 10 2.5", setLimits(1, 10.0f, 2.5f)},
      {"clear_errors", clearErrors(1)},
      {"estop", estop(1)},
      {"heartbeat ok", makeHeartbeat(1, ok)},
      {"heartbeat watchdog", makeHeartbeat(1, expired)},
      {"encoder 1.5 -0.25", makeFloatPair(1, Command::kGetEncoderEstimates, {1.5f, -0.25f})},
      {"get_error estop", makeErrorReport(1, {kEstopRequested, kEstopRequested})},
      {"iq 1.0 0.5", makeFloatPair(1, Command::kGetIq, {1.0f, 0.5f})},
      {"temp 40 55.5", makeFloatPair(1, Command::kGetTemperature, {40.0f, 55.5f})},
  };
  auto theirs = odriveFrames();
  for (const auto& [name, frame] : ours) {
    ASSERT_EQ(theirs.count(name), 1u) << name;
    EXPECT_EQ(frame, theirs[name]) << name << ": " << toHex(frame.bytes());
    theirs.erase(name);
  }
  // The vendor leaves the second half of a torque undefined.
  ASSERT_EQ(theirs.size(), 1u);
  EXPECT_EQ(toHex(setInputTorque(1, 0.05f).bytes().first(4)),
            toHex(theirs.at("input_torque 0.05 (first 4)").bytes()));
}

TEST(ODriveVectors, MessagesTellTheirMeaning) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  const auto frames = odriveFrames();
  EXPECT_EQ(odrive::encoderEstimatesOf(frames.at("encoder 1.5 -0.25")),
            (odrive::FloatPair{1.5f, -0.25f}));
  EXPECT_EQ(odrive::iqOf(frames.at("iq 1.0 0.5")), (odrive::FloatPair{1.0f, 0.5f}));
  EXPECT_EQ(odrive::temperatureOf(frames.at("temp 40 55.5")),
            (odrive::FloatPair{40.0f, 55.5f}));
  EXPECT_EQ(odrive::limitsOf(frames.at("limits 10 2.5")), (odrive::FloatPair{10.0f, 2.5f}));
  EXPECT_EQ(odrive::errorReportOf(frames.at("get_error estop"))->active,
            odrive::kEstopRequested);
  const auto beat = odrive::heartbeatOf(frames.at("heartbeat watchdog"));
  ASSERT_TRUE(beat);
  EXPECT_EQ(beat->error, odrive::kWatchdogExpired);
  EXPECT_EQ(beat->state, odrive::AxisState::kIdle);
  EXPECT_TRUE(beat->is_trajectory_done);
  EXPECT_FALSE(odrive::heartbeatOf(frames.at("heartbeat ok"))->isFaulty());
}

TEST(ODriveVectors, PassBothCarriersUnchanged) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  for (const auto& [name, frame] : odriveFrames()) {
    EXPECT_EQ(fromSocketCan(toSocketCan(frame)).frame, frame) << name;
    ByteBuffer line;
    slcan::encode(frame, line);
    EXPECT_EQ(slcan::lineOf(line.bytes()).frame, frame) << name;
  }
}

TEST(SlcanVectors, AreReadAndWrittenBack) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  for (const ByteVector& wire : slcanLines()) {
    const slcan::Line line = slcan::lineOf(wire);
    ASSERT_EQ(line.kind, slcan::Line::Kind::kFrame) << toHex(wire);
    ByteBuffer again;
    slcan::encode(line.frame, again);
    EXPECT_EQ(toHex(again.bytes()), toHex(wire));
  }
}

TEST(SlcanVectors, AreFoundAtEverySplitAndAfterGarbage) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  // A line that was begun ends only with a CR or a BEL.
  const std::vector<ByteVector> garbage = {{'\r'},
                                           {'\a'},
                                           test::bytesOf("t02\a"),
                                           test::bytesOf("xyz\r"),
                                           test::bytesOf(std::string(100, 'T') + "\r")};
  for (const ByteVector& wire : slcanLines()) {
    test::checkSplits<slcan::Framing>(wire);
    test::checkGarbageBefore<slcan::Framing>(wire, garbage);
  }
}

// A line has no checksum: see the test of slcan for what holds with wrong bits.
TEST(SlcanVectors, AWrongBitNeverGivesTheSameFrame) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  for (const ByteVector& wire : slcanLines()) {
    const CanFrame frame = slcan::lineOf(wire).frame;
    for (std::size_t at = 0; at < wire.size(); ++at) {
      for (int bit = 0; bit < 8; ++bit) {
        ByteVector wrong = wire;
        wrong[at] = static_cast<std::uint8_t>(wrong[at] ^ 1 << bit);
        if (bit == 5 && at > 0 && wire[at] >= 'A' && wire[at] <= 'F') continue;  // same digit
        for (const std::string& found : test::framesIn<slcan::Framing>({wrong})) {
          const slcan::Line line = slcan::lineOf(test::fromHex(found));
          EXPECT_FALSE(line.kind == slcan::Line::Kind::kFrame && line.frame == frame)
              << std::string(wrong.begin(), wrong.end());
        }
      }
    }
  }
}

}  // namespace
}  // namespace handgraft::protocols
