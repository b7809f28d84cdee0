#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "core/contact/segmentation.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::test {

/// A cup with thin walls, and a recording of a finger that stands in one: its tip touches the
/// wall from within, 40 mm below the rim, and its knuckle the same place from without.
struct CupGrasp {
  static constexpr double kRadius = 0.035;  // m
  static constexpr double kWall = 0.003;    // m
  static constexpr double kHeight = 0.09;   // m
  static constexpr int kAround = 72;

  std::shared_ptr<const geometry::TriangleMesh> mesh = makeCup();
  contact::ContactSet contacts;

  CupGrasp() {
    const double inner = kRadius - kWall;
    for (const auto& [name, x] :
         {std::pair{"thumb_distal", -kRadius}, std::pair{"index_distal", inner},
          std::pair{"index_proximal", kRadius}}) {
      const bool is_within = x == inner;
      contact::ContactMap map;
      map.mesh_O = *mesh;
      map.value.resize(mesh->vertexCount());
      for (int v = 0; v < mesh->vertexCount(); ++v) {
        const Eigen::Vector3d& p = mesh->vertex(v);
        const bool on_side = (std::hypot(p.x(), p.y()) < kRadius - 0.5 * kWall) == is_within;
        const Eigen::Vector3d centre(x, 0.0, 0.05);
        map.value[v] = on_side && (p - centre).norm() < 0.007 ? 1.0 : 0.0;
      }
      contacts.patches.push_back(contact::segment(map, {}).patches.at(0));
      contacts.patches.back().name = name;
    }
  }

 private:
  /// A profile from the bottom's middle without to the bottom's middle within, turned about z.
  static std::shared_ptr<const geometry::TriangleMesh> makeCup() {
    const double inner = kRadius - kWall;
    const std::array<Eigen::Vector2d, 6> corners{
        Eigen::Vector2d(0.0, 0.0),       {kRadius, 0.0}, {kRadius, kHeight},
        Eigen::Vector2d(inner, kHeight), {inner, kWall}, {0.0, kWall}};
    std::vector<Eigen::Vector2d> profile;
    for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
      const int cuts =
          std::max(1, static_cast<int>((corners[i + 1] - corners[i]).norm() / 0.003));
      for (int k = 0; k < cuts; ++k)
        profile.push_back(corners[i] + (corners[i + 1] - corners[i]) * k / cuts);
    }
    profile.erase(profile.begin());  // the middle without is a vertex of its own
    const int rings = static_cast<int>(profile.size());
    Eigen::Matrix3Xd vertices(3, rings * kAround + 2);
    for (int r = 0; r < rings; ++r) {
      for (int k = 0; k < kAround; ++k) {
        const double turn = 2.0 * std::numbers::pi * k / kAround;
        const Eigen::Vector2d& at = profile[static_cast<std::size_t>(r)];
        vertices.col(r * kAround + k) << at.x() * std::cos(turn), at.x() * std::sin(turn),
            at.y();
      }
    }
    const int without = rings * kAround;
    const int within = without + 1;
    vertices.col(without) = Eigen::Vector3d::Zero();
    vertices.col(within) = Eigen::Vector3d(0.0, 0.0, kWall);
    Eigen::Matrix3Xi faces(3, 2 * kAround * rings);
    int f = 0;
    for (int k = 0; k < kAround; ++k) {
      const int next = (k + 1) % kAround;
      faces.col(f++) << without, next, k;
      for (int r = 0; r + 1 < rings; ++r) {
        const int below = r * kAround;
        const int above = below + kAround;
        faces.col(f++) << below + k, below + next, above + next;
        faces.col(f++) << below + k, above + next, above + k;
      }
      const int last = (rings - 1) * kAround;
      faces.col(f++) << last + k, last + next, within;
    }
    return std::make_shared<const geometry::TriangleMesh>(std::move(vertices),
                                                          std::move(faces));
  }
};

}  // namespace handgraft::test
