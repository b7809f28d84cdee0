#include "client/present/render/overlay.h"

namespace handgraft::client::render {

namespace {

constexpr Color kRimColor{255, 255, 255};
constexpr float kRimLift = 0.5F;  // of the scene's: rims lie between surfaces and what they rim

}  // namespace

void drawOverlay(const Scene& scene, const Camera& camera, float factor, DepthBuffer& buffer) {
  const auto lifted = [&](const Eigen::Vector3f& p_W, float share) {
    return camera.toSample(p_W + share * scene.lift_m * camera.towardsEye(p_W), factor);
  };
  std::uint32_t id = 0;
  const auto rims = static_cast<std::uint32_t>(scene.segments.size() + scene.markers.size());
  const auto draw = [&](const Eigen::Vector3f& from_W, const Eigen::Vector3f& to_W,
                        float width_px, float rim_px) {
    if (from_W.allFinite() && to_W.allFinite()) {
      buffer.drawSegment(lifted(from_W, 1.0F), lifted(to_W, 1.0F), factor * width_px, id);
      if (rim_px > 0.0F) {
        buffer.drawSegment(lifted(from_W, kRimLift), lifted(to_W, kRimLift),
                           factor * (width_px + 2.0F * rim_px), rims + id);
      }
    }
    ++id;
  };
  for (const Segment& segment : scene.segments)
    draw(segment.from_W, segment.to_W, segment.width_px, segment.rim_px);
  for (const Marker& marker : scene.markers)
    draw(marker.center_W, marker.center_W, 2.0F * marker.radius_px, marker.rim_px);
}

Color overlayColor(const Scene& scene, std::uint32_t id) {
  if (id < scene.segments.size()) return scene.segments[id].color;
  const std::size_t marker = id - scene.segments.size();
  return marker < scene.markers.size() ? scene.markers[marker].color : kRimColor;
}

}  // namespace handgraft::client::render
