#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "core/hand/kinematics.h"
#include "core/hand/skin.h"

namespace handgraft::hand {

namespace {

/// Gaps wider than this stay open in the wrap; more distance gains nothing.
constexpr double kWantedGap = 0.010;  // m
constexpr int kSamplesPerLink = 40;
constexpr int kSweeps = 2;
/// Fingers stay nearly straight: strong bends crease the skin.
constexpr double kWidestMove = 0.35;  // rad
/// What leaving the rest position by the joint's whole range costs, against a squared share of
/// the wanted gap per sample: only real crowding is worth moving a joint.
constexpr double kRestWeight = 0.5;

/// A link's surface as a few points, even in area.
struct Cloud {
  int link = 0;
  Eigen::Matrix3Xd points_L;
};

/// `count` points spread evenly over the area of a link: the golden-ratio sequence picks faces
/// by area, so large flat faces get their share; no random numbers.
Eigen::Matrix3Xd sampleLink(const Link& link, int count) {
  std::vector<const geometry::TriangleMesh*> meshes;
  std::vector<std::pair<int, int>> faces;
  std::vector<double> area_sums;
  double total = 0.0;
  for (const Shape& shape : link.surface()) {
    const geometry::TriangleMesh& mesh = shape.mesh_L;
    for (int f = 0; f < mesh.faceCount(); ++f) {
      const Eigen::Vector3i corners = mesh.face(f);
      total += 0.5 * (mesh.vertex(corners[1]) - mesh.vertex(corners[0]))
                         .cross(mesh.vertex(corners[2]) - mesh.vertex(corners[0]))
                         .norm();
      faces.emplace_back(static_cast<int>(meshes.size()), f);
      area_sums.push_back(total);
    }
    meshes.push_back(&mesh);
  }
  if (!(total > 0.0)) return Eigen::Matrix3Xd(3, 0);

  const auto fraction = [](double x) {
    return x - std::floor(x);
  };
  Eigen::Matrix3Xd points(3, count);
  for (int i = 0; i < count; ++i) {
    const double target = (i + 0.5) / count * total;
    const auto found = std::lower_bound(area_sums.begin(), area_sums.end(), target);
    const auto index = static_cast<std::size_t>(std::min<std::ptrdiff_t>(
        found - area_sums.begin(), static_cast<std::ptrdiff_t>(faces.size()) - 1));
    const geometry::TriangleMesh& mesh = *meshes[static_cast<std::size_t>(faces[index].first)];
    const Eigen::Vector3i corners = mesh.face(faces[index].second);
    double u = fraction(0.7548776662466927 * (i + 1));
    double v = fraction(0.5698402909980532 * (i + 1));
    if (u + v > 1.0) {
      u = 1.0 - u;
      v = 1.0 - v;
    }
    points.col(i) = (1.0 - u - v) * mesh.vertex(corners[0]) + u * mesh.vertex(corners[1]) +
                    v * mesh.vertex(corners[2]);
  }
  return points;
}

/// How crowded the links stand at a pose. Links that touch by construction, a link and the one
/// that carries it, are not compared.
class Crowding {
 public:
  explicit Crowding(const HandModel& model) : model_(model) {
    for (int link = 0; link < model.linkCount(); ++link) {
      Eigen::Matrix3Xd points =
          sampleLink(model.links()[static_cast<std::size_t>(link)], kSamplesPerLink);
      if (points.cols() > 0) clouds_.push_back({link, std::move(points)});
    }
    for (std::size_t a = 0; a < clouds_.size(); ++a)
      for (std::size_t b = a + 1; b < clouds_.size(); ++b)
        if (!areNeighbours(clouds_[a].link, clouds_[b].link)) pairs_.emplace_back(a, b);
  }

  double at(const Eigen::VectorXd& q) {
    forwardKinematics(model_, Pose::Identity(), q, X_HL_);
    points_H_.resize(clouds_.size());
    boxes_.resize(clouds_.size());
    for (std::size_t i = 0; i < clouds_.size(); ++i) {
      points_H_[i] = X_HL_[static_cast<std::size_t>(clouds_[i].link)] * clouds_[i].points_L;
      boxes_[i] = Eigen::AlignedBox3d(points_H_[i].rowwise().minCoeff(),
                                      points_H_[i].rowwise().maxCoeff());
    }
    double sum = 0.0;
    for (const auto& [a, b] : pairs_) {
      if (boxes_[a].exteriorDistance(boxes_[b]) >= kWantedGap) continue;
      for (Eigen::Index i = 0; i < points_H_[a].cols(); ++i) {
        const double nearest = std::sqrt(
            (points_H_[b].colwise() - points_H_[a].col(i)).colwise().squaredNorm().minCoeff());
        const double lack = std::max(0.0, 1.0 - nearest / kWantedGap);
        sum += lack * lack;
      }
    }
    return sum;
  }

 private:
  [[nodiscard]] bool areNeighbours(int a, int b) const {
    // Links without a surface (joint centres) do not separate what they connect.
    const auto carrier = [&](int link) {
      do {
        if (link == 0) return -1;
        link = model_.nodes()[static_cast<std::size_t>(link - 1)].parent_link;
      } while (model_.links()[static_cast<std::size_t>(link)].surface().empty());
      return link;
    };
    return carrier(a) == b || carrier(b) == a;
  }

  const HandModel& model_;
  std::vector<Cloud> clouds_;
  std::vector<std::pair<std::size_t, std::size_t>> pairs_;
  LinkPoses X_HL_;
  std::vector<Eigen::Matrix3Xd> points_H_;
  std::vector<Eigen::AlignedBox3d> boxes_;
};

}  // namespace

Eigen::VectorXd skinReferencePose(const HandModel& model) {
  // A rest pose that somebody chose must not make another skin.
  const Eigen::VectorXd rest = model.zeroPose();
  Eigen::VectorXd q = rest;
  Crowding crowding(model);

  // Coordinate descent over a few values per joint. Exactly repeatable, and good enough: the
  // wrap needs gaps, not the widest ones.
  const auto cost_of = [&](const Eigen::VectorXd& candidate) {
    double cost = crowding.at(candidate);
    for (int i = 0; i < model.dofCount(); ++i) {
      const double range = std::min(model.upper()[i] - model.lower()[i], 2.0);
      if (range > 0.0) cost += kRestWeight * std::pow((candidate[i] - rest[i]) / range, 2);
    }
    return cost;
  };
  double best = cost_of(q);
  for (int sweep = 0; sweep < kSweeps && best > 0.0; ++sweep) {
    for (int i = 0; i < model.dofCount(); ++i) {
      // Jaws that slide are apart by their whole way; at rest they may touch.
      const double widest = model.dofJoint(i).type == JointType::kRevolute
                                ? kWidestMove
                                : std::numeric_limits<double>::max();
      const double lower = std::max(model.lower()[i], rest[i] - widest);
      const double upper = std::min(model.upper()[i], rest[i] + widest);
      if (!(lower < upper) || !std::isfinite(upper - lower)) continue;
      const double before = q[i];
      double best_value = before;
      for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        Eigen::VectorXd candidate = q;
        candidate[i] = lower + share * (upper - lower);
        const double cost = cost_of(candidate);
        if (cost < best) {
          best = cost;
          best_value = candidate[i];
        }
      }
      q[i] = best_value;
    }
  }
  return q;
}

}  // namespace handgraft::hand
