// Packets of the e-Manual and of the vendor's C++ SDK, both ways.

#include <functional>
#include <map>
#include <numeric>
#include <string>

#include "hardware/protocols/dynamixel_packet.h"
#include "hardware/protocols/dynamixel_table.h"

#include "tests/hardware/protocols/shared_vectors.h"
#include "tests/hardware/protocols/stream_checks.h"

namespace handgraft::protocols::dynamixel {
namespace {

using test::ByteVector;
using test::framesIn;
using test::toHex;

/// Each packet of the groups, with its case's name.
void forEachPacket(const std::function<void(const std::string&, const ByteVector&)>& use) {
  const auto vectors = test::sharedVectors();
  int count = 0;
  for (const char* group : {"emanual", "stuffing", "hand"}) {
    for (const auto& entry : vectors.at("dxl").at(group)) {
      for (const ByteVector& wire : test::bytesOfAll(entry.at("packets"))) {
        use(entry.at("case"), wire);
        ++count;
      }
    }
  }
  EXPECT_GE(count, 35);
}

TEST(DynamixelVectors, AreReadAndWrittenBack) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  forEachPacket([](const std::string& name, const ByteVector& wire) {
    const auto found = framesIn<Framing>({wire});
    ASSERT_EQ(found.size(), 1u) << name;
    ByteBuffer again;
    const ByteVector content = test::fromHex(found[0]);
    encode(packetOf(content), again);
    EXPECT_EQ(toHex(again.bytes()), toHex(wire)) << name;
  });
}

TEST(DynamixelVectors, AreFoundAtEverySplitAfterGarbageAndNeverWithAWrongBit) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  const std::vector<ByteVector> garbage = {
      {0x00},
      {0xFF, 0xFF},
      {0xFF, 0xFF, 0xFD, 0x00},
      {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0x08, 0x00, 0x55},
      {0xFF, 0xFF, 0xFD, 0x00, 0x01, 0xF0, 0x07, 0x55, 0x12}};
  forEachPacket([&](const std::string& name, const ByteVector& wire) {
    SCOPED_TRACE(name);
    test::checkSplits<Framing>(wire);
    test::checkGarbageBefore<Framing>(wire, garbage);
    test::checkFlips<Framing>(wire);
  });
}

