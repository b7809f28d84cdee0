// Small files that claim to be huge, or would become so: refused in words, in bounded memory.

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include "core/base/error.h"
#include "core/io/contact_file.h"
#include "core/io/hand_joints_file.h"
#include "core/io/mesh_file.h"
#include "core/io/png_file.h"
#include "core/io/problem_file.h"
#include "core/io/sites_file.h"
#include "core/io/srdf_file.h"
#include "core/io/urdf_file.h"

#include "tests/core/io/hostile_reading.h"
#include "tests/support/plates.h"
#include "tests/support/shared_data.h"
#include "tests/support/small_hand.h"

namespace handgraft::io {
namespace {

namespace fs = std::filesystem;
using test::readApart;
using test::Reading;

fs::path write(const std::string& name, const std::string& bytes) {
  static const fs::path claims_folder = test::scratchDirectory();
  fs::path path = claims_folder / name;
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

std::string repeated(const std::string& text, int count) {
  std::string all;
  all.reserve(text.size() * static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i)
    all += text;
  return all;
}

template <class T>
std::string raw(T value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}

MeshFile plate() {
  MeshFile file;
  file.mesh = test::makePlate(4, 4, 0.01);
  for (int v = 0; v < file.mesh.vertexCount(); ++v) {
    file.file_vertex.push_back(v);
    file.mesh_vertex.push_back(v);
  }
  for (int f = 0; f < file.mesh.faceCount(); ++f)
    file.file_face.push_back(f);
  return file;
}

// === Meshes

void expectMeshRefused(const std::string& name,
                       const std::string& bytes,
                       const std::string& thing) {
  const fs::path path = write(name, bytes);
  test::expectRefused(path, thing, [&] {
    (void)readMesh(path);
  });
}

TEST(HostileClaims, OfAThousandMillionVerticesAreNotBelieved) {
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  const std::string faces = "property list uchar int vertex_indices\nend_header\n";
  for (const std::string format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    const std::string head = "ply\nformat " + format + " 1.0\n";
    expectMeshRefused(format + "_vertices.ply",
                      head + "element vertex 1000000000\n" + xyz + "end_header\n0 0 0 1 1 1",
                      "1000000000");
    expectMeshRefused(format + "_faces.ply",
                      head + "element vertex 0\n" + xyz + "element face 1000000000\n" + faces,
                      "1000000000");
    expectMeshRefused(format + "_other.ply",
                      head +
                          "element spark 1000000000\nproperty list int double s\n"
                          "element vertex 0\n" +
                          xyz + "end_header\n",
                      "'spark'");
  }
  expectMeshRefused(
      "beyond.ply",
      "ply\nformat ascii 1.0\nelement vertex 99999999999999999999\n" + xyz + "end_header\n",
      "99999999999999999999");
  expectMeshRefused("facets.stl", std::string(80, ' ') + raw(std::uint32_t{4'000'000'000}),
                    "4000000000");
  expectMeshRefused("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 1000000000\n", "1000000000");
}

TEST(HostileClaims, OfGigabyteListsAreNotBelieved) {
  const std::string head =
      "element vertex 0\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list ";
  const std::string end = " int vertex_indices\nend_header\n";
  const std::string ascii = "ply\nformat ascii 1.0\n" + head;
  const std::string little = "ply\nformat binary_little_endian 1.0\n" + head;
  expectMeshRefused("list_ascii.ply", ascii + "uint" + end + "4000000000 0 1 2", "4000000000");
  expectMeshRefused("list_uint.ply", little + "uint" + end + raw(0xffffffffU) + "123",
                    "4294967295");
  expectMeshRefused("list_int.ply", little + "int" + end + raw(-1) + "123", "-1");
  expectMeshRefused("list_double.ply", little + "double" + end + raw(1e300) + "123", "1e+300");
}

/// A glTF of one triangle, with one of its numbers replaced.
std::string gltf(const std::string& old_part, const std::string& new_part) {
  std::string text =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"buffers":[{)"
      R"("uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA)"
      R"(","byteLength":42}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},)"
      R"({"buffer":0,"byteOffset":36,"byteLength":6}],"accessors":[)"
      R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},)"
      R"({"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}]})";
  const std::size_t at = text.find(old_part);
  HANDGRAFT_REQUIRE(at != std::string::npos);
  return text.replace(at, old_part.size(), new_part);
}

