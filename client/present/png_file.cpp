#include "client/present/png_file.h"

#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include <png.h>

#include "client/present/output_file.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

// libpng reports errors by a long jump, which skips C++ destructors: nothing that owns memory
// may be created between setjmp and the end of this function.
bool encode(std::FILE* file, const render::Image& image, std::vector<png_const_bytep>& rows) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr,
                                            [](png_structp, png_const_charp) {});
  if (png == nullptr) return false;
  png_infop info = png_create_info_struct(png);
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_init_io(png, file);
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width()),
               static_cast<png_uint_32>(image.height()), 8, PNG_COLOR_TYPE_RGB,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_set_compression_level(png, 5);  // 9 takes three times as long for 3 % less
  png_write_info(png, info);
  png_write_image(png, const_cast<png_bytepp>(rows.data()));
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return true;
}

}  // namespace

void writePng(const std::filesystem::path& path, const render::Image& image) {
  static_assert(sizeof(render::Color) == 3, "rows are handed to libpng as they lie in memory");
  std::vector<png_const_bytep> rows;
  rows.reserve(static_cast<std::size_t>(image.height()));
  for (int y = 0; y < image.height(); ++y)
    rows.push_back(&image.at(0, y).r);

  char* bytes = nullptr;
  std::size_t size = 0;
  std::FILE* memory = open_memstream(&bytes, &size);
  const bool encoded = memory != nullptr && encode(memory, image, rows);
  const bool closed = memory != nullptr && std::fclose(memory) == 0;
  const std::unique_ptr<char, decltype(&std::free)> owner(bytes, &std::free);
  if (!encoded || !closed) {
    rejectInput("{}: the picture cannot be encoded", quoted(path.string()));
  }
  writeFile(path, {bytes, size});
}

}  // namespace handgraft::client
