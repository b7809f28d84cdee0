#include "core/contact/threshold.h"

#include <algorithm>
#include <numeric>

#include <Eigen/Geometry>

#include "core/base/error.h"

namespace handgraft::contact {
namespace {

using geometry::TriangleMesh;

Eigen::VectorXd faceAreas(const TriangleMesh& mesh) {
  Eigen::VectorXd areas(mesh.faceCount());
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3d a = mesh.vertex(mesh.face(f)[0]);
    areas[f] =
        0.5 * (mesh.vertex(mesh.face(f)[1]) - a).cross(mesh.vertex(mesh.face(f)[2]) - a).norm();
  }
  return areas;
}

}  // namespace

Eigen::VectorXd vertexAreas(const TriangleMesh& mesh) {
  const Eigen::VectorXd face_areas = faceAreas(mesh);
  Eigen::VectorXd areas = Eigen::VectorXd::Zero(mesh.vertexCount());
  for (int f = 0; f < mesh.faceCount(); ++f) {
    for (const int v : mesh.face(f))
      areas[v] += face_areas[f] / 3.0;
  }
  return areas;
}

double otsuThreshold(const Eigen::VectorXd& values, const Eigen::VectorXd& weights) {
  HANDGRAFT_REQUIRE(values.size() == weights.size());
  std::vector<Eigen::Index> order;
  double weight = 0.0;
  double sum = 0.0;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (!(weights[i] > 0.0)) continue;
    order.push_back(i);
    weight += weights[i];
    sum += weights[i] * values[i];
  }
  std::sort(order.begin(), order.end(), [&](Eigen::Index i, Eigen::Index j) {
    return values[i] < values[j];
  });

  double best = -1.0;
  double threshold = 0.0;
  double weight_below = 0.0;
  double sum_below = 0.0;
  for (std::size_t k = 0; k + 1 < order.size(); ++k) {
    const double value = values[order[k]];
    const double next = values[order[k + 1]];
    weight_below += weights[order[k]];
    sum_below += weights[order[k]] * value;
    if (!(next > value)) continue;
    const double weight_above = weight - weight_below;
    const double apart = (sum - sum_below) / weight_above - sum_below / weight_below;
    const double variance = weight_below * weight_above * apart * apart;
    if (variance <= best) continue;
    best = variance;
    threshold = 0.5 * (value + next);
  }
  if (best < 0.0) rejectInput("all contact values are the same: no threshold parts them");
  return threshold;
}

std::vector<char> aboveWithHysteresis(const TriangleMesh& mesh,
                                      const Eigen::VectorXd& value,
                                      const std::vector<char>& candidates,
                                      double low,
                                      double high) {
  const auto count = static_cast<std::size_t>(mesh.vertexCount());
  HANDGRAFT_REQUIRE(candidates.size() == count && value.size() == mesh.vertexCount());
  std::vector<char> kept(count, 0);
  std::vector<int> open;
  const auto reach = [&](int v, double least) {
    const auto i = static_cast<std::size_t>(v);
    if (kept[i] != 0 || candidates[i] == 0 || !(value[v] > least)) return;
    kept[i] = 1;
    open.push_back(v);
  };
  for (int seed = 0; seed < mesh.vertexCount(); ++seed) {
    reach(seed, high);
    while (!open.empty()) {
      const int v = open.back();
      open.pop_back();
      // A halfedge that leaves v and the one that comes to it in the same face: on an open
      // surface's edge only one of the two leads to the neighbour.
      for (const int* h = mesh.outgoingBegin(v); h != mesh.outgoingEnd(v); ++h) {
        reach(mesh.to(*h), low);
        reach(mesh.from(TriangleMesh::previous(*h)), low);
      }
    }
  }
  return kept;
}

Eigen::VectorXd smoothed(const TriangleMesh& mesh, const Eigen::VectorXd& value, int steps) {
  HANDGRAFT_REQUIRE(value.size() == mesh.vertexCount());
  if (steps < 0 || steps > kMostSmoothingSteps) {
    rejectInput("smoothing steps are {}; permitted are 0 to {}", steps, kMostSmoothingSteps);
  }
  if (steps == 0) return value;
  const Eigen::VectorXd face_areas = faceAreas(mesh);
  const Eigen::VectorXd vertex_areas = vertexAreas(mesh);
  Eigen::VectorXd now = value;
  for (int step = 0; step < steps; ++step) {
    Eigen::VectorXd next = Eigen::VectorXd::Zero(now.size());
    for (int f = 0; f < mesh.faceCount(); ++f) {
      const Eigen::Vector3i face = mesh.face(f);
      const double share =
          face_areas[f] / 3.0 * (now[face[0]] + now[face[1]] + now[face[2]]) / 3.0;
      for (const int v : face)
        next[v] += share;
    }
    for (Eigen::Index v = 0; v < now.size(); ++v)
      now[v] = vertex_areas[v] > 0.0 ? next[v] / vertex_areas[v] : now[v];
  }
  return now;
}

}  // namespace handgraft::contact
