#pragma once

#include <string>

namespace handgraft::test {

/// A config that was made, once its owner accepted that its device has no watchdog; as it is
/// where the device has one.
inline std::string acceptedConfig(std::string made) {
  const std::string to_fill_in = "no_watchdog: FILL IN";
  const auto at = made.find(to_fill_in);
  return at == std::string::npos ? made
                                 : made.replace(at, to_fill_in.size(), "no_watchdog: accepted");
}

}  // namespace handgraft::test
