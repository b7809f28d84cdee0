#include "core/hand/skin_report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "core/hand/skin_wrap.h"

namespace handgraft::hand {

void measure(const Skin& skin, SkinReport& report) {
  const geometry::TriangleMesh& mesh = skin.mesh();
  report.vertices = mesh.vertexCount();
  report.faces = mesh.faceCount();
  report.pieces = mesh.components().second;
  report.genus = report.pieces - mesh.eulerCharacteristic() / 2;
  report.is_closed = mesh.isClosed();
  report.crossing_faces =
      report.is_closed ? static_cast<int>(selfIntersectingFaces(mesh).size()) : 0;

  // === Triangles
  report.mean_edge_m = mesh.meanEdgeLength();
  report.shortest_edge_m = std::numeric_limits<double>::infinity();
  report.longest_edge_m = 0.0;
  report.smallest_angle_rad = std::numbers::pi;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d u = mesh.vertex(face[(c + 1) % 3]) - mesh.vertex(face[c]);
      const Eigen::Vector3d v = mesh.vertex(face[(c + 2) % 3]) - mesh.vertex(face[c]);
      report.shortest_edge_m = std::min(report.shortest_edge_m, u.norm());
      report.longest_edge_m = std::max(report.longest_edge_m, u.norm());
      report.smallest_angle_rad =
          std::min(report.smallest_angle_rad, std::atan2(u.cross(v).norm(), u.dot(v)));
    }
  }

  // === Links
  double sum = 0.0;
  int projected = 0;
  report.max_clearance_m = 0.0;
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    const auto hit =
        skin.links().nearest(mesh.vertex(v), std::numeric_limits<double>::infinity());
    if (!hit) continue;
    sum += hit->distance_m;
    report.max_clearance_m = std::max(report.max_clearance_m, hit->distance_m);
    if (skin.project(mesh.vertex(v), mesh.vertexNormals().col(v))) ++projected;
  }
  const double count = std::max(1, mesh.vertexCount());
  report.mean_clearance_m = sum / count;
  report.projected_share = projected / count;
}

std::string describe(const SkinReport& report) {
  std::string text;
  for (const SkinStep& step : report.steps) {
    text += fmt::format("{:<18}", step.action);
    if (step.alpha_m > 0.0)
      text += fmt::format(" alpha {:.2f} mm, offset {:.2f} mm", 1e3 * step.alpha_m,
                          1e3 * step.offset_m);
    if (step.edge_m > 0.0) text += fmt::format(", edge {:.2f} mm", 1e3 * step.edge_m);
    if (step.sheets > 0)
      text += fmt::format("{} {} sheets of {:.0f} mm2", step.alpha_m > 0.0 ? "," : "",
                          step.sheets, 1e6 * step.sheets_area_m2);
    if (step.vertices > 0)
      text += fmt::format(": {} vertices, {} {}, genus {}", step.vertices, step.pieces,
                          step.pieces == 1 ? "piece" : "pieces", step.genus);
    if (step.crossing_faces > 0) text += fmt::format(", {} faces cross", step.crossing_faces);
    text += fmt::format(", {:.2f} s: {}\n", step.time_s, step.verdict);
  }
  text += fmt::format(
      "skin: {} vertices, {} {}, genus {}, {}, {} crossing faces; edges {:.2f} to {:.2f} mm, "
      "mean {:.2f} mm, smallest angle {:.1f} deg; clearance mean {:.2f} mm, max {:.2f} mm; "
      "{:.1f} % of the vertices on a link; {:.2f} s{}",
      report.vertices, report.pieces, report.pieces == 1 ? "piece" : "pieces", report.genus,
      report.is_closed ? "closed" : "open", report.crossing_faces, 1e3 * report.shortest_edge_m,
      1e3 * report.longest_edge_m, 1e3 * report.mean_edge_m,
      report.smallest_angle_rad * 180.0 / std::numbers::pi, 1e3 * report.mean_clearance_m,
      1e3 * report.max_clearance_m, 100.0 * report.projected_share, report.time_s,
      report.from_cache ? " (from the cache)" : "");
  for (const std::string& note : report.notes)
    text += "\nnote: " + note;
  return text;
}

}  // namespace handgraft::hand
