#include "core/io/png_file.h"

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include "core/base/error.h"
#include "core/io/file_bytes.h"

#include "tests/support/shared_data.h"

namespace handgraft::io {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr unsigned kWidth = 5;
constexpr unsigned kHeight = 3;

/// What a channel of a pixel is, in 16 bits.
unsigned deepAt(unsigned x, unsigned y, unsigned channel) {
  return (x * 9001 + y * 20011 + channel * 31) % 65536;
}

std::filesystem::path writePng(int depth, int color_type, int interlace) {
  const auto path = test::scratchDirectory() / "picture.png";
  std::FILE* file = std::fopen(path.c_str(), "wb");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, kWidth, kHeight, depth, color_type, interlace,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  const unsigned channels = png_get_channels(png, info);
  std::vector<std::vector<png_byte>> rows(kHeight);
  std::vector<png_bytep> pointers;
  for (unsigned y = 0; y < kHeight; ++y) {
    for (unsigned x = 0; x < kWidth; ++x) {
      for (unsigned c = 0; c < channels; ++c) {
        rows[y].push_back(static_cast<png_byte>(deepAt(x, y, c) >> 8U));
        if (depth == 16) rows[y].push_back(static_cast<png_byte>(deepAt(x, y, c) & 0xFFU));
      }
    }
    pointers.push_back(rows[y].data());
  }
  png_write_image(png, pointers.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
  return path;
}

TEST(PngFile, KeepsEightAndSixteenBits) {
  for (const int depth : {8, 16}) {
    for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
      const Picture picture = readPng(writePng(depth, PNG_COLOR_TYPE_RGB, interlace));
      ASSERT_EQ(picture.width, 5);
      ASSERT_EQ(picture.height, 3);
      for (unsigned y = 0; y < kHeight; ++y) {
        for (unsigned x = 0; x < kWidth; ++x) {
          for (unsigned c = 0; c < 3; ++c) {
            const double expected =
                depth == 16 ? deepAt(x, y, c) / 65535.0 : (deepAt(x, y, c) >> 8U) / 255.0;
            EXPECT_NEAR(picture.rgb(c, y * kWidth + x), expected, 1e-6);
          }
        }
      }
    }
  }
}

TEST(PngFile, ReadsGreyAndLeavesTransparencyOut) {
  const Picture grey = readPng(writePng(16, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_INTERLACE_NONE));
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(grey.rgb(c, 7), deepAt(2, 1, 0) / 65535.0, 1e-6);
  const Picture clear = readPng(writePng(8, PNG_COLOR_TYPE_RGB_ALPHA, PNG_INTERLACE_NONE));
  EXPECT_NEAR(clear.rgb(2, 7), (deepAt(2, 1, 2) >> 8U) / 255.0, 1e-6);
}

TEST(PngFile, RefusesWhatIsCutShortOrNoPng) {
  const auto path = writePng(16, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE);
  const std::string whole = readFileBytes(path);
  for (std::size_t size = 1; size < whole.size(); ++size) {
    std::ofstream(path, std::ios::binary) << whole.substr(0, size);
    EXPECT_THROW(readPng(path), InvalidInput) << size;
  }
  std::ofstream(path, std::ios::binary) << "no picture at all";
  EXPECT_THAT(
      [&] {
        readPng(path);
      },
      ThrowsMessage<InvalidInput>(HasSubstr("picture.png")));
}

TEST(PngFile, RefusesAHugeClaimBeforeTakingMemory) {
  const auto path = writePng(8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE);
  std::string bytes = readFileBytes(path);
  bytes[17] = 0x0F;  // width 5 becomes about a million; the checksum is wrong then, too
  bytes[21] = 0x0F;
  std::ofstream(path, std::ios::binary) << bytes;
  EXPECT_THROW(readPng(path), InvalidInput);
}

}  // namespace
}  // namespace handgraft::io
