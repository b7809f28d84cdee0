#include "core/optimize/avoidance_term.h"

#include "core/base/error.h"

namespace handgraft::optimize {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using hand::LinkSolid;
using hand::SampleSet;
using hand::SurfaceSample;

}  // namespace

AvoidanceTerm::AvoidanceTerm(const Avoidance& avoidance, const MomentTree& tree)
    : avoidance_(avoidance), X_OW_(inverse(avoidance.X_WO)) {
  std::size_t samples = 0;
  for (const LinkSolid& solid : avoidance_.hand->links()) {
    const LinkPlace& place = tree.links.at(static_cast<std::size_t>(solid.link));
    HANDGRAFT_REQUIRE(place.body >= 0);
    bodies_.push_back(place.body);
    X_BL_.push_back(place.X_BL);
    samples += solid.coarse.samples.size();
  }
  places_.resize(bodies_.size());
  touches_.reserve(2 * samples);
}

double AvoidanceTerm::evaluate(const Vector3d& p_WH, const std::vector<BodyPlace>& bodies) {
  touches_.clear();
  const auto& solids = avoidance_.hand->links();
  for (std::size_t k = 0; k < places_.size(); ++k) {
    const BodyPlace& body = bodies[static_cast<std::size_t>(bodies_[k])];
    Place& place = places_[k];
    place.R_WL.noalias() = body.R_WB.lazyProduct(X_BL_[k].linear());
    place.arm_W = body.p_HB_W + body.R_WB.lazyProduct(X_BL_[k].translation());
    place.centre_W = place.arm_W + place.R_WL.lazyProduct(solids[k].centre_L);
    place.a_W = place.arm_W + place.R_WL.lazyProduct(solids[k].capsule_L.a);
    place.b_W = place.arm_W + place.R_WL.lazyProduct(solids[k].capsule_L.b);
  }
  if (care_.share == 0.0) return 0.0;
  chargeObject(p_WH);
  chargeItself();
  double sum = 0.0;
  for (const PenetratingSample& touch : touches_)
    sum += touch.weight * touch.depth * touch.depth;
  return sum;
}

void AvoidanceTerm::chargeObject(const Vector3d& p_WH) {
  const geometry::DistanceGrid& object_O = avoidance_.object_O->grid();
  const auto& solids = avoidance_.hand->links();
  const Matrix3d R_OW = X_OW_.linear();
  const Vector3d p_OH = X_OW_ * p_WH;
  const double margin = avoidance_.margin_m;
  for (std::size_t k = 0; k < places_.size(); ++k) {
    const Place& place = places_[k];
    const LinkSolid& solid = solids[k];
    if (object_O.isClear(p_OH + R_OW * place.centre_W, solid.radius)) continue;
    Pose X_OL;
    X_OL.linear() = R_OW * place.R_WL;
    X_OL.translation() = p_OH + R_OW * place.arm_W;
    const SampleSet& set = samplesOf(solid);
    const Matrix3d R_OL = X_OL.linear();
    const Vector3d p_OL = X_OL.translation();
    set.visit(
        [&](const Vector3d& centre_L, double radius) {
          return object_O.isClear(p_OL + R_OL.lazyProduct(centre_L), radius);
        },
        [&](const SurfaceSample& sample) {
          const Vector3d p_O = p_OL + R_OL.lazyProduct(sample.p_L);
          // Most that are near do not touch: their slopes would be for nothing.
          if (object_O.isClear(p_O, 0.0)) return;
          const double depth = margin - object_O.at(p_O);
          if (depth <= 0.0) return;
          Vector3d slope_O;
          static_cast<void>(object_O.at(p_O, slope_O));
          touches_.push_back({bodies_[k], -1, place.arm_W + place.R_WL * sample.p_L,
                              R_OW.transpose() * slope_O, depth,
                              sample.area_m2 / Avoidance::kPointArea});
        });
    chargeWalls(k, X_OL);
  }
}

