#include "core/formats/npz_file.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/formats/byte_parts.h"

namespace handgraft::formats {

namespace {

static_assert(std::endian::native == std::endian::little, "NPY is written little-endian");

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
  return zipOf(members_);
}

// === Reading

namespace {

// A number takes eight bytes in memory, and one in some files.
constexpr std::size_t kMostNumbersOfAnyFile = std::size_t{1} << 22;

/// `count` numbers as they lie in memory.
template <class T>
std::vector<double> numbersAs(std::string_view raw, std::size_t count) {
  raw = partAt(raw, 0, count * sizeof(T));
  std::vector<double> values;
  values.reserve(count);
  for (std::size_t at = 0; at < raw.size(); at += sizeof(T)) {
    T value;
    std::memcpy(&value, raw.data() + at, sizeof(T));
    values.push_back(static_cast<double>(value));
  }
  return values;
}

/// What stands behind `'key':` in the header of an NPY file, up to its end.
std::string_view headerField(std::string_view header, std::string_view key) {
  const std::size_t at = header.find(key);
  const std::size_t colon = header.find(':', at == std::string_view::npos ? header.size() : at);
  if (at == std::string_view::npos || colon == std::string_view::npos)
    rejectInput("npz: the header of an array lacks {}", quoted(std::string(key)));
  return header.substr(colon + 1);
}

/// The sizes in an array's header, up to `most`.
std::vector<std::size_t> shapeFrom(std::string_view header, std::size_t most) {
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
      size = std::min(10 * size + static_cast<std::size_t>(text[i] - '0'), most);
    shape.push_back(size);
  }
  return shape;
}

/// Up to `most`.
std::size_t countOf(const std::vector<std::size_t>& shape, std::size_t most) {
  std::size_t count = 1;
  for (const std::size_t size : shape)
    count = size == 0 ? 0 : std::min(count * size, most);
  return count;
}

/// A text of NumPy, whose points of Unicode take four bytes each, or (`|S`) one.
std::string textFrom(std::string_view raw, std::size_t bytes_per_point) {
  std::string text;
  for (std::size_t at = 0; at + bytes_per_point <= raw.size(); at += bytes_per_point) {
    const std::uint64_t point = numberAt(raw, at, bytes_per_point);
    if (point != 0) text += point < 0x80 ? static_cast<char>(point) : '?';
  }
  return text;
}

using ReadNumbers = std::vector<double> (*)(std::string_view raw, std::size_t count);

/// How numbers of each type of NumPy are read.
const std::map<std::string_view, ReadNumbers>& numberTypes() {
  static const std::map<std::string_view, ReadNumbers> types = {
      {"<f8", numbersAs<double>},       {"<f4", numbersAs<float>},
      {"<i8", numbersAs<std::int64_t>}, {"<u8", numbersAs<std::uint64_t>},
      {"<i4", numbersAs<std::int32_t>}, {"<u4", numbersAs<std::uint32_t>},
      {"<i2", numbersAs<std::int16_t>}, {"<u2", numbersAs<std::uint16_t>},
      {"|i1", numbersAs<std::int8_t>},  {"|u1", numbersAs<std::uint8_t>},
      {"|b1", numbersAs<std::uint8_t>},
  };
  return types;
}

/// Values whose first index goes fastest, with the last one fastest instead.
std::vector<double> lastIndexFastest(const std::vector<double>& values,
                                     const std::vector<std::size_t>& shape) {
  std::vector<std::size_t> steps(shape.size(), 1);
  for (std::size_t k = 1; k < shape.size(); ++k)
    steps[k] = steps[k - 1] * shape[k - 1];
  std::vector<double> turned;
  turned.reserve(values.size());
  std::vector<std::size_t> index(shape.size(), 0);
  while (turned.size() < values.size()) {
    turned.push_back(
        values[std::inner_product(index.begin(), index.end(), steps.begin(), std::size_t{0})]);
    for (std::size_t k = shape.size(); k-- > 0;) {
      if (++index[k] < shape[k]) break;
      index[k] = 0;
    }
  }
  return turned;
}

NpzArray arrayFrom(std::string_view bytes, const std::string& name, std::size_t most) {
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
  array.type = type;
  array.shape = shapeFrom(header, most + 1);
  const std::size_t count = countOf(array.shape, most + 1);
  if (count > most)
    rejectInput(
        "npz: array {} has more numbers than the {} that are left of what a file of its "
        "size may hold",
        quoted(name), most);
  if (const bool is_unicode = type.starts_with("<U"); is_unicode || type.starts_with("|S")) {
    if (count == 1) array.text = textFrom(raw, is_unicode ? 4 : 1);
    return array;
  }
  const auto read = numberTypes().find(type);
  if (read == numberTypes().end()) return array;
  array.values = read->second(raw, count);
  const bool is_fortran = headerField(header, "'fortran_order'").substr(0, 6).find("True") !=
                          std::string_view::npos;
  if (is_fortran && array.shape.size() > 1)
    array.values = lastIndexFastest(array.values, array.shape);
  return array;
}

}  // namespace

std::map<std::string, NpzArray> readNpz(std::string_view bytes) {
  constexpr std::string_view kEnding = ".npy";
  const std::size_t most = kMostNumbersOfAnyFile + 2 * bytes.size();
  std::size_t total = 0;
  std::map<std::string, NpzArray> arrays;
  readZip(bytes, [&](const ZipMember& member) {
    std::string name = member.name;
    if (name.size() > kEnding.size() && name.ends_with(kEnding))
      name.resize(name.size() - kEnding.size());
    NpzArray& array = arrays[name] = arrayFrom(member.content, name, most - total);
    total += array.values.size();
  });
  return arrays;
}

}  // namespace handgraft::formats
