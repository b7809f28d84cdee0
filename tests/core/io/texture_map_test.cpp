#include "core/io/texture_map.h"

#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include "core/base/error.h"
#include "core/geometry/surface_locator.h"
#include "core/hand/skin_wrap.h"
#include "core/io/contact_file.h"
#include "core/io/contact_map_file.h"
#include "core/io/hand_joints_file.h"

#include "tests/support/shared_data.h"
#include "tests/support/wrapping.h"

namespace handgraft::io {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr const char* kBulb = "contacts/contactpose/light_bulb.glb";
constexpr const char* kPicture = "contacts/contactpose/full28_use_light_bulb.png";

TEST(TextureMap, AgreesWithTheMapThatOthersReadFromThePicture) {
  HANDGRAFT_NEEDS_SHARED_DATA("contacts/contactpose");
  const contact::ContactMap map =
      readTextureMap(test::sharedData(kBulb), test::sharedData(kPicture), colorMap("inferno"));
  const contact::ContactMap given = readContactMap(
      test::sharedData("contacts/contactpose/full28_use_light_bulb_contact.ply"));
  const geometry::SurfaceLocator surface(map.mesh_O);
  Eigen::VectorXd ours = Eigen::VectorXd::Zero(given.value.size());
  for (int v = 0; v < given.mesh_O.vertexCount(); ++v) {
    const auto hit = surface.nearest(given.mesh_O.vertex(v));
    EXPECT_LT(hit.distance, 1e-4);
    for (int i = 0; i < 3; ++i)
      ours[v] += hit.point.barycentric[i] * map.value[map.mesh_O.face(hit.point.face)[i]];
  }
  const double mean_difference = (ours - given.value).cwiseAbs().mean();
  const Eigen::VectorXd a = ours.array() - ours.mean();
  const Eigen::VectorXd b = given.value.array() - given.value.mean();
  const double correlation = a.normalized().dot(b.normalized());
  RecordProperty("mean_difference", std::to_string(mean_difference));
  RecordProperty("correlation", std::to_string(correlation));
  EXPECT_LT(mean_difference, 0.02);
  EXPECT_GT(correlation, 0.98);  // with the picture upside down about 0
}

/// A scan's mesh with far fewer triangles and a picture of its own, a cell of an atlas a face:
/// what ContactPose's simplified objects are.
struct PaintedMesh {
  std::filesystem::path mesh;
  std::filesystem::path picture;
};

constexpr int kCell = 24;  // pixels of the atlas across

/// Where the three corners of cell (x, y)'s triangle lie, in pixels.
std::array<Eigen::Vector2d, 3> cornersOfCell(int x, int y) {
  const Eigen::Vector2d at(x * kCell, y * kCell);
  return {at + Eigen::Vector2d(1, 1), at + Eigen::Vector2d(kCell - 2, 1),
          at + Eigen::Vector2d(1, kCell - 2)};
}

void writeCollada(const std::filesystem::path& path,
                  const geometry::TriangleMesh& mesh,
                  int cells,
                  int size) {
  std::ofstream file(path);
  const auto source = [&](const char* id, int count, int stride, const std::string& values) {
    file << fmt::format(
        R"(<source id="{0}"><float_array id="{0}a" count="{1}">{2}</float_array><technique_common>)"
        R"(<accessor source="#{0}a" count="{3}" stride="{4}">)",
        id, count * stride, values, count, stride);
    for (int i = 0; i < stride; ++i)
      file << fmt::format(R"(<param name="{}" type="float"/>)",
                          stride == 3 ? "XYZ"[i] : "ST"[i]);
    file << "</accessor></technique_common></source>";
  };
  file
      << R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" )"
      << R"(version="1.4.1"><asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>)"
      << R"(<library_geometries><geometry id="g"><mesh>)";
  std::string places;
  for (int v = 0; v < mesh.vertexCount(); ++v)
    places +=
        fmt::format("{} {} {} ", mesh.vertex(v).x(), mesh.vertex(v).y(), mesh.vertex(v).z());
  std::string coordinates;
  std::string indices;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const auto corners = cornersOfCell(f % cells, f / cells);
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector2d middle = corners[i] + Eigen::Vector2d(0.5, 0.5);
      coordinates += fmt::format("{} {} ", middle.x() / size, 1.0 - middle.y() / size);
      indices += fmt::format("{} {} ", mesh.face(f)[static_cast<Eigen::Index>(i)],
                             3 * f + static_cast<int>(i));
    }
  }
  source("p", mesh.vertexCount(), 3, places);
  source("t", 3 * mesh.faceCount(), 2, coordinates);
  file
      << R"(<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>)"
      << fmt::format(
             R"(<triangles count="{}"><input semantic="VERTEX" source="#v" offset="0"/>)"
             R"(<input semantic="TEXCOORD" source="#t" offset="1" set="0"/><p>{}</p>)",
             mesh.faceCount(), indices)
      << R"(</triangles></mesh></geometry></library_geometries><library_visual_scenes>)"
      << R"(<visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene>)"
      << R"(</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

