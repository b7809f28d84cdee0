#include "core/io/contact_map_file.h"

#include <array>
#include <cmath>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/io/color_map.h"

#include "tests/support/shared_data.h"

namespace handgraft::io {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// A square of two faces; `rows` hold what each of its corners has behind its place.
std::filesystem::path writeSquare(const std::string& properties,
                                  const std::array<std::string, 4>& rows) {
  const auto path = test::scratchDirectory() / "square.ply";
  std::ofstream(path) << "ply\nformat ascii 1.0\ncomment 0=thumb 1=index\nelement vertex 4\n"
                         "property float x\nproperty float y\nproperty float z\n"
                      << properties
                      << "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
                      << "0 0 0 " << rows[0] << "\n1 0 0 " << rows[1] << "\n1 1 0 " << rows[2]
                      << "\n0 1 0 " << rows[3] << "\n3 0 1 2\n3 0 2 3\n";
  return path;
}

void expectFault(const std::filesystem::path& path,
                 const ContactMapSource& source,
                 const char* fault) {
  EXPECT_THAT(
      [&] {
        readContactMap(path, source);
      },
      ThrowsMessage<InvalidInput>(HasSubstr(fault)));
}

TEST(ContactMapFile, ReadsPropertiesOfAnyName) {
  const auto path = writeSquare("property float heat\nproperty char part\n",
                                {"0.5 -1", "0.25 0", "1 1", "0 -1"});
  ContactMapSource source;
  source.value_property = "heat";
  source.label_property = "part";
  const contact::ContactMap map = readContactMap(path, source);
  EXPECT_THAT(map.value, ElementsAre(0.5, 0.25, 1.0, 0.0));
  EXPECT_THAT(map.label, ElementsAre(-1, 0, 1, -1));
  EXPECT_THAT(map.segment_names, ElementsAre("thumb", "index"));
  source.label_property = "link";
  EXPECT_TRUE(readContactMap(path, source).label.empty());
}

// As textures' seams and unwelded exports have vertices: twice at the same place.
TEST(ContactMapFile, GoesOverSeams) {
  const auto path = test::scratchDirectory() / "seam.ply";
  std::ofstream(path) << "ply\nformat ascii 1.0\ncomment 0=thumb 1=index\nelement vertex 6\n"
                         "property float x\nproperty float y\nproperty float z\n"
                         "property float contact\nproperty char link\n"
                         "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
                         "0 0 0 1 0\n1 0 0 0.5 -1\n1 1 0 0.25 -1\n"
                         "0 0 0 1 0\n1 1 0 0.75 1\n0 1 0 0 -1\n3 0 1 2\n3 3 4 5\n";
  const contact::ContactMap map = readContactMap(path, {});
  ASSERT_EQ(map.mesh_O.vertexCount(), 4);
  EXPECT_EQ(map.mesh_O.faceCount(), 2);
  EXPECT_THAT(map.value, ElementsAre(1.0, 0.5, 0.5, 0.0));
  EXPECT_THAT(map.label, ElementsAre(0, -1, 1, -1));
  EXPECT_THAT(map.segment_names, ElementsAre("thumb", "index"));
}

TEST(ContactMapFile, HasEachFaceOnce) {
  const auto path = test::scratchDirectory() / "twice.ply";
  std::ofstream(path) << "ply\nformat ascii 1.0\nelement vertex 3\n"
                         "property float x\nproperty float y\nproperty float z\n"
                         "property float contact\nelement face 2\n"
                         "property list uchar int vertex_indices\nend_header\n"
                         "0 0 0 1\n1 0 0 0.5\n0 1 0 0\n3 0 1 2\n3 1 2 0\n";
  const contact::ContactMap map = readContactMap(path, {});
  EXPECT_EQ(map.mesh_O.faceCount(), 1);
  EXPECT_THAT(map.value, ElementsAre(1.0, 0.5, 0.0));
}

TEST(ContactMapFile, NamesThePropertyThatIsMissing) {
  const auto path = writeSquare("property float heat\n", {"0.5", "0.25", "1", "0"});
  expectFault(path, {}, "no vertex property 'contact'");
  expectFault(path, {}, "it has heat, x, y, z");
  expectFault(path, {.value_property = "heat", .label_property = "part"}, "property 'part'");
  expectFault(path, {.color_scale = "inferno"}, "property 'red'");
}

TEST(ContactMapFile, InvertsColoursOfVertices) {
  const std::array<double, 4> values = {0.0, 0.3, 0.62, 1.0};
  for (const std::string& name : colorMapNames()) {
    std::array<std::string, 4> bytes;
    std::array<std::string, 4> fractions;
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector3d rgb = colorOf(colorMap(name), values[i]);
      bytes[i] =
          fmt::format("{:.0f} {:.0f} {:.0f}", 255 * rgb.x(), 255 * rgb.y(), 255 * rgb.z());
      fractions[i] = fmt::format("{} {} {}", rgb.x(), rgb.y(), rgb.z());
    }
    const auto properties = [](const char* type) {
      return fmt::format("property {0} red\nproperty {0} green\nproperty {0} blue\n", type);
    };
    const auto whole =
        readContactMap(writeSquare(properties("uchar"), bytes), {.color_scale = name});
    const auto part =
        readContactMap(writeSquare(properties("float"), fractions), {.color_scale = name});
    for (int i = 0; i < 4; ++i) {
      EXPECT_NEAR(whole.value[i], values[static_cast<std::size_t>(i)], 0.005) << name;
      EXPECT_NEAR(part.value[i], values[static_cast<std::size_t>(i)], 1e-5) << name;
    }
  }
}

