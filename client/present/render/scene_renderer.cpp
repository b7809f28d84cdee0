#include "client/present/render/scene_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include <Eigen/Geometry>

#include "client/present/render/corner_normals.h"
#include "client/present/render/depth_buffer.h"
#include "client/present/render/overlay.h"
#include "client/present/render/shading.h"
#include "core/base/error.h"

namespace handgraft::client::render {

namespace {

constexpr int kSamplesPerSide = 2;                           // of a pixel
constexpr double kCrease = 40.0 * std::numbers::pi / 180.0;  // rounder than the eye notices
constexpr double kDecalOpacity = 0.78;  // of its colour over the surface's own

struct Corner {
  Eigen::Vector3f p_W = Eigen::Vector3f::Zero();
  Eigen::Vector3f n_W = Eigen::Vector3f::Zero();
  Eigen::Vector3f rgb = Eigen::Vector3f::Zero();  // 0-255
};

Eigen::Vector3f channels(const Color& color) {
  return {static_cast<float>(color.r), static_cast<float>(color.g),
          static_cast<float>(color.b)};
}

Color colorFrom(const Eigen::Vector3f& rgb) {
  const Eigen::Vector3f rounded = (rgb.array() + 0.5F).max(0.0F).min(255.0F);
  return {static_cast<std::uint8_t>(rounded.x()), static_cast<std::uint8_t>(rounded.y()),
          static_cast<std::uint8_t>(rounded.z())};
}

// A triangle as it is on the screen, after clipping.
struct Face {
  std::array<ScreenPoint, 3> screen;
  std::array<Corner, 3> corners;
};

// What one view makes of one layer.
struct LayerView {
  std::vector<Face> faces;
  DepthBuffer buffer;
};

struct DrawnView {
  std::vector<LayerView> layers;
  DepthBuffer overlay;  // ids: segments, markers, then the rims of both
};

// Cuts off what lies nearer than the near plane; up to four corners remain.
std::size_t clipToNear(const Camera& camera,
                       const std::array<Corner, 3>& triangle,
                       std::array<Corner, 4>& kept) {
  std::array<float, 3> depth{};
  for (std::size_t k = 0; k < 3; ++k)
    depth[k] = camera.toCamera(triangle[k].p_W).z();
  if (camera.projection() == Projection::kOrthographic ||
      std::min({depth[0], depth[1], depth[2]}) >= camera.nearPlane()) {
    std::copy(triangle.begin(), triangle.end(), kept.begin());
    return 3;
  }
  std::size_t count = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    const bool in = depth[k] >= camera.nearPlane();
    if (in) kept[count++] = triangle[k];
    if (in == (depth[next] >= camera.nearPlane())) continue;
    const float share = (camera.nearPlane() - depth[k]) / (depth[next] - depth[k]);
    const Corner& a = triangle[k];
    const Corner& b = triangle[next];
    kept[count++] = {a.p_W + share * (b.p_W - a.p_W), a.n_W + share * (b.n_W - a.n_W),
                     a.rgb + share * (b.rgb - a.rgb)};
  }
  return count;
}

void drawLayer(const Layer& layer,
               const std::vector<std::vector<Eigen::Vector3f>>& normals,
               const Camera& camera,
               float factor,
               LayerView& view) {
  for (std::size_t m = 0; m < layer.meshes.size(); ++m) {
    const SurfaceMesh& mesh = layer.meshes[m];
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      std::array<Corner, 3> triangle;
      bool finite = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t vertex = mesh.triangles[t][k];
        triangle[k] = {
            mesh.vertices_W[vertex], normals[m][3 * t + k],
            channels(mesh.vertex_colors.empty() ? mesh.color : mesh.vertex_colors[vertex])};
        finite = finite && triangle[k].p_W.allFinite();
      }
      std::array<Corner, 4> kept;
      const std::size_t count = finite ? clipToNear(camera, triangle, kept) : 0;
      for (std::size_t k = 2; k < count; ++k) {
        Face face{{}, {kept[0], kept[k - 1], kept[k]}};
        for (std::size_t c = 0; c < 3; ++c) {
          face.screen[c] = camera.toSample(face.corners[c].p_W, factor);
        }
        const auto id = static_cast<std::uint32_t>(view.faces.size());
        if (view.buffer.drawTriangle(face.screen, id)) view.faces.push_back(face);
      }
    }
  }
}

DrawnView drawAll(const Scene& scene,
                  const std::vector<std::vector<std::vector<Eigen::Vector3f>>>& normals,
                  const Camera& camera,
                  int width,
                  int height,
                  int samples) {
  DrawnView view{{}, DepthBuffer(samples * width, samples * height)};
  for (std::size_t l = 0; l < scene.layers.size(); ++l) {
    view.layers.push_back({{}, DepthBuffer(samples * width, samples * height)});
    drawLayer(scene.layers[l], normals[l], camera, static_cast<float>(samples),
              view.layers.back());
  }
  drawOverlay(scene, camera, static_cast<float>(samples), view.overlay);
  return view;
}

