#include "core/base/base64.h"

#include <algorithm>
#include <cstddef>

#include <openssl/evp.h>

#include "core/base/error.h"

namespace handgraft {

namespace {

// In pieces: libcrypto counts bytes as int.
constexpr std::size_t kPiece = 3u << 20;  // a multiple of three
constexpr std::size_t kCodedPiece = kPiece / 3 * 4;

const unsigned char* plain(const char* bytes) {
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes for a C library
  return reinterpret_cast<const unsigned char*>(bytes);
}

unsigned char* plain(char* bytes) {
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes for a C library
  return reinterpret_cast<unsigned char*>(bytes);
}

}  // namespace

std::string base64Of(std::string_view bytes) {
  std::string text((bytes.size() + 2) / 3 * 4 + 1, '\0');  // libcrypto ends it by a zero
  std::size_t written = 0;
  for (std::size_t begin = 0; begin < bytes.size(); begin += kPiece) {
    const std::string_view piece = bytes.substr(begin, kPiece);
    written += static_cast<std::size_t>(EVP_EncodeBlock(
        plain(text.data() + written), plain(piece.data()), static_cast<int>(piece.size())));
  }
  text.resize(written);
  return text;
}

std::string bytesOfBase64(std::string_view text) {
  // libcrypto passes over blanks, and counts padding as bytes.
  const auto is_letter = [](char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') ||
           c == '+' || c == '/';
  };
  const auto end = std::find_if_not(text.begin(), text.end(), is_letter);
  const auto padding = static_cast<std::size_t>(text.end() - end);
  if (text.size() % 4 != 0 || padding > 2 || std::any_of(end, text.end(), [](char c) {
        return c != '=';
      }))
    rejectInput("base64: {} characters, of which the first that is not right is number {}",
                text.size(), static_cast<std::size_t>(end - text.begin()) + 1);
  std::string bytes(text.size() / 4 * 3, '\0');
  std::size_t written = 0;
  for (std::size_t begin = 0; begin < text.size(); begin += kCodedPiece) {
    const std::string_view piece = text.substr(begin, kCodedPiece);
    const int count = EVP_DecodeBlock(plain(bytes.data() + written), plain(piece.data()),
                                      static_cast<int>(piece.size()));
    HANDGRAFT_REQUIRE(count >= 0);
    written += static_cast<std::size_t>(count);
  }
  bytes.resize(written - padding);
  return bytes;
}

}  // namespace handgraft