void AvoidanceTerm::chargeWalls(std::size_t link, const Pose& X_OL) {
  const Place& place = places_[link];
  const LinkSolid& solid = avoidance_.hand->links()[link];
  const Matrix3d R_LO = X_OL.linear().transpose();
  const Vector3d p_LO = -(R_LO * X_OL.translation());
  avoidance_.object_O->walls().visit(
      [&](const Vector3d& centre_O, double radius) {
        return solid.grid_L->isClear(p_LO + R_LO.lazyProduct(centre_O), radius);
      },
      [&](const geometry::WallSample& sample) {
        const Vector3d p_L = p_LO + R_LO.lazyProduct(sample.p);
        if (solid.grid_L->isClear(p_L, 0.0)) return;
        Vector3d slope_L;
        const double distance = solid.distance(p_L, slope_L) - avoidance_.margin_m;
        if (distance >= 0.0) return;
        // It is the link that moves, and the sample in it the other way.
        touches_.push_back({bodies_[link], -1, place.arm_W + place.R_WL * p_L,
                            -(place.R_WL * slope_L), -distance,
                            sample.area_m2 / Avoidance::kPointArea});
      });
}

void AvoidanceTerm::chargeItself() {
  const auto& solids = avoidance_.hand->links();
  for (const auto& [i, j] : avoidance_.hand->collisionPairs()) {
    const LinkSolid& a = solids[static_cast<std::size_t>(i)];
    const LinkSolid& b = solids[static_cast<std::size_t>(j)];
    const Place& place_a = places_[static_cast<std::size_t>(i)];
    const Place& place_b = places_[static_cast<std::size_t>(j)];
    const double balls = a.radius + b.radius + avoidance_.margin_m;
    if ((place_a.centre_W - place_b.centre_W).squaredNorm() > balls * balls) continue;
    const double bones = a.capsule_L.radius + b.capsule_L.radius + avoidance_.margin_m;
    if (geometry::squaredDistance(place_a.a_W, place_a.b_W, place_b.a_W, place_b.b_W) >
        bones * bones)
      continue;
    charge(i, j);
    charge(j, i);
  }
}

void AvoidanceTerm::charge(int a, int b) {
  const LinkSolid& solid = avoidance_.hand->links()[static_cast<std::size_t>(a)];
  const LinkSolid& other = avoidance_.hand->links()[static_cast<std::size_t>(b)];
  const Place& place = places_[static_cast<std::size_t>(a)];
  const Place& other_place = places_[static_cast<std::size_t>(b)];
  const SampleSet& set = samplesOf(solid);
  const Matrix3d R_BA = other_place.R_WL.transpose().lazyProduct(place.R_WL);
  const Vector3d p_BA =
      other_place.R_WL.transpose().lazyProduct(place.arm_W - other_place.arm_W);
  const geometry::DistanceGrid& grid_B = *other.grid_L;
  set.visit(
      [&](const Vector3d& centre_A, double radius) {
        return grid_B.isClear(p_BA + R_BA.lazyProduct(centre_A), radius + avoidance_.margin_m);
      },
      [&](const SurfaceSample& sample) {
        const Vector3d p_B = p_BA + R_BA.lazyProduct(sample.p_L);
        if (grid_B.isClear(p_B, avoidance_.margin_m)) return;
        const double depth = avoidance_.margin_m - other.distance(p_B);
        if (depth <= 0.0) return;
        Vector3d slope_B;
        static_cast<void>(grid_B.at(p_B, slope_B));
        touches_.push_back({bodies_[static_cast<std::size_t>(a)],
                            bodies_[static_cast<std::size_t>(b)],
                            place.arm_W + place.R_WL * sample.p_L, other_place.R_WL * slope_B,
                            depth, sample.area_m2 / Avoidance::kPointArea});
      });
}

}  // namespace handgraft::optimize
