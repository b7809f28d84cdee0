#include "core/io/mesh_file.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/io/file_mesh.h"

#include "tests/support/shared_data.h"

namespace handgraft::io {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

std::filesystem::path write(const std::string& name, const std::string& bytes) {
  const std::filesystem::path path = test::scratchDirectory() / name;
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

std::string faultOf(const std::filesystem::path& path) {
  try {
    readMesh(path);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "accepted";
}

std::string binaryStl(const std::vector<std::array<float, 9>>& facets, std::uint32_t claimed) {
  std::string bytes(80, ' ');
  bytes.append(reinterpret_cast<const char*>(&claimed), 4);
  for (const auto& facet : facets) {
    bytes.append(12, '\0');
    bytes.append(reinterpret_cast<const char*>(facet.data()), sizeof(facet));
    bytes.append(2, '\0');
  }
  return bytes;
}

const std::vector<std::array<float, 9>> two_facets = {{0, 0, 0, 1, 0, 0, 0, 1, 0},
                                                      {1, 0, 0, 1, 1, 0, 0, 1, 0}};

TEST(MeshFile, WeldsStlCornersAndKeepsTheirOrder) {
  const MeshFile file = readMesh(write("two.stl", binaryStl(two_facets, 2)));
  EXPECT_EQ(file.mesh.vertexCount(), 4);
  EXPECT_THAT(file.file_vertex, ElementsAre(0, 1, 2, 4));
  EXPECT_THAT(file.mesh_vertex, ElementsAre(0, 1, 2, 1, 3, 2));
  EXPECT_THAT(file.file_face, ElementsAre(0, 1));
  EXPECT_THAT(file.notes, Contains("welded 6 vertices to 4"));
}

TEST(MeshFile, ReadsTextStl) {
  const MeshFile file = readMesh(write("text.stl",
                                       "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"
                                       "vertex 1e0 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
                                       "endsolid s\n"));
  EXPECT_EQ(file.mesh.faceCount(), 1);
  EXPECT_EQ(file.mesh.vertex(1), Eigen::Vector3d(1, 0, 0));
}

TEST(MeshFile, ReadsBinaryStlThatBeginsLikeText) {
  std::string bytes = binaryStl(two_facets, 2);
  bytes.replace(0, 5, "solid");
  EXPECT_EQ(readMesh(write("solid.stl", bytes)).mesh.faceCount(), 2);
}

TEST(MeshFile, CountsObjVerticesByTheirLines) {
  const MeshFile file = readMesh(write("order.obj",
                                       "mtllib missing.mtl\no part\nv 9 9 9\nv 0 0 0\nvt 0 0\n"
                                       "v 1 0 0 # x\nusemtl m\nv 0 1 0\nv 1 0 0\n"
                                       "f 2/1/1 3//1 \\\n 4/1\nf -2 -1 -4\n"));
  EXPECT_THAT(file.file_vertex, ElementsAre(1, 2, 3));
  EXPECT_THAT(file.mesh_vertex, ElementsAre(-1, 0, 1, 2, 1));
  EXPECT_EQ(file.mesh.faceCount(), 2);
  EXPECT_THAT(file.notes, Contains("left out 1 vertices without a face"));
}

TEST(MeshFile, CutsConcavePolygonsInside) {
  // An arrow head: a fan from its first corner would leave the shape.
  const MeshFile file =
      readMesh(write("arrow.obj", "v 1 0 0\nv 0 2 0\nv -1 0 0\nv 0 0.5 0\nf 1 2 3 4\n"));
  EXPECT_NEAR(file.mesh.area(), 1.5, 1e-12);
  EXPECT_THAT(file.file_face, ElementsAre(0, 0));
}

TEST(MeshFile, DropsFacesThatCollapse) {
  const MeshFile file =
      readMesh(write("thin.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nf 1 2 3\nf 1 2 4\n"));
  EXPECT_EQ(file.mesh.faceCount(), 1);
  EXPECT_THAT(file.notes, Contains("dropped 1 faces without area"));
}

// As some exporters write what they merge; a face turned over is another one.
TEST(MeshFile, DropsFacesThatAreListedBefore) {
  const MeshFile file = readMesh(write("twice.obj",
                                       "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0 0 0\n"
                                       "f 1 2 3\nf 2 4 3\nf 2 3 5\nf 3 2 1\nf 3 2 4\n"));
  EXPECT_EQ(file.mesh.faceCount(), 3);
  EXPECT_THAT(file.file_face, ElementsAre(0, 1, 3));
  EXPECT_THAT(file.notes, Contains("dropped 2 faces that are listed before"));
}

/// A cube of side 1, every face two triangles with corners of their own, each coordinate of
/// which is off by up to `off`.
std::string looseCube(double off, bool both_sides = false) {
  const std::vector<std::array<int, 4>> sides = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                                 {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  std::string vertices;
  std::string faces;
  int count = 0;
  const auto add = [&](int a, int b, int c) {
    for (const int corner : {a, b, c}) {
      for (int axis = 0; axis < 3; ++axis) {
        const double wobble = off * (((7 * count + 3 * axis) % 5) / 2.0 - 1.0) / 2.0;
        const double at = ((corner >> axis) & 1) != 0 ? 1.0 : 0.0;
        vertices += fmt::format("{}{:.9f}", axis == 0 ? "v " : " ", at + wobble);
      }
      vertices += "\n";
      ++count;
    }
    faces += fmt::format("f {} {} {}\n", count - 2, count - 1, count);
    if (both_sides) faces += fmt::format("f {} {} {}\n", count - 1, count - 2, count);
  };
  for (const std::array<int, 4>& side : sides) {
    add(side[0], side[1], side[2]);
    add(side[0], side[2], side[3]);
  }
  return vertices + faces;
}

TEST(MeshFile, JoinsBordersThatMeetWithinARounding) {
  const MeshFile file = readMesh(write("loose.obj", looseCube(1e-5)));
  EXPECT_EQ(file.mesh.vertexCount(), 8);
  EXPECT_EQ(file.mesh.faceCount(), 12);
  EXPECT_TRUE(file.mesh.isClosed());
  EXPECT_THAT(file.notes, Contains(HasSubstr("border vertices")));
  EXPECT_EQ(file.mesh_vertex.size(), 36u);
  for (const int v : file.mesh_vertex)
    EXPECT_GE(v, 0);
}

TEST(MeshFile, LeavesPiecesThatAreApart) {
  const MeshFile file = readMesh(write("apart.obj", looseCube(1e-3)));
  EXPECT_EQ(file.mesh.faceCount(), 12);
  EXPECT_GT(file.mesh.vertexCount(), 8);
}

// Two vertices of a closed mesh that are as near are no seam.
TEST(MeshFile, LeavesFineDetailOfWhatIsClosed) {
  const MeshFile file = readMesh(write("needle.obj",
                                       "v 0 0 0\nv 0.00001 0 0\nv 0 1 0\nv 0 0 1\n"
                                       "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"));
  EXPECT_EQ(file.mesh.vertexCount(), 4);
  EXPECT_EQ(file.mesh.faceCount(), 4);
}

TEST(MeshFile, TakesOneSideWhereAllFacesAreListedBothWays) {
  for (const double off : {0.0, 1e-5}) {
    const MeshFile file = readMesh(write("both.obj", looseCube(off, true)));
    EXPECT_EQ(file.mesh.faceCount(), 12) << off;
    EXPECT_NEAR(file.mesh.area(), 6.0, 1e-3);
    EXPECT_THAT(file.notes, Contains("dropped 12 faces that are others turned over"));
    for (int f = 0; f < file.mesh.faceCount(); ++f)
      EXPECT_EQ(file.file_face[f], 2 * f);  // the fronts, which come first
  }
}

/// One triangle whose corners lie in the buffer at `uri`.
std::string gltfWithBuffer(const std::string& uri) {
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],)"
         R"("nodes":[{"mesh":0,"translation":[0,0,5],"scale":[2,2,2]}],)"
         R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
         R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",)"
         R"("min":[0,0,0],"max":[1,1,0]}],"bufferViews":[{"buffer":0,"byteLength":36}],)"
         R"("buffers":[{"uri":")" +
         uri + R"(","byteLength":36}]})";
}

