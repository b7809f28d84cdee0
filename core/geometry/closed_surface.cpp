#include "core/geometry/closed_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>
#include <vector>

namespace handgraft::geometry {

namespace {

using Edge = std::pair<int, int>;  // lower vertex first

struct Soup {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> faces;
  std::vector<int> given_face;  ///< per face, as in SolidsAndSheets; and so is the next
  std::vector<char> is_turned;
};

Soup welded(const TriangleMesh& mesh) {
  Soup soup;
  std::map<std::array<double, 3>, int> places;
  std::vector<int> where(static_cast<std::size_t>(mesh.vertexCount()));
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    const Eigen::Vector3d p = mesh.vertex(v);
    // Adding zero makes one of both zeros.
    const std::array<double, 3> key{p[0] + 0.0, p[1] + 0.0, p[2] + 0.0};
    const auto [place, is_new] =
        places.try_emplace(key, static_cast<int>(soup.vertices.size()));
    if (is_new) soup.vertices.push_back(p);
    where[static_cast<std::size_t>(v)] = place->second;
  }
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f).unaryExpr([&where](int v) {
      return where[static_cast<std::size_t>(v)];
    });
    if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) continue;
    soup.faces.push_back(face);
    soup.given_face.push_back(f);
  }
  soup.is_turned.assign(soup.faces.size(), 0);
  return soup;
}

double areaOf(const Soup& soup, const Eigen::Vector3i& face) {
  const auto at = [&](int i) {
    return soup.vertices[static_cast<std::size_t>(face[i])];
  };
  return 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).norm();
}

/// Calls `visit(edge, forward)` for the three edges of a face.
template <class Visit>
void forEdges(const Eigen::Vector3i& face, const Visit& visit) {
  for (int i = 0; i < 3; ++i) {
    const int a = face[i];
    const int b = face[(i + 1) % 3];
    visit(Edge(std::min(a, b), std::max(a, b)), a < b);
  }
}

using FacesAtEdges = std::map<Edge, std::vector<int>>;

FacesAtEdges facesAtEdges(const Soup& soup) {
  FacesAtEdges faces_at;
  for (int f = 0; f < std::ssize(soup.faces); ++f)
    forEdges(soup.faces[f], [&](const Edge& edge, bool) {
      faces_at[edge].push_back(f);
    });
  return faces_at;
}

bool passesForward(const Eigen::Vector3i& face, const Edge& wanted) {
  bool result = false;
  forEdges(face, [&](const Edge& edge, bool forward) {
    if (edge == wanted) result = forward;
  });
  return result;
}

/// Whether a face has to be turned (1) to agree with the first of its component, or not (0).
using Turns = std::vector<char>;
constexpr char kUnseen = 2;

/// The faces that hang together with `seed`, each with its turn.
std::vector<int> componentOf(int seed,
                             const Soup& soup,
                             const FacesAtEdges& faces_at,
                             Turns& turned) {
  turned[seed] = 0;
  std::vector<int> component{seed};
  for (std::size_t next = 0; next < component.size(); ++next) {
    const int f = component[next];
    forEdges(soup.faces[f], [&](const Edge& edge, bool forward) {
      const std::vector<int>& both = faces_at.at(edge);
      if (both.size() != 2) return;
      const int other = both[0] == f ? both[1] : both[0];
      if (turned[other] != kUnseen) return;
      const bool agree = passesForward(soup.faces[other], edge) != forward;
      turned[other] = static_cast<char>(agree ? turned[f] : 1 - turned[f]);
      component.push_back(other);
    });
  }
  return component;
}

/// Turns faces so that neighbours over an edge of two faces pass it in opposite directions;
/// those of less area give way.
void orient(Soup& soup) {
  const FacesAtEdges faces_at = facesAtEdges(soup);
  Turns turned(soup.faces.size(), kUnseen);
  for (int seed = 0; seed < std::ssize(soup.faces); ++seed) {
    if (turned[seed] != kUnseen) continue;
    const std::vector<int> component = componentOf(seed, soup, faces_at, turned);
    double kept_area = 0.0;
    double turned_area = 0.0;
    for (const int f : component)
      (turned[f] != 0 ? turned_area : kept_area) += areaOf(soup, soup.faces[f]);
    const char wrong = turned_area > kept_area ? 0 : 1;
    for (const int f : component) {
      if (turned[f] != wrong) continue;
      std::swap(soup.faces[f][1], soup.faces[f][2]);
      soup.is_turned[f] = 1;
    }
  }
}

int rootOf(std::vector<int>& parents, int v) {
  while (parents[v] != v)
    v = parents[v] = parents[parents[v]];
  return v;
}

/// A connected piece of the chain's border, and the cone over it.
struct Rim {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double length = 0.0;
  double area = 0.0;
  int vertex = -1;  ///< one of it
  int tip = -1;
};

