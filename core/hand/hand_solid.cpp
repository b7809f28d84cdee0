#include "core/hand/hand_solid.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/parallel_for.h"
#include "core/geometry/sample_thinning.h"
#include "core/hand/kinematics.h"
#include "core/hand/link_facets.h"
#include "core/hand/link_part.h"

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

// A link's own mesh is a solid's if it holds so much of what its skin holds more than
// `kBeneath` beneath itself, and so much of that as deep; that is looked at in so many places
// along each side of its box.
constexpr double kHeldShare = 0.95;
constexpr double kDepthShare = 0.5;
constexpr double kBeneath = 0.001;  // m
constexpr int kLattice = 12;

constexpr double kThinnest = 0.003;  // m; for how far samples stand apart
// m, of fine samples: an object's edge lay 2.6 mm deep between those of a palm, and 0.3 was
// told.
constexpr double kWidest = 0.004;

// m, along edges: where two cross at right angles 1.8 mm deep, 3.6 mm of each is in the other.
// Facets lie 1.5 mm apart there (link_facets).
// A noisy scan is all edges: wider where their samples were more than so many times all
// others'.
constexpr double kAlongEdges = 0.0012;
constexpr double kMostOnEdges = 1.5;

constexpr double kCoarsestGrid = 0.0015;  // m, a cell of the box around a link
constexpr double kMostNodes = 128000.0;

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

geometry::Thinned thinnedAt(double apart, const std::vector<Facet>& facets) {
  Eigen::Matrix3Xd points(3, std::ssize(facets));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) = facets[static_cast<std::size_t>(i)].p_S;
  return geometry::thinOut(points, std::vector<int>(facets.size(), 0), apart);
}

/// Samples of a link: on its faces none within `spacing` of another one, of its facets the
/// first ones stay; along its edges none within `along_edges`, or more where they are many.
SampleSet spread(const std::vector<Facet>& facets, double spacing, double along_edges) {
  const geometry::Thinned even = thinnedAt(spacing, facets);
  std::vector<double> areas(even.kept.size(), 0.0);
  for (std::size_t i = 0; i < facets.size(); ++i)
    areas[static_cast<std::size_t>(even.nearest[i])] += facets[i].area_m2;
  SampleSet set;
  for (std::size_t k = 0; k < even.kept.size(); ++k) {
    const Facet& facet = facets[static_cast<std::size_t>(even.kept[k])];
    if (!facet.is_sharp) set.samples.push_back({facet.p_L, areas[k]});
  }

  std::vector<Facet> sharp;
  for (const Facet& facet : facets)
    if (facet.is_sharp) sharp.push_back(facet);
  const auto most =
      static_cast<std::size_t>(kMostOnEdges * static_cast<double>(even.kept.size()));
  double apart = along_edges;
  geometry::Thinned along = thinnedAt(apart, sharp);
  while (along.kept.size() > most && apart < spacing) {
    apart = std::min(1.25 * apart, spacing);
    along = thinnedAt(apart, sharp);
  }
  // A corner has little area about it, and is the first to be in something.
  for (const int kept : along.kept)
    set.samples.push_back(
        {sharp[static_cast<std::size_t>(kept)].p_L, spacing * apart / kPacking});
  arrange(set);
  return set;
}

/// How far apart samples of each link stand if there are `count` in all: what bulges between
/// two of them is as the square of that by the link's thickness, and the same on all links.
std::vector<double> spacingsOf(const std::vector<double>& areas,
                               const std::vector<double>& thicknesses,
                               int count) {
  double sum = 0.0;
  for (std::size_t i = 0; i < areas.size(); ++i)
    if (areas[i] > 0.0) sum += areas[i] / thicknesses[i];
  std::vector<double> spacings;
  spacings.reserve(thicknesses.size());
  for (const double thickness : thicknesses)
    spacings.push_back(std::sqrt(kPacking * sum / count * thickness));
  return spacings;
}

/// Of what lies around a link's longest axis.
double thicknessOf(const std::vector<Facet>& facets) {
  Eigen::Matrix3Xd points(3, std::ssize(facets));
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) = facets[static_cast<std::size_t>(i)].p_S;
  return geometry::capsuleAround(points).radius;
}

/// A link's own surface in its frame; nothing if it has none.
std::shared_ptr<const geometry::SignedDistance> ownSurface(const Skin& skin,
                                                           int link,
                                                           const Pose& X_SL) {
  const geometry::TriangleMesh* mesh_S = skin.links().surfaceOf(link);
  if (mesh_S == nullptr) return nullptr;
  const Pose X_LS = inverse(X_SL);
  Eigen::Matrix3Xd vertices =
      (X_LS.linear() * mesh_S->vertices()).colwise() + X_LS.translation();
  return std::make_shared<const geometry::SignedDistance>(
      geometry::TriangleMesh(std::move(vertices), mesh_S->faces()));
}