TEST(ContactMapFile, ReadsColoursAtAnObjsVertices) {
  const auto path = test::scratchDirectory() / "square.obj";
  std::ofstream(path) << "v 0 0 0 0 0 0\nv 1 0 0 0.25 0.25 0.25\nv 1 1 0 1 1 1\nv 0 1 0 0 0 0\n"
                         "f 1 2 3\nf 1 3 4\n";
  const ContactMapSource source{.color_scale = "grey"};
  ASSERT_TRUE(isContactMap(path, source));
  const contact::ContactMap map = readContactMap(path, source);
  EXPECT_EQ(map.mesh_O.faceCount(), 2);
  EXPECT_NEAR(map.value[1], 0.25, 1e-3);
  EXPECT_NEAR(map.value[2], 1.0, 1e-3);
  expectFault(path, {}, "its vertices have colours: ");
}

TEST(ContactMapFile, AnObjWithoutColoursIsNone) {
  const auto path = test::scratchDirectory() / "bare.obj";
  std::ofstream(path) << "v 0 0 0 1\nv 1 0 0 1\nv 1 1 0 1\nf 1 2 3\n";
  EXPECT_FALSE(isContactMap(path, {}));
}

TEST(ContactMapFile, AnObjOfWhichSomeVerticesHaveColoursIsToldWhichHasNone) {
  const auto path = test::scratchDirectory() / "partly.obj";
  const char* fault =
      " (the first is 0) has no colour, 2 of 3 vertices have one; permitted are red, green";
  const ContactMapSource source{.color_scale = "grey"};
  for (int without = 0; without < 3; ++without) {
    std::ofstream file(path);
    for (int v = 0; v < 3; ++v)
      file << "v " << v << " " << v * v << (v == without ? " 0\n" : " 0 0.5 0.5 0.5\n");
    file << "f 1 2 3\n";
    file.close();
    EXPECT_TRUE(isContactMap(path));
    expectFault(path, source, fmt::format("vertex {}{}", without, fault).c_str());
  }
}

TEST(ContactMapFile, AColourOutOfRangeIsToldWithItsVertex) {
  const auto path = test::scratchDirectory() / "bright.obj";
  std::ofstream(path) << "v 0 0 0 0 0 0\nv 1 0 0 0 300 0\nv 1 1 0 0 0 0\nf 1 2 3\n";
  expectFault(path, {.color_scale = "grey"},
              "vertex 1 (the first is 0) has the colour 0 300 0; permitted are 0 to 255");
}

TEST(ContactMapFile, ColoursThatNameFingersAreToldWhatToWrite) {
  const auto path =
      writeSquare("property uchar red\nproperty uchar green\nproperty uchar blue\n",
                  {"128 128 128", "255 0 0", "0 255 0", "0 0 255"});
  const char* hint = "; 4 colours are all there are: one for each finger is not read; write";
  expectFault(path, {}, hint);
  expectFault(path, {.color_scale = "inferno"}, hint);
}

TEST(ContactMapFile, WhatFacesSayIsToldToBelongToVertices) {
  const auto path = test::scratchDirectory() / "faces.ply";
  std::ofstream(path) << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty "
                         "float y\nproperty float z\nelement face 1\nproperty list uchar int "
                         "vertex_indices\nproperty int label\nend_header\n"
                         "0 0 0\n1 0 0\n1 1 0\n3 0 1 2 4\n";
  expectFault(path, {}, "its faces have label, and what faces say is not read");
}

TEST(ContactMapFile, NamesTheColoursWhereItFindsNoValues) {
  const auto path =
      writeSquare("property uchar red\nproperty uchar green\nproperty uchar blue\n",
                  {"0 0 4", "0 0 4", "0 0 4", "221 81 58"});
  expectFault(path, {},
              "its vertices have colours: #000004 75 %, #dd513a 25 %; nearest is the "
              "scale 'inferno', 0.00 off");
  expectFault(path, {.value_property = "heat"}, "no vertex property 'heat'");
}

TEST(ContactMapFile, RefusesColoursOfAnotherScale) {
  const auto path =
      writeSquare("property uchar red\nproperty uchar green\nproperty uchar blue\n",
                  {"0 255 255", "0 255 0", "0 0 255", "0 0 200"});
  expectFault(path, {.color_scale = "inferno"}, "nearest scale is 'jet'");
  expectFault(path, {.color_scale = "rainbow"}, "colour map 'rainbow'");
  expectFault(path, {.picture = "a.png"}, "needs a colour scale");
}

}  // namespace
}  // namespace handgraft::io
