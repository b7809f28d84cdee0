#include "core/geometry/heat_log_map.h"

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/geometry/coordinate_disk.h"
#include "core/geometry/heat_flow.h"
#include "core/geometry/heat_source.h"
#include "core/geometry/log_map_source.h"

namespace handgraft::geometry {

namespace {

/// A component on its own, its vertices and faces in the order of the mesh.
struct Piece {
  TriangleMesh mesh;
  std::vector<int> vertices;  ///< of the whole mesh
  std::unique_ptr<HeatFlow> flow;
  std::string refusal;  ///< why there is no flow
};

}  // namespace

struct HeatLogMap::Parts {
  TriangleMesh mesh;
  std::vector<int> piece_of_face;
  std::vector<int> vertex_in_piece;
  std::vector<int> face_in_piece;
  std::vector<Piece> pieces;

  explicit Parts(const TriangleMesh& whole);

  template <class Solve>
  LogMap solve(const SurfacePoint& source,
               const Eigen::Vector3d& direction,
               double radius,
               const Solve& coordinates_from) const;
};

HeatLogMap::Parts::Parts(const TriangleMesh& whole) : mesh(whole) {
  const auto [component_of, component_count] = mesh.components();
  std::vector<int> piece_of_component(static_cast<std::size_t>(component_count), -1);
  std::vector<std::vector<int>> faces_of;
  std::vector<std::string> refusals;
  piece_of_face.resize(static_cast<std::size_t>(mesh.faceCount()));
  face_in_piece.resize(piece_of_face.size());
  for (int f = 0; f < mesh.faceCount(); ++f) {
    int& piece = piece_of_component[component_of[mesh.faces()(0, f)]];
    if (piece < 0) {
      piece = static_cast<int>(faces_of.size());
      faces_of.emplace_back();
      refusals.emplace_back();
    }
    piece_of_face[f] = piece;
    face_in_piece[f] = static_cast<int>(faces_of[piece].size());
    faces_of[piece].push_back(f);
    // Told in the numbers of the whole mesh; the first one is enough.
    std::string& refusal = refusals[piece];
    if (refusal.empty()) refusal = defectOfFace(mesh, f);
  }
  pieces.resize(faces_of.size());
  vertex_in_piece.resize(static_cast<std::size_t>(mesh.vertexCount()));
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    const int piece = piece_of_component[component_of[v]];
    if (piece < 0) continue;
    vertex_in_piece[v] = static_cast<int>(pieces[piece].vertices.size());
    pieces[piece].vertices.push_back(v);
    std::string& refusal = refusals[piece];
    if (refusal.empty()) refusal = defectOfVertex(mesh, v);
  }
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    Piece& piece = pieces[i];
    piece.refusal = refusals[i];
    if (!piece.refusal.empty()) continue;
    Eigen::Matrix3Xd vertices(3, piece.vertices.size());
    for (std::size_t v = 0; v < piece.vertices.size(); ++v)
      vertices.col(v) = mesh.vertex(piece.vertices[v]);
    Eigen::Matrix3Xi faces(3, faces_of[i].size());
    for (std::size_t f = 0; f < faces_of[i].size(); ++f) {
      for (int c = 0; c < 3; ++c)
        faces(c, f) = vertex_in_piece[mesh.faces()(c, faces_of[i][f])];
    }
    piece.mesh = TriangleMesh(std::move(vertices), std::move(faces));
    try {
      piece.flow = std::make_unique<HeatFlow>(piece.mesh);
    } catch (const InvalidInput& error) {
      piece.refusal = error.what();
    }
  }
}

template <class Solve>
LogMap HeatLogMap::Parts::solve(const SurfacePoint& source,
                                const Eigen::Vector3d& direction,
                                double radius,
                                const Solve& coordinates_from) const {
  validate(mesh, source, "log map source");
  if (!(radius > 0.0)) rejectInput("log map radius is {} m, it must be positive", radius);
  const SourceLayout layout = layOutSource(mesh, source, direction);

  const Piece& piece = pieces[piece_of_face[source.face]];
  if (!piece.flow) throw InvalidInput(piece.refusal);
  const SurfacePoint source_in_piece{face_in_piece[source.face], source.barycentric};
  const SourceLayout layout_in_piece = layOutSource(piece.mesh, source_in_piece, direction);
  const Eigen::Matrix2Xd p_T = coordinates_from(piece, source_in_piece, layout_in_piece);

  Eigen::Matrix2Xd whole_T = Eigen::Matrix2Xd::Constant(
      2, mesh.vertexCount(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t v = 0; v < piece.vertices.size(); ++v)
    whole_T.col(piece.vertices[v]) = p_T.col(v);
  // What lies next to the source is seen straight, without any flow.
  if (layout.vertex >= 0) whole_T.col(layout.vertex).setZero();
  for (const SourceNeighbour& neighbour : layout.neighbours)
    whole_T.col(neighbour.vertex) = neighbour.r * neighbour.direction_T;
  return diskFromCoordinates(mesh, whole_T, source, layout.faces, radius);
}

HeatLogMap::HeatLogMap(const TriangleMesh& mesh) : parts_(std::make_unique<Parts>(mesh)) {}

HeatLogMap::~HeatLogMap() = default;
HeatLogMap::HeatLogMap(HeatLogMap&&) noexcept = default;
HeatLogMap& HeatLogMap::operator=(HeatLogMap&&) noexcept = default;

LogMap HeatLogMap::smooth(const SurfacePoint& source,
                          const Eigen::Vector3d& direction,
                          double radius) const {
  const auto coordinates_from = [&](const Piece& piece, const SurfacePoint& source_in_piece,
                                    const SourceLayout& layout) {
    const HeatFlow& flow = *piece.flow;
    return flow.affineLog(
        roundSeeds(piece.mesh, flow.surface(), source_in_piece, layout, flow.unitLength()),
        layout.origin, radius);
  };
  LogMap map = parts_->solve(source, direction, radius, coordinates_from);
  map.method = LogMapMethod::kSmooth;
  return map;
}

LogMap HeatLogMap::heat(const SurfacePoint& source,
                        const Eigen::Vector3d& direction,
                        double radius) const {
  const auto coordinates_from = [](const Piece& piece, const SurfacePoint& source_in_piece,
                                   const SourceLayout& layout) {
    // Each seed costs two solutions of its own here, and half an edge is off anyway.
    return piece.flow->vectorLog(
        cornerSeeds(piece.mesh, piece.flow->surface(), source_in_piece, layout));
  };
  LogMap map = parts_->solve(source, direction, radius, coordinates_from);
  map.method = LogMapMethod::kHeat;
  return map;
}

}  // namespace handgraft::geometry
