// Contact is face to face, so a patch on the hand is the mirror image of the patch
// on the object. An L between two planes tells the two apart.
#include <complex>

#include <gtest/gtest.h>

#include "core/contact/patch.h"
#include "core/optimize/solver.h"
#include "core/transfer/patch_transfer.h"

#include "tests/support/plate_hand.h"
#include "tests/support/plates.h"

namespace handgraft::transfer {
namespace {

using Complex = std::complex<double>;

constexpr int kCells = 40;
constexpr double kStep = 0.001;

int vertexAtCell(int i, int j) {
  return (j + kCells / 2) * (kCells + 1) + i + kCells / 2;
}

/// An L of 6 x 18 mm and 14 x 6 mm on a plate, its root in the corner.
contact::Patch lShape(const geometry::TriangleMesh& plate) {
  const std::vector<std::pair<int, int>> corners = {{-3, -3}, {14, -3}, {14, 3},
                                                    {3, 3},   {3, 15},  {-3, 15}};
  contact::Patch patch;
  patch.name = "thumb";
  patch.root = surfacePointAtVertex(plate, vertexAtCell(0, 0));
  patch.direction_O = Eigen::Vector3d(1.0, 0.4, 0.0);
  for (std::size_t k = 0; k < corners.size(); ++k) {
    auto [i, j] = corners[k];
    const auto [i_end, j_end] = corners[(k + 1) % corners.size()];
    while (i != i_end || j != j_end) {
      patch.boundary.push_back(vertexAtCell(i, j));
      i += (i_end > i) - (i_end < i);
      j += (j_end > j) - (j_end < j);
    }
  }
  patch.interpolation_boundary = contact::sampleLoop(plate, patch.boundary);
  return patch;
}

struct LBetweenPlanes {
  geometry::TriangleMesh plate = test::makePlate(kCells, kCells, kStep);
  std::shared_ptr<const hand::HandModel> model = test::makeRigidHand(plate);
  hand::Skin skin = test::makeRigidSkin(*model, plate);
  PatchTransfer transfer;

  LBetweenPlanes() {
    const PatchPlacement placement = {surfacePointAtVertex(plate, vertexAtCell(2, -1)),
                                      Eigen::Vector3d(-0.2, 1.0, 0.0)};
    transfer = transferPatch(plate, lShape(plate), skin, placement);
  }
};

/// Smallest sum of squared distances that a rigid motion reaches which turns the hand's plane
/// face to face with the object's: then the hand's plane is seen from behind, z -> conj(z), and
/// a rotation and a shift in the plane remain.
double faceToFaceResidual(const std::vector<Complex>& object,
                          const std::vector<Complex>& hand) {
  const auto count = static_cast<double>(object.size());
  Complex object_mean = 0.0;
  Complex hand_mean = 0.0;
  for (std::size_t i = 0; i < object.size(); ++i) {
    object_mean += object[i] / count;
    hand_mean += std::conj(hand[i]) / count;
  }
  double squares = 0.0;
  Complex product = 0.0;
  for (std::size_t i = 0; i < object.size(); ++i) {
    const Complex o = object[i] - object_mean;
    const Complex h = std::conj(hand[i]) - hand_mean;
    squares += std::norm(o) + std::norm(h);
    product += o * std::conj(h);
  }
  return squares - 2.0 * std::abs(product);
}

TEST(PatchTransfer, LShapeMeetsItselfFaceToFaceOnlyWhenMirrored) {
  const LBetweenPlanes l;
  ASSERT_EQ(l.transfer.correspondences.size(), 25u);
  std::vector<Complex> object;
  std::vector<Complex> hand;
  std::vector<Complex> unmirrored;
  const Complex along = std::polar(1.0, std::atan2(1.0, -0.2));  // the direction on the hand
  const Complex root(2 * kStep, -1 * kStep);
  for (const Correspondence& pair : l.transfer.correspondences) {
    object.emplace_back(pair.p_O.x(), pair.p_O.y());
    hand.emplace_back(pair.p_L.x(), pair.p_L.y());
    unmirrored.push_back(root + along * std::conj((hand.back() - root) / along));
  }
  EXPECT_NEAR(faceToFaceResidual(object, hand), 0.0, 1e-15);
  EXPECT_GT(faceToFaceResidual(object, unmirrored), 1e-4);  // 2 mm a point
}

TEST(PatchTransfer, LShapeBetweenPlanesIsSolvedToNothing) {
  const LBetweenPlanes l;
  Pose X_WO = Pose::Identity();
  X_WO.linear() = rotationFromVector({0.7, -1.9, 0.4});
  X_WO.translation() << 0.2, -0.1, 0.5;

  optimize::PoseProblem problem = optimize::makeProblem(l.model);
  problem.weights.prior = 0.0;
  for (const Correspondence& pair : l.transfer.correspondences) {
    problem.pairs.push_back({pair.link, pair.p_L, pair.n_L, X_WO * pair.p_O,
                             X_WO.linear() * pair.n_O, pair.weight, 0});
  }
  const optimize::SolveReport report = optimize::solve(problem, {}, Progress());
  EXPECT_LT(report.terms.distance, 1e-10);
  EXPECT_LT(report.terms.normal, 1e-10);
}

}  // namespace
}  // namespace handgraft::transfer
