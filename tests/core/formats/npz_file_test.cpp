#include "core/formats/npz_file.h"

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include "core/base/error.h"

namespace handgraft::formats {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

template <class T>
std::string bytesOf(const std::vector<T>& values) {
  std::string bytes(values.size() * sizeof(T), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

/// An NPY file, as numpy.lib.format describes version 1.0.
std::string npy(const std::string& type,
                const std::string& shape,
                const std::string& values,
                bool is_fortran = false) {
  const std::string head = "{'descr': '" + type +
                           "', 'fortran_order': " + (is_fortran ? "True" : "False") +
                           ", 'shape': (" + shape + "), }\n";
  return std::string("\x93NUMPY\x01\x00", 8) + static_cast<char>(head.size() & 0xFF) +
         static_cast<char>(head.size() >> 8) + head + values;
}

void append(std::string& bytes, std::uint64_t value, int size) {
  for (int i = 0; i < size; ++i)
    bytes += static_cast<char>((value >> (8 * i)) & 0xFF);
}

std::string deflated(const std::string& content) {
  std::string packed(compressBound(content.size()) + 64, '\0');
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY), Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(content.data()));
  stream.avail_in = static_cast<uInt>(content.size());
  stream.next_out = reinterpret_cast<Bytef*>(packed.data());
  stream.avail_out = static_cast<uInt>(packed.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  packed.resize(stream.total_out);
  deflateEnd(&stream);
  return packed;
}

/// What a zip file says of its one member, so that it can say something else.
struct Claims {
  std::uint64_t method = 8;
  std::uint64_t flags = 0;
  std::uint64_t size_more = 0;
  int entries = 1;  ///< of the directory, all of the one member
};

/// A zip file of one member as numpy.savez_compressed writes it.
std::string zipped(const std::string& name,
                   const std::string& content,
                   const Claims& say = {}) {
  const std::string packed = say.method == 8 ? deflated(content) : content;
  const auto middle = [&](std::string& bytes) {
    append(bytes, 20, 2);
    append(bytes, say.flags, 2);
    append(bytes, say.method, 2);
    append(bytes, 0, 4);
    append(bytes,
           crc32(0, reinterpret_cast<const Bytef*>(content.data()),
                 static_cast<uInt>(content.size())),
           4);
    append(bytes, packed.size(), 4);
    append(bytes, content.size() + say.size_more, 4);
    append(bytes, name.size(), 2);
    append(bytes, 0, 2);
  };
  std::string file = "PK\x03\x04";
  middle(file);
  file += name + packed;
  const std::size_t begin = file.size();
  for (int i = 0; i < say.entries; ++i) {
    file += "PK\x01\x02";
    append(file, 20, 2);
    middle(file);
    file += std::string(14, '\0');
    file += name;
  }
  const std::size_t size = file.size() - begin;
  file += "PK\x05\x06";
  append(file, 0, 4);
  append(file, static_cast<std::uint64_t>(say.entries), 2);
  append(file, static_cast<std::uint64_t>(say.entries), 2);
  append(file, size, 4);
  append(file, begin, 4);
  append(file, 0, 2);
  return file;
}

NpzArray only(const std::string& array, const Claims& say = {}) {
  return readNpz(zipped("a.npy", array, say)).at("a");
}

std::string objectionTo(const std::string& file) {
  try {
    readNpz(file);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "";
}

const std::string six_values = bytesOf<double>({1, 2, 3, 4, 5, 6});

TEST(NpzFile, IsAZipOfArraysThatNumpyKnows) {
  NpzFile file;
  file.add("a", {1.0, 2.0, 3.0, 4.0, 5.0, 6.0}, {2, 3});
  file.add("names", {"x", "gr\xC3\xBC\xC3\x9F"});
  const std::string bytes = file.bytes();
  EXPECT_EQ(bytes.substr(0, 4), "PK\x03\x04");
  EXPECT_THAT(bytes, HasSubstr("'descr': '<f8', 'fortran_order': False, 'shape': (2,3,)"));
  EXPECT_THAT(bytes, HasSubstr("'descr': '<U4'"));
  // CRC-32 of the member, as any zip program checks it, of bytes worked out by hand elsewhere.
  const std::size_t begin = bytes.find("\x93NUMPY");
  ASSERT_NE(begin, std::string::npos);
  EXPECT_EQ((begin + 10 + static_cast<unsigned char>(bytes[begin + 8]) - begin) % 64, 0u);
  EXPECT_EQ(file.bytes(), bytes);
  const auto arrays = readNpz(bytes);
  EXPECT_THAT(arrays.at("a").values, ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(arrays.at("names").shape, ElementsAre(2));
}

TEST(NpzFile, MayBeCompressed) {
  const NpzArray array = only(npy("<f8", "2, 3", six_values));
  EXPECT_THAT(array.shape, ElementsAre(2, 3));
  EXPECT_THAT(array.values, ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(only(npy("<f8", "2, 3", six_values), {.method = 0}).values,
              ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST(NpzFile, MayBeInFortransOrder) {
  // Columns first: a(0,0) a(1,0) a(0,1) ...
  EXPECT_THAT(only(npy("<f8", "2, 3", six_values, true)).values, ElementsAre(1, 3, 5, 2, 4, 6));
  const NpzArray deep =
      only(npy("<i2", "2, 2, 2", bytesOf<std::int16_t>({0, 1, 2, 3, 4, 5, 6, 7}), true));
  EXPECT_THAT(deep.values, ElementsAre(0, 4, 2, 6, 1, 5, 3, 7));
}

TEST(NpzFile, HoldsNumbersOfManyTypesAndSingleTexts) {
  EXPECT_THAT(only(npy("<f4", "2,", bytesOf<float>({0.5F, -2.0F}))).values,
              ElementsAre(0.5, -2.0));
  EXPECT_THAT(only(npy("<u8", "1,", bytesOf<std::uint64_t>({7}))).values, ElementsAre(7));
  EXPECT_THAT(only(npy("|i1", "1,", bytesOf<std::int8_t>({-7}))).values, ElementsAre(-7));
  EXPECT_EQ(only(npy("<U4", "", bytesOf<std::uint32_t>({'l', 'e', 'f', 't'}))).text, "left");
  EXPECT_EQ(only(npy("|S5", "1,", "right")).text, "right");
}

TEST(NpzFile, SaysOfWhichTypeIsWhatItCannotRead) {
  const NpzArray array = only(npy("|O", "2,", "anything"));
  EXPECT_EQ(array.type, "|O");
  EXPECT_TRUE(array.values.empty());
}

TEST(NpzFile, DamageIsToldByName) {
  const std::string array = npy("<f8", "2, 3", six_values);
  std::string file = zipped("a.npy", array, {.method = 0});
  file[100] = static_cast<char>(file[100] ^ 1);  // within the array
  EXPECT_THAT(objectionTo(file), AllOf(HasSubstr("a.npy"), HasSubstr("checksum")));
  EXPECT_THAT(objectionTo(zipped("a.npy", array, {.method = 12})), HasSubstr("method 12"));
  EXPECT_THAT(objectionTo(zipped("a.npy", array, {.flags = 1})), HasSubstr("encrypted"));
  EXPECT_THAT(objectionTo(zipped("a.npy", array, {.size_more = 1})),
              HasSubstr("cannot be unpacked"));
}

TEST(NpzFile, CannotBeABomb) {
  const std::string zeros(std::size_t{40} << 20, '\0');
  EXPECT_THAT(objectionTo(zipped("a.npy", npy("|u1", "41943040,", zeros))),
              AllOf(HasSubstr("a.npy"), HasSubstr("claims"), HasSubstr("permitted")));
  const std::string fewer(std::size_t{10} << 20, '\0');
  EXPECT_THAT(objectionTo(zipped("a.npy", npy("|u1", "10485760,", fewer))),
              AllOf(HasSubstr("'a'"), HasSubstr("numbers")));
  const std::string text = npy("<U1000000", "", std::string(4'000'000, '\0'));
  EXPECT_THAT(objectionTo(zipped("a.npy", text, {.entries = 1000})),
              HasSubstr("members claim more than"));
}

}  // namespace
}  // namespace handgraft::formats