/// `size` pixels wide and high, three bytes each, the upper row first.
void writePicture(const std::filesystem::path& path,
                  int size,
                  const std::vector<png_byte>& pixels) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(size);
  image.height = static_cast<png_uint_32>(size);
  image.format = PNG_FORMAT_RGB;
  EXPECT_NE(png_image_write_to_file(&image, path.c_str(), 0, pixels.data(), 0, nullptr), 0);
}

/// The values of `fine`, painted onto `coarse` by where its pixels lie.
PaintedMesh painted(const contact::ContactMap& fine, const geometry::TriangleMesh& coarse) {
  const geometry::SurfaceLocator surface(fine.mesh_O);
  const int cells = static_cast<int>(std::ceil(std::sqrt(coarse.faceCount())));
  const int size = cells * kCell;
  std::vector<png_byte> pixels(static_cast<std::size_t>(3 * size * size), 0);
  for (int f = 0; f < coarse.faceCount(); ++f) {
    const auto corners = cornersOfCell(f % cells, f / cells);
    const double across = corners[1].x() - corners[0].x();
    const Eigen::Vector3i face = coarse.face(f);
    for (int y = 0; y < kCell; ++y) {
      for (int x = 0; x < kCell; ++x) {
        const double b = (x - 1) / across;
        const double c = (y - 1) / across;
        const Eigen::Vector3d p = (1.0 - b - c) * coarse.vertex(face[0]) +
                                  b * coarse.vertex(face[1]) + c * coarse.vertex(face[2]);
        const auto hit = surface.nearest(p);
        double value = 0.0;
        for (int i = 0; i < 3; ++i)
          value += hit.point.barycentric[i] * fine.value[fine.mesh_O.face(hit.point.face)[i]];
        const Eigen::Vector3d rgb = colorOf(colorMap("inferno"), value);
        const std::size_t pixel =
            static_cast<std::size_t>((f / cells * kCell + y) * size + f % cells * kCell + x);
        for (int i = 0; i < 3; ++i)
          pixels[3 * pixel + static_cast<std::size_t>(i)] =
              static_cast<png_byte>(std::lround(255.0 * rgb[i]));
      }
    }
  }
  PaintedMesh result{test::scratchDirectory() / "coarse.dae",
                     test::scratchDirectory() / "coarse.png"};
  writeCollada(result.mesh, coarse, cells, size);
  writePicture(result.picture, size, pixels);
  return result;
}

/// Of each finger's patches and the palm's.
std::map<std::string, double> areasOf(const contact::ContactMap& map) {
  contact::SegmentationOptions options;
  options.joints_O =
      readHandJoints(test::sharedData("contacts/contactpose/full28_use_light_bulb.json"));
  std::map<std::string, double> areas;
  for (const contact::Patch& patch : contact::segment(map, options).patches) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    const auto& ring = patch.interpolation_boundary;
    const Eigen::Vector3d root = positionOf(map.mesh_O, patch.root);
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Eigen::Vector3d a = positionOf(map.mesh_O, ring[i]) - root;
      const Eigen::Vector3d b = positionOf(map.mesh_O, ring[(i + 1) % ring.size()]) - root;
      sum += 0.5 * a.cross(b);
    }
    areas[patch.name.substr(0, patch.name.find('_'))] += sum.norm();
  }
  return areas;
}

