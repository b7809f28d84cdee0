#include "core/hand/hand_solid.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/sample_thinning.h"
#include "core/hand/kinematics.h"

namespace handgraft::hand {

namespace {

using Eigen::Vector3d;

// Deeper than this at rest, two links are made to stand in each other.
constexpr double kTouch = 5e-4;  // m

// Joints no further apart make one: the axes of a thumb's base, of a knuckle. What they join
// overlaps where it was cut, whatever small link lies between.
constexpr double kOnePlace = 0.01;  // m

// Random packings with a least distance r hold about 0.8 points an area of r^2.
constexpr double kPacking = 0.8;

/// A face of the skin, as its link has it.
struct Facet {
  int link = -1;
  Vector3d p_S = Vector3d::Zero();
  Vector3d p_L = Vector3d::Zero();
  double area_m2 = 0.0;
  double offset = 0.0;  ///< of the skin above the link
};

std::vector<Facet> facetsOf(const Skin& skin, const LinkPoses& X_SL) {
  const geometry::TriangleMesh& mesh_S = skin.mesh();
  std::vector<Facet> facets;
  for (int f = 0; f < mesh_S.faceCount(); ++f) {
    const int link = skin.faceLinks()[static_cast<std::size_t>(f)];
    if (link < 0) continue;
    const Eigen::Vector3i face = mesh_S.face(f);
    const Vector3d a = mesh_S.vertex(face[0]);
    const Vector3d b = mesh_S.vertex(face[1]);
    const Vector3d c = mesh_S.vertex(face[2]);
    Facet facet;
    facet.link = link;
    facet.p_S = (a + b + c) / 3.0;
    facet.p_L = inverse(X_SL[static_cast<std::size_t>(link)]) * facet.p_S;
    facet.area_m2 = 0.5 * (b - a).cross(c - a).norm();
    facets.push_back(facet);
  }
  return facets;
}

/// Moves facets onto their links' own surfaces, where those are beneath the skin.
void project(const Skin& skin, const LinkPoses& X_SL, std::vector<Facet>& facets) {
  for (Facet& facet : facets) {
    const auto hit = skin.links().nearestOf(facet.link, facet.p_S, skin.epsilon());
    if (!hit) continue;
    facet.p_L = inverse(X_SL[static_cast<std::size_t>(facet.link)]) * hit->position_S;
    facet.offset = hit->distance_m;
  }
}

/// Lays balls around the samples.
void arrange(SampleSet& set) {
  Eigen::Matrix3Xd points(3, std::ssize(set.samples));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) = set.samples[static_cast<std::size_t>(i)].p_L;
  std::vector<int> order;
  set.tree_L = geometry::BallTree(points, order);
  const std::vector<SurfaceSample> before = set.samples;
  for (std::size_t i = 0; i < order.size(); ++i)
    set.samples[i] = before[static_cast<std::size_t>(order[i])];
}

/// About `count` samples of the hand, by link.
std::vector<SampleSet> spread(const std::vector<Facet>& facets, int links, int count) {
  Eigen::Matrix3Xd points(3, std::ssize(facets));
  std::vector<int> groups;
  double area = 0.0;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Facet& facet = facets[static_cast<std::size_t>(i)];
    points.col(i) = facet.p_S;
    groups.push_back(facet.link);
    area += facet.area_m2;
  }
  std::vector<SampleSet> sets(static_cast<std::size_t>(links));
  if (!(area > 0.0)) return sets;
  const geometry::Thinned thinned =
      geometry::thinOut(points, groups, std::sqrt(kPacking * area / count));
  std::vector<double> areas(thinned.kept.size(), 0.0);
  for (std::size_t i = 0; i < facets.size(); ++i)
    areas[static_cast<std::size_t>(thinned.nearest[i])] += facets[i].area_m2;
  for (std::size_t k = 0; k < thinned.kept.size(); ++k) {
    const Facet& facet = facets[static_cast<std::size_t>(thinned.kept[k])];
    sets[static_cast<std::size_t>(facet.link)].samples.push_back({facet.p_L, areas[k]});
  }
  for (SampleSet& set : sets)
    arrange(set);
  return sets;
}

/// The part of the skin that belongs to a link, in its frame.
geometry::TriangleMesh partOf(const Skin& skin, int link, const Pose& X_SL) {
  const geometry::TriangleMesh& mesh_S = skin.mesh();
  std::vector<int> numbers(static_cast<std::size_t>(mesh_S.vertexCount()), -1);
  std::vector<Vector3d> vertices;
  std::vector<Eigen::Vector3i> faces;
  for (int f = 0; f < mesh_S.faceCount(); ++f) {
    if (skin.faceLinks()[static_cast<std::size_t>(f)] != link) continue;
    Eigen::Vector3i face = mesh_S.face(f);
    for (int& v : face) {
      int& number = numbers[static_cast<std::size_t>(v)];
      if (number < 0) {
        number = static_cast<int>(vertices.size());
        vertices.push_back(inverse(X_SL) * mesh_S.vertex(v));
      }
      v = number;
    }
    faces.push_back(face);
  }
  Eigen::Matrix3Xd columns(3, std::ssize(vertices));
  for (Eigen::Index i = 0; i < columns.cols(); ++i)
    columns.col(i) = vertices[static_cast<std::size_t>(i)];
  Eigen::Matrix3Xi triples(3, std::ssize(faces));
  for (Eigen::Index i = 0; i < triples.cols(); ++i)
    triples.col(i) = faces[static_cast<std::size_t>(i)];
  return {std::move(columns), std::move(triples)};
}