std::string gltfCorners() {
  const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  return {reinterpret_cast<const char*>(corners), sizeof(corners)};
}

TEST(MeshFile, AppliesNodeTransformsOfAGltfWithABufferBeside) {
  write("beside.bin", gltfCorners());
  const MeshFile file = readMesh(write("tri.gltf", gltfWithBuffer("beside.bin")));
  ASSERT_EQ(file.mesh.faceCount(), 1);
  EXPECT_EQ(file.mesh.vertex(1), Eigen::Vector3d(2, 0, 5));
}

TEST(MeshFile, KeepsAGltfFromReadingOutsideItsFolder) {
  const auto outside = write("outside.bin", gltfCorners());
  const auto folder = test::scratchDirectory() / "inside";
  std::filesystem::create_directories(folder);
  for (const std::string& uri : {std::string("../outside.bin"), outside.string()}) {
    const auto path = folder / "tri.gltf";
    std::ofstream(path) << gltfWithBuffer(uri);
    EXPECT_THROW(readMesh(path), InvalidInput) << uri;
  }
}

TEST(MeshFile, KeepsTheFrameAndAppliesTheUnitOfCollada) {
  const MeshFile file = readMesh(write(
      "tri.dae",
      R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" )"
      R"(version="1.4.1"><asset><unit meter="0.01"/><up_axis>Z_UP</up_axis></asset>)"
      R"(<library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" )"
      R"(count="9">0 0 0 100 0 0 0 0 100</float_array><technique_common><accessor source="#a" )"
      R"(count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>)"
      R"(<param name="Z" type="float"/></accessor></technique_common></source>)"
      R"(<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>)"
      R"(<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p>)"
      R"(</triangles></mesh></geometry></library_geometries><library_visual_scenes>)"
      R"(<visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene>)"
      R"(</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)"));
  ASSERT_EQ(file.mesh.faceCount(), 1);
  EXPECT_NEAR((file.mesh.vertex(1) - Eigen::Vector3d(1, 0, 0)).norm(), 0.0, 1e-6);
  EXPECT_NEAR((file.mesh.vertex(2) - Eigen::Vector3d(0, 0, 1)).norm(), 0.0, 1e-6);
}

