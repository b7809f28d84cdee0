#include "tests/bench/retargeting/exact_penetration.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/base/content_hash.h"
#include "core/base/progress.h"
#include "core/hand/skin_cache.h"
#include "core/hand/skin_wrap.h"

namespace handgraft::bench {

namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr double kAlpha = 0.0015;  // m; a ball that passes no gap between two plates of a link
constexpr double kOffset = 0.00015;   // m; of the wrap; taken off again
constexpr double kMadeToMeet = 5e-4;  // m
constexpr double kOnePlace = 0.01;    // m

std::string keyOf(const geometry::TriangleMesh& mesh) {
  ContentHash hash;
  hash.add("exact link 1");
  hash.addNumbers(mesh.vertices().data(), static_cast<std::size_t>(mesh.vertices().size()));
  hash.addNumbers(mesh.faces().data(), static_cast<std::size_t>(mesh.faces().size()));
  hash.addNumbers(&kAlpha, 1);
  hash.addNumbers(&kOffset, 1);
  return hash.finish();
}

geometry::TriangleMesh wrapOf(const geometry::TriangleMesh& mesh, const fs::path& cache) {
  const std::string key = keyOf(mesh);
  const fs::path file = cache / ("link_" + key);
  if (std::ifstream in(file, std::ios::binary); in) {
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    if (auto stored = hand::deserialise(bytes, key)) return std::move(stored->mesh_S);
  }
  const geometry::TriangleMesh wrap = hand::wrapped(mesh, kAlpha, kOffset, Progress());
  std::error_code nobody_cares;
  fs::create_directories(cache, nobody_cares);
  std::ofstream(file, std::ios::binary) << hand::serialise({wrap, {}}, key);
  return wrap;
}

geometry::TriangleMesh surfaceOf(const hand::Link& link) {
  std::vector<geometry::TriangleMesh> shapes;
  for (const hand::Shape& shape : link.surface())
    shapes.push_back(shape.mesh_L);
  return geometry::merged(shapes);
}

/// Whether at most one movable joint lies between two links, or several in one place.
bool areJoined(const hand::HandModel& model, const hand::LinkPoses& X_HL, int a, int b) {
  Eigen::AlignedBox3d joints;
  while (a != b) {
    int& child = a > b ? a : b;  // parents come first
    const auto& node = model.nodes()[static_cast<std::size_t>(child - 1)];
    if (node.type != hand::JointType::kFixed)
      joints.extend(X_HL[static_cast<std::size_t>(child)].translation());
    child = node.parent_link;
  }
  return joints.isEmpty() || joints.diagonal().norm() <= kOnePlace;
}

/// Deepest sample of `a` in `b`.
double depthIn(const ExactSolid& a, const ExactSolid& b, const Pose& X_BA) {
  double deepest = 0.0;
  for (const Vector3d& p_A : a.samples())
    deepest = std::max(deepest, b.depth(X_BA * p_A));
  return deepest;
}

bool boxesMeet(const ExactSolid& a, const ExactSolid& b, const Pose& X_BA) {
  // The ball around a's box against b's box.
  const Vector3d centre_B = X_BA * a.box().center();
  return b.box().exteriorDistance(centre_B) <= 0.5 * a.box().diagonal().norm();
}

double depthOfPair(const ExactHand::Link& a,
                   const ExactHand::Link& b,
                   const hand::LinkPoses& X_AL) {
  const Pose X_BA =
      inverse(X_AL[static_cast<std::size_t>(b.link)]) * X_AL[static_cast<std::size_t>(a.link)];
  if (!boxesMeet(*a.solid_L, *b.solid_L, X_BA)) return 0.0;
  return std::max(depthIn(*a.solid_L, *b.solid_L, X_BA),
                  depthIn(*b.solid_L, *a.solid_L, inverse(X_BA)));
}

}  // namespace

ExactHand::ExactHand(std::shared_ptr<const hand::HandModel> model, const fs::path& cache)
    : model_(std::move(model)) {
  for (int i = 0; i < model_->linkCount(); ++i) {
    const geometry::TriangleMesh mesh = surfaceOf(model_->links()[static_cast<std::size_t>(i)]);
    if (mesh.faceCount() == 0) continue;
    Link link;
    link.link = i;
    link.solid_L = std::make_shared<const ExactSolid>(wrapOf(mesh, cache),
                                                      ExactPenetration::kHandSpacing, kOffset);
    link.cells_L = link.solid_L->cells(ExactPenetration::kCell);
    links_.push_back(std::move(link));
  }
  findCollisionPairs();
}

void ExactHand::findCollisionPairs() {
  const hand::LinkPoses X_HL =
      hand::forwardKinematics(*model_, {Pose::Identity(), model_->restPose()});
  for (int i = 0; i < std::ssize(links_); ++i) {
    for (int j = i + 1; j < std::ssize(links_); ++j) {
      const Link& a = links_[static_cast<std::size_t>(i)];
      const Link& b = links_[static_cast<std::size_t>(j)];
      if (areJoined(*model_, X_HL, a.link, b.link)) continue;
      if (depthOfPair(a, b, X_HL) <= kMadeToMeet) collision_pairs_.push_back({i, j});
    }
  }
}

double ExactPenetration::deepest() const {
  return std::max(hand_in_object_m, object_in_hand_m);
}

ExactPenetration measureExactly(const ExactHand& hand,
                                const ExactSolid& object_W,
                                const hand::HandPose& pose) {
  const hand::LinkPoses X_WL = hand::forwardKinematics(hand.model(), pose);
  ExactPenetration result;
  std::size_t cells = 0;
  for (const ExactHand::Link& link : hand.links()) {
    const Pose& X = X_WL[static_cast<std::size_t>(link.link)];
    const Pose X_LW = inverse(X);
    const double before = result.deepest();
    if (boxesMeet(*link.solid_L, object_W, X)) {
      result.hand_in_object_m =
          std::max(result.hand_in_object_m, depthIn(*link.solid_L, object_W, X));
      for (const Vector3d& p_L : link.cells_L)
        cells += object_W.depth(X * p_L) > 0.0 ? 1 : 0;
    }
    if (boxesMeet(object_W, *link.solid_L, X_LW)) {
      result.object_in_hand_m =
          std::max(result.object_in_hand_m, depthIn(object_W, *link.solid_L, X_LW));
    }
    if (result.deepest() > before) result.deepest_link = link.link;
  }
  constexpr double kCellVolume =
      ExactPenetration::kCell * ExactPenetration::kCell * ExactPenetration::kCell;
  result.volume_m3 = static_cast<double>(cells) * kCellVolume;
  for (const auto& [i, j] : hand.collisionPairs()) {
    const ExactHand::Link& a = hand.links()[static_cast<std::size_t>(i)];
    const ExactHand::Link& b = hand.links()[static_cast<std::size_t>(j)];
    const double depth = depthOfPair(a, b, X_WL);
    if (depth <= result.self_m) continue;
    result.self_m = depth;
    result.self_links = {a.link, b.link};
  }
  return result;
}

}  // namespace handgraft::bench
