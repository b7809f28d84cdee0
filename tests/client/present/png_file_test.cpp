#include "client/present/png_file.h"

#include <cstring>

#include <gtest/gtest.h>
#include <png.h>

#include "core/base/error.h"

#include "tests/support/shared_data.h"

namespace handgraft::client {
namespace {

using render::Image;

namespace fs = std::filesystem;

Image noise(int width, int height) {
  Image image(width, height);
  unsigned state = 1;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      state = state * 1664525U + 1013904223U;
      image.at(x, y) = {static_cast<std::uint8_t>(state >> 24U),
                        static_cast<std::uint8_t>(state >> 16U),
                        static_cast<std::uint8_t>(state >> 8U)};
    }
  }
  return image;
}

TEST(PngFile, ComesBackAsItWas) {
  const fs::path path = test::scratchDirectory() / "noise.png";
  const Image image = noise(37, 23);
  writePng(path, image);

  png_image header;  // libpng's simple reader: another way through the library than ours
  std::memset(&header, 0, sizeof(header));
  header.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_file(&header, path.c_str()), 0) << header.message;
  header.format = PNG_FORMAT_RGB;
  EXPECT_EQ(header.width, 37U);
  EXPECT_EQ(header.height, 23U);
  std::vector<render::Color> back(PNG_IMAGE_SIZE(header) / sizeof(render::Color));
  ASSERT_NE(png_image_finish_read(&header, nullptr, back.data(), 0, nullptr), 0)
      << header.message;
  EXPECT_EQ(back, image.pixels());
}

TEST(PngFile, NamesAPathThatCannotBeWritten) {
  try {
    writePng(test::scratchDirectory() / "no such folder" / "a.png", Image(4, 4));
    FAIL() << "must throw";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("a.png"), std::string::npos);
  }
}

TEST(PngFile, LeavesNoPartialFileBehind) {
  const fs::path folder = test::scratchDirectory() / "target";
  fs::create_directories(folder / "taken.png");  // a folder has the name already
  EXPECT_THROW(writePng(folder / "taken.png", Image(4, 4)), InvalidInput);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
}

TEST(Image, RefusesSizesThatAreNone) {
  EXPECT_THROW(Image(0, 5), InvalidInput);
  EXPECT_THROW(Image(5, -1), InvalidInput);
  EXPECT_THROW(Image(1 << 20, 1), InvalidInput);
  EXPECT_THROW(static_cast<void>(Image(2, 2).at(2, 0)), BrokenContract);
}

}  // namespace
}  // namespace handgraft::client
