#pragma once

#include <array>
#include <string>
#include <vector>

#include "client/present/render/image.h"
#include "client/present/render/scene.h"
#include "client/present/render/views.h"

namespace handgraft::client::render {

struct LegendEntry {
  Color color;
  std::string text;
};

struct Caption {
  std::string title;
  std::string subtitle;
  std::vector<LegendEntry> legend;
};

struct PictureSize {
  int width = 1600;
  int height = 1000;
};

/// A picture of the scene from two sides, next to each other under a title and above a legend.
/// Labels of the scene stand beside their places.
/// Errors: InvalidInput for a scene that is not valid, or a side below 200 pixels.
Image renderTwoViews(const Scene& scene,
                     const Caption& caption,
                     const std::array<View, 2>& views,
                     PictureSize size = {});

/// The same from `viewsAroundUp`.
/// Cost:   92,000 triangles on 1600 x 1000 pixels take about 0.6 s of one core, the choice of
/// the views included.
Image renderTwoViews(const Scene& scene, const Caption& caption, PictureSize size = {});

}  // namespace handgraft::client::render