/// Whether one solid has what another one has more than `margin` beneath its surface, and has
/// it as deep, by places on a lattice. Where meshes overlap, walls stand within them: what is
/// near one seems to be near a way out. A knuckle may lack some of its skin and have no walls:
/// that of a hand whose mesh held 97 % stood 1.6 mm in its neighbour, beneath the skin of both.
bool holds(const geometry::SignedDistance& own,
           const geometry::SignedDistance& other,
           double margin) {
  const Eigen::Matrix3Xd& vertices = other.surface().vertices();
  const Vector3d low = vertices.rowwise().minCoeff();
  const Vector3d step = (vertices.rowwise().maxCoeff() - low) / kLattice;
  int inside = 0;
  int held = 0;
  int as_deep = 0;
  for (int i = 0; i < kLattice * kLattice * kLattice; ++i) {
    const Eigen::Array3i cell(i % kLattice, (i / kLattice) % kLattice,
                              i / (kLattice * kLattice));
    const Vector3d p = low + step.cwiseProduct((cell.cast<double>() + 0.5).matrix());
    if (other.isWithin(p, margin) || !other.contains(p)) continue;
    ++inside;
    if (!own.contains(p)) continue;
    ++held;
    if (own.distance(p) > kDepthShare * (other.distance(p) - margin)) ++as_deep;
  }
  return inside > 0 && held >= kHeldShare * inside && as_deep >= kHeldShare * held;
}

/// What bounds a link: its own surface if it is a solid's, else its part of the skin.
struct Bounds {
  std::shared_ptr<const geometry::SignedDistance> exact_L;
  bool is_own = false;
  std::shared_ptr<const geometry::SignedDistance> for_objects_L = nullptr;  ///< if not the same
};

Bounds boundsOf(const Skin& skin,
                int link,
                bool carries_several,
                double skin_offset,
                const Pose& X_SL,
                std::vector<Facet>& facets,
                SolidFindings::OfLink& findings) {
  const geometry::TriangleMesh of_skin = partOf(skin, link, X_SL);
  const auto part = std::make_shared<const geometry::SignedDistance>(of_skin);
  const auto as_of_skin = [&]() -> Bounds {
    const geometry::TriangleMesh domed = withDomesOnCuts(of_skin);
    if (domed.faceCount() == of_skin.faceCount()) return {part, false};  // it is nowhere cut
    return {part, false, std::make_shared<const geometry::SignedDistance>(domed)};
  };
  const double beneath = skin_offset + kBeneath;
  auto own = ownSurface(skin, link, X_SL);
  if (own == nullptr) return as_of_skin();
  if (!holds(*own, *part, beneath)) {
    // A digit's own parts meet where the skin sees them; at a knuckle a wall is the only way
    // out along the digit.
    std::shared_ptr<const geometry::SignedDistance> open;
    if (carries_several) {
      if (findings.outer_faces.empty()) findings.outer_faces = own->outerFaces(0.5 * kHidden);
      open = std::make_shared<const geometry::SignedDistance>(
          own->withOuterFaces(findings.outer_faces));
    }
    if (open == nullptr || !holds(*open, *part, beneath)) {
      addSharp(*own, *part, false, skin_offset + kHidden, link, X_SL, facets);
      return as_of_skin();
    }
    own = open;
  }
  addSharp(*own, *part, true, 0.0, link, X_SL, facets);
  addHidden(*own, *part, link, X_SL, facets);
  return {own, true};
}

void fillSolid(const Bounds& bounds,
               int most_nodes,
               const Progress& progress,
               SolidFindings::OfLink& findings,
               LinkSolid& solid) {
  const auto& outermost = bounds.for_objects_L ? bounds.for_objects_L : bounds.exact_L;
  const Eigen::Matrix3Xd& vertices = outermost->surface().vertices();
  solid.centre_L = 0.5 * (vertices.rowwise().minCoeff() + vertices.rowwise().maxCoeff());
  solid.radius = (vertices.colwise() - solid.centre_L).colwise().norm().maxCoeff();
  solid.capsule_L = geometry::capsuleAround(vertices);
  geometry::DistanceGridOptions options;
  // A large link takes more nodes than most: coarse ones let an apple's stem 1.3 mm into a
  // palm's edge, which they rounded, and told 0.02.
  const Vector3d size = vertices.rowwise().maxCoeff() - vertices.rowwise().minCoeff();
  const double nodes = (size / kCoarsestGrid).array().prod();
  options.most_nodes = std::max(most_nodes, static_cast<int>(std::min(nodes, kMostNodes)));
  const auto grid_of = [&](const std::shared_ptr<const geometry::SignedDistance>& exact,
                           std::vector<float>& values) {
    auto grid = std::make_shared<const geometry::DistanceGrid>(exact, options, progress,
                                                               std::move(values));
    values = grid->values();
    return grid;
  };
  solid.for_links_L = grid_of(bounds.exact_L, findings.for_links);
  solid.grid_L = bounds.for_objects_L ? grid_of(bounds.for_objects_L, findings.for_objects)
                                      : solid.for_links_L;
  const double h = solid.for_links_L->spacing();
  for (const geometry::DistanceGrid::Cell& cell : solid.for_links_L->solidCells()) {
    const double distance = solid.for_links_L->at(cell.p) + solid.skin_offset;
    const double share = std::clamp(0.5 - distance / h, 0.0, 1.0);
    if (share > 0.0) solid.cells_L.push_back({cell.p, share});
  }
}