TEST(HostileClaims, OfGltfsAreNotBelieved) {
  EXPECT_EQ(readMesh(write("whole.gltf", gltf("scene\"", "scene\""))).mesh.faceCount(), 1);
  expectMeshRefused(
      "count.gltf",
      gltf("\"count\":3,\"type\":\"VEC3\"", "\"count\":1000000000,\"type\":\"VEC3\""), "");
  expectMeshRefused(
      "index_count.gltf",
      gltf("\"count\":3,\"type\":\"SCALAR\"", "\"count\":1000000000,\"type\":\"SCALAR\""), "");
  expectMeshRefused("no_view.gltf",
                    gltf("{\"bufferView\":0,\"componentType\":5126,\"count\":3",
                         "{\"componentType\":5126,\"count\":1000000000"),
                    "");
  expectMeshRefused("view.gltf", gltf("\"byteLength\":36", "\"byteLength\":4000000000"), "");
  expectMeshRefused("offset.gltf", gltf("\"byteOffset\":36", "\"byteOffset\":4000000000"), "");
  expectMeshRefused("buffer.gltf", gltf("\"byteLength\":42", "\"byteLength\":4000000000"), "");
  expectMeshRefused("loop.gltf", gltf("{\"mesh\":0}", "{\"mesh\":0,\"children\":[0]}"), "");
}

TEST(HostileClaims, PolygonsOfAMillionCornersAreCutAllTheSame) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf";
  text += repeated(" 1 2 3 4", 250'000) + "\n";
  const fs::path path = write("corners.obj", text);
  const Reading reading = readApart([&] {
    (void)readMesh(path);
  });
  EXPECT_NE(reading.end, Reading::End::kDied) << reading.message;
  // Many small ones that cross themselves, so that none has an ear to cut.
  std::string stars;
  for (int i = 0; i < 2001; ++i) {
    const double angle = 2.0 * 3.14159265358979 * 1000.0 * i / 2001.0;
    stars += fmt::format("v {} {} 0\n", std::cos(angle), std::sin(angle));
  }
  for (int face = 0; face < 60; ++face) {
    stars += "f";
    for (int i = 1; i <= 2001; ++i)
      stars += fmt::format(" {}", i);
    stars += "\n";
  }
  const fs::path star = write("stars.obj", stars);
  EXPECT_EQ(readApart([&] {
              (void)readMesh(star);
            }).end,
            Reading::End::kRead);
}

// === Pictures

TEST(HostileClaims, OfHugePicturesAreNotBelieved) {
  const auto big_endian = [](std::uint32_t value) {
    std::string bytes = raw(value);
    return std::string(bytes.rbegin(), bytes.rend());
  };
  const auto chunk = [&](const std::string& kind, const std::string& body) {
    const std::string both = kind + body;
    const uLong sum =
        crc32(0, reinterpret_cast<const Bytef*>(both.data()), static_cast<uInt>(both.size()));
    return big_endian(static_cast<std::uint32_t>(body.size())) + both +
           big_endian(static_cast<std::uint32_t>(sum));
  };
  for (const std::uint32_t width : {100'000U, 1'000'000U, 0x7fffffffU}) {
    std::string header = big_endian(width) + big_endian(100'000U);
    header += std::string("\x10\x06\0\0\0", 5);  // 16 bits, red, green, blue and alpha
    const fs::path path = write("wide.png", "\x89PNG\r\n\x1a\n" + chunk("IHDR", header) +
                                                chunk("IDAT", "x\x9c") + chunk("IEND", ""));
    test::expectRefused(path, "", [&] {
      (void)readPng(path);
    });
  }
}

// === Contacts

TEST(HostileClaims, OfManyPointsInAContactSetAreRefused) {
  const MeshFile object = plate();
  const std::string patch = R"({"name": "p%", "root": {"vertex": 12},
      "boundary": [6, 7, 8, 13, 18, 17, 16, 11], "interpolation_count": 10000})";
  std::string patches;
  for (int i = 0; i < 20'000; ++i) {
    std::string one = patch;
    one.replace(one.find('%'), 1, std::to_string(i));
    patches += (i == 0 ? "" : ",") + one;
  }
  const fs::path path =
      write("many.json",
            R"({"format": "handgraft-contacts/1", "name": "n", "patches": [)" + patches + "]}");
  test::expectRefused(path, "permitted are", [&] {
    (void)readContactSet(path, object);
  });
}