// The surface that a sample shows: perspective-correct, since what is linear on the screen is
// an attribute divided by depth.
Corner surfaceAt(const Face& face, float x, float y, Projection projection) {
  const auto& [a, b, c] = face.screen;
  const float area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  Eigen::Vector3f weight(1.0F / 3.0F, 1.0F / 3.0F, 1.0F / 3.0F);
  if (area != 0.0F) {
    weight[1] = ((x - a.x) * (c.y - a.y) - (y - a.y) * (c.x - a.x)) / area;
    weight[2] = ((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)) / area;
    weight[0] = 1.0F - weight[1] - weight[2];
  }
  if (projection == Projection::kPerspective) {
    weight = weight.cwiseProduct(Eigen::Vector3f(a.nearness, b.nearness, c.nearness));
  }
  weight = weight.cwiseMax(0.0F);  // a rounded corner lies a little outside
  const float sum = weight.sum();
  if (sum > 0.0F) weight /= sum;
  Corner at;
  for (std::size_t k = 0; k < 3; ++k) {
    at.p_W += weight[static_cast<Eigen::Index>(k)] * face.corners[k].p_W;
    at.n_W += weight[static_cast<Eigen::Index>(k)] * face.corners[k].n_W;
    at.rgb += weight[static_cast<Eigen::Index>(k)] * face.corners[k].rgb;
  }
  const float length = at.n_W.norm();
  if (length > 0.0F) at.n_W /= length;
  return at;
}

const DecalArea* decalAt(const std::vector<DecalArea>& decals, const Corner& surface) {
  for (const DecalArea& decal : decals) {
    if (decal.covers(surface.p_W, surface.n_W)) return &decal;
  }
  return nullptr;
}

// Surfaces along the ray of a sample, farthest first.
struct Hit {
  float nearness;
  std::size_t layer;  // one past the last: the overlay
  std::uint32_t id;
};

void hitsAt(const DrawnView& view, int x, int y, std::vector<Hit>& hits) {
  hits.clear();
  for (std::size_t l = 0; l <= view.layers.size(); ++l) {
    const DepthBuffer& buffer = l < view.layers.size() ? view.layers[l].buffer : view.overlay;
    const std::uint32_t id = buffer.idAt(x, y);
    if (id != DepthBuffer::kNothing) hits.push_back({buffer.nearnessAt(x, y), l, id});
  }
  std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
    return a.nearness < b.nearness;
  });
}

}  // namespace

SceneRenderer::SceneRenderer(const Scene& scene) : scene_(scene) {
  validate(scene);
  for (const Layer& layer : scene.layers) {
    auto& normals = corner_normals_.emplace_back();
    for (const SurfaceMesh& mesh : layer.meshes)
      normals.push_back(cornerNormals(mesh, kCrease));
    decals_.emplace_back(layer.decals.begin(), layer.decals.end());
  }
}

Image SceneRenderer::draw(const Camera& camera, const Image& background) const {
  const DrawnView view = drawAll(scene_, corner_normals_, camera, background.width(),
                                 background.height(), kSamplesPerSide);
  const Lights lights(camera);
  Image image = background;
  std::vector<Hit> hits;
  const auto sample_color = [&](int x, int y, Color color) {
    hitsAt(view, x, y, hits);
    for (const Hit& hit : hits) {
      if (hit.layer == scene_.layers.size()) {
        color = overlayColor(scene_, hit.id);
        continue;
      }
      const Layer& layer = scene_.layers[hit.layer];
      const Face& face = view.layers[hit.layer].faces[hit.id];
      const Corner surface = surfaceAt(face, static_cast<float>(x) + 0.5F,
                                       static_cast<float>(y) + 0.5F, camera.projection());
      Color own = colorFrom(surface.rgb);
      double opacity = layer.opacity;
      if (const DecalArea* decal = decalAt(decals_[hit.layer], surface)) {
        own = blend(own, decal->color(), kDecalOpacity);
        opacity = 1.0 - 0.3 * (1.0 - opacity);  // contact shows best
      }
      color = blend(color, lights.lit(own, surface.p_W, surface.n_W), opacity);
    }
    return color;
  };

  constexpr int kCount = kSamplesPerSide * kSamplesPerSide;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      Color& pixel = image.at(x, y);
      int r = kCount / 2;
      int g = r;
      int b = r;
      for (int s = 0; s < kCount; ++s) {
        const Color sample = sample_color(kSamplesPerSide * x + s % kSamplesPerSide,
                                          kSamplesPerSide * y + s / kSamplesPerSide, pixel);
        r += sample.r;
        g += sample.g;
        b += sample.b;
      }
      pixel = {static_cast<std::uint8_t>(r / kCount), static_cast<std::uint8_t>(g / kCount),
               static_cast<std::uint8_t>(b / kCount)};
    }
  }
  return image;
}

std::vector<double> SceneRenderer::visibleDecals(const Camera& camera,
                                                 int width,
                                                 int height) const {
  const DrawnView view = drawAll(scene_, corner_normals_, camera, width, height, 1);
  std::vector<std::size_t> first_of;  // decal of each layer, in the list of all
  std::size_t count = 0;
  for (const auto& decals : decals_) {
    first_of.push_back(count);
    count += decals.size();
  }
  std::vector<double> seen(count, 0.0);
  std::vector<Hit> hits;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      hitsAt(view, x, y, hits);
      double passing = 1.0;
      for (auto hit = hits.rbegin(); hit != hits.rend(); ++hit) {
        if (hit->layer == scene_.layers.size()) continue;
        const Face& face = view.layers[hit->layer].faces[hit->id];
        const Corner surface = surfaceAt(face, static_cast<float>(x) + 0.5F,
                                         static_cast<float>(y) + 0.5F, camera.projection());
        const std::vector<DecalArea>& decals = decals_[hit->layer];
        if (const DecalArea* decal = decalAt(decals, surface)) {
          seen[first_of[hit->layer] + static_cast<std::size_t>(decal - decals.data())] +=
              passing / (static_cast<double>(width) * height);
        }
        passing *= 1.0 - scene_.layers[hit->layer].opacity;
      }
    }
  }
  return seen;
}

double SceneRenderer::visibleContact(const Camera& camera, int width, int height) const {
  const std::vector<double> seen = visibleDecals(camera, width, height);
  return std::accumulate(seen.begin(), seen.end(), 0.0);
}

}  // namespace handgraft::client::render
