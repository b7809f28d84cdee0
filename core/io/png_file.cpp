#include "core/io/png_file.h"

#include <csetjmp>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <png.h>

#include "core/base/error.h"
#include "core/io/file_bytes.h"

namespace handgraft::io {
namespace {

/// What libpng's callbacks see.
struct Source {
  const char* bytes = nullptr;
  std::size_t left = 0;
  char fault[200] = "";
};

void readBytes(png_structp png, png_bytep out, std::size_t count) {
  auto* source = static_cast<Source*>(png_get_io_ptr(png));
  if (count > source->left) png_error(png, "the file ends too early");
  std::memcpy(out, source->bytes, count);
  source->bytes += count;
  source->left -= count;
}

void keepFault(png_structp png, png_const_charp fault) {
  auto* source = static_cast<Source*>(png_get_error_ptr(png));
  std::strncpy(source->fault, fault, sizeof source->fault - 1);
  png_longjmp(png, 1);
}

void ignoreWarning(png_structp, png_const_charp) {}

// libpng reports errors by a long jump, which skips C++ destructors: nothing that owns memory
// may be created between setjmp and the end of the two functions below.

/// Asks for rows of three channels, 8 or 16 bits each (in this machine's order).
bool readHeader(png_structp png, png_infop info) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_read_info(png, info);
  png_set_expand(png);
  png_set_gray_to_rgb(png);
  png_set_strip_alpha(png);
  if (png_get_bit_depth(png, info) == 16) png_set_swap(png);
  png_set_interlace_handling(png);
  png_read_update_info(png, info);
  return true;
}

bool readRows(png_structp png, std::vector<png_bytep>& rows) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_read_image(png, rows.data());
  png_read_end(png, nullptr);
  return true;
}

/// Frees libpng's structs however the reading ends.
struct Reader {
  explicit Reader(Source& source)
      : png(png_create_read_struct(PNG_LIBPNG_VER_STRING, &source, keepFault, ignoreWarning)),
        info(png != nullptr ? png_create_info_struct(png) : nullptr) {
    HANDGRAFT_REQUIRE(info != nullptr);
    png_set_read_fn(png, &source, readBytes);
  }

  ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }

  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  png_structp png;
  png_infop info;
};

}  // namespace

Picture readPng(const std::filesystem::path& path) {
  const std::string bytes = readFileBytes(path);
  Source source{bytes.data(), bytes.size()};
  Reader reader(source);
  const auto reject = [&]() {
    rejectInput("{}: cannot be read as a PNG: {}", quoted(path.string()), source.fault);
  };
  if (!readHeader(reader.png, reader.info)) reject();
  const auto width = static_cast<long>(png_get_image_width(reader.png, reader.info));
  const auto height = static_cast<long>(png_get_image_height(reader.png, reader.info));
  if (width > kMostPixels / height) {
    rejectInput("{}: has {} x {} pixels, permitted are {} in all", quoted(path.string()), width,
                height, kMostPixels);
  }
  const std::size_t row_bytes = png_get_rowbytes(reader.png, reader.info);
  const bool is_deep = png_get_bit_depth(reader.png, reader.info) == 16;
  std::vector<png_byte> pixels(row_bytes * static_cast<std::size_t>(height));
  std::vector<png_bytep> rows;
  rows.reserve(static_cast<std::size_t>(height));
  for (long y = 0; y < height; ++y)
    rows.push_back(pixels.data() + static_cast<std::size_t>(y) * row_bytes);
  if (!readRows(reader.png, rows)) reject();

  Picture picture;
  picture.width = static_cast<int>(width);
  picture.height = static_cast<int>(height);
  picture.rgb.resize(3, width * height);
  for (Eigen::Index i = 0; i < picture.rgb.size(); ++i) {
    const png_byte* at = pixels.data() + (is_deep ? 2 * i : i);
    std::uint16_t deep = 0;
    if (is_deep) std::memcpy(&deep, at, sizeof deep);
    picture.rgb.data()[i] =
        is_deep ? static_cast<float>(deep) / 65535.0F : static_cast<float>(*at) / 255.0F;
  }
  return picture;
}

}  // namespace handgraft::io