/// A GLB's header, which claims `length` bytes.
std::string glb(std::uint32_t length) {
  std::string bytes("glTF\2\0\0\0", 8);
  for (int i = 0; i < 4; ++i)
    bytes.push_back(static_cast<char>(length >> (8 * i) & 0xffU));
  return bytes;
}

std::string glbTriangle() {
  std::string scene = gltfWithBuffer("");
  scene.replace(scene.find("\"uri\":\"\","), 9, "");
  scene.resize((scene.size() + 3) / 4 * 4, ' ');
  const auto chunk = [](const std::string& type, const std::string& content) {
    return glb(static_cast<std::uint32_t>(content.size())).substr(8) + type + content;
  };
  const std::string chunks =
      chunk("JSON", scene) + chunk(std::string("BIN\0", 4), gltfCorners());
  return glb(static_cast<std::uint32_t>(12 + chunks.size())) + chunks;
}

TEST(MeshFile, ReadsAGlbWhateverItsExtensionsCase) {
  EXPECT_EQ(readMesh(write("tri.GLB", glbTriangle())).mesh.faceCount(), 1);
}

TEST(MeshFile, ComparesAGlbsHeaderWithTheFile) {
  const std::string whole = glbTriangle();
  EXPECT_THAT(faultOf(write("longer.glb", whole + "    ")), HasSubstr("header says"));
  EXPECT_THAT(faultOf(write("shorter.glb", whole.substr(0, whole.size() / 2))),
              HasSubstr("header says"));
  std::string greedy = whole;
  greedy.replace(12, 4, "\xff\xff\xff\xff");
  EXPECT_THAT(faultOf(write("greedy.glb", greedy)), HasSubstr("JSON says 4294967295 bytes"));
  EXPECT_THAT(faultOf(write("bare.glb", glb(12))), HasSubstr("first chunk is not JSON"));
  std::string other = whole;
  other[4] = 1;
  EXPECT_THAT(faultOf(write("other.glb", other)), HasSubstr("version 1, permitted is 2"));
}

