#include "core/geometry/intrinsic_delaunay.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/error.h"

namespace handgraft::geometry {

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
// Negative sum of cotangents up to which an edge stays: rounding of four nearly cocircular
// vertices, which would flip for ever.
constexpr double kCocircular = 1e-9;
// Triangles thinner than this (excess of two sides over the third, in mean edges) have no area
// left in their lengths; rounding of coordinates is 1e-4 of it.
constexpr double kThinnest = 1e-12;
// Four areas against the sum of squared sides: keeps cotangents finite where a flip left none.
constexpr double kLeastArea = 1e-14;
// Flips per edge after which the mesh is taken as it is; usual meshes need less than one.
constexpr std::size_t kMostFlips = 200;

/// Four times the area; Kahan's order of Heron's formula, which keeps its digits on slivers.
double fourAreas(double a, double b, double c) {
  if (a < b) std::swap(a, b);
  if (b < c) std::swap(b, c);
  if (a < b) std::swap(a, b);
  return std::sqrt(
      std::max(0.0, (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))));
}

/// Twice the product of b and c times the cosine of the angle between them, opposite to a.
double cosineTerm(double a, double b, double c) {
  return (b - a) * (b + a) + c * c;
}

/// The halfedge that leaves v and has no face to its right; any of them around an inner vertex.
int firstOfFan(const TriangleMesh& mesh, int v) {
  for (const int* h = mesh.outgoingBegin(v); h != mesh.outgoingEnd(v); ++h) {
    if (mesh.twin(*h) < 0) return *h;
  }
  return *mesh.outgoingBegin(v);
}

}  // namespace

std::string defectOfFace(const TriangleMesh& mesh, int face) {
  if (!mesh.faceNormals().col(face).isZero(0.0)) return {};
  return fmt::format("face {} has no area; this log map method needs faces with area", face);
}

std::string defectOfVertex(const TriangleMesh& mesh, int vertex) {
  const auto face_count = mesh.outgoingEnd(vertex) - mesh.outgoingBegin(vertex);
  if (face_count == 0) return {};
  const int first = firstOfFan(mesh, vertex);
  std::ptrdiff_t met = 1;
  int last = first;
  int h = mesh.twin(TriangleMesh::previous(first));
  while (h >= 0 && h != first) {
    ++met;
    last = h;
    h = mesh.twin(TriangleMesh::previous(h));
  }
  // An open fan whose two ends are one edge holds faces that disagree on what is outside.
  const bool bent_back = h < 0 && mesh.from(TriangleMesh::previous(last)) == mesh.to(first);
  if (met == face_count && !bent_back) return {};
  return fmt::format(
      "vertex {} is not manifold (its {} faces do not form one fan); this log map method needs "
      "a manifold surface around the source",
      vertex, face_count);
}

IntrinsicDelaunay::IntrinsicDelaunay(const TriangleMesh& mesh) {
  const int halfedge_count = 3 * mesh.faceCount();
  from_.resize(static_cast<std::size_t>(halfedge_count));
  twins_.resize(from_.size());
  lengths_.resize(from_.size());
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const std::string defect = defectOfFace(mesh, f);
    if (!defect.empty()) throw InvalidInput(defect);
  }
  if (mesh.faceCount() > 0) unit_length_ = mesh.meanEdgeLength();
  if (!std::isfinite(unit_length_)) {
    rejectInput("the mean edge of the mesh is {} m, it must be finite", unit_length_);
  }
  double lack = 0.0;
  for (int h = 0; h < halfedge_count; ++h) {
    from_[h] = mesh.from(h);
    twins_[h] = mesh.twin(h);
    lengths_[h] =
        (mesh.vertex(mesh.to(h)) - mesh.vertex(mesh.from(h))).stableNorm() / unit_length_;
  }
  // Rounding may leave slivers whose sides do not meet; all edges grow by what is missing.
  for (int h = 0; h < halfedge_count; ++h) {
    const double excess =
        lengths_[TriangleMesh::next(h)] + lengths_[TriangleMesh::previous(h)] - lengths_[h];
    lack = std::max(lack, kThinnest - excess);
  }
  for (double& length : lengths_)
    length += lack;
  measureAngles(mesh);
  flipToDelaunay();
}

void IntrinsicDelaunay::measureAngles(const TriangleMesh& mesh) {
  angles_.assign(from_.size(), 0.0);
  angle_scales_.assign(static_cast<std::size_t>(mesh.vertexCount()), 1.0);
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    if (mesh.outgoingBegin(v) == mesh.outgoingEnd(v)) continue;
    const std::string defect = defectOfVertex(mesh, v);
    if (!defect.empty()) throw InvalidInput(defect);
    const int first = firstOfFan(mesh, v);
    double angle = 0.0;
    int h = first;
    do {
      angles_[h] = angle;
      angle += cornerAngle(h);
      h = mesh.twin(TriangleMesh::previous(h));
    } while (h >= 0 && h != first);
    const bool closed = h == first;
    if (closed || angle > kTurn) angle_scales_[v] = kTurn / angle;
  }
  mesh_angles_ = angles_;
}

double IntrinsicDelaunay::area(int face) const {
  const std::size_t h = 3 * static_cast<std::size_t>(face);
  const double four_areas = fourAreas(lengths_[h], lengths_[h + 1], lengths_[h + 2]);
  return unit_length_ * unit_length_ * four_areas / 4.0;
}

double IntrinsicDelaunay::cornerAngle(int h) const {
  const double a = lengths_[TriangleMesh::next(h)];
  const double b = lengths_[h];
  const double c = lengths_[TriangleMesh::previous(h)];
  return std::atan2(fourAreas(a, b, c), cosineTerm(a, b, c));
}

