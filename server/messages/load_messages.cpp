#include "server/messages/load_messages.h"

#include <cmath>

#include "core/base/error.h"
#include "core/contact/threshold.h"
#include "core/io/color_map.h"
#include "server/reading/units.h"

namespace handgraft::server {

namespace {

/// 0 stands for the default. The ranges are those of core/hand/skin.h.
void takeLength(double& length_m, double given_m, const char* name, double least, double most) {
  if (given_m == 0.0) return;
  if (!(given_m >= least && given_m <= most)) {
    rejectInput("skin: {} is {} m; permitted are {} to {} m, or 0 for the default", name,
                given_m, least, most);
  }
  length_m = given_m;
}

/// The one of a sequence that holds one or none.
template <class Sequence, class Value>
void take(const Sequence& given, Value& value, const char* name) {
  if (given.empty()) return;
  if (given.size() > 1) rejectInput("{}: {} values instead of one", name, given.size());
  value = given.front();
}

void requireRange(double value, const char* name, double least, double most) {
  if (!(value >= least && value <= most))
    rejectInput("{} is {}; permitted are {} to {}", name, value, least, most);
}

template <class Options>
void refuse(const std::vector<Options>& options, const char* what, const char* kind) {
  if (!options.empty())
    rejectInput("{} options are for {}, which this model is not", what, kind);
}

ReadKind kindFrom(v1::ModelKind kind) {
  switch (kind) {
    case v1::MODEL_HAND:
      return ReadKind::kHand;
    case v1::MODEL_OBJECT:
      return ReadKind::kObject;
    case v1::MODEL_CONTACTS:
      return ReadKind::kContacts;
    case v1::MODEL_MOTION:
      return ReadKind::kMotion;
  }
  rejectInput("model kind {} does not exist", static_cast<unsigned>(kind));
}

}  // namespace

hand::SkinOptions skinOptionsFrom(const v1::SkinRecipe& recipe) {
  hand::SkinOptions options;
  if (recipe.surfaces() == "collisions") {
    options.source = hand::SurfaceSource::kCollisions;
  } else if (!recipe.surfaces().empty() && recipe.surfaces() != "visuals") {
    rejectInput("skin: surfaces {} are not known; permitted are visuals and collisions",
                handgraft::quoted(recipe.surfaces()));
  }
  takeLength(options.alpha_m, recipe.alpha_m(), "alpha", 5e-4, 0.05);
  takeLength(options.offset_m, recipe.offset_m(), "offset", 5e-5, 0.01);
  takeLength(options.edge_m, recipe.edge_m(), "edge", 5e-4, 0.05);
  return options;
}

HandReading handReadingFrom(const v1::HandOptions& options) {
  HandReading reading;
  reading.mirrored = options.mirrored();
  reading.srdf_uri = options.srdf_uri();
  reading.rest_pose = options.rest_pose();
  if (!reading.rest_pose.empty() && reading.srdf_uri.empty()) {
    rejectInput("rest pose {}: there is no SRDF that could name it",
                handgraft::quoted(reading.rest_pose));
  }
  reading.skin = skinOptionsFrom(options.skin());
  return reading;
}

contact::SegmentationOptions segmentationFrom(const v1::ContactOptions& options) {
  constexpr double kMostNumber = 1e12;
  contact::SegmentationOptions segmentation;
  take(options.threshold(), segmentation.threshold, "threshold");
  requireRange(segmentation.threshold, "threshold", -kMostNumber, kMostNumber);
  if (options.otsu()) {
    if (!options.threshold().empty())
      rejectInput("threshold is {} and to be found at once; choose one",
                  segmentation.threshold);
    segmentation.rule = contact::ThresholdRule::kOtsu;
  }
  take(options.low_share(), segmentation.low_share, "low_share");
  if (!(segmentation.low_share > 0.0 && segmentation.low_share <= 1.0))
    rejectInput("low_share is {}; permitted are (0, 1]", segmentation.low_share);
  take(options.outline_share(), segmentation.outline_share, "outline_share");
  if (!(segmentation.outline_share >= 0.0 && segmentation.outline_share < 1.0))
    rejectInput("outline_share is {}; permitted are [0, 1)", segmentation.outline_share);
  requireRange(options.smoothing_steps(), "smoothing_steps", 0, contact::kMostSmoothingSteps);
  segmentation.smoothing_steps = static_cast<int>(options.smoothing_steps());
  take(options.minimum_area_m2(), segmentation.minimum_area_m2, "minimum_area_m2");
  requireRange(segmentation.minimum_area_m2, "minimum_area_m2", 0.0, kMostNumber);
  if (options.interpolation_count() != 0) {
    requireRange(options.interpolation_count(), "interpolation_count",
                 contact::kFewestInterpolationPoints, contact::kMostInterpolationPoints);
    segmentation.interpolation_count = static_cast<int>(options.interpolation_count());
  }
  return segmentation;
}

ContactReading contactReadingFrom(const v1::ContactOptions& options) {
  ContactReading reading;
  reading.segmentation = segmentationFrom(options);
  if (!options.value_property().empty())
    reading.source.value_property = options.value_property();
  if (!options.label_property().empty())
    reading.source.label_property = options.label_property();
  reading.source.color_scale = options.color_scale();
  if (!options.color_scale().empty()) (void)io::colorMap(options.color_scale());
  reading.picture_uri = options.picture_uri();
  if (!reading.picture_uri.empty() && reading.source.color_scale.empty()) {
    rejectInput("picture {}: a picture needs a colour scale, one of {}",
                handgraft::quoted(reading.picture_uri), fmt::join(io::colorMapNames(), ", "));
  }
  reading.joints_uri = options.joints_uri();
  take(options.joints_hand(), reading.joints_hand, "joints_hand");
  return reading;
}

ReadRequest readRequestFrom(const v1::LoadModelRequest& request, const UploadedFiles& files) {
  ReadRequest reading;
  reading.kind = kindFrom(request.kind());
  reading.name = request.name();
  reading.main_uri = request.main_uri();
  reading.files = files.all();
  reading.units = request.units();
  (void)metresPer(reading.units);
  if (reading.kind != ReadKind::kHand) refuse(request.hand(), "hand", "hands");
  if (reading.kind != ReadKind::kContacts)
    refuse(request.contacts(), "contact map", "contact maps");
  if (!request.hand().empty()) reading.hand = handReadingFrom(request.hand().front());
  if (!request.contacts().empty())
    reading.contacts = contactReadingFrom(request.contacts().front());
  return reading;
}

}  // namespace handgraft::server