TEST(MeshFile, TriesNoFormatThatTheExtensionDoesNotSay) {
  EXPECT_THAT(faultOf(write("stl.glb", binaryStl(two_facets, 2))), HasSubstr("is no GLB"));
  EXPECT_THAT(faultOf(write("obj.gltf", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")),
              HasSubstr("is no glTF"));
  EXPECT_THAT(faultOf(write("obj.dae", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")),
              HasSubstr("is no COLLADA"));
  // Past the look at the start, the loaders of other formats must not take over.
  EXPECT_THAT(
      faultOf(write("obj_inside.dae", "# <COLLADA\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")),
      HasSubstr("cannot be read as a mesh"));
}

TEST(MeshFile, RefusesAnObjCutShortAmongItsFaces) {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  EXPECT_THAT(faultOf(write("cut.obj", corners + "f 1 2 3\nf 1 2 ")), HasSubstr("truncated"));
  EXPECT_THAT(faultOf(write("cut.obj", corners + "f 1 2 3\nf 3 2 1")),
              AllOf(HasSubstr("cut.obj"), HasSubstr("1 of 4 vertices have no face")));
  EXPECT_THAT(faultOf(write("points.obj", corners)),
              HasSubstr(": 4 vertices and no face: is the file cut short? Point clouds"));
  EXPECT_THAT(readMesh(write("cut.obj", corners + "f 1 2 3\n")).notes,
              Contains("1 of 4 vertices have no face; is the file cut short?"));
  // Whole, but its last line is left open.
  EXPECT_EQ(readMesh(write("whole.obj", corners + "f 1 2 3\nf 1 2 4")).mesh.faceCount(), 2);
}

TEST(MeshFile, ToleratesAFewObjVerticesWithoutAFace) {
  std::string text = "v 0 0 0\nv 1 0 0\n";
  for (int i = 0; i < 20; ++i)
    text += fmt::format("v 0 1 {}\n", i);
  for (int i = 1; i < 20; ++i)
    text += fmt::format("f 1 2 {}\n", i + 2);
  const MeshFile file = readMesh(write("few.obj", text));
  EXPECT_THAT(file.notes, ElementsAre("left out 1 vertices without a face"));
}

TEST(MeshFile, WritesPlyThatReadsTheSame) {
  const geometry::TriangleMesh sphere = geometry::makeSphere(0.03, 2);
  const std::filesystem::path path = test::scratchDirectory() / "sphere.ply";
  writePly(path, sphere);
  const MeshFile file = readMesh(path);
  EXPECT_EQ(file.mesh.vertices(), sphere.vertices());
  EXPECT_EQ(file.mesh.faces(), sphere.faces());
}

TEST(MeshFile, RefusesDamagedFilesInOneLineThatNamesThem) {
  const std::string stl = binaryStl(two_facets, 2);
  const std::filesystem::path damaged[] = {
      write("half.stl", stl.substr(0, stl.size() / 2)),
      write("claims.stl", binaryStl(two_facets, 4000000000U)),
      write("tiny.stl", "x"),
      write("half_text.stl", "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1"),
      write("empty.obj", ""),
      write("nothing.obj", "# nothing\n"),
      write("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"),
      write("huge_index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99999999999999999999\n"),
      write("half.obj", "v 0 0 0\nv 1 0 0\nv 0 1"),
      write("half.glb", glb(12).substr(0, 11)),
      write("length.glb", glb(0xffff)),
      write("garbage.glb", std::string(100, '\xa5')),
      write("list.gltf", "[1, 2]"),
      write("blank.gltf", "   \n"),
      write("plain.dae", "<?xml version='1.0'?><x3d/>"),
      write("bad.gltf", "{\"asset\":{\"version\":\"2.0\"},"),
      write("bad.dae", "<COLLADA><library_geom"),
      write("mesh.xyz", "1 2 3\n"),
      test::scratchDirectory() / "missing.stl",
      test::scratchDirectory(),
  };
  for (const std::filesystem::path& path : damaged) {
    EXPECT_THAT(faultOf(path),
                AllOf(HasSubstr(path.filename().string()), Not(HasSubstr("\n"))));
  }
}

TEST(MeshFile, NamesAVertexThatIsNotFiniteByItsFileIndex) {
  EXPECT_THAT(faultOf(write("nan.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nf 1 2 3\n")),
              HasSubstr("vertex 3 is (nan, 0, 0)"));
  std::vector<std::array<float, 9>> facets = two_facets;
  facets[1][6] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(faultOf(write("nan.stl", binaryStl(facets, 2))),
              HasSubstr("vertex 5 is (nan, 1, 0)"));
}

TEST(CutPolygon, CoversASpiralWithoutOverlap) {
  Eigen::Matrix3Xd spiral(3, 8);
  spiral << 0, 4, 4, 1, 1, 2, 2, 0,  //
      0, 0, 3, 3, 2, 2, 1, 1,        //
      7, 7, 7, 7, 7, 7, 7, 7;
  double area = 0.0;
  for (const auto& t : cutPolygon(spiral)) {
    const Eigen::Vector3d a = spiral.col(t[0]);
    const double part = (spiral.col(t[1]) - a).eval().x() * (spiral.col(t[2]) - a).eval().y() -
                        (spiral.col(t[1]) - a).eval().y() * (spiral.col(t[2]) - a).eval().x();
    EXPECT_GE(part, 0.0);
    area += part / 2.0;
  }
  EXPECT_NEAR(area, 9.0, 1e-12);  // rows of 4, 2 and 3 squares
}

TEST(MeshFile, ReadsEveryRealMesh) {
  HANDGRAFT_NEEDS_SHARED_DATA("hands");
  int count = 0;
  for (const char* folder : {"hands", "objects", "contacts"}) {
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(test::sharedData(folder))) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".obj" && extension != ".stl" && extension != ".ply" &&
          extension != ".glb") {
        continue;
      }
      const MeshFile file = readMesh(entry.path());
      ++count;
      EXPECT_EQ(file.file_vertex.size(), static_cast<std::size_t>(file.mesh.vertexCount()));
      EXPECT_EQ(file.file_face.size(), static_cast<std::size_t>(file.mesh.faceCount()));
      for (int v = 0; v < file.mesh.vertexCount(); ++v) {
        ASSERT_EQ(file.mesh_vertex[file.file_vertex[v]], v) << entry.path();
      }
    }
  }
  EXPECT_GT(count, 80);
}

}  // namespace
}  // namespace handgraft::io
