#include "client/cli/options/model_flags.h"

#include <cmath>

#include <CLI/CLI.hpp>
#include <fmt/ranges.h>

#include "client/cli/options/option_checks.h"
#include "core/base/error.h"
#include "core/base/length_unit.h"

namespace handgraft::client {

namespace {

// Errors that name the first option that was given.
void requireNone(const std::vector<CLI::Option*>& options, const std::string& reason) {
  for (const CLI::Option* given : options) {
    if (given->count() > 0) rejectInput("{}: {}", given->get_name(), reason);
  }
}

std::string alreadyRead(const std::string& model, const char* option) {
  return fmt::format("{} {} has been read already; it is for files", option, model);
}

std::int32_t handNumber(const std::string& text) {
  if (text == "left" || text == "0") return 0;
  if (text == "right" || text == "1") return 1;
  rejectInput("--joints-hand {}: it is left, right, 0 or 1", quoted(text));
}

}  // namespace

void HandFlags::addTo(CLI::App& command) {
  options_ = {
      command.add_flag("--mirror", mirrored_, "Take the other hand: a left one of a right one"),
      command.add_option("--srdf", srdf_, "Named poses; default: the SRDF beside the URDF")
          ->check(objectionToFile),
      command.add_option("--rest", rest_pose_, "The named pose that the hand rests in"),
      command
          .add_option("--surfaces", surfaces_,
                      "What the skin is laid around: visuals (default) or collisions")
          ->check(CLI::IsMember({"visuals", "collisions"})),
      command.add_option("--alpha", alpha_mm_,
                         "How tightly the skin is laid: gaps of about 2 alpha close; mm"),
      command.add_option("--offset", offset_mm_, "How far off the links the skin stands; mm"),
      command.add_option("--edge", edge_mm_, "Length of the skin's edges; mm"),
      command.add_option("--package", packages_, "NAME=DIR: where package://NAME leads")
          ->allow_extra_args(false)};  // what follows may be the command's own argument
}

HandReading HandFlags::reading() const {
  HandReading reading;
  reading.packages = packagesOf(packages_);
  reading.srdf = srdf_;
  reading.options.mirrored(mirrored_);
  reading.options.rest_pose(rest_pose_);
  v1::SkinRecipe& skin = reading.options.skin();
  skin.surfaces(surfaces_);
  skin.alpha_m(scaled(alpha_mm_, "--alpha", 0.5, 50.0, 1e-3));
  skin.offset_m(scaled(offset_mm_, "--offset", 0.05, 10.0, 1e-3));
  skin.edge_m(scaled(edge_mm_, "--edge", 0.5, 50.0, 1e-3));
  return reading;
}

void HandFlags::requirePath(const std::string& hand, const char* option) const {
  if (isPath(hand)) return;
  const bool is_option = option[0] == '-';
  requireNone(options_,
              fmt::format("{}: give the hand's URDF, as {}HAND.urdf", alreadyRead(hand, option),
                          is_option ? option + std::string(" ") : ""));
}

void HandFlags::requireUnused(const char* whom) const {
  requireNone(options_, fmt::format("it is for {} alone", whom));
}

void ContactFlags::addSourceTo(CLI::App& command, const std::string& hand_option) {
  for (CLI::Option* option :
       {command.add_option("--value", value_property_,
                           "The map's property with the values; default: contact"),
        command.add_option("--label", label_property_,
                           "The one with the touching segment; default: link, if there is one"),
        command.add_option("--colors", color_scale_,
                           "Values are shown by colours: grey, hot, inferno, jet, viridis"),
        command
            .add_option("--picture", picture_,
                        "A PNG with those colours, for a map with texture coordinates")
            ->check(objectionToFile),
        command
            .add_option("--joints", joints_,
                        "JSON: 21 joints of the hand that touched; they tell the fingers")
            ->check(objectionToFile),
        command.add_option(hand_option, joints_hand_,
                           "Which hand of that file: left, right, 0 or 1")}) {
    options_.push_back(option);
  }
}

void ContactFlags::addSegmentationTo(CLI::App& command) {
  CLI::Option* threshold =
      command.add_option("--threshold", threshold_, "Contact above this counts; default 0.4");
  CLI::Option* otsu = command.add_flag("--otsu", otsu_, "Find the threshold (Otsu)");
  threshold->excludes(otsu);
  for (CLI::Option* option :
       {threshold, otsu,
        command.add_option("--low-share", low_share_,
                           "Down to this share of the threshold counts beside contact: 0-1"),
        command.add_option("--outline", outline_share_,
                           "A patch ends below this share of what its contact reaches: 0 (at "
                           "the threshold) to 1; default 0.75"),
        command.add_option("--smooth", smoothing_steps_, "Steps of smoothing: 0-1000")
            ->check(objectionToCount),
        command.add_option("--min-area", minimum_area_mm2_,
                           "Smaller regions are dropped; mm2, default 20"),
        command
            .add_option("--points", interpolation_count_,
                        "Points on each patch's outline: 3-10000, default 25")
            ->check(objectionToCount)}) {
    options_.push_back(option);
  }
}

ContactReading ContactFlags::reading() const {
  ContactReading reading;
  reading.picture = picture_;
  reading.joints = joints_;
  v1::ContactOptions& options = reading.options;
  options.value_property(value_property_);
  options.label_property(label_property_);
  options.color_scale(color_scale_);
  if (!picture_.empty() && color_scale_.empty()) {
    rejectInput("--picture {}: --colors must say what its colours mean", quoted(picture_));
  }
  if (!joints_hand_.empty()) {
    if (joints_.empty()) rejectInput("--joints-hand {}: it goes with --joints", joints_hand_);
    options.joints_hand().push_back(handNumber(joints_hand_));
  }
  if (threshold_) {
    if (!std::isfinite(*threshold_)) {
      rejectInput("--threshold {}: it must be finite", *threshold_);
    }
    options.threshold().push_back(*threshold_);
  }
  options.otsu(otsu_);
  if (low_share_) {
    if (!(*low_share_ > 0.0 && *low_share_ <= 1.0)) {
      rejectInput("--low-share {}: it must be above 0 and at most 1", *low_share_);
    }
    options.low_share().push_back(*low_share_);
  }
  if (outline_share_) {
    if (!(*outline_share_ >= 0.0 && *outline_share_ < 1.0)) {
      rejectInput("--outline {}: it must be at least 0 and below 1", *outline_share_);
    }
    options.outline_share().push_back(*outline_share_);
  }
  if (smoothing_steps_ > 1000) {
    rejectInput("--smooth {}: it must be 0 to 1000", smoothing_steps_);
  }
  options.smoothing_steps(smoothing_steps_);
  if (minimum_area_mm2_) {
    options.minimum_area_m2().push_back(
        scaled(minimum_area_mm2_, "--min-area", 0.0, 1e6, 1e-6));
  }
  const bool no_loop = interpolation_count_ < 3 || interpolation_count_ > 10000;
  for (const CLI::Option* option : options_) {
    if (option->get_name() != "--points" || option->count() == 0 || !no_loop) continue;
    rejectInput("--points {}: it must be 3 to 10000", interpolation_count_);
  }
  options.interpolation_count(interpolation_count_);
  return reading;
}

void ContactFlags::requirePath(const std::string& contacts, const char* option) const {
  if (!isPath(contacts)) requireNone(options_, alreadyRead(contacts, option));
}

void ContactFlags::requireUnused(const char* whom) const {
  requireNone(options_, fmt::format("it is for {} alone", whom));
}

void addUnits(CLI::App& command, std::string& units, const std::string& whose) {
  std::vector<std::string> names;
  names.reserve(std::size(kLengthUnits));
  for (const LengthUnit& unit : kLengthUnits)
    names.emplace_back(unit.name);
  command
      .add_option("--units", units,
                  fmt::format("Units of {}: {}; default: m unless its size says otherwise",
                              whose, fmt::join(names, ", ")))
      ->check(CLI::IsMember(names));
}

}  // namespace handgraft::client
