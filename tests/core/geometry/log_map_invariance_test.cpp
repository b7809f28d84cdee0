// What a log map must not depend on: where the mesh stands, its unit, and how it is numbered.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/geometry/log_map.h"
#include "core/io/mesh_file.h"

#include "tests/support/shared_data.h"

namespace handgraft::geometry {
namespace {

/// The same surface, told otherwise. Vertex v of the first is `vertex_of[v]` of the second.
struct Retold {
  TriangleMesh mesh;
  std::vector<int> vertex_of;
  SurfacePoint source;
  Eigen::Vector3d direction;
  double scale = 1.0;
};

struct Question {
  SurfacePoint source;
  Eigen::Vector3d direction;
  double radius;
};

std::vector<int> identity(int count) {
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

Retold moved(const TriangleMesh& mesh, const Question& question, const Eigen::Affine3d& X) {
  return {transformed(mesh, X), identity(mesh.vertexCount()), question.source,
          X.linear() * question.direction, std::cbrt(X.linear().determinant())};
}

Retold rotated(const TriangleMesh& mesh, const Question& question) {
  const Eigen::AngleAxisd turn(1.1, Eigen::Vector3d(0.3, -0.8, 0.5).normalized());
  return moved(mesh, question, Eigen::Affine3d(turn));
}

Retold scaled(const TriangleMesh& mesh, const Question& question, double scale) {
  return moved(mesh, question, Eigen::Affine3d(Eigen::Scaling(scale)));
}

/// Vertices and faces in another order, each face from another corner.
Retold renumbered(const TriangleMesh& mesh, const Question& question) {
  std::mt19937 random(5);
  Retold retold{{}, identity(mesh.vertexCount()), {}, question.direction};
  std::shuffle(retold.vertex_of.begin(), retold.vertex_of.end(), random);
  std::vector<int> face_of = identity(mesh.faceCount());
  std::shuffle(face_of.begin(), face_of.end(), random);
  Eigen::Matrix3Xd vertices(3, mesh.vertexCount());
  Eigen::Matrix3Xi faces(3, mesh.faceCount());
  for (int v = 0; v < mesh.vertexCount(); ++v)
    vertices.col(retold.vertex_of[v]) = mesh.vertex(v);
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const int turn = static_cast<int>(random() % 3);
    for (int c = 0; c < 3; ++c) {
      faces((c + turn) % 3, face_of[f]) = retold.vertex_of[mesh.faces()(c, f)];
    }
    if (f == question.source.face) {
      retold.source.face = face_of[f];
      for (int c = 0; c < 3; ++c)
        retold.source.barycentric[(c + turn) % 3] = question.source.barycentric[c];
    }
  }
  retold.mesh = TriangleMesh(std::move(vertices), std::move(faces));
  return retold;
}

struct Difference {
  double r = 0.0;    ///< of the radius of the disk
  double phi = 0.0;  ///< along the circle, of the radius of the disk
  int missed = 0;    ///< vertices that only one of the two reached, the rim's last 1e-9 apart
  int count = 0;
};

Difference differenceOf(const LogMap& map, const LogMap& other, const Retold& retold) {
  Difference difference;
  const double size = map.r[map.vertices.back()];
  for (int v = 0; v < map.r.size(); ++v) {
    const double r = map.r[v];
    const double r_other = other.r[retold.vertex_of[v]] / retold.scale;
    if (std::isnan(r) && std::isnan(r_other)) continue;
    if (std::isnan(r) || std::isnan(r_other)) {
      const double known = std::isnan(r) ? r_other : r;
      if (known < map.radius * (1.0 - 1e-9)) ++difference.missed;
      continue;
    }
    ++difference.count;
    difference.r = std::max(difference.r, std::abs(r_other - r) / size);
    const double turn =
        std::remainder(other.phi[retold.vertex_of[v]] - map.phi[v], 2.0 * std::numbers::pi);
    difference.phi = std::max(difference.phi, std::abs(turn) * r / size);
  }
  return difference;
}

std::vector<Question> questionsOn(const TriangleMesh& mesh, double radius) {
  std::mt19937 random(3);
  std::vector<Question> questions;
  for (int i = 0; i < 6; ++i) {
    SurfacePoint source{static_cast<int>(random() % static_cast<unsigned>(mesh.faceCount())),
                        {0.2, 0.5, 0.3}};
    if (i % 3 == 1) source.barycentric = {0.0, 0.4, 0.6};
    if (i % 3 == 2) source.barycentric = {0.0, 0.0, 1.0};
    const Eigen::Vector3d normal = normalOf(mesh, source);
    questions.push_back({source,
                         normal.unitOrthogonal() + normal.cross(Eigen::Vector3d(0.2, 0.7, 0.1)),
                         radius});
  }
  return questions;
}

struct Surface {
  std::string name;
  TriangleMesh mesh;
  double radius;
};

/// Smooth, sharp, shipped, and scanned where there are scans.
std::vector<Surface> surfaces() {
  std::vector<Surface> all;
  all.push_back({"sphere", makeSphere(0.05, 4), 0.03});  // all symmetry: full of ties
  all.push_back({"box", makeBox({0.04, 0.06, 0.1}), 0.05});
  all.push_back({"cylinder", makeCylinder(0.02, 0.1, 48), 0.05});
  for (const char* name : {"lemon", "scissors", "wine_glass"}) {
    const auto path = test::sourceDirectory() / "server/models/objects" / name;
    all.push_back({name, io::readMesh(path.string() + ".obj").mesh, 0.02});
  }
  for (const char* scan : {"objects/ycb_16k/014_lemon.stl", "objects/contactdb/mug.stl"}) {
    if (!std::filesystem::exists(test::sharedData(scan))) continue;
    all.push_back({scan, io::readMesh(test::sharedData(scan)).mesh, 0.02});
  }
  return all;
}

class LogMapInvariance : public ::testing::TestWithParam<LogMapMethod> {
 protected:
  /// `retell` tells a mesh and a question otherwise.
  template <class Retell>
  void expectTheSame(const Retell& retell, double tolerance) const {
    int count = 0;
    for (const Surface& surface : surfaces()) {
      for (const Question& question : questionsOn(surface.mesh, surface.radius)) {
        SCOPED_TRACE(surface.name + ", face " + std::to_string(question.source.face));
        const Retold retold = retell(surface.mesh, question);
        const LogMap map = computeLogMap(surface.mesh, question.source, question.direction,
                                         question.radius, GetParam());
        const LogMap other = computeLogMap(retold.mesh, retold.source, retold.direction,
                                           question.radius * retold.scale, GetParam());
        const Difference difference = differenceOf(map, other, retold);
        EXPECT_EQ(map.method, other.method);
        EXPECT_LE(difference.r, tolerance);
        EXPECT_LE(difference.phi, tolerance);
        EXPECT_EQ(difference.missed, 0);
        count += difference.count;
      }
    }
    EXPECT_GT(count, 5000);
  }
};

// Of the disk's radius. Rounding alone is 1e-13; what is left for it to grow by stays far below
// what a tie decided otherwise makes (1e-7 in r, 1e-3 in phi).
constexpr double kRounding = 1e-9;

TEST_P(LogMapInvariance, TurningTheMeshChangesNothing) {
  expectTheSame(rotated, kRounding);
}

TEST_P(LogMapInvariance, TheUnitChangesNothing) {
  for (const double scale : {1e-3, 1e3}) {
    SCOPED_TRACE(scale);
    expectTheSame(
        [&](const TriangleMesh& mesh, const Question& question) {
          return scaled(mesh, question, scale);
        },
        kRounding);
  }
}

TEST_P(LogMapInvariance, TheNumberingChangesNothing) {
  expectTheSame(renumbered, kRounding);
}

INSTANTIATE_TEST_SUITE_P(Methods,
                         LogMapInvariance,
                         ::testing::Values(LogMapMethod::kFast,
                                           LogMapMethod::kExact,
                                           LogMapMethod::kAuto),
                         [](const auto& method) {
                           return std::string(nameOf(method.param));
                         });

// Solves on a triangulation that the flips make their own; its systems amplify rounding.
TEST(SmoothLogMapInvariance, HoldsUpToItsSystems) {
  const TriangleMesh lemon =
      io::readMesh(test::sourceDirectory() / "server/models/objects/lemon.obj").mesh;
  const Question question = questionsOn(lemon, 0.02).front();
  const LogMap map = computeLogMap(lemon, question.source, question.direction, question.radius,
                                   LogMapMethod::kSmooth);
  for (const Retold& retold : {rotated(lemon, question), scaled(lemon, question, 1e-3),
                               scaled(lemon, question, 1e3), renumbered(lemon, question)}) {
    const LogMap other = computeLogMap(retold.mesh, retold.source, retold.direction,
                                       question.radius * retold.scale, LogMapMethod::kSmooth);
    const Difference difference = differenceOf(map, other, retold);
    EXPECT_LE(difference.r, 1e-8);
    EXPECT_LE(difference.phi, 1e-8);
    EXPECT_EQ(difference.missed, 0);
    EXPECT_GT(difference.count, 100);
  }
}

}  // namespace
}  // namespace handgraft::geometry
