#include "hardware/protocols/dynamixel_table.h"

#include <algorithm>
#include <array>

#include "core/base/error.h"

namespace handgraft::protocols::dynamixel {

namespace {

constexpr bool kSigned = true, kUnsigned = false;
constexpr bool kEeprom = true, kRam = false;
constexpr bool kWritable = true, kReadOnly = false;

// clang-format off: a table
constexpr std::array kTable = {
    Register{0, 2, kUnsigned, kEeprom, kReadOnly, 1240, "model_number"},
    Register{2, 4, kUnsigned, kEeprom, kReadOnly, 0, "model_information"},
    Register{6, 1, kUnsigned, kEeprom, kReadOnly, 0, "firmware_version"},
    Register{7, 1, kUnsigned, kEeprom, kWritable, 1, "id"},
    Register{8, 1, kUnsigned, kEeprom, kWritable, 1, "baud_rate"},
    Register{9, 1, kUnsigned, kEeprom, kWritable, 250, "return_delay"},  // 2 us
    Register{10, 1, kUnsigned, kEeprom, kWritable, 0, "drive_mode"},
    Register{11, 1, kUnsigned, kEeprom, kWritable, 3, "operating_mode"},
    Register{12, 1, kUnsigned, kEeprom, kWritable, 255, "secondary_id"},
    Register{13, 1, kUnsigned, kEeprom, kWritable, 2, "protocol_type"},
    Register{20, 4, kSigned, kEeprom, kWritable, 0, "homing_offset"},
    Register{24, 4, kUnsigned, kEeprom, kWritable, 10, "moving_threshold"},
    Register{31, 1, kUnsigned, kEeprom, kWritable, 70, "temperature_limit"},  // degrees Celsius
    Register{32, 2, kUnsigned, kEeprom, kWritable, 70, "max_voltage_limit"},  // 0.1 V
    Register{34, 2, kUnsigned, kEeprom, kWritable, 35, "min_voltage_limit"},
    Register{36, 2, kUnsigned, kEeprom, kWritable, 885, "pwm_limit"},
    Register{38, 2, kUnsigned, kEeprom, kWritable, 2352, "current_limit"},  // mA
    Register{44, 4, kUnsigned, kEeprom, kWritable, 350, "velocity_limit"},
    Register{48, 4, kUnsigned, kEeprom, kWritable, 4095, "max_position_limit"},  // mode 3 alone
    Register{52, 4, kUnsigned, kEeprom, kWritable, 0, "min_position_limit"},
    Register{60, 1, kUnsigned, kEeprom, kWritable, 0, "startup_configuration"},
    Register{62, 1, kUnsigned, kEeprom, kWritable, 140, "pwm_slope"},  // 1.977 mV/ms
    Register{63, 1, kUnsigned, kEeprom, kWritable, 0x34, "shutdown"},
    Register{64, 1, kUnsigned, kRam, kWritable, 0, "torque_enable"},
    Register{65, 1, kUnsigned, kRam, kWritable, 0, "led"},
    Register{68, 1, kUnsigned, kRam, kWritable, 2, "status_return_level"},
    Register{69, 1, kUnsigned, kRam, kReadOnly, 0, "registered_instruction"},
    Register{70, 1, kUnsigned, kRam, kReadOnly, 0, "hardware_error"},
    Register{76, 2, kUnsigned, kRam, kWritable, 1600, "velocity_i_gain"},
    Register{78, 2, kUnsigned, kRam, kWritable, 50, "velocity_p_gain"},
    Register{80, 2, kUnsigned, kRam, kWritable, 500, "position_d_gain"},
    Register{82, 2, kUnsigned, kRam, kWritable, 0, "position_i_gain"},
    Register{84, 2, kUnsigned, kRam, kWritable, 1100, "position_p_gain"},
    Register{88, 2, kUnsigned, kRam, kWritable, 0, "feedforward_2nd_gain"},
    Register{90, 2, kUnsigned, kRam, kWritable, 0, "feedforward_1st_gain"},
    Register{98, 1, kUnsigned, kRam, kWritable, 0, "bus_watchdog"},  // 20 ms
    Register{100, 2, kSigned, kRam, kWritable, 885, "goal_pwm"},
    Register{102, 2, kSigned, kRam, kWritable, 2352, "goal_current"},  // mA
    Register{104, 4, kSigned, kRam, kWritable, 0, "goal_velocity"},
    Register{108, 4, kUnsigned, kRam, kWritable, 0, "profile_acceleration"},
    Register{112, 4, kUnsigned, kRam, kWritable, 0, "profile_velocity"},
    Register{116, 4, kSigned, kRam, kWritable, 0, "goal_position"},
    Register{120, 2, kUnsigned, kRam, kReadOnly, 0, "realtime_tick"},  // ms
    Register{122, 1, kUnsigned, kRam, kReadOnly, 0, "moving"},
    Register{123, 1, kUnsigned, kRam, kReadOnly, 0, "moving_status"},
    Register{124, 2, kSigned, kRam, kReadOnly, 0, "present_pwm"},
    Register{126, 2, kSigned, kRam, kReadOnly, 0, "present_current"},  // mA
    Register{128, 4, kSigned, kRam, kReadOnly, 0, "present_velocity"},
    Register{132, 4, kSigned, kRam, kReadOnly, 0, "present_position"},
    Register{136, 4, kSigned, kRam, kReadOnly, 0, "velocity_trajectory"},
    Register{140, 4, kSigned, kRam, kReadOnly, 0, "position_trajectory"},
    Register{144, 2, kUnsigned, kRam, kReadOnly, 50, "input_voltage"},  // 0.1 V
    Register{146, 1, kUnsigned, kRam, kReadOnly, 30, "temperature"},    // degrees Celsius
    Register{147, 1, kUnsigned, kRam, kReadOnly, 0, "backup_ready"},
};
// clang-format on

constexpr std::uint16_t k330 = kIndirectData, kOthers = kIndirectDataOfOthers;
constexpr double kNoCurrent = 0, kFineMilliamp = 1.0, kCoarseMilliamp = 2.69;

// clang-format off: a table. Source: e-Manual, one page a model. Not in it: XM335-T323, of whose
// number there are two accounts, and XL320, whose registers are others.
constexpr std::array kModels = {
    ModelFacts{"XC330-M288-T", 1240, kFineMilliamp, 2352, 0x34, k330},
    ModelFacts{"XC330-M181-T", 1230, kFineMilliamp, 0, 0x34, k330},
    ModelFacts{"XC330-T288-T", 1220, kFineMilliamp, 0, 0x34, k330},
    ModelFacts{"XC330-T181-T", 1210, kFineMilliamp, 0, 0x34, k330},
    ModelFacts{"XL330-M288-T", 1200, kFineMilliamp, 1750, 0x35, k330},
    ModelFacts{"XL330-M077-T", 1190, kFineMilliamp, 1750, 0x35, k330},
    ModelFacts{"XM430-W210", 1030, kCoarseMilliamp, 1193, 0x34, kOthers},
    ModelFacts{"XM430-W350", 1020, kCoarseMilliamp, 1193, 0x34, kOthers},
    ModelFacts{"XM540-W270", 1120, kCoarseMilliamp, 2047, 0x34, kOthers},
    ModelFacts{"XM540-W150", 1130, kCoarseMilliamp, 2047, 0x34, kOthers},
    ModelFacts{"XH430-W350", 1000, kCoarseMilliamp, 648, 0x34, kOthers},
    ModelFacts{"XH430-W210", 1010, kCoarseMilliamp, 648, 0x34, kOthers},
    ModelFacts{"XH430-V350", 1040, 1.34, 689, 0x34, kOthers},
    ModelFacts{"XH430-V210", 1050, 1.34, 689, 0x34, kOthers},
    ModelFacts{"XH540-W270", 1100, kCoarseMilliamp, 2047, 0x34, kOthers},
    ModelFacts{"XH540-W150", 1110, kCoarseMilliamp, 2047, 0x34, kOthers},
    ModelFacts{"XH540-V270", 1140, kCoarseMilliamp, 0, 0x34, kOthers},
    ModelFacts{"XH540-V150", 1150, kCoarseMilliamp, 0, 0x34, kOthers},
    ModelFacts{"XD430-T350", 1001, kCoarseMilliamp, 648, 0x34, kOthers},
    ModelFacts{"XD430-T210", 1011, kCoarseMilliamp, 648, 0x34, kOthers},
    ModelFacts{"XD540-T270", 1101, kCoarseMilliamp, 2047, 0x34, kOthers},
    ModelFacts{"XD540-T150", 1111, kCoarseMilliamp, 2047, 0x34, kOthers},
    ModelFacts{"XW540-H260", 1310, kCoarseMilliamp, 1188, 0x34, kOthers},
    ModelFacts{"XW540-T260", 1170, kCoarseMilliamp, 0, 0x34, kOthers},
    ModelFacts{"XW540-T140", 1180, kCoarseMilliamp, 0, 0x34, kOthers},
    ModelFacts{"XW430-T333", 1270, kCoarseMilliamp, 0, 0x34, kOthers},
    ModelFacts{"XW430-T200", 1280, kCoarseMilliamp, 0, 0x34, kOthers},
    ModelFacts{"XL430-W250", 1060, kNoCurrent, 0, 0x34, kOthers},
    ModelFacts{"2XL430-W250", 1090, kNoCurrent, 0, 0x34, kOthers},
    ModelFacts{"XC430-W150", 1070, kNoCurrent, 0, 0x34, kOthers},
    ModelFacts{"XC430-W240", 1080, kNoCurrent, 0, 0x34, kOthers},
    ModelFacts{"2XC430-W250", 1160, kNoCurrent, 0, 0x34, kOthers},
};
// clang-format on

}  // namespace

std::span<const Register> controlTable() {
  return kTable;
}

const Register& registerNamed(std::string_view name) {
  const auto found = std::find_if(kTable.begin(), kTable.end(), [&](const Register& entry) {
    return entry.name == name;
  });
  HANDGRAFT_REQUIRE(found != kTable.end());
  return *found;
}

std::span<const ModelFacts> models() {
  return kModels;
}

std::optional<ModelFacts> modelNumbered(std::uint16_t number) {
  for (const ModelFacts& model : kModels) {
    if (model.number == number) return model;
  }
  return std::nullopt;
}

}  // namespace handgraft::protocols::dynamixel
