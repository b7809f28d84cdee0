#include "client/render/two_views.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Geometry>

#include "client/render/camera.h"
#include "client/render/scene_renderer.h"
#include "client/render/text.h"
#include "core/base/error.h"

namespace handgraft::client::render {

namespace {

constexpr int kLeastSide = 200;
constexpr int kPad = 14;
constexpr int kTitleScale = 3;
constexpr int kTextScale = 2;
constexpr Color kInk{38, 42, 48};
constexpr Color kFaintInk{105, 112, 122};
constexpr Color kSky{250, 251, 253};
constexpr Color kGround{226, 231, 238};
constexpr Color kPaper{255, 255, 255};

constexpr int kAzimuths = 8;
constexpr int kScoutSize = 112;  // pixels: a fingertip's patch is about 6 across

struct Direction {
  int azimuth;  // in steps of 360 / kAzimuths degrees
  Eigen::Vector3d from_W;
  double contact;
};

std::vector<Direction> scout(const SceneRenderer& renderer,
                             const std::vector<Eigen::Vector3f>& points) {
  std::vector<Direction> directions;
  for (const double elevation : {0.18, 0.65}) {  // rad: about level, and from above
    for (int a = 0; a < kAzimuths; ++a) {
      const double azimuth = 2.0 * std::numbers::pi * (a + 0.25) / kAzimuths;  // seldom edge-on
      const Eigen::Vector3d from_W(std::cos(elevation) * std::cos(azimuth),
                                   std::cos(elevation) * std::sin(azimuth),
                                   std::sin(elevation));
      const Camera camera = Camera::fitting(points, from_W, Eigen::Vector3d::UnitZ(),
                                            kScoutSize, kScoutSize, Projection::kPerspective);
      directions.push_back(
          {a, from_W, renderer.visibleContact(camera, kScoutSize, kScoutSize)});
    }
  }
  return directions;
}

Eigen::Vector3d best(const std::vector<Direction>& directions, std::optional<int> away_from) {
  const Direction* found = nullptr;
  for (const Direction& direction : directions) {
    if (away_from) {
      const int turn = std::abs(direction.azimuth - *away_from);
      const int steps = std::min(turn, kAzimuths - turn);
      if (steps < kAzimuths / 4 || steps > 3 * kAzimuths / 8) continue;
    }
    if (found == nullptr || direction.contact > found->contact) found = &direction;
  }
  HANDGRAFT_REQUIRE(found != nullptr);
  return found->from_W;
}

int azimuthOf(const std::vector<Direction>& directions, const Eigen::Vector3d& from_W) {
  const auto found =
      std::find_if(directions.begin(), directions.end(), [&](const Direction& d) {
        return d.from_W == from_W;
      });
  return found->azimuth;
}

Image gradient(int width, int height) {
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    image.fill(0, y, width, 1, blend(kSky, kGround, static_cast<double>(y) / height));
  }
  return image;
}

void paste(Image& target, int left, int top, const Image& source) {
  const int width = std::min(source.width(), target.width() - left);
  const int height = std::min(source.height(), target.height() - top);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x)
      target.at(left + x, top + y) = source.at(x, y);
  }
}

struct LegendPlace {
  int x;
  int row;
};

// Entries one after the other, broken into rows where the picture ends.
std::vector<LegendPlace> layOut(const std::vector<LegendEntry>& legend, int width) {
  std::vector<LegendPlace> places;
  int x = kPad;
  int row = 0;
  for (const LegendEntry& entry : legend) {
    const int needed = 28 + textWidth(entry.text, kTextScale);
    if (x > kPad && x + needed > width - kPad) {
      x = kPad;
      ++row;
    }
    places.push_back({x, row});
    x += needed + 2 * kPad;
  }
  return places;
}

}  // namespace

Image renderTwoViews(const Scene& scene, const Caption& caption, PictureSize size) {
  if (size.width < kLeastSide || size.height < kLeastSide) {
    rejectInput("picture size {} x {}: each side is at least {} pixels", size.width,
                size.height, kLeastSide);
  }
  Image picture(size.width, size.height, kPaper);

  // === What the caption leaves for the views
  const int header = 2 * kPad + textHeight(kTitleScale) +
                     (caption.subtitle.empty() ? 0 : kPad / 2 + textHeight(kTextScale));
  const int line = textHeight(kTextScale) + 6;
  const std::vector<LegendPlace> places = layOut(caption.legend, size.width);
  const int rows = places.empty() ? 0 : places.back().row + 1;
  const int footer = rows == 0 ? kPad : 2 * kPad + rows * line - 6;
  const int view_height = std::max(kLeastSide / 4, size.height - header - footer);
  const int view_width = (size.width - 3 * kPad) / 2;

  // === The views
  const SceneRenderer renderer(scene);
  const std::vector<Eigen::Vector3f> points = scene.points();
  const std::vector<Direction> directions = scout(renderer, points);
  const Eigen::Vector3d left_W = best(directions, std::nullopt);
  const Eigen::Vector3d right_W = best(directions, azimuthOf(directions, left_W));
  const Image background = gradient(view_width, view_height);
  int x = kPad;
  for (const Eigen::Vector3d& from_W : {left_W, right_W}) {
    const Camera camera = Camera::fitting(points, from_W, Eigen::Vector3d::UnitZ(), view_width,
                                          view_height, Projection::kPerspective);
    paste(picture, x, header, renderer.draw(camera, background));
    x += view_width + kPad;
  }

  // === Title and legend
  drawText(picture, kPad, kPad, kTitleScale, kInk, caption.title);
  drawText(picture, kPad, kPad + textHeight(kTitleScale) + kPad / 2, kTextScale, kFaintInk,
           caption.subtitle);
  for (std::size_t i = 0; i < caption.legend.size(); ++i) {
    const int y = header + view_height + kPad + places[i].row * line;
    picture.fill(places[i].x, y, 20, 7 * kTextScale, caption.legend[i].color);
    drawText(picture, places[i].x + 28, y, kTextScale, kInk, caption.legend[i].text);
  }
  return picture;
}

}  // namespace handgraft::client::render
