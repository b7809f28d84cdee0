#include "core/contact/edge_refinement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/base/error.h"

namespace handgraft::contact {
namespace {

using geometry::TriangleMesh;

[[noreturn]] void rejectSize(double longest_edge_m) {
  rejectInput("edges of at most {:.3g} mm need more than {} vertices on this object",
              1e3 * longest_edge_m, kMostRefinedVertices);
}

/// Vertices and faces while they grow; one pass halves every edge that is too long.
class Refiner {
 public:
  Refiner(const TriangleMesh& mesh, double longest_edge_m) : longest_edge_m_(longest_edge_m) {
    for (int v = 0; v < mesh.vertexCount(); ++v)
      vertices_.emplace_back(mesh.vertex(v));
    for (int f = 0; f < mesh.faceCount(); ++f) {
      faces_.push_back({mesh.face(f)[0], mesh.face(f)[1], mesh.face(f)[2]});
      parents_.push_back(f);
    }
  }

  /// False when there was nothing left to cut.
  bool pass() {
    const std::size_t before = vertices_.size();
    middles_.clear();
    std::vector<Face> cut;
    cut.reserve(faces_.size());
    std::vector<int> parents;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      cutFace(faces_[f], cut);
      parents.resize(cut.size(), parents_[f]);
    }
    faces_ = std::move(cut);
    parents_ = std::move(parents);
    return vertices_.size() > before;
  }

  [[nodiscard]] TriangleMesh mesh() const {
    Eigen::Matrix3Xd vertices(3, static_cast<Eigen::Index>(vertices_.size()));
    for (std::size_t v = 0; v < vertices_.size(); ++v)
      vertices.col(static_cast<Eigen::Index>(v)) = vertices_[v];
    Eigen::Matrix3Xi faces(3, static_cast<Eigen::Index>(faces_.size()));
    for (std::size_t f = 0; f < faces_.size(); ++f)
      faces.col(static_cast<Eigen::Index>(f)) << faces_[f][0], faces_[f][1], faces_[f][2];
    return {std::move(vertices), std::move(faces)};
  }

  [[nodiscard]] const std::vector<int>& parents() const { return parents_; }

 private:
  using Face = std::array<int, 3>;

  [[nodiscard]] double length(int a, int b) const {
    return (vertices_[static_cast<std::size_t>(a)] - vertices_[static_cast<std::size_t>(b)])
        .norm();
  }

  /// The vertex in the middle of an edge that is too long, or -1. Both faces of an edge ask
  /// with the same two vertices, so they get the same answer.
  int middleOf(int a, int b) {
    if (a > b) std::swap(a, b);
    if (!(length(a, b) > longest_edge_m_)) return -1;
    const auto key = (static_cast<std::uint64_t>(a) << 32U) | static_cast<std::uint64_t>(b);
    const auto [at, is_new] = middles_.emplace(key, static_cast<int>(vertices_.size()));
    if (is_new) {
      if (vertices_.size() >= static_cast<std::size_t>(kMostRefinedVertices))
        rejectSize(longest_edge_m_);
      vertices_.emplace_back(0.5 * (vertices_[static_cast<std::size_t>(a)] +
                                    vertices_[static_cast<std::size_t>(b)]));
    }
    return at->second;
  }

  void cutFace(const Face& face, std::vector<Face>& out) {
    std::array<int, 3> middle{};  // middle[i] lies on the edge from corner i to corner i + 1
    for (std::size_t i = 0; i < 3; ++i)
      middle[i] = middleOf(face[i], face[(i + 1) % 3]);
    const auto cuts = std::count_if(middle.begin(), middle.end(), [](int m) {
      return m >= 0;
    });
    if (cuts == 0) {
      out.push_back(face);
      return;
    }
    if (cuts == 3) {
      for (std::size_t i = 0; i < 3; ++i)
        out.push_back({face[i], middle[i], middle[(i + 2) % 3]});
      out.push_back(middle);
      return;
    }
    // Turn the face until its longest edge, which is one of those to be cut, comes first.
    std::size_t first = 0;
    for (std::size_t i = 1; i < 3; ++i) {
      if (length(face[i], face[(i + 1) % 3]) > length(face[first], face[(first + 1) % 3]))
        first = i;
    }
    const int a = face[first];
    const int b = face[(first + 1) % 3];
    const int c = face[(first + 2) % 3];
    const int m = middle[first];
    const int m_bc = middle[(first + 1) % 3];
    const int m_ca = middle[(first + 2) % 3];
    if (m_bc >= 0) {
      out.push_back({m, b, m_bc});
      out.push_back({m, m_bc, c});
    } else {
      out.push_back({m, b, c});
    }
    if (m_ca >= 0) {
      out.push_back({m, c, m_ca});
      out.push_back({m, m_ca, a});
    } else {
      out.push_back({m, c, a});
    }
  }

  double longest_edge_m_;
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<Face> faces_;
  std::vector<int> parents_;  ///< of each face, the one it was cut from
  std::unordered_map<std::uint64_t, int> middles_;
};

}  // namespace

TriangleMesh refineEdges(const TriangleMesh& mesh,
                         double longest_edge_m,
                         std::vector<int>* parents) {
  if (!(longest_edge_m > 0.0)) {
    rejectInput("longest edge is {} m; it must be above 0", longest_edge_m);
  }
  // The largest face with such edges is equilateral; a surface has half as many vertices as
  // faces. Cutting ends with more, which the refiner counts, but slowly.
  const double largest_face_m2 = 0.25 * std::sqrt(3.0) * longest_edge_m * longest_edge_m;
  if (0.5 * mesh.area() > kMostRefinedVertices * largest_face_m2) rejectSize(longest_edge_m);
  Refiner refiner(mesh, longest_edge_m);
  while (refiner.pass()) {
  }
  if (parents != nullptr) *parents = refiner.parents();
  return refiner.mesh();
}

}  // namespace handgraft::contact
