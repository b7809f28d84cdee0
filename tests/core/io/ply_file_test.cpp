#include "core/io/ply_file.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/shared_data.h"

namespace handgraft::io {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::filesystem::path write(const std::string& name, const std::string& bytes) {
  const std::filesystem::path path = test::scratchDirectory() / name;
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

std::string faultOf(const std::string& bytes) {
  try {
    readPly(write("bad.ply", bytes));
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

template <class T>
void put(std::string& bytes, T value, bool big_endian) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (big_endian) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

constexpr const char* kTriangleHeader =
    "element vertex 3\nproperty float x\nproperty double y\nproperty short z\n"
    "property list uchar int neighbours\nproperty uchar link\n"
    "element face 1\nproperty list uchar uint vertex_indices\nend_header\n";

std::string binaryTriangle(bool big_endian) {
  std::string bytes = std::string("ply\nformat binary_") + (big_endian ? "big" : "little") +
                      "_endian 1.0\n" + kTriangleHeader;
  for (int v = 0; v < 3; ++v) {
    put<float>(bytes, static_cast<float>(v) + 0.5F, big_endian);
    put<double>(bytes, -2.25 * v, big_endian);
    put<short>(bytes, static_cast<short>(-300 * v), big_endian);
    put<unsigned char>(bytes, 1, big_endian);
    put<int>(bytes, 7, big_endian);
    put<unsigned char>(bytes, static_cast<unsigned char>(200 + v), big_endian);
  }
  put<unsigned char>(bytes, 3, big_endian);
  for (unsigned v = 0; v < 3; ++v)
    put<unsigned>(bytes, v, big_endian);
  return bytes;
}

void expectTriangle(const PlyFile& ply) {
  ASSERT_EQ(ply.vertex_count, 3);
  EXPECT_EQ(ply.vertex.at("x"), Eigen::Vector3d(0.5, 1.5, 2.5));
  EXPECT_EQ(ply.vertex.at("y"), Eigen::Vector3d(0.0, -2.25, -4.5));
  EXPECT_EQ(ply.vertex.at("z"), Eigen::Vector3d(0.0, -300.0, -600.0));
  EXPECT_EQ(ply.vertex.at("link"), Eigen::Vector3d(200.0, 201.0, 202.0));
  EXPECT_EQ(ply.vertex.count("neighbours"), 0U);
  ASSERT_EQ(ply.faces.cols(), 1);
  EXPECT_EQ(ply.faces.col(0), Eigen::Vector3i(0, 1, 2));
}

TEST(PlyFile, ReadsLittleEndianScalarsAndSkipsLists) {
  expectTriangle(readPly(write("little.ply", binaryTriangle(false))));
}

TEST(PlyFile, ReadsBigEndianScalarsAndSkipsLists) {
  expectTriangle(readPly(write("big.ply", binaryTriangle(true))));
}

TEST(PlyFile, ReadsAsciiAndKeepsComments) {
  const PlyFile ply = readPly(
      write("text.ply",
            std::string("ply\r\nformat ascii 1.0\r\ncomment links: 0=palm 1=thumb\r\n") +
                kTriangleHeader +
                "0.5 0 0 1 7 200\n1.5 -2.25 -300 1 7 201\n2.5 -4.5 -600 1 7 202\n3 0 1 2"));
  expectTriangle(ply);
  EXPECT_THAT(ply.comments, ElementsAre("links: 0=palm 1=thumb"));
}

TEST(PlyFile, CutsPolygonsIntoFansAndRemembersTheirFace) {
  const PlyFile ply = readPly(write(
      "quad.ply",
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nelement face 2\n"
      "property list uchar int vertex_index\nend_header\n0\n1\n2\n3\n4\n3 0 1 4\n4 0 1 2 3\n"));
  ASSERT_EQ(ply.faces.cols(), 3);
  EXPECT_EQ(ply.faces.col(1), Eigen::Vector3i(0, 1, 2));
  EXPECT_EQ(ply.faces.col(2), Eigen::Vector3i(0, 2, 3));
  EXPECT_THAT(ply.file_face, ElementsAre(0, 1, 1));
}

TEST(PlyFile, RejectsEveryTruncation) {
  const std::string whole = binaryTriangle(false);
  for (std::size_t size = 1; size < whole.size(); ++size) {
    EXPECT_THROW(readPly(write("cut.ply", whole.substr(0, size))), InvalidInput) << size;
  }
}

TEST(PlyFile, ChecksTheCountsOfItsHeaderBeforeBelievingThem) {
  EXPECT_THAT(faultOf("ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n"
                      "property double x\nend_header\n12345678"),
              HasSubstr("claims 4000000000"));
  EXPECT_THAT(faultOf("ply\nformat ascii 1.0\nelement vertex 1\nproperty list uint int x\n"
                      "end_header\n4000000000 1"),
              HasSubstr("list of length 4000000000"));
}

TEST(PlyFile, NamesTheFault) {
  EXPECT_THAT(faultOf("solid"), HasSubstr("truncated"));
  EXPECT_THAT(faultOf("not\n"), HasSubstr("not a PLY"));
  EXPECT_THAT(faultOf("ply\nformat ascii 1.0\nelement vertex x\nend_header\n"),
              HasSubstr("'element vertex x' is not understood"));
  EXPECT_THAT(
      faultOf("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\nab"),
      HasSubstr("'ab'"));
  EXPECT_THAT(
      faultOf("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nelement face 1\n"
              "property list uchar int vertex_indices\nend_header\n0\n1\n2\n3 0 1 3\n"),
      HasSubstr("face 0 names vertex 3, the file has vertices 0 to 2"));
}

TEST(PlyFile, ReadsARealContactMap) {
  HANDGRAFT_NEEDS_SHARED_DATA("contacts/dexycb/006_mustard_bottle_grasp0_contact.ply");
  const PlyFile ply =
      readPly(test::sharedData("contacts/dexycb/006_mustard_bottle_grasp0_contact.ply"));
  EXPECT_GT(ply.vertex_count, 100);
  ASSERT_EQ(ply.vertex.count("contact"), 1U);
  EXPECT_GE(ply.vertex.at("contact").minCoeff(), 0.0);
  EXPECT_LE(ply.vertex.at("contact").maxCoeff(), 1.0);
}

}  // namespace
}  // namespace handgraft::io