void fillSolid(const Skin& skin,
               const Pose& X_SL,
               int most_nodes,
               const Progress& progress,
               LinkSolid& solid) {
  auto exact = std::make_shared<const geometry::SignedDistance>(partOf(skin, solid.link, X_SL));
  const Eigen::Matrix3Xd& vertices = exact->surface().vertices();
  solid.centre_L = 0.5 * (vertices.rowwise().minCoeff() + vertices.rowwise().maxCoeff());
  solid.radius = (vertices.colwise() - solid.centre_L).colwise().norm().maxCoeff();
  solid.capsule_L = geometry::capsuleAround(vertices);
  geometry::DistanceGridOptions options;
  options.most_nodes = most_nodes;
  solid.grid_L =
      std::make_unique<const geometry::DistanceGrid>(std::move(exact), options, progress);
  const double h = solid.grid_L->spacing();
  for (const geometry::DistanceGrid::Cell& cell : solid.grid_L->solidCells()) {
    const double share = std::clamp(0.5 - solid.distance(cell.p) / h, 0.0, 1.0);
    if (share > 0.0) solid.cells_L.push_back({cell.p, share});
  }
}

/// Whether a link hangs on another one: by one movable joint, none, or several in nearly one
/// place. `X_HL`: at rest.
bool areJoined(const HandModel& model, const LinkPoses& X_HL, int a, int b) {
  Eigen::AlignedBox3d joints_H;
  // Parents come before children: the later of the two is never above the other.
  while (a != b) {
    int& later = a > b ? a : b;
    const HandModel::Node& node = model.nodes()[static_cast<std::size_t>(later - 1)];
    if (node.type != JointType::kFixed)
      joints_H.extend(X_HL[static_cast<std::size_t>(later)].translation());
    later = node.parent_link;
  }
  return joints_H.isEmpty() || joints_H.diagonal().norm() <= kOnePlace;
}

}  // namespace

HandSolid::HandSolid(const HandModel& model,
                     const Skin& skin,
                     const Progress& progress,
                     const HandSolidOptions& options) {
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skin.qReference(), X_SL);
  std::vector<Facet> facets = facetsOf(skin, X_SL);
  progress.checkpoint();
  project(skin, X_SL, facets);
  progress.checkpoint();
  std::vector<SampleSet> coarse = spread(facets, model.linkCount(), options.coarse_samples);
  std::vector<SampleSet> fine = spread(facets, model.linkCount(), options.fine_samples);
  for (int link = 0; link < model.linkCount(); ++link) {
    const auto index = static_cast<std::size_t>(link);
    if (coarse[index].samples.empty()) continue;
    LinkSolid solid;
    solid.link = link;
    solid.coarse = std::move(coarse[index]);
    solid.fine = std::move(fine[index]);
    double area = 0.0;
    for (const Facet& facet : facets) {
      if (facet.link != link) continue;
      solid.skin_offset += facet.area_m2 * facet.offset;
      area += facet.area_m2;
    }
    if (area > 0.0) solid.skin_offset /= area;
    fillSolid(skin, X_SL[index], options.nodes_per_link, progress, solid);
    links_.push_back(std::move(solid));
  }
  findCollisionPairs(model);
}

void HandSolid::findCollisionPairs(const HandModel& model) {
  LinkPoses X_HL;
  forwardKinematics(model, Pose::Identity(), model.restPose(), X_HL);
  const int count = static_cast<int>(links_.size());
  for (int i = 0; i < count; ++i) {
    for (int j = i + 1; j < count; ++j) {
      const LinkSolid& a = links_[static_cast<std::size_t>(i)];
      const LinkSolid& b = links_[static_cast<std::size_t>(j)];
      if (areJoined(model, X_HL, a.link, b.link)) continue;
      const Pose X_BA = inverse(X_HL[static_cast<std::size_t>(b.link)]) *
                        X_HL[static_cast<std::size_t>(a.link)];
      if (depthOf(a, b, X_BA) > kTouch || depthOf(b, a, inverse(X_BA)) > kTouch) continue;
      collision_pairs_.push_back({i, j});
    }
  }
}

double depthOf(const LinkSolid& a, const LinkSolid& b, const Pose& X_BA) {
  double depth = 0.0;
  if ((X_BA * a.centre_L - b.centre_L).norm() > a.radius + b.radius) return depth;
  a.fine.visit(
      [&](const Vector3d& centre_A, double radius) {
        return b.grid_L->isClear(X_BA * centre_A, radius);
      },
      [&](const SurfaceSample& sample) {
        depth = std::max(depth, -b.distance(X_BA * sample.p_L));
      });
  return depth;
}

}  // namespace handgraft::hand