TEST(HostileClaims, OfManyPointsInAContactMapAreRefused) {
  // Separate triangles in contact, each a patch of 10,000 points.
  constexpr int kTriangles = 20'000;
  std::string vertices;
  std::string faces;
  for (int i = 0; i < kTriangles; ++i) {
    vertices += fmt::format("{0} 0 0 1\n{0}.5 0 0 1\n{0} 1 0 1\n", i);
    faces += fmt::format("3 {} {} {}\n", 3 * i, 3 * i + 1, 3 * i + 2);
  }
  const fs::path path = write(
      "specks.ply",
      fmt::format("ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float "
                  "y\nproperty float z\nproperty float contact\nelement face {}\nproperty list "
                  "uchar int vertex_indices\nend_header\n",
                  3 * kTriangles, kTriangles) +
          vertices + faces);
  contact::SegmentationOptions options;
  options.interpolation_count = 10'000;
  test::expectRefused(path, "permitted are", [&] {
    (void)readContacts(path, readMesh(path), options);
  });
}

// === Nesting

TEST(HostileNesting, OfJsonIsAnErrorWhereverItStands) {
  const MeshFile object = plate();
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  const std::string start = R"({"format": "handgraft-contacts/1", "name": "n", )";
  const std::string sets[] = {
      deep,
      R"({"format": )" + deep + "}",
      R"({"format": "handgraft-contacts/1", "name": )" + deep + "}",
      start + R"("object": )" + deep + "}",
      start + R"("patches": )" + deep + "}",
      start + R"("patches": [)" + deep + "]}",
      start + R"("patches": [{"name": )" + deep + "}]}",
      start + R"("patches": [{"name": "p", "root": )" + deep + "}]}",
      start + R"("patches": [{"name": "p", "root": {"vertex": )" + deep + "}}]}",
      start + R"("patches": [{"name": "p", "root": {"vertex": 1}, "weight": )" + deep + "}]}",
      start + R"("patches": [{"name": "p", "root": {"vertex": 1}, "direction": [1, 2, )" +
          deep + "]}]}",
      std::string(1'000'000, '['),
      repeated("{\"a\":", 100'000)};
  for (const std::string& text : sets) {
    const fs::path path = write("deep_set.json", text);
    test::expectRefused(path, "", [&] {
      (void)readContactSet(path, object);
    });
  }
  const std::string joints[] = {deep,
                                R"({"joints": )" + deep + "}",
                                R"({"hands": )" + deep + "}",
                                R"({"hands": [{"valid": )" + deep + R"(, "joints": []}]})",
                                R"({"hands": [{"joints": )" + deep + "}]}",
                                std::string(1'000'000, '[')};
  for (const std::string& text : joints) {
    const fs::path path = write("deep_joints.json", text);
    test::expectRefused(path, "", [&] {
      (void)readHandJoints(path);
    });
  }
  const fs::path path =
      write("deep_problem.json", R"({"format": "handgraft-problem/1", "hand": )" + deep + "}");
  test::expectRefused(path, "", [&] {
    (void)readProblem(path);
  });
}

TEST(HostileNesting, OfYamlIsAnError) {
  const test::SmallHand hand = test::makeSmallHand();
  const std::string head = "format: handgraft-sites/1\nsites: ";
  std::string anchors = "format: handgraft-sites/1\na0: &a0 [x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 30; ++i)
    anchors += fmt::format("a{0}: &a{0} [{1}*a{2}]\n", i,
                           repeated(fmt::format("*a{}, ", i - 1), 8), i - 1);
  std::string indented;
  for (int i = 0; i < 900; ++i)
    indented += std::string(static_cast<std::size_t>(i), ' ') + "-\n";
  const std::string texts[] = {head + std::string(100'000, '['),
                               head + std::string(100'000, '{'),
                               head + repeated("- ", 50'000),
                               head + repeated("? ", 50'000),
                               head + repeated("[a,", 30'000),
                               head + repeated("!!a ", 30'000),
                               head + repeated("&a ", 30'000),
                               head + repeated("a: ", 30'000),
                               head + "\n" + indented,
                               head + "&s [*s]\n",
                               head + "[" + repeated("0,", 60'000) + "]",
                               anchors + "sites: *a29\n"};
  for (const std::string& text : texts) {
    const fs::path path = write("deep.yaml", text);
    test::expectRefused(path, "", [&] {
      (void)readSites(path, *hand.model);
    });
  }
  const fs::path large = write("large.yaml", head + "[" + repeated("0,", 5'000'000) + "]");
  test::expectRefused(large, "bytes", [&] {
    (void)readSites(large, *hand.model);
  });
}

// === Names

TEST(HostileNames, OfAMillionBytesAreRefusedShortly) {
  const std::string name(1'000'000, 'n');
  const MeshFile object = plate();
  const std::string rest =
      R"("root": {"vertex": 12}, "boundary": [6, 7, 8, 13, 18, 17, 16, 11]}]})";
  const std::string start = R"({"format": "handgraft-contacts/1", "name": ")";
  const std::string sets[] = {
      start + name + R"(", "patches": [{"name": "p", )" + rest,
      start + R"(n", "object": ")" + name + R"(", "patches": [{"name": "p", )" + rest,
      start + R"(n", "patches": [{"name": ")" + name + R"(", )" + rest,
      start + R"(n", "patches": [{")" + name + R"(": 1, "name": "p", )" + rest};
  for (const std::string& text : sets) {
    const fs::path path = write("long_name.json", text);
    test::expectRefused(path, "", [&] {
      (void)readContactSet(path, object);
    });
  }
}

TEST(HostileNames, OfSitesAreShortTexts) {
  const test::SmallHand hand = test::makeSmallHand();
  for (const std::string& name : {std::string(1000, 'n'), std::string("\x8c\x97"),
                                  std::string("a\xc0\x80"), std::string("\xed\xa0\x80"),
                                  std::string("\xf5\x80\x80\x80"), std::string("\xe2\x82")}) {
    const fs::path path =
        write("site.yaml", "format: handgraft-sites/1\nsites:\n  - {name: \"" + name +
                               "\", link: thumb_tip, point_m: [0, 0, 0], normal: [0, 0, 1], "
                               "direction: [1, 0, 0]}\n");
    test::expectRefused(path, "name", [&] {
      (void)readSites(path, *hand.model);
    });
  }
}

// === XML

/// A URDF and an SRDF of the same damage.
void expectXmlRefused(const std::string& text, const std::string& thing) {
  const test::SmallHand hand = test::makeSmallHand();
  const fs::path urdf = write("hostile.urdf", text);
  test::expectRefused(urdf, thing, [&] {
    (void)readUrdf(urdf);
  });
  const fs::path srdf = write("hostile.srdf", text);
  test::expectRefused(srdf, thing, [&] {
    (void)readSrdf(srdf, *hand.model);
  });
}

TEST(HostileXml, IsNotNestedWithoutEnd) {
  expectXmlRefused(repeated("<robot>", 100'000), "not well-formed");
  expectXmlRefused(
      "<robot>" + repeated("<a>", 100'000) + repeated("</a>", 100'000) + "</robot>",
      "not well-formed");
}

TEST(HostileXml, NeverExpandsItsOwnEntities) {
  std::string laughs = "<!DOCTYPE robot [<!ENTITY e0 'ha'>";
  for (int i = 1; i < 30; ++i)
    laughs += fmt::format("<!ENTITY e{} '{}'>", i, repeated(fmt::format("&e{};", i - 1), 10));
  laughs += "]>";
  const test::SmallHand hand = test::makeSmallHand();
  const fs::path urdf = write("laughs.urdf", laughs +
                                                 "<robot name='&e29;'><link name='&e29;'/>"
                                                 "&e29;</robot>");
  const fs::path srdf = write("laughs.srdf", laughs +
                                                 "<robot name='&e29;'><group_state "
                                                 "name='&e29;' group='g'/></robot>");
  const Reading of_urdf = readApart([&] {
    if (readUrdf(urdf).model.links()[0].name.size() > 100) throw std::runtime_error("expanded");
  });
  const Reading of_srdf = readApart([&] {
    if (readSrdf(srdf, *hand.model).poses.at(0).name.size() > 100)
      throw std::runtime_error("expanded");
  });
  for (const Reading& reading : {of_urdf, of_srdf}) {
    EXPECT_THAT(reading.end, ::testing::AnyOf(Reading::End::kRead, Reading::End::kRefused))
        << reading.message;
    if (test::canMeasureMemory()) {
      EXPECT_LE(reading.grown_mb, 64.0);
    }
  }
}

TEST(HostileXml, NeverOpensOtherFiles) {
  const fs::path secret = write("secret.txt", "TOPSECRET");
  const std::string type = "<!DOCTYPE robot [<!ENTITY x SYSTEM '" + secret.string() +
                           "'><!ENTITY y SYSTEM 'file://" + secret.string() + "'>]>";
  const auto shown = [](const auto& read) -> std::string {
    try {
      return read();
    } catch (const InvalidInput& error) {
      return error.what();
    }
  };
  const test::SmallHand hand = test::makeSmallHand();
  const fs::path urdf =
      write("secret.urdf", type + "<robot name='&x;'><link name='&y;'/>&x;</robot>");
  EXPECT_THAT(shown([&] {
                const UrdfFile file = readUrdf(urdf);
                return file.model.name() + file.model.links()[0].name;
              }),
              ::testing::Not(::testing::HasSubstr("TOPSECRET")));
  const fs::path srdf =
      write("secret.srdf", type + "<robot><group_state name='&x;' group='&y;'/>&x;</robot>");
  EXPECT_THAT(shown([&] {
                return readSrdf(srdf, *hand.model).poses.at(0).name;
              }),
              ::testing::Not(::testing::HasSubstr("TOPSECRET")));
}

TEST(HostileXml, OfAMillionElementsIsRefusedInBoundedMemory) {
  std::string links;
  std::string joints = "<link name='a'/><link name='b'/>";
  for (int i = 0; i < 1'000'000; ++i) {
    links += fmt::format("<link name='l{}'/>", i);
    if (i % 4 == 0)
      joints += fmt::format(
          "<joint name='j{}' type='fixed'><parent link='a'/><child link='b'/>"
          "</joint>",
          i);
  }
  for (const std::string& inner : {links, joints, repeated("<x/>", 4'000'000)}) {
    const fs::path path = write("million.urdf", "<robot name='r'>" + inner + "</robot>");
    test::expectRefused(path, "", [&] {
      (void)readUrdf(path);
    });
  }
  const test::SmallHand hand = test::makeSmallHand();
  for (const std::string& inner : {repeated("<x/>", 4'000'000),
                                   repeated("<group_state name='s' group='g'/>", 1'000'000)}) {
    const fs::path path = write("million.srdf", "<robot name='r'>" + inner + "</robot>");
    test::expectRefused(path, "", [&] {
      (void)readSrdf(path, *hand.model);
    });
  }
}

}  // namespace
}  // namespace handgraft::io