// Shows 7: patches as they were measured, however coarse the mesh that the picture is for.
TEST(TextureMap, GivesACoarseMeshThePatchesOfTheFineOne) {
  HANDGRAFT_NEEDS_CGAL();
  HANDGRAFT_NEEDS_SHARED_DATA("contacts/contactpose");
  const contact::ContactMap fine =
      readTextureMap(test::sharedData(kBulb), test::sharedData(kPicture), colorMap("inferno"));
  const contact::ContactMap given = readContactMap(
      test::sharedData("contacts/contactpose/full28_use_light_bulb_contact.ply"));
  const geometry::TriangleMesh coarse = hand::remeshed(given.mesh_O, 0.012);
  ASSERT_LT(coarse.faceCount(), given.mesh_O.faceCount() / 5);
  const PaintedMesh files = painted(fine, coarse);

  const contact::ContactMap map =
      readTextureMap(files.mesh, files.picture, colorMap("inferno"));
  const std::map<std::string, double> expected = areasOf(fine);
  const std::map<std::string, double> found = areasOf(map);
  ASSERT_GE(expected.size(), 3u);
  for (const auto& [name, area] : expected) {
    ASSERT_EQ(found.count(name), 1u) << name;
    EXPECT_NEAR(found.at(name), area, 0.15 * area) << name;  // ring, 254 mm2: 12 % less
  }
  EXPECT_EQ(found.size(), expected.size());

  const MeshFile object = readMesh(files.mesh);
  contact::SegmentationOptions options;
  const contact::ContactSet set = contactsFromMap(map, object, options);
  for (const contact::Patch& patch : set.patches)
    EXPECT_NO_THROW(validate(object.mesh, patch)) << "results lie on the file's own mesh";
}

// Its corners have places of their own in the picture, in another order than its vertices.
TEST(TextureMap, MayBeOfAnObj) {
  const std::filesystem::path mesh = test::scratchDirectory() / "plate.obj";
  std::ofstream(mesh) << "v 0 0 0\nv 0.04 0 0\nv 0.04 0.04 0\nv 0 0.04 0\n"
                         "vt 1 1\nvt 0 1\nvt 0 0\nvt 1 0\n"
                         "f 3/1 4/2 1/3\nf 1/3 2/4 3/1\n";
  const PaintedMesh files{mesh, test::scratchDirectory() / "plate.png"};
  constexpr int kSize = 64;
  std::vector<png_byte> pixels;  // black, but for the upper right quarter
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      pixels.insert(pixels.end(), 3, x >= kSize / 2 && y < kSize / 2 ? 255 : 0);
  writePicture(files.picture, kSize, pixels);

  const contact::ContactMap map = readTextureMap(files.mesh, files.picture, colorMap("grey"));
  for (int v = 0; v < map.mesh_O.vertexCount(); ++v) {
    const Eigen::Vector3d p = map.mesh_O.vertex(v);
    const double inside = std::min(p.x(), p.y()) - 0.02;  // m, of the white quarter
    if (std::abs(inside) < 0.004) continue;
    EXPECT_NEAR(map.value[v], inside > 0.0 ? 1.0 : 0.0, 0.01) << p.transpose();
  }
}

TEST(TextureMap, RefusesAScaleThatDoesNotFit) {
  HANDGRAFT_NEEDS_SHARED_DATA("contacts/contactpose");
  EXPECT_THAT(
      [&] {
        readTextureMap(test::sharedData(kBulb), test::sharedData(kPicture),
                       colorMap("viridis"));
      },
      ThrowsMessage<InvalidInput>(HasSubstr("nearest scale is 'inferno'")));
}

}  // namespace
}  // namespace handgraft::io
