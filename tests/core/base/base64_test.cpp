#include "core/base/base64.h"

#include <string>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft {
namespace {

TEST(Base64, IsThatOfItsStandard) {
  // RFC 4648, section 10.
  EXPECT_EQ(base64Of(""), "");
  EXPECT_EQ(base64Of("f"), "Zg==");
  EXPECT_EQ(base64Of("fo"), "Zm8=");
  EXPECT_EQ(base64Of("foobar"), "Zm9vYmFy");
}

TEST(Base64, ReadsBackWhatItWrote) {
  // Every byte, every length modulo three, and more than one piece.
  for (const std::size_t size : {0u, 1u, 2u, 3u, 256u, 257u, (3u << 20) + 1, (6u << 20) + 2}) {
    std::string bytes(size, '\0');
    for (std::size_t i = 0; i < size; ++i)
      bytes[i] = static_cast<char>(i * 7 + i / 256);
    EXPECT_EQ(bytesOfBase64(base64Of(bytes)), bytes) << size;
  }
}

TEST(Base64, RefusesWhatItIsNot) {
  for (const char* text :
       {"Zg=", "Zg", "Z===", "====", "Zm9 ", "Zm9v\n", "Z=9v", "Zm9vZg==Zm9v"})
    EXPECT_THROW(bytesOfBase64(text), InvalidInput) << text;
}

}  // namespace
}  // namespace handgraft
