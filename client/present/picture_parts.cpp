#include "client/present/picture_parts.h"

#include <algorithm>
#include <array>
#include <map>

#include <Eigen/Geometry>

#include "core/base/error.h"

namespace handgraft::client {

using render::Color;

namespace {

constexpr float kRim_px = 1.6F;

}  // namespace

render::Color colorOf(const std::string& patch, std::size_t index) {
  static const std::map<std::string, Color> kFingers = {
      {"thumb", {213, 74, 0}},  {"index", {0, 114, 178}},  {"middle", {0, 150, 110}},
      {"ring", {190, 90, 160}}, {"little", {214, 170, 0}}, {"palm", {70, 175, 230}}};
  if (const auto found = kFingers.find(patch); found != kFingers.end()) return found->second;
  static const std::array<Color, 6> kOthers = {{{140, 86, 75},
                                                {148, 103, 189},
                                                {188, 189, 34},
                                                {23, 150, 160},
                                                {214, 39, 120},
                                                {90, 90, 200}}};
  return kOthers[index % kOthers.size()];
}

render::SurfaceMesh surface(const v1::Mesh& mesh, const Pose& X_WM, Color color) {
  render::SurfaceMesh out;
  out.color = color;
  const std::vector<float>& xyz = mesh.vertices_m();
  for (std::size_t i = 0; i + 2 < xyz.size(); i += 3) {
    const Eigen::Vector3d p_M(xyz[i], xyz[i + 1], xyz[i + 2]);
    out.vertices_W.push_back((X_WM * p_M).cast<float>());
  }
  const std::vector<std::uint32_t>& corners = mesh.triangles();
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
    out.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
  }
  return out;
}

std::vector<Eigen::Vector3f> pointsOf(const std::vector<double>& xyz) {
  std::vector<Eigen::Vector3f> points;
  for (std::size_t i = 0; i + 2 < xyz.size(); i += 3) {
    points.push_back(Eigen::Vector3d(xyz[i], xyz[i + 1], xyz[i + 2]).cast<float>());
  }
  return points;
}

void addCasedLine(render::Scene& scene,
                  const Eigen::Vector3f& from_W,
                  const Eigen::Vector3f& to_W,
                  float width_px,
                  Color color) {
  scene.segments.push_back({from_W, to_W, width_px, color, kRim_px});
}

void addArrow(render::Scene& scene,
              const Eigen::Vector3f& from_W,
              const Eigen::Vector3f& to_W,
              const Eigen::Vector3f& normal_W,
              float width_px,
              Color color) {
  const Eigen::Vector3f along = to_W - from_W;
  const Eigen::Vector3f aside = normal_W.cross(along);
  addCasedLine(scene, from_W, to_W, width_px, color);
  for (const float side : {-0.13F, 0.13F}) {
    addCasedLine(scene, to_W, to_W - 0.26F * along + side * aside, width_px, color);
  }
}

void addDot(render::Scene& scene, const Eigen::Vector3f& at_W, float radius_px, Color color) {
  scene.markers.push_back({at_W, radius_px, color, kRim_px});
}

MeshPlace placeOn(const v1::Mesh& mesh, const v1::SurfacePoint& point) {
  std::array<Eigen::Vector3d, 3> corners;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t corner = 3 * static_cast<std::size_t>(std::max(point.face(), 0)) + k;
    if (point.face() < 0 || corner >= mesh.triangles().size() ||
        3 * std::size_t{mesh.triangles()[corner]} + 2 >= mesh.vertices_m().size()) {
      throw TransportError(fmt::format("the server named face {} of a mesh that has {}",
                                       point.face(), mesh.triangles().size() / 3));
    }
    const float* xyz = mesh.vertices_m().data() + 3 * std::size_t{mesh.triangles()[corner]};
    corners[k] = {xyz[0], xyz[1], xyz[2]};
  }
  const Eigen::Vector3d p = point.barycentric()[0] * corners[0] +
                            point.barycentric()[1] * corners[1] +
                            point.barycentric()[2] * corners[2];
  const Eigen::Vector3d area = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  const double length = area.norm();
  const Eigen::Vector3d n = length > 0.0 ? Eigen::Vector3d(area / length) : area;
  return {p.cast<float>(), n.cast<float>()};
}

}  // namespace handgraft::client