TEST(DynamixelVectors, InstructionsAreEncodedFromTheirMeaning) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  ByteVector sixteen(16);
  std::iota(sixteen.begin(), sixteen.end(), std::uint8_t{0});
  const auto address = [](const char* name) {
    return registerNamed(name).address;
  };
  const auto to_all = [&](const char* name, std::uint8_t value) {
    return [=](ByteBuffer& out) {
      encodeSyncWrite(registerNamed(name).address, 1, sixteen, ByteVector(16, value), out);
    };
  };
  const auto write = [&](ByteVector data) {
    return [=](ByteBuffer& out) {
      encodeWrite(1, 116, data, out);
    };
  };
  ByteVector indirect;
  for (const int byte : {126, 127, 128, 129, 130, 131, 132, 133, 134, 135, 70, 146})
    indirect.insert(indirect.end(), {static_cast<std::uint8_t>(byte), 0});

  const std::map<std::string, std::function<void(ByteBuffer&)>> cases = {
      {"ping id1",
       [](ByteBuffer& out) {
         encodePing(1, out);
       }},
      {"ping broadcast",
       [](ByteBuffer& out) {
         encodePing(kBroadcastId, out);
       }},
      {"reboot id1",
       [](ByteBuffer& out) {
         encodeReboot(1, out);
       }},
      {"read id1 addr132 len4",
       [&](ByteBuffer& out) {
         encodeRead(1, address("present_position"), 4, out);
       }},
      {"write id1 addr116 = 512", write({0x00, 0x02, 0x00, 0x00})},
      {"write id1 addr116 data FF FF FD 00", write({0xFF, 0xFF, 0xFD, 0x00})},
      {"… data FF FF FD FD", write({0xFF, 0xFF, 0xFD, 0xFD})},
      {"… data FF FF FF FD", write({0xFF, 0xFF, 0xFF, 0xFD})},
      {"sync read addr132 len4 ids 1,2",
       [](ByteBuffer& out) {
         encodeSyncRead(132, 4, ByteVector{1, 2}, out);
       }},
      {"sync write addr116 id1=150 id2=170",
       [](ByteBuffer& out) {
         encodeSyncWrite(116, 4, ByteVector{1, 2}, ByteVector{150, 0, 0, 0, 170, 0, 0, 0}, out);
       }},
      {"torque on, ids 0..15", to_all("torque_enable", 1)},
      {"torque off, ids 0..15", to_all("torque_enable", 0)},
      {"operating mode 5, ids 0..15", to_all("operating_mode", kCurrentBasedPositionMode)},
      {"bus watchdog 5 (=100 ms), ids 0..15", to_all("bus_watchdog", 100 / kWatchdogUnitMs)},
      {"goal current 350 mA ids 0,1",
       [&](ByteBuffer& out) {
         encodeSyncWrite(address("goal_current"), 2, ByteVector{0, 1},
                         ByteVector{0x5E, 1, 0x5E, 1}, out);
       }},
      {"indirect setup id1: addresses 126..135,70,146 at 168",
       [&](ByteBuffer& out) {
         encodeWrite(1, kIndirectAddresses, indirect, out);
       }},
      {"sync read indirect 208 len12 ids 1,2",
       [](ByteBuffer& out) {
         encodeSyncRead(kIndirectData, 12, ByteVector{1, 2}, out);
       }},
  };
  std::size_t found = 0;
  forEachPacket([&](const std::string& name, const ByteVector& wire) {
    const auto known = cases.find(name);
    if (known == cases.end()) return;
    ++found;
    ByteBuffer out;
    known->second(out);
    EXPECT_EQ(toHex(out.bytes()), toHex(wire)) << name;
  });
  EXPECT_EQ(found, cases.size());
}

TEST(DynamixelVectors, StatusPacketsTellTheirMeaning) {
  HANDGRAFT_NEEDS_SHARED_DATA(test::kVectorFile);
  int alerts = 0, range_errors = 0, half_turns = 0;
  forEachPacket([&](const std::string& name, const ByteVector& wire) {
    const ByteVector content = test::fromHex(framesIn<Framing>({wire}).at(0));
    const auto status = statusOf(packetOf(content));
    EXPECT_EQ(status.has_value(), name.find("status") != std::string::npos) << name;
    if (!status) return;
    if (status->alert) ++alerts;
    if (status->error == Error::kDataRange) ++range_errors;
    if (name.find("position 2048") != std::string::npos) {
      EXPECT_EQ(numberAt<std::int16_t>(status->data, 0), -50);
      EXPECT_EQ(numberAt<std::int32_t>(status->data, 2), 3);
      EXPECT_EQ(numberAt<std::int32_t>(status->data, 6), kCountsPerRevolution / 2);
      ++half_turns;
    }
  });
  EXPECT_EQ(alerts, 1);
  EXPECT_EQ(range_errors, 1);
  EXPECT_EQ(half_turns, 1);
}

TEST(DynamixelTable, IsSortedWithoutOverlaps) {
  const auto table = controlTable();
  for (std::size_t i = 1; i < table.size(); ++i) {
    EXPECT_LE(table[i - 1].address + table[i - 1].size, table[i].address) << table[i].name;
    EXPECT_EQ(&registerNamed(table[i].name), &table[i]) << "a name twice";
  }
  for (const Register& entry : table)
    EXPECT_EQ(entry.is_eeprom, entry.address < 64) << entry.name;
  EXPECT_THROW(registerNamed("no_such"), BrokenContract);
  EXPECT_FALSE(modelNumbered(1));
  EXPECT_EQ(modelNumbered(1200)->name, "XL330-M288-T");
}

}  // namespace
}  // namespace handgraft::protocols::dynamixel
