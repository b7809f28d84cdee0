#include "client/present/render/two_views.h"

#include <algorithm>
#include <utility>

#include <Eigen/Geometry>

#include "client/present/render/camera.h"
#include "client/present/render/scene_renderer.h"
#include "client/present/render/text.h"
#include "core/base/error.h"

namespace handgraft::client::render {

namespace {

constexpr int kLeastSide = 200;
constexpr int kPad = 14;
constexpr int kTitleScale = 3;
constexpr int kTextScale = 2;
constexpr int kLabelGap = 14;
constexpr Color kInk{38, 42, 48};
constexpr Color kFaintInk{105, 112, 122};
constexpr Color kSky{250, 251, 253};
constexpr Color kGround{226, 231, 238};
constexpr Color kPaper{255, 255, 255};

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

// Words beside their places, on paper-coloured rims so that they can be read anywhere; later
// ones make way for earlier ones.
void drawLabels(Image& view, const std::vector<Label>& labels, const Camera& camera) {
  struct Box {
    int left, top, right, bottom;
  };

  std::vector<Box> taken;
  for (const Label& label : labels) {
    const Eigen::Vector3f p_C = camera.toCamera(label.at_W);
    if (!(p_C.z() >= camera.nearPlane())) continue;
    if (label.facing_W.dot(camera.towardsEye(label.at_W)) < 0.0F) continue;
    const ScreenPoint place = camera.toScreen(p_C);
    const int width = textWidth(label.text, kTextScale);
    const int height = textHeight(kTextScale);
    int x = static_cast<int>(place.x) + kLabelGap;
    if (x + width > view.width()) x = static_cast<int>(place.x) - kLabelGap - width;
    int y = std::clamp(static_cast<int>(place.y) - height / 2, 1,
                       std::max(1, view.height() - height));
    for (std::size_t i = 0; i < taken.size(); ++i) {
      const Box& box = taken[i];
      if (x >= box.right || x + width <= box.left) continue;
      if (y >= box.bottom || y + height <= box.top) continue;
      y = box.bottom;
      i = static_cast<std::size_t>(-1);  // it may meet an earlier one now; each step goes down
    }
    taken.push_back({x - 4, y - 2, x + width + 4, y + height + 2});
    for (const auto& [dx, dy] :
         {std::pair(-2, 0), {2, 0}, {0, -2}, {0, 2}, {-1, -1}, {1, 1}, {-1, 1}, {1, -1}}) {
      drawText(view, x + dx, y + dy, kTextScale, kPaper, label.text);
    }
    drawText(view, x, y, kTextScale, blend(label.color, {0, 0, 0}, 0.35), label.text);
  }
}

}  // namespace

Image renderTwoViews(const Scene& scene,
                     const Caption& caption,
                     const std::array<View, 2>& views,
                     PictureSize size) {
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
  const Image background = gradient(view_width, view_height);
  int x = kPad;
  for (const View& view : views) {
    const Camera camera = Camera::fitting(points, view.from_W, view.up_W, view_width,
                                          view_height, Projection::kPerspective);
    Image side = renderer.draw(camera, background);
    drawLabels(side, scene.labels, camera);
    drawText(side, kPad, kPad, kTextScale, kFaintInk, view.title);
    paste(picture, x, header, side);
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

Image renderTwoViews(const Scene& scene, const Caption& caption, PictureSize size) {
  return renderTwoViews(scene, caption, viewsAroundUp(scene), size);
}

}  // namespace handgraft::client::render