/// Whether several digits hang on a link, also by way of links that are fixed to it.
bool carriesSeveral(const HandModel& model, int link) {
  const auto node_of = [&](int child) -> const HandModel::Node& {
    return model.nodes()[static_cast<std::size_t>(child - 1)];
  };
  int digits = 0;
  for (const HandModel::Node& node : model.nodes()) {
    if (node.type == JointType::kFixed) continue;
    int carrier = node.parent_link;
    while (carrier != link && carrier > 0 && node_of(carrier).type == JointType::kFixed)
      carrier = node_of(carrier).parent_link;
    digits += carrier == link ? 1 : 0;
  }
  return digits > 1;
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
                     const HandSolidOptions& options,
                     SolidFindings* findings) {
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), skin.qReference(), X_SL);
  std::vector<Facet> facets = facetsOf(skin, X_SL);
  progress.checkpoint();
  projectOntoLinks(skin, X_SL, facets);
  progress.checkpoint();
  const auto link_count = static_cast<std::size_t>(model.linkCount());
  std::vector<double> areas(link_count, 0.0);
  std::vector<double> offsets(link_count, 0.0);
  for (const Facet& facet : facets) {
    areas[static_cast<std::size_t>(facet.link)] += facet.area_m2;
    offsets[static_cast<std::size_t>(facet.link)] += facet.area_m2 * facet.offset;
  }
  for (std::size_t i = 0; i < link_count; ++i)
    offsets[i] = areas[i] > 0.0 ? offsets[i] / areas[i] : 0.0;

  std::vector<std::vector<Facet>> of_links(link_count);
  for (const Facet& facet : facets)
    of_links[static_cast<std::size_t>(facet.link)].push_back(facet);
  std::vector<double> thicknesses(link_count, kThinnest);
  std::vector<Bounds> bounds(link_count);
  SolidFindings unkept;
  std::vector<SolidFindings::OfLink>& found = (findings != nullptr ? *findings : unkept).links;
  found.resize(link_count);
  parallelFor(model.linkCount(), [&](int link) {
    progress.checkpoint();
    const auto i = static_cast<std::size_t>(link);
    if (!(areas[i] > 0.0)) return;
    thicknesses[i] = std::max(kThinnest, thicknessOf(of_links[i]));
    bounds[i] = boundsOf(skin, link, carriesSeveral(model, link), offsets[i], X_SL[i],
                         of_links[i], found[i]);
  });
  const std::vector<double> coarse = spacingsOf(areas, thicknesses, options.coarse_samples);
  const std::vector<double> fine = spacingsOf(areas, thicknesses, options.fine_samples);
  for (std::size_t i = 0; i < link_count; ++i) {
    if (!(areas[i] > 0.0)) continue;
    LinkSolid& solid = links_.emplace_back();
    solid.link = static_cast<int>(i);
    solid.coarse = spread(of_links[i], coarse[i], coarse[i]);
    const double spacing = std::min(kWidest, fine[i]);
    solid.fine = spread(of_links[i], spacing, std::min(kAlongEdges, spacing));
    solid.skin_offset = bounds[i].is_own ? 0.0 : offsets[i];
  }
  parallelFor(static_cast<int>(links_.size()), [&](int k) {
    LinkSolid& solid = links_[static_cast<std::size_t>(k)];
    const auto i = static_cast<std::size_t>(solid.link);
    fillSolid(bounds[i], options.nodes_per_link, progress, found[i], solid);
  });
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
        return b.for_links_L->isClear(X_BA * centre_A, radius);
      },
      [&](const SurfaceSample& sample) {
        depth = std::max(depth, -b.for_links_L->at(X_BA * sample.p_L) - b.skin_offset);
      });
  return depth;
}

}  // namespace handgraft::hand
