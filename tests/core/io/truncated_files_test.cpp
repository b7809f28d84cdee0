// Every kind of file, cut short anywhere: refused in a line that names it, or, where its format
// has no end mark, read as far as it goes. What goes wrong otherwise, sanitizers see.

#include <algorithm>
#include <cstring>
#include <fstream>
#include <functional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/io/contact_file.h"
#include "core/io/contact_map_file.h"
#include "core/io/hand_joints_file.h"
#include "core/io/mesh_file.h"
#include "core/io/problem_file.h"
#include "core/io/sites_file.h"
#include "core/io/srdf_file.h"
#include "core/io/urdf_file.h"

#include "tests/support/shared_data.h"
#include "tests/support/small_hand.h"

namespace handgraft::io {
namespace {

namespace fs = std::filesystem;

struct Whole {
  std::string name;  ///< of the file
  std::string bytes;
  std::function<void(const fs::path&)> read;
  /// Bytes at its end without which it may still be whole: blanks, digits of the last number.
  /// All of them where the format has no end mark.
  std::size_t optional_end = 0;
};

// NOLINTNEXTLINE(readability-identifier-naming): GoogleTest's name
void PrintTo(const Whole& whole, std::ostream* out) {
  *out << whole.name;
}

constexpr const char* kObj =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
constexpr const char* kStl =
    "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
    "endloop\nendfacet\nendsolid s\n";
constexpr const char* kDae =
    "<?xml version=\"1.0\"?>\n<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
    "version=\"1.4.1\"><library_geometries><geometry id=\"g\"><mesh><source id=\"p\">"
    "<float_array id=\"a\" count=\"9\">0 0 0 1 0 0 0 1 0</float_array><technique_common>"
    "<accessor source=\"#a\" count=\"3\" stride=\"3\"><param name=\"X\" type=\"float\"/>"
    "<param name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor>"
    "</technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" "
    "source=\"#p\"/></vertices><triangles count=\"1\"><input semantic=\"VERTEX\" "
    "source=\"#v\" offset=\"0\"/><p>0 1 2</p></triangles></mesh></geometry>"
    "</library_geometries><library_visual_scenes><visual_scene id=\"s\"><node id=\"n\">"
    "<instance_geometry url=\"#g\"/></node></visual_scene></library_visual_scenes><scene>"
    "<instance_visual_scene url=\"#s\"/></scene></COLLADA>\n";
constexpr const char* kGltf =
    R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
    R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"buffers":[{)"
    R"("uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA)"
    R"(","byteLength":42}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},)"
    R"({"buffer":0,"byteOffset":36,"byteLength":6}],"accessors":[)"
    R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},)"
    R"({"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}]})";
constexpr const char* kPlyMap =
    "ply\nformat ascii 1.0\ncomment 0=thumb\nelement vertex 3\nproperty float x\nproperty "
    "float "
    "y\nproperty float z\nproperty float contact\nproperty int link\nelement face 1\nproperty "
    "list uchar int vertex_indices\nend_header\n0 0 0 0.5 0\n1 0 0 0.5 0\n0 1 0 0.5 -1\n"
    "3 0 1 2\n";
constexpr const char* kUrdf =
    "<?xml version='1.0'?><robot name='r'><link name='a'><visual><geometry><box size='1 1 1'/>"
    "</geometry></visual></link><link name='b'/><joint name='j' type='revolute'><parent "
    "link='a'/><child link='b'/><axis xyz='0 0 1'/><limit lower='0' upper='1' effort='1' "
    "velocity='1'/></joint></robot>\n";
constexpr const char* kSrdf =
    "<robot name='r'><group_state name='open' group='g'><joint name='thumb_1' value='0.2'/>"
    "</group_state></robot>\n";
constexpr const char* kSet =
    R"({"format": "handgraft-contacts/1", "name": "n", "patches": [{"name": "thumb", "root":
    {"vertex": 0}, "boundary": [], "interpolation_boundary": [{"vertex": 0}, {"vertex": 1},
    {"vertex": 2}]}]})";
constexpr const char* kSites =
    "format: handgraft-sites/1\nsites:\n  - {name: thumb, link: thumb_tip, point_m: [0, 0, 0], "
    "normal: [0, 0, 1], direction: [1, 0, 0]}\n";
constexpr const char* kProblem =
    R"({"format": "handgraft-problem/1", "hand": {"urdf": "whole.urdf"}, "dofs": ["root_rx",
    "root_ry", "root_rz", "root_tx", "root_ty", "root_tz", "j"], "start": [0, 0, 0, 0, 0, 0, 0],
    "prior": [0, 0, 0, 0, 0, 0, 0], "lower": [null, null, null, null, null, null, 0],
    "upper": [null, null, null, null, null, null, 1],
    "weights": {"distance": 1, "normal": 1, "prior": 1}, "correspondences": []})";

