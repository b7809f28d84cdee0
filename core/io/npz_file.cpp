#include "core/io/npz_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"

namespace handgraft::io {

namespace {

static_assert(std::endian::native == std::endian::little, "NPY is written little-endian");

/// Of ISO 3309, as zip wants it.
std::uint32_t crcOf(std::string_view bytes) {
  static const std::array<std::uint32_t, 256> kTable = [] {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < table.size(); ++i) {
      std::uint32_t value = i;
      for (int bit = 0; bit < 8; ++bit)
        value = (value & 1) != 0 ? 0xEDB88320u ^ (value >> 1) : value >> 1;
      table[i] = value;
    }
    return table;
  }();
  std::uint32_t crc = 0xFFFFFFFFu;
  for (const char c : bytes)
    crc = kTable[(crc ^ static_cast<unsigned char>(c)) & 0xFFu] ^ (crc >> 8);
  return crc ^ 0xFFFFFFFFu;
}

void appendNumber(std::string& bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i)
    bytes += static_cast<char>((value >> (8 * i)) & 0xFFu);
}

/// The code points of a text.
std::vector<char32_t> pointsOf(const std::string& text) {
  std::vector<char32_t> points;
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const int more = lead < 0x80             ? 0
                     : (lead & 0xE0) == 0xC0 ? 1
                     : (lead & 0xF0) == 0xE0 ? 2
                     : (lead & 0xF8) == 0xF0 ? 3
                                             : -1;
    bool fine = more >= 0 && i + static_cast<std::size_t>(std::max(more, 0)) < text.size();
    char32_t point = more <= 0 ? lead : lead & (0x3Fu >> more);
    for (int k = 1; fine && k <= more; ++k) {
      const auto byte = static_cast<unsigned char>(text[i + static_cast<std::size_t>(k)]);
      fine = (byte & 0xC0) == 0x80;
      point = (point << 6) | (byte & 0x3Fu);
    }
    points.push_back(fine ? point : U'?');
    i += fine ? static_cast<std::size_t>(more) + 1 : 1;
  }
  return points;
}

/// What stands before a member, and (`central`) in the list at the end.
std::string zipHead(const std::string& name, const std::string& content, bool central) {
  constexpr std::uint32_t kLocal = 0x04034B50;
  constexpr std::uint32_t kCentral = 0x02014B50;
  constexpr std::uint64_t kVersion = 20;
  constexpr std::uint64_t kDay = (1 << 5) | 1;  // 1980-01-01: no clock in the bytes
  std::string head;
  appendNumber(head, central ? kCentral : kLocal, 4);
  if (central) appendNumber(head, kVersion, 2);  // made by
  appendNumber(head, kVersion, 2);               // needed
  appendNumber(head, 0, 2);                      // flags
  appendNumber(head, 0, 2);                      // stored
  appendNumber(head, 0, 2);                      // time
  appendNumber(head, kDay, 2);
  appendNumber(head, crcOf(content), 4);
  appendNumber(head, content.size(), 4);
  appendNumber(head, content.size(), 4);
  appendNumber(head, name.size(), 2);
  appendNumber(head, 0, 2);  // extra field
  return head;
}

}  // namespace

void NpzFile::add(const std::string& name,
                  const std::vector<double>& values,
                  const std::vector<std::size_t>& shape) {
  std::size_t count = 1;
  for (const std::size_t size : shape)
    count *= size;
  HANDGRAFT_REQUIRE(count == values.size());
  std::string bytes(values.size() * sizeof(double), '\0');
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  add(name, "<f8", shape, bytes);
}

void NpzFile::add(const std::string& name, const std::vector<std::string>& texts) {
  std::vector<std::vector<char32_t>> points;
  std::size_t longest = 1;
  for (const std::string& text : texts) {
    points.push_back(pointsOf(text));
    longest = std::max(longest, points.back().size());
  }
  std::string bytes;
  for (std::vector<char32_t>& text : points) {
    text.resize(longest, 0);
    for (const char32_t point : text)
      appendNumber(bytes, point, 4);
  }
  add(name, fmt::format("<U{}", longest), {texts.size()}, bytes);
}

void NpzFile::add(const std::string& name,
                  const std::string& type,
                  const std::vector<std::size_t>& shape,
                  std::string_view values) {
  std::string sizes;
  for (const std::size_t size : shape)
    sizes += fmt::format("{},", size);
  std::string head =
      fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}), }}", type, sizes);
  constexpr std::size_t kBefore = 10;  // magic, version and this text's length
  constexpr std::size_t kAlignment = 64;
  head.append(kAlignment - (kBefore + head.size() + 1) % kAlignment, ' ');
  head += '\n';
  std::string content = "\x93NUMPY";
  appendNumber(content, 1, 2);  // version 1.0
  appendNumber(content, head.size(), 2);
  content += head;
  content += values;
  members_.push_back({name + ".npy", std::move(content)});
}

std::string NpzFile::bytes() const {
  std::string file;
  std::string list;
  std::uint64_t total = 0;
  for (const Member& member : members_)
    total += 2 * member.name.size() + 128 + member.content.size();
  if (total > std::numeric_limits<std::uint32_t>::max())
    rejectInput("a npz file of {} bytes; permitted are 4 GiB", total);
  for (const Member& member : members_) {
    list += zipHead(member.name, member.content, true);
    appendNumber(list, 0, 2);            // comment
    appendNumber(list, 0, 2);            // disk
    appendNumber(list, 0, 2);            // internal attributes
    appendNumber(list, 0, 4);            // external ones
    appendNumber(list, file.size(), 4);  // where it begins
    list += member.name;
    file += zipHead(member.name, member.content, false) + member.name + member.content;
  }
  const std::size_t begin = file.size();
  file += list;
  constexpr std::uint32_t kEnd = 0x06054B50;
  appendNumber(file, kEnd, 4);
  appendNumber(file, 0, 4);  // disks
  appendNumber(file, members_.size(), 2);
  appendNumber(file, members_.size(), 2);
  appendNumber(file, list.size(), 4);
  appendNumber(file, begin, 4);
  appendNumber(file, 0, 2);  // comment
  return file;
}

}  // namespace handgraft::io
