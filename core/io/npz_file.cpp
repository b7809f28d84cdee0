#include "core/io/npz_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"

namespace handgraft::io {

namespace {

static_assert(std::endian::native == std::endian::little, "NPY is written little-endian");

/// Of ISO 3309, as zip wants it.
std::uint32_t crcOf(std::string_view bytes) {
  static const std::array<std::uint32_t, 256> crc_table = [] {
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
    crc = crc_table[(crc ^ static_cast<unsigned char>(c)) & 0xFFu] ^ (crc >> 8);
  return crc ^ 0xFFFFFFFFu;
}

void appendNumber(std::string& bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i)
    bytes += static_cast<char>((value >> (8 * i)) & 0xFFu);
}

/// How many bytes of UTF-8 follow one that begins a code point; -1 for one that begins none.
int bytesBehind(unsigned char lead) {
  if (lead < 0x80) return 0;
  if ((lead & 0xE0) == 0xC0) return 1;
  if ((lead & 0xF0) == 0xE0) return 2;
  if ((lead & 0xF8) == 0xF0) return 3;
  return -1;
}

/// The code points of a text.
std::vector<char32_t> pointsOf(const std::string& text) {
  std::vector<char32_t> points;
  for (std::size_t i = 0; i < text.size();) {
    const auto lead = static_cast<unsigned char>(text[i]);
    const int more = bytesBehind(lead);
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

// === Reading

namespace {

constexpr std::size_t kMostNumbers = std::size_t{1} << 28;

std::uint64_t numberAt(std::string_view bytes, std::size_t at, std::size_t size) {
  if (at > bytes.size() || size > bytes.size() - at)
    rejectInput("npz: it breaks off at byte {}", bytes.size());
  std::uint64_t value = 0;
  for (std::size_t i = size; i-- > 0;)
    value = (value << 8) | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

std::string_view partAt(std::string_view bytes, std::size_t at, std::size_t size) {
  if (at > bytes.size() || size > bytes.size() - at)
    rejectInput("npz: it breaks off at byte {}", bytes.size());
  return bytes.substr(at, size);
}

template <class T>
void appendAs(std::string_view raw, std::vector<double>& values) {
  for (std::size_t i = 0; i + sizeof(T) <= raw.size(); i += sizeof(T)) {
    T value;
    std::memcpy(&value, raw.data() + i, sizeof(T));
    values.push_back(static_cast<double>(value));
  }
}

/// What stands behind `'key':` in the header of an NPY file, up to its end.
std::string_view headerField(std::string_view header, std::string_view key) {
  const std::size_t at = header.find(key);
  const std::size_t colon = header.find(':', at == std::string_view::npos ? header.size() : at);
  if (at == std::string_view::npos || colon == std::string_view::npos)
    rejectInput("npz: the header of an array lacks {}", quoted(std::string(key)));
  return header.substr(colon + 1);
}

/// The sizes in an array's header, as far as they are permitted and one more.
std::vector<std::size_t> shapeFrom(std::string_view header) {
  std::string_view text = headerField(header, "'shape'");
  text = text.substr(0, text.find(')'));
  const auto is_digit = [](char c) {
    return c >= '0' && c <= '9';
  };
  std::vector<std::size_t> shape;
  for (std::size_t i = 0; i < text.size();) {
    if (!is_digit(text[i])) {
      ++i;
      continue;
    }
    std::size_t size = 0;
    for (; i < text.size() && is_digit(text[i]); ++i)
      size = std::min(10 * size + static_cast<std::size_t>(text[i] - '0'), kMostNumbers + 1);
    shape.push_back(size);
  }
  return shape;
}

/// As far as they are permitted and one more.
std::size_t countOf(const std::vector<std::size_t>& shape) {
  std::size_t count = 1;
  for (const std::size_t size : shape)
    count = size == 0 ? 0 : std::min(count * size, kMostNumbers + 1);
  return count;
}

std::string textFrom(std::string_view raw) {
  std::string text;
  for (std::size_t at = 0; at + 4 <= raw.size(); at += 4) {
    const std::uint64_t point = numberAt(raw, at, 4);
    if (point != 0) text += point < 0x80 ? static_cast<char>(point) : '?';
  }
  return text;
}

/// `count` numbers of a type of NumPy; nothing if it is none of those that are read.
std::optional<std::vector<double>> numbersFrom(std::string_view raw,
                                               std::string_view type,
                                               std::size_t count) {
  std::vector<double> values;
  const auto first_bytes = [&](std::size_t size) {
    return partAt(raw, 0, count * size);
  };
  if (type == "<f8")
    appendAs<double>(first_bytes(8), values);
  else if (type == "<f4")
    appendAs<float>(first_bytes(4), values);
  else if (type == "<i8")
    appendAs<std::int64_t>(first_bytes(8), values);
  else if (type == "<i4")
    appendAs<std::int32_t>(first_bytes(4), values);
  else if (type == "|u1" || type == "|b1")
    appendAs<std::uint8_t>(first_bytes(1), values);
  else
    return std::nullopt;
  return values;
}

/// An NPY file; nothing if it holds neither numbers nor one text.
std::optional<NpzArray> arrayFrom(std::string_view bytes, const std::string& name) {
  if (bytes.substr(0, 6) != std::string_view("\x93NUMPY", 6))
    rejectInput("npz: array {} is no NPY file", quoted(name));
  const bool is_first = numberAt(bytes, 6, 1) == 1;
  const std::size_t begin = is_first ? 10 : 12;
  const auto length = static_cast<std::size_t>(numberAt(bytes, 8, is_first ? 2 : 4));
  const std::string_view header = partAt(bytes, begin, length);
  const std::string_view raw = bytes.substr(begin + length);

  std::string_view type = headerField(header, "'descr'");
  type.remove_prefix(std::min(type.size(), type.find('\'') + 1));
  type = type.substr(0, type.find('\''));
  NpzArray array;
  array.shape = shapeFrom(header);
  const std::size_t count = countOf(array.shape);
  if (count > kMostNumbers)
    rejectInput("npz: array {} holds more than {} numbers", quoted(name), kMostNumbers);
  if (type.substr(0, 2) == "<U" && array.shape.empty()) {
    array.text = textFrom(raw);
    return array;
  }
  auto numbers = numbersFrom(raw, type, count);
  if (!numbers) return std::nullopt;
  array.values = std::move(*numbers);
  if (array.shape.size() > 1 &&
      headerField(header, "'fortran_order'").substr(0, 6).find("True") !=
          std::string_view::npos)
    rejectInput("npz: array {} is in Fortran's order; write numpy.ascontiguousarray of it",
                quoted(name));
  return array;
}

}  // namespace

bool isNpz(std::string_view bytes) {
  return bytes.substr(0, 4) == std::string_view("PK\x03\x04", 4);
}

std::map<std::string, NpzArray> readNpz(std::string_view bytes) {
  // Source: PKWARE's APPNOTE 4.3.16, 4.3.12, 4.3.7: the directory stands at the end.
  const std::size_t end = bytes.rfind(std::string_view("PK\x05\x06", 4));
  if (!isNpz(bytes) || end == std::string_view::npos)
    rejectInput("npz: it is no zip file, or breaks off");
  const std::uint64_t members = numberAt(bytes, end + 10, 2);
  auto at = static_cast<std::size_t>(numberAt(bytes, end + 16, 4));
  std::map<std::string, NpzArray> arrays;
  for (std::uint64_t i = 0; i < members; ++i) {
    if (partAt(bytes, at, 4) != std::string_view("PK\x01\x02", 4))
      rejectInput("npz: its directory is wrong at entry {}", i);
    const std::uint64_t method = numberAt(bytes, at + 10, 2);
    std::uint64_t size = numberAt(bytes, at + 24, 4);
    const auto name_size = static_cast<std::size_t>(numberAt(bytes, at + 28, 2));
    const auto extra_size = static_cast<std::size_t>(numberAt(bytes, at + 30, 2));
    const auto comment_size = static_cast<std::size_t>(numberAt(bytes, at + 32, 2));
    const auto local = static_cast<std::size_t>(numberAt(bytes, at + 42, 4));
    std::string name(partAt(bytes, at + 46, name_size));
    constexpr std::uint64_t kInExtra = 0xFFFFFFFF;
    if (size == kInExtra) size = numberAt(bytes, at + 46 + name_size + 4, 8);
    if (method != 0)
      rejectInput("npz: array {} is compressed; write the file by numpy.savez",
                  handgraft::quoted(name));
    const auto data = local + 30 + static_cast<std::size_t>(numberAt(bytes, local + 26, 2)) +
                      static_cast<std::size_t>(numberAt(bytes, local + 28, 2));
    constexpr std::string_view kEnding = ".npy";
    if (name.size() > kEnding.size() && name.ends_with(kEnding))
      name.resize(name.size() - kEnding.size());
    if (auto array = arrayFrom(partAt(bytes, data, static_cast<std::size_t>(size)), name))
      arrays[name] = std::move(*array);
    at += 46 + name_size + extra_size + comment_size;
  }
  return arrays;
}

}  // namespace handgraft::io