/// A cone over the chain's border, one tip a connected rim: what it adds borders nothing
/// itself. Rims wider than `widest` are left as they are: one vertex of each is returned.
std::vector<int> shutHoles(double widest, Soup& soup) {
  std::map<Edge, int> balance;
  for (const Eigen::Vector3i& face : soup.faces)
    forEdges(face, [&](const Edge& edge, bool forward) {
      balance[edge] += forward ? 1 : -1;
    });
  std::vector<int> parents(soup.vertices.size());
  std::iota(parents.begin(), parents.end(), 0);
  for (const auto& [edge, surplus] : balance)
    if (surplus != 0) parents[rootOf(parents, edge.first)] = rootOf(parents, edge.second);

  std::map<int, Rim> rims;
  const auto for_border = [&](const auto& visit) {
    for (const auto& [edge, surplus] : balance)
      if (surplus != 0) visit(edge, surplus, rims[rootOf(parents, edge.first)]);
  };
  for_border([&](const Edge& edge, int, Rim& rim) {
    const Eigen::Vector3d a = soup.vertices[edge.first];
    const Eigen::Vector3d b = soup.vertices[edge.second];
    rim.sum += 0.5 * (b - a).norm() * (a + b);
    rim.length += (b - a).norm();
    rim.vertex = edge.first;
  });
  for (auto& [root, rim] : rims) {
    // Welded vertices differ, but their distance may round to nothing.
    rim.sum = rim.length > 0.0 ? Eigen::Vector3d(rim.sum / rim.length) : soup.vertices[root];
  }
  for_border([&](const Edge& edge, int, Rim& rim) {
    const Eigen::Vector3d a = soup.vertices[edge.first] - rim.sum;
    rim.area += 0.5 * a.cross(soup.vertices[edge.second] - rim.sum).norm();
  });
  std::vector<int> open;
  for (auto& [root, rim] : rims) {
    if (rim.area > 0.25 * std::numbers::pi * widest * widest) {
      open.push_back(rim.vertex);
      continue;
    }
    rim.tip = static_cast<int>(soup.vertices.size());
    soup.vertices.push_back(rim.sum);
  }
  for_border([&](const Edge& edge, int surplus, const Rim& rim) {
    if (rim.tip < 0) return;
    // Against the direction of the surplus.
    const Eigen::Vector3i face = surplus > 0
                                     ? Eigen::Vector3i(edge.second, edge.first, rim.tip)
                                     : Eigen::Vector3i(edge.first, edge.second, rim.tip);
    soup.faces.insert(soup.faces.end(), static_cast<std::size_t>(std::abs(surplus)), face);
  });
  soup.given_face.resize(soup.faces.size(), -1);
  soup.is_turned.resize(soup.faces.size(), 0);
  return open;
}

/// Puts the faces that hang together with `vertices` behind the others; how many those are.
int putLast(const std::vector<int>& vertices, Soup& soup) {
  std::vector<int> parents(soup.vertices.size());
  std::iota(parents.begin(), parents.end(), 0);
  for (const Eigen::Vector3i& face : soup.faces) {
    parents[rootOf(parents, face[1])] = rootOf(parents, face[0]);
    parents[rootOf(parents, face[2])] = rootOf(parents, face[0]);
  }
  std::vector<char> is_open(soup.vertices.size(), 0);
  for (const int v : vertices)
    is_open[rootOf(parents, v)] = 1;
  std::vector<int> order(soup.faces.size());
  std::iota(order.begin(), order.end(), 0);
  const auto sheets = std::stable_partition(order.begin(), order.end(), [&](int f) {
    return is_open[rootOf(parents, soup.faces[f][0])] == 0;
  });
  Soup parted{std::move(soup.vertices), {}, {}, {}};
  for (const int f : order) {
    parted.faces.push_back(soup.faces[f]);
    parted.given_face.push_back(soup.given_face[f]);
    parted.is_turned.push_back(soup.is_turned[f]);
  }
  soup = std::move(parted);
  return static_cast<int>(sheets - order.begin());
}

TriangleMesh meshOf(const Soup& soup) {
  Eigen::Matrix3Xd vertices(3, std::ssize(soup.vertices));
  for (int v = 0; v < vertices.cols(); ++v)
    vertices.col(v) = soup.vertices[v];
  Eigen::Matrix3Xi faces(3, std::ssize(soup.faces));
  for (int f = 0; f < faces.cols(); ++f)
    faces.col(f) = soup.faces[f];
  return {std::move(vertices), std::move(faces)};
}

}  // namespace

TriangleMesh closedSurface(const TriangleMesh& mesh) {
  return solidsAndSheets(mesh, std::numeric_limits<double>::infinity()).mesh;
}

SolidsAndSheets solidsAndSheets(const TriangleMesh& mesh, double widest_hole_m) {
  Soup soup = welded(mesh);
  orient(soup);
  const std::vector<int> open = shutHoles(widest_hole_m, soup);
  SolidsAndSheets result;
  result.solid_faces = open.empty() ? static_cast<int>(soup.faces.size()) : putLast(open, soup);
  result.mesh = meshOf(soup);
  result.given_face = std::move(soup.given_face);
  result.is_turned = std::move(soup.is_turned);
  return result;
}

}  // namespace handgraft::geometry