std::string joints() {
  std::string text = "{\"joints\": [";
  for (int i = 0; i < 21; ++i)
    text += fmt::format("{}[{}, 0, {}]", i == 0 ? "" : ", ", 0.01 * i, 0.5);
  return text + "]}";
}

std::string binaryStl() {
  std::string bytes(80, ' ');
  bytes += std::string("\1\0\0\0", 4);
  const float corners[12] = {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0};
  bytes += std::string(reinterpret_cast<const char*>(corners), sizeof corners);
  return bytes + std::string(2, '\0');
}

/// The same triangle with its buffer as a second chunk.
std::string glb() {
  std::string json = kGltf;
  const std::size_t uri = json.find("\"uri\"");
  json.erase(uri, json.find("\"byteLength\"") - uri);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string buffer(44, '\0');
  const float one = 1.0F;
  std::memcpy(buffer.data() + 12, &one, sizeof one);
  std::memcpy(buffer.data() + 28, &one, sizeof one);
  buffer[38] = 1;
  buffer[40] = 2;
  const auto word = [](std::size_t value) {
    std::string bytes;
    for (unsigned i = 0; i < 4; ++i)
      bytes += static_cast<char>(value >> (8 * i) & 0xffU);
    return bytes;
  };
  const std::string chunks = word(json.size()) + "JSON" + json + word(buffer.size()) +
                             std::string("BIN\0", 4) + buffer;
  return "glTF" + word(2) + word(12 + chunks.size()) + chunks;
}

/// A triangle, for contact sets.
MeshFile triangle() {
  const fs::path path = test::scratchDirectory() / "triangle.obj";
  std::ofstream(path) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  return readMesh(path);
}

const hand::HandModel& smallHand() {
  static const test::SmallHand small_hand = test::makeSmallHand();
  return *small_hand.model;
}

void mesh(const fs::path& path) {
  (void)readMesh(path);
}

class TruncatedFile : public ::testing::TestWithParam<Whole> {};

TEST_P(TruncatedFile, IsRefusedByItsName) {
  const Whole& whole = GetParam();
  const fs::path folder = test::scratchDirectory();
  std::ofstream(folder / "whole.urdf") << kUrdf;  // for problems
  const fs::path path = folder / whole.name;
  const auto write = [&](std::size_t size) {
    std::ofstream(path, std::ios::binary) << whole.bytes.substr(0, size);
  };
  write(whole.bytes.size());
  ASSERT_NO_THROW(whole.read(path));

  const std::size_t step = std::max<std::size_t>(1, whole.bytes.size() / 300);
  for (std::size_t size = 0; size < whole.bytes.size(); size += step) {
    write(size);
    try {
      whole.read(path);
      EXPECT_GE(size + whole.optional_end, whole.bytes.size()) << "cut after byte " << size;
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr(whole.name)) << "cut after byte " << size;
      EXPECT_THAT(error.what(), ::testing::Not(::testing::HasSubstr("\n")));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Every,
                         TruncatedFile,
                         ::testing::Values(Whole{"cut.obj", kObj, mesh,
                                                 std::string(kObj).size()},
                                           Whole{"cut_text.stl", kStl, mesh, 3},
                                           Whole{"cut_binary.stl", binaryStl(), mesh},
                                           Whole{"cut.dae", kDae, mesh, 1},
                                           Whole{"cut.gltf", kGltf, mesh},
                                           Whole{"cut.glb", glb(), mesh},
                                           Whole{"cut.ply", kPlyMap,
                                                 [](const fs::path& path) {
                                                   (void)readContactMap(path);
                                                 },
                                                 1},
                                           Whole{"cut.urdf", kUrdf,
                                                 [](const fs::path& path) {
                                                   (void)readUrdf(path);
                                                 },
                                                 1},
                                           Whole{"cut.srdf", kSrdf,
                                                 [](const fs::path& path) {
                                                   (void)readSrdf(path, smallHand());
                                                 },
                                                 1},
                                           Whole{"cut_set.json", kSet,
                                                 [](const fs::path& path) {
                                                   (void)readContactSet(path, triangle());
                                                 }},
                                           Whole{"cut_joints.json", joints(),
                                                 [](const fs::path& path) {
                                                   (void)readHandJoints(path);
                                                 }},
                                           Whole{"cut_problem.json", kProblem,
                                                 [](const fs::path& path) {
                                                   (void)readProblem(path);
                                                 }},
                                           Whole{"cut.yaml", kSites,
                                                 [](const fs::path& path) {
                                                   (void)readSites(path, smallHand());
                                                 },
                                                 1}),
                         [](const auto& each) {
                           std::string name = each.param.name;
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

}  // namespace
}  // namespace handgraft::io
