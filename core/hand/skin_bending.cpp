#include "core/hand/skin_bending.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <Eigen/SVD>

#include "core/base/error.h"
#include "core/hand/kinematics.h"

namespace handgraft::hand {

namespace {

/// Rounds of averaging over neighbours: a border between links becomes a band of about 7 mm on
/// either side at the usual edge of 2.5 mm.
constexpr int kBlendingRounds = 8;

/// The vertices that share an edge with each one.
std::vector<std::vector<int>> neighboursOf(const geometry::TriangleMesh& mesh) {
  std::vector<std::vector<int>> neighbours(static_cast<std::size_t>(mesh.vertexCount()));
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    auto& mine = neighbours[static_cast<std::size_t>(v)];
    for (const int* h = mesh.outgoingBegin(v); h != mesh.outgoingEnd(v); ++h) {
      mine.push_back(mesh.to(*h));
      mine.push_back(mesh.from(geometry::TriangleMesh::previous(*h)));
    }
    std::sort(mine.begin(), mine.end());
    mine.erase(std::unique(mine.begin(), mine.end()), mine.end());
  }
  return neighbours;
}

/// Shares of the links of the faces around each vertex; zero where these are of no link.
Eigen::MatrixXf sharesOfFaces(const Skin& skin, int link_count) {
  const geometry::TriangleMesh& mesh = skin.mesh();
  Eigen::MatrixXf shares = Eigen::MatrixXf::Zero(link_count, mesh.vertexCount());
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const int link = skin.faceLinks()[static_cast<std::size_t>(f)];
    if (link < 0) continue;
    for (int c = 0; c < 3; ++c)
      shares(link, mesh.face(f)[c]) += 1.0F;
  }
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    const float sum = shares.col(v).sum();
    if (sum > 0.0F) shares.col(v) /= sum;
  }
  return shares;
}

/// Spreads the shares over vertices that have none, ring by ring from those that do.
void fill(const std::vector<std::vector<int>>& neighbours, Eigen::MatrixXf& shares) {
  std::vector<int> empty;
  for (int v = 0; v < shares.cols(); ++v)
    if (shares.col(v).isZero()) empty.push_back(v);
  while (!empty.empty()) {
    std::vector<int> left;
    std::vector<std::pair<int, Eigen::VectorXf>> filled;
    for (const int v : empty) {
      Eigen::VectorXf sum = Eigen::VectorXf::Zero(shares.rows());
      for (const int other : neighbours[static_cast<std::size_t>(v)])
        sum += shares.col(other);
      if (sum.isZero()) {
        left.push_back(v);
      } else {
        filled.emplace_back(v, sum / sum.sum());
      }
    }
    for (const auto& [v, column] : filled)
      shares.col(v) = column;
    if (filled.empty()) break;  // a piece that is of no link at all
    empty = std::move(left);
  }
  for (const int v : empty)
    shares(0, v) = 1.0F;  // it goes with the root
}

void blend(const std::vector<std::vector<int>>& neighbours, Eigen::MatrixXf& shares) {
  Eigen::MatrixXf next(shares.rows(), shares.cols());
  for (int round = 0; round < kBlendingRounds; ++round) {
    for (int v = 0; v < shares.cols(); ++v) {
      const auto& around = neighbours[static_cast<std::size_t>(v)];
      next.col(v) = shares.col(v);
      for (const int other : around)
        next.col(v) += shares.col(other);
      next.col(v) /= 1.0F + static_cast<float>(around.size());
    }
    shares.swap(next);
  }
}

}  // namespace

SkinBending::SkinBending(std::shared_ptr<const HandModel> model,
                         std::shared_ptr<const Skin> skin)
    : model_(std::move(model)), skin_(std::move(skin)) {
  const auto neighbours = neighboursOf(skin_->mesh());
  weights_ = sharesOfFaces(*skin_, model_->linkCount());
  fill(neighbours, weights_);
  blend(neighbours, weights_);
}

std::shared_ptr<const Skin> SkinBending::bent(const HandVariant& variant) const {
  if (!variant.shape_changed) return skin_;
  HANDGRAFT_REQUIRE(variant.model.linkCount() == model_->linkCount());
  const Eigen::VectorXd q = skin_->qReference().cwiseProduct(variant.joint_scale);
  LinkPoses X_SL;
  forwardKinematics(*model_, Pose::Identity(), skin_->qReference(), X_SL);
  LinkPoses X_SV;
  forwardKinematics(variant.model, Pose::Identity(), q, X_SV);

  // === Where each link takes the place that it has on the original
  const auto count = static_cast<std::size_t>(model_->linkCount());
  std::vector<Eigen::Matrix3d> A(count);
  std::vector<Eigen::Vector3d> shift(count);
  double most_stretch = 0.0;
  for (std::size_t link = 0; link < count; ++link) {
    const Eigen::Matrix3d& stretch = variant.stretch_L[link];
    const Pose X_LS = inverse(X_SL[link]);
    A[link] = X_SV[link].linear() * stretch * X_LS.linear();
    shift[link] =
        X_SV[link].linear() * (stretch * X_LS.translation()) + X_SV[link].translation();
    most_stretch =
        std::max(most_stretch, Eigen::JacobiSVD<Eigen::Matrix3d>(stretch).singularValues()[0]);
  }

  // === Vertices
  const geometry::TriangleMesh& mesh = skin_->mesh();
  Eigen::Matrix3Xd vertices = Eigen::Matrix3Xd::Zero(3, mesh.vertexCount());
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    double sum = 0.0;
    for (std::size_t link = 0; link < count; ++link) {
      const double weight = weights_(static_cast<Eigen::Index>(link), v);
      if (weight == 0.0) continue;
      vertices.col(v) += weight * (A[link] * mesh.vertex(v) + shift[link]);
      sum += weight;
    }
    vertices.col(v) /= sum;
  }
  return std::make_shared<const Skin>(
      variant.model, geometry::TriangleMesh(std::move(vertices), mesh.faces()), q,
      skin_->epsilon() * most_stretch, skin_->source(), skin_->faceLinks());
}

}  // namespace handgraft::hand
