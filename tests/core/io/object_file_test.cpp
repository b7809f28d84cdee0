#include "core/io/object_file.h"

#include <fstream>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/geometry/kd_tree.h"
#include "core/io/contact_file.h"

#include "tests/support/shared_data.h"
#include "tests/support/wrapping.h"

namespace handgraft::io {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double kRadius = 0.03;

std::filesystem::path write(const std::string& name, const std::string& text) {
  const std::filesystem::path path = test::scratchDirectory() / name;
  std::ofstream(path) << text;
  return path;
}

/// A sphere's points; contact 1 where z is above two thirds of the radius.
std::string plySphere(const std::string& extra_property) {
  const geometry::TriangleMesh sphere = geometry::makeSphere(kRadius, 4);
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
      "property double z\n{}end_header\n",
      sphere.vertexCount(), extra_property);
  for (int v = 0; v < sphere.vertexCount(); ++v) {
    const Eigen::Vector3d p = sphere.vertex(v);
    text += fmt::format("{} {} {}", p.x(), p.y(), p.z());
    if (!extra_property.empty()) text += p.z() > kRadius * 2 / 3 ? " 1" : " 0";
    text += '\n';
  }
  return text;
}

TEST(ObjectFile, LaysASurfaceThroughPoints) {
  HANDGRAFT_NEEDS_CGAL();
  const MeshFile object = readObject(write("cloud.ply", plySphere("")));
  EXPECT_TRUE(object.mesh.isClosed());
  EXPECT_EQ(object.cloud_O.cols(), 2562);
  EXPECT_THAT(object.notes, Contains(HasSubstr("surface of 2562 points")));
  EXPECT_THAT(object.notes, Contains(HasSubstr("the points are")));
}

/// `count` boxes in a row, 1 cm apart.
std::string boxesText(int count) {
  const geometry::TriangleMesh box = geometry::makeBox({0.06, 0.05, 0.04});
  std::string text;
  for (int b = 0; b < count; ++b) {
    for (int v = 0; v < box.vertexCount(); ++v)
      text += fmt::format("v {} {} {}\n", box.vertex(v).x() + 0.07 * b, box.vertex(v).y(),
                          box.vertex(v).z());
    for (int f = 0; f < box.faceCount(); ++f) {
      const Eigen::Vector3i corner =
          box.face(f) + Eigen::Vector3i::Constant(1 + b * box.vertexCount());
      text += fmt::format("f {} {} {}\n", corner[0], corner[1], corner[2]);
    }
  }
  return text;
}

TEST(ObjectFile, TellsOfASurfaceInPieces) {
  EXPECT_TRUE(readObject(write("one.obj", boxesText(1))).notes.empty());
  EXPECT_THAT(
      readObject(write("three.obj", boxesText(3))).notes,
      Contains(HasSubstr("falls into 3 pieces that share no corner, the largest 33 %")));
}

/// A box with corners as they should be, or each face the other way round, as some scanners
/// write them; a place on it in the file's own order.
TEST(ObjectFile, TurnsAMeshThatIsInsideOut) {
  const geometry::TriangleMesh box = geometry::makeBox({0.06, 0.05, 0.04});
  const auto text_of = [&](bool is_turned) {
    std::string text;
    for (int v = 0; v < box.vertexCount(); ++v)
      text +=
          fmt::format("v {} {} {}\n", box.vertex(v).x(), box.vertex(v).y(), box.vertex(v).z());
    for (int f = 0; f < box.faceCount(); ++f) {
      const Eigen::Vector3i face = box.face(f);
      text += fmt::format("f {} {} {}\n", face[0] + 1, face[is_turned ? 2 : 1] + 1,
                          face[is_turned ? 1 : 2] + 1);
    }
    return text;
  };
  const MeshFile right = readObject(write("right.obj", text_of(false)));
  const MeshFile turned = readObject(write("turned.obj", text_of(true)));
  EXPECT_EQ(turned.mesh.faces(), right.mesh.faces());
  EXPECT_TRUE(right.is_turned.empty());
  EXPECT_THAT(turned.notes, Contains(HasSubstr("turned all faces: they looked inwards")));

  const std::string set = fmt::format(
      R"({{"format": "handgraft-contacts/1", "name": "s", "object": "turned",
      "patches": [{{"name": "thumb", "root": {{"face": 3, "barycentric": [0.2, 0.3, 0.5]}},
      "boundary": [{}]}}]}})",
      fmt::join(box.face(3), ", "));
  const contact::ContactSet contacts = readContactSet(write("s.json", set), turned);
  const Eigen::Vector3i listed = box.face(3);  // the file has 0, 2, 1
  EXPECT_TRUE(positionOf(turned.mesh, contacts.patches.front().root)
                  .isApprox(0.2 * box.vertex(listed[0]) + 0.3 * box.vertex(listed[2]) +
                            0.5 * box.vertex(listed[1])));
  EXPECT_THAT(contactSetText(contacts, turned), HasSubstr("0.2"));
  const contact::ContactSet again =
      readContactSet(write("again.json", contactSetText(contacts, turned)), turned);
  EXPECT_EQ(again.patches.front().root.barycentric, contacts.patches.front().root.barycentric);
}

TEST(ObjectFile, CarriesAMapOfPointsOntoTheirSurface) {
  HANDGRAFT_NEEDS_CGAL();
  const MeshFile object = readObject(write("cloud.ply", plySphere("")));
  const contact::ContactSet set =
      readContacts(write("map.ply", plySphere("property double contact\n")), object);
  ASSERT_EQ(set.patches.size(), 1u);
  const contact::Patch& patch = set.patches.front();
  // The cap about +z: its rim stands at two thirds of the radius, give or take an edge.
  EXPECT_GT(positionOf(object.mesh, patch.root).z(), 0.95 * kRadius);
  for (const auto& point : patch.interpolation_boundary)
    EXPECT_NEAR(positionOf(object.mesh, point).z(), kRadius * 2 / 3, 0.0025);
}

const std::string contact_set_text =
    R"({{"format": "handgraft-contacts/1", "name": "s", "object": "cloud", "patches":
      [{{"name": "thumb", "root": {{"vertex": {}}}, "boundary": [{}, {}, {}]}}]}})";

TEST(ObjectFile, PlacesContactSetsByPointsOfTheCloud) {
  HANDGRAFT_NEEDS_CGAL();
  const MeshFile object = readObject(write("cloud.ply", plySphere("")));
  const auto near = geometry::KdTree(object.cloud_O).nearestFew(object.cloud_O.col(12), 4);
  const auto set_with_root = [&](int root) {
    return fmt::format(fmt::runtime(contact_set_text), root, near[1].index, near[2].index,
                       near[3].index);
  };
  const contact::ContactSet set = readContactSet(write("set.json", set_with_root(12)), object);
  const Eigen::Vector3d root = positionOf(object.mesh, set.patches.front().root);
  EXPECT_LT((root - object.cloud_O.col(12)).norm(), 2e-4);
  EXPECT_EQ(set.patches.front().interpolation_boundary.size(), 25u);
  try {
    readContactSet(write("bad.json", set_with_root(2562)), object);
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("points 0 to 2561"));
  }
}

}  // namespace
}  // namespace handgraft::io
