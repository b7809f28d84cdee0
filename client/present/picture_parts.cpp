#include "client/present/picture_parts.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>
#include <system_error>
#include <utility>

#include <Eigen/Geometry>

#include "core/base/error.h"

namespace handgraft::client {

using render::Color;

namespace {

constexpr float kRimPixels = 1.6F;

// As client/web/src/colors.ts has them.
constexpr std::array<std::pair<std::string_view, Color>, 6> kFingers{
    {{"thumb", {213, 94, 0}},
     {"index", {0, 114, 178}},
     {"middle", {0, 158, 115}},
     {"ring", {204, 121, 167}},
     {"little", {214, 170, 0}},
     {"palm", {123, 97, 201}}}};
constexpr std::array<Color, 6> kOthers{{{184, 134, 11},
                                        {140, 109, 79},
                                        {79, 125, 140},
                                        {176, 65, 122},
                                        {106, 143, 42},
                                        {230, 159, 0}}};

/// The words of `index_distal_2`.
std::vector<std::string> wordsOf(const std::string& name) {
  std::vector<std::string> words(1);
  for (const char c : name) {
    if (c == '_') {
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  return words;
}

/// 0 where `text` is no number.
int numberOf(const std::string& text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? std::max(number, 0) : 0;
}

/// Darker below 0, paler above.
Color shaded(Color color, double share) {
  return share < 0.0 ? render::blend(color, {0, 0, 0}, -share)
                     : render::blend(color, {255, 255, 255}, share);
}

}  // namespace

render::Color colorOf(const std::string& patch, std::size_t index) {
  constexpr double kSegmentStep = 0.33;
  constexpr double kNumberStep = 0.11;  // three patches before the next segment's shade
  const std::vector<std::string> words = wordsOf(patch);
  const std::string& digit = words.front();
  const auto* const finger =
      std::find_if(kFingers.begin(), kFingers.end(), [&](const auto& known) {
        return known.first == digit;
      });
  // Fingers without a name are f1, f2...
  const int place = digit.rfind('f', 0) == 0 ? numberOf(digit.substr(1)) : 0;
  if (finger == kFingers.end() && place == 0) {
    const std::size_t round = index / kOthers.size() % 3;
    return shaded(kOthers[index % kOthers.size()],
                  round == 2 ? kSegmentStep : -kSegmentStep * static_cast<double>(round));
  }
  double share = 0.0;
  if (words.size() > 1 && words[1] == "proximal") share = -kSegmentStep;
  if (words.size() > 1 && words[1] == "distal") share = kSegmentStep;
  const int number = words.size() > 1 ? numberOf(words.back()) : 0;
  share += kNumberStep * (std::max(number, 1) - 1);
  const Color own = finger != kFingers.end()
                        ? finger->second
                        : kOthers[static_cast<std::size_t>(place - 1) % kOthers.size()];
  return shaded(own, std::min(share, 0.7));
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
  scene.segments.push_back({from_W, to_W, width_px, color, kRimPixels});
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
  scene.markers.push_back({at_W, radius_px, color, kRimPixels});
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
