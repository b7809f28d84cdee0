#include "core/optimize/avoidance_term.h"

#include <algorithm>

#include "core/base/error.h"

namespace handgraft::optimize {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using hand::LinkSolid;
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
  if (level_.share == 0.0) return 0.0;
  near_.startFor({avoidance_.hand, avoidance_.object_O, avoidance_.margin_m,
                  avoidance_.self_margin_m, level_.fine});
  near_.in_object.resize(places_.size());
  near_.of_walls.resize(places_.size());
  near_.of_pairs.resize(avoidance_.hand->collisionPairs().size());
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
  for (std::size_t k = 0; k < places_.size(); ++k) {
    const Place& place = places_[k];
    const LinkSolid& solid = solids[k];
    const Vector3d centre_O = p_OH + R_OW * place.centre_W;
    if (object_O.isClear(centre_O, solid.radius)) continue;
    Pose X_OL;
    X_OL.linear() = R_OW * place.R_WL;
    X_OL.translation() = p_OH + R_OW * place.arm_W;
    near_.in_object[k].visit(
        {object_O, avoidance_.margin_m, solid.centre_L, solid.radius}, X_OL,
        [&](const auto& passes, const auto& take) {
          samplesOf(solid).visit(passes, [&](const SurfaceSample& sample) {
            take(sample.p_L, sample.area_m2);
          });
        },
        [&](const NearSamples::Sample& sample, const Vector3d&, double distance,
            const Vector3d& slope_O) {
          touches_.push_back({bodies_[k], -1, place.arm_W + place.R_WL * sample.p_A,
                              R_OW.transpose() * slope_O, avoidance_.margin_m - distance,
                              sample.area_m2 / Avoidance::kPointArea});
        });
    chargeWalls(k, X_OL, centre_O);
  }
}

void AvoidanceTerm::chargeWalls(std::size_t link, const Pose& X_OL, const Vector3d& centre_O) {
  const Place& place = places_[link];
  const LinkSolid& solid = avoidance_.hand->links()[link];
  const Pose X_LO = inverse(X_OL);
  // What of the walls is in the link lies in the link's ball, wherever that was in the object.
  near_.of_walls[link].visit(
      {*solid.grid_L, avoidance_.margin_m - solid.skin_offset, centre_O,
       solid.radius + solid.grid_L->spacing()},
      X_LO,
      [&](const auto& passes, const auto& take) {
        avoidance_.object_O->walls().visit(passes, [&](const geometry::WallSample& sample) {
          take(sample.p, sample.area_m2);
        });
      },
      [&](const NearSamples::Sample& sample, const Vector3d& p_L, double distance,
          const Vector3d& slope_L) {
        // It is the link that moves, and the sample in it the other way.
        touches_.push_back({bodies_[link], -1, place.arm_W + place.R_WL * p_L,
                            -(place.R_WL * slope_L),
                            avoidance_.margin_m - (distance + solid.skin_offset),
                            sample.area_m2 / Avoidance::kPointArea});
      });
}

void AvoidanceTerm::chargeItself() {
  const auto& solids = avoidance_.hand->links();
  const auto& pairs = avoidance_.hand->collisionPairs();
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto& [i, j] = pairs[k];
    const LinkSolid& a = solids[static_cast<std::size_t>(i)];
    const LinkSolid& b = solids[static_cast<std::size_t>(j)];
    const Place& place_a = places_[static_cast<std::size_t>(i)];
    const Place& place_b = places_[static_cast<std::size_t>(j)];
    const double balls = a.radius + b.radius + avoidance_.self_margin_m;
    if ((place_a.centre_W - place_b.centre_W).squaredNorm() > balls * balls) continue;
    const double bones = a.capsule_L.radius + b.capsule_L.radius + avoidance_.self_margin_m;
    if (geometry::squaredDistance(place_a.a_W, place_a.b_W, place_b.a_W, place_b.b_W) >
        bones * bones)
      continue;
    if (near_.of_pairs[k] == nullptr)
      near_.of_pairs[k] = std::make_unique<std::array<NearSamples, 2>>();
    charge(i, j, (*near_.of_pairs[k])[0]);
    charge(j, i, (*near_.of_pairs[k])[1]);
  }
}

void AvoidanceTerm::charge(int a, int b, NearSamples& near) {
  const LinkSolid& solid = avoidance_.hand->links()[static_cast<std::size_t>(a)];
  const LinkSolid& other = avoidance_.hand->links()[static_cast<std::size_t>(b)];
  const Place& place = places_[static_cast<std::size_t>(a)];
  const Place& other_place = places_[static_cast<std::size_t>(b)];
  Pose X_BA;
  X_BA.linear() = other_place.R_WL.transpose().lazyProduct(place.R_WL);
  X_BA.translation() =
      other_place.R_WL.transpose().lazyProduct(place.arm_W - other_place.arm_W);
  // What touches lies in the balls of both.
  const bool is_smaller = solid.radius < other.radius;
  const Vector3d centre_A =
      is_smaller ? solid.centre_L
                 : Vector3d(place.R_WL.transpose() * (other_place.centre_W - place.arm_W));
  near.visit(
      {*other.for_links_L, avoidance_.self_margin_m - other.skin_offset, centre_A,
       std::min(solid.radius, other.radius) + other.for_links_L->spacing()},
      X_BA,
      [&](const auto& passes, const auto& take) {
        samplesOf(solid).visit(passes, [&](const SurfaceSample& sample) {
          take(sample.p_L, sample.area_m2);
        });
      },
      [&](const NearSamples::Sample& sample, const Vector3d&, double distance,
          const Vector3d& slope_B) {
        touches_.push_back({bodies_[static_cast<std::size_t>(a)],
                            bodies_[static_cast<std::size_t>(b)],
                            place.arm_W + place.R_WL * sample.p_A, other_place.R_WL * slope_B,
                            avoidance_.self_margin_m - (distance + other.skin_offset),
                            sample.area_m2 / Avoidance::kPointArea});
      });
}

}  // namespace handgraft::optimize