double IntrinsicDelaunay::cotanOpposite(int h) const {
  const double a = lengths_[h];
  const double b = lengths_[TriangleMesh::next(h)];
  const double c = lengths_[TriangleMesh::previous(h)];
  const double least = kLeastArea * (a * a + b * b + c * c);
  return cosineTerm(a, b, c) / std::max(fourAreas(a, b, c), least);
}

double IntrinsicDelaunay::cotanWeight(int h) const {
  const double sum = cotanOpposite(h) + (twin(h) >= 0 ? cotanOpposite(twin(h)) : 0.0);
  return sum / 2.0;
}

bool IntrinsicDelaunay::isDelaunay(int h) const {
  const int t = twin(h);
  if (t < 0 || TriangleMesh::faceOf(h) == TriangleMesh::faceOf(t)) return true;
  const double one = cotanOpposite(h);
  const double other = cotanOpposite(t);
  return !(one + other < -kCocircular * (1.0 + std::abs(one) + std::abs(other)));
}

std::complex<double> IntrinsicDelaunay::unitAt(int vertex, double angle) const {
  return std::polar(1.0, angle_scales_[vertex] * angle);
}

std::complex<double> IntrinsicDelaunay::direction(int h) const {
  return unitAt(from(h), angles_[h]);
}

std::complex<double> IntrinsicDelaunay::directionBack(int h) const {
  const int n = TriangleMesh::next(h);
  return unitAt(to(h), twin(h) >= 0 ? angles_[twin(h)] : angles_[n] + cornerAngle(n));
}

std::complex<double> IntrinsicDelaunay::meshDirection(int vertex,
                                                      int mesh_halfedge,
                                                      double turn) const {
  return unitAt(vertex, mesh_angles_[mesh_halfedge] + turn);
}

void IntrinsicDelaunay::flipToDelaunay() {
  std::vector<int> waiting;
  waiting.reserve(from_.size());
  for (int h = halfedgeCount() - 1; h >= 0; --h) {
    if (isFirstOfEdge(h)) waiting.push_back(h);
  }
  const std::size_t most_flips = kMostFlips * waiting.size();
  while (!waiting.empty() && static_cast<std::size_t>(flip_count_) < most_flips) {
    const int h = waiting.back();
    waiting.pop_back();
    if (isDelaunay(h)) continue;
    const int t = twin(h);
    flip(h);
    // The four sides of the two triangles; the new diagonal is the first halfedge of both.
    for (const int face : {TriangleMesh::faceOf(h), TriangleMesh::faceOf(t)}) {
      waiting.push_back(3 * face + 1);
      waiting.push_back(3 * face + 2);
    }
  }
}

/// From the edge a-b between faces (a, b, c) and (b, a, d) to the edge d-c between (d, c, a)
/// and (c, d, b).
void IntrinsicDelaunay::flip(int h) {
  const int t = twin(h);
  const int f = TriangleMesh::faceOf(h);
  const int g = TriangleMesh::faceOf(t);
  const int bc = TriangleMesh::next(h);
  const int ca = TriangleMesh::previous(h);
  const int ad = TriangleMesh::next(t);
  const int db = TriangleMesh::previous(t);

  // Both triangles laid flat along a-b, c to its left and d to its right.
  const double ab_length = lengths_[h];
  const double c_x = cosineTerm(lengths_[bc], ab_length, lengths_[ca]) / (2.0 * ab_length);
  const double d_x = cosineTerm(lengths_[db], ab_length, lengths_[ad]) / (2.0 * ab_length);
  const double height = (fourAreas(ab_length, lengths_[bc], lengths_[ca]) +
                         fourAreas(ab_length, lengths_[db], lengths_[ad])) /
                        (2.0 * ab_length);
  const double cd_length = std::hypot(c_x - d_x, height);

  struct Side {
    int from;
    int twin;
    double length;
    double angle;
  };

  const std::array<int, 4> old_places = {ca, ad, db, bc};
  const std::array<int, 4> new_places = {3 * f + 1, 3 * f + 2, 3 * g + 1, 3 * g + 2};
  std::array<Side, 4> sides{};
  for (std::size_t s = 0; s < 4; ++s) {
    const int side = old_places[s];
    sides[s] = {from_[side], twins_[side], lengths_[side], angles_[side]};
  }
  for (std::size_t s = 0; s < 4; ++s) {
    // Two of the sides may be glued to each other.
    const auto own = std::find(old_places.begin(), old_places.end(), sides[s].twin);
    const int other =
        own == old_places.end() ? sides[s].twin : new_places[own - old_places.begin()];
    const int place = new_places[s];
    from_[place] = sides[s].from;
    lengths_[place] = sides[s].length;
    angles_[place] = sides[s].angle;
    twins_[place] = other;
    if (other >= 0) twins_[other] = place;
  }
  const int dc = 3 * f;
  const int cd = 3 * g;
  from_[dc] = sides[2].from;
  from_[cd] = sides[0].from;
  twins_[dc] = cd;
  twins_[cd] = dc;
  lengths_[dc] = lengths_[cd] = cd_length;
  // Counter-clockwise at c: c-a, c-d, c-b; at d: d-b, d-c, d-a.
  angles_[cd] = sides[0].angle + cornerAngle(3 * f + 1);
  angles_[dc] = sides[2].angle + cornerAngle(3 * g + 1);
  ++flip_count_;
}

}  // namespace handgraft::geometry
