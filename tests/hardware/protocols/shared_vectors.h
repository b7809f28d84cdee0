#pragma once

#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/hardware/protocols/hex.h"
#include "tests/support/shared_data.h"

namespace handgraft::test {

inline constexpr const char* kVectorFile = "../hardware/vectors.json";

/// Frames that vendors' code and documentation give, beside the shared data.
inline nlohmann::json sharedVectors() {
  std::ifstream file(sharedData(kVectorFile));
  return nlohmann::json::parse(file);
}

/// The strings of a JSON array of hexadecimal bytes.
inline std::vector<ByteVector> bytesOfAll(const nlohmann::json& array) {
  std::vector<ByteVector> all;
  for (const auto& text : array)
    all.push_back(fromHex(text.get<std::string>()));
  return all;
}

}  // namespace handgraft::test
