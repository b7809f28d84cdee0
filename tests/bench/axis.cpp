#include "tests/bench/axis.h"

#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/contact/axis.h"
#include "core/contact/segmentation.h"
#include "core/geometry/straightest_geodesic.h"
#include "core/geometry/surface_locator.h"
#include "core/geometry/tangent_direction.h"
#include "core/hand/contact_site.h"
#include "core/io/contact_file.h"
#include "core/io/urdf_file.h"
#include "core/transfer/patch_transfer.h"

#include "tests/bench/axis_shape.h"

namespace handgraft::bench {
namespace {

using contact::Patch;
using geometry::SurfacePoint;
using geometry::TriangleMesh;

constexpr int kRings = 5;

struct Hand {
  std::string name;
  std::shared_ptr<const hand::HandModel> model;
  std::shared_ptr<const hand::Skin> skin;
  std::vector<hand::ContactSite> sites;
};

struct LongPatch {
  std::string name;  ///< of the object and the patch
  std::shared_ptr<const TriangleMesh> object_O;
  Patch patch;
  contact::PatchShape shape;
};

Hand loadHand(const std::filesystem::path& urdf) {
  Hand hand;
  hand.name = urdf.stem().string();
  hand.model = std::make_shared<const hand::HandModel>(io::readUrdf(urdf).model);
  hand.skin = std::make_shared<const hand::Skin>(
      hand::buildSkin(*hand.model, hand::SkinOptions(), Progress()));
  hand.sites = hand::findContactSites(*hand.model, *hand.skin);
  return hand;
}

// === Patches

/// A finger's strip on a round object: `at(along, across)` says where, around the root.
template <class At>
LongPatch stripOn(const std::string& name, const TriangleMesh& mesh, const At& at) {
  const geometry::SurfaceLocator locator(mesh);
  constexpr double kLength = 0.080;
  constexpr double kWidth = 0.015;
  constexpr double kRound = 0.0075;  // the ends are half disks
  LongPatch strip;
  strip.name = name;
  strip.object_O = std::make_shared<const TriangleMesh>(mesh);
  strip.patch.name = "index";
  strip.patch.root = locator.nearest(at(0.0, 0.0)).point;
  constexpr int kCount = 50;
  const double straight = kLength - 2.0 * kRound;
  const double around = std::numbers::pi * kRound;
  for (int k = 0; k < kCount; ++k) {
    double s = (2.0 * straight + 2.0 * around) * k / kCount;
    double across = -0.5 * kWidth;
    const bool back = s >= straight + around;
    if (back) s -= straight + around;
    double along = s - 0.5 * straight;
    if (s > straight) {
      const double angle = (s - straight) / kRound;
      along = 0.5 * straight + kRound * std::sin(angle);
      across = -kRound * std::cos(angle);
    }
    if (back) along = -along;
    if (back) across = -across;
    strip.patch.interpolation_boundary.push_back(locator.nearest(at(along, across)).point);
  }
  return strip;
}

/// Around a bottle of 70 mm, straight and slanted; over a ball of 100 mm; inside a bowl's
/// curve.
std::vector<LongPatch> strips() {
  std::vector<LongPatch> strips;
  const TriangleMesh bottle = geometry::makeCylinder(0.035, 0.2, 96);
  for (const double slant : {0.0, 0.5}) {
    strips.push_back(stripOn(
        slant == 0.0 ? "strip around a bottle" : "strip slanted on a bottle", bottle,
        [&](double along, double across) {
          const Eigen::Vector2d p = Eigen::Rotation2Dd(slant) * Eigen::Vector2d(along, across);
          const double angle = p.x() / 0.035;
          return Eigen::Vector3d(0.035 * std::cos(angle), 0.035 * std::sin(angle), p.y());
        }));
  }
  for (const double radius : {0.05, 0.03}) {
    strips.push_back(stripOn(fmt::format("strip over a ball of {:.0f} mm", 2e3 * radius),
                             geometry::makeSphere(radius, 5), [&](double along, double across) {
                               const double a = along / radius;
                               const double b = across / radius;
                               return Eigen::Vector3d(
                                   radius * Eigen::Vector3d(std::cos(b) * std::sin(a),
                                                            std::sin(b),
                                                            std::cos(b) * std::cos(a)));
                             }));
  }
  return strips;
}

/// Patches of the contact map longer than 40 mm, at the threshold.
void addPatchesOf(const std::filesystem::path& path,
                  double threshold,
                  std::vector<LongPatch>& patches) {
  const contact::ContactMap map = io::readContactMap(path);
  contact::SegmentationOptions options;
  options.threshold = threshold;
  const auto object_O = std::make_shared<const TriangleMesh>(map.mesh_O);
  contact::ContactSet set;
  try {
    set = segment(map, options);
  } catch (const InvalidInput&) {
    return;  // nothing above the threshold
  }
  for (const Patch& patch : set.patches) {
    const std::string name =
        fmt::format("{} {} > {}", path.stem().string(), patch.name, threshold);
    patches.push_back({name, object_O, patch, {}});
  }
}

// === One patch on one hand

/// A finger's patch lies along it, its end at the tip; others lie about the palm's site.
std::optional<transfer::Placement> placementOf(const Hand& hand, const LongPatch& item) {
  const auto siteOf = [&](const std::string& name) -> const hand::ContactSite* {
    for (const hand::ContactSite& site : hand.sites) {
      if (site.name == name) return &site;
    }
    return nullptr;
  };
  const hand::ContactSite* site = siteOf(item.patch.name);
  const bool is_finger = site != nullptr && item.patch.name != "palm";
  if (site == nullptr) site = siteOf("palm");
  if (site == nullptr) return std::nullopt;
  const transfer::Placement placement = transfer::placementAt(*hand.model, *hand.skin, *site);
  if (!is_finger) return placement;
  const double way = std::max(0.5 * item.shape.length_m - 0.008, 0.0);
  const geometry::StraightWalk walk =
      walkStraight(hand.skin->mesh(), placement.root_S, placement.direction_S, way);
  return transfer::Placement{walk.point, walk.direction};
}

NetChange changeOn(const Hand& hand,
                   const LongPatch& item,
                   const PatchNet& net,
                   const std::vector<SurfacePoint>& axis,
                   const transfer::Placement& placement) {
  // The whole net goes over as the boundary would: from the root, or from the axis.
  Patch patch = item.patch;
  patch.boundary.clear();
  patch.interpolation_boundary = net.places;
  patch.axis = axis;
  const transfer::PatchTransfer moved =
      transferPatch(*item.object_O, patch, *hand.skin, placement);
  std::vector<char> is_lost(net.places.size());
  for (const transfer::LostPoint& lost : moved.lost) {
    if (lost.ring == 0) is_lost[lost.index] = 1;
  }
  std::vector<std::optional<Eigen::Vector3d>> p_S(net.places.size());
  std::vector<std::optional<Eigen::Vector3d>> n_S(net.places.size());
  std::size_t next = 0;
  for (std::size_t i = 0; i < net.places.size(); ++i) {
    if (is_lost[i] != 0) continue;
    const SurfacePoint& place = moved.places_S[next++];
    p_S[i] = positionOf(hand.skin->mesh(), place);
    n_S[i] = normalOf(hand.skin->mesh(), place);
  }
  return changeOf(net, p_S, n_S);
}

struct Sum {
  int count = 0;
  int lost = 0;
  int places = 0;
  double length = 0.0;
  double worst = 0.0;
  double angle = 0.0;
  double area = 0.0;
  double turned = 0.0;
  double fit = 0.0;

  void add(const NetChange& change, int size) {
    ++count;
    places += size;
    lost += change.lost;
    length += change.length_mean;
    worst += change.length_worst;
    angle += change.angle_mean;
    area += std::abs(std::log(change.area_ratio));
    turned += change.turned_over;
    fit += change.fit_rms;
  }

  void print(const char* name) const {
    if (count == 0) return;
    fmt::print(
        "| {} | {} | {} of {} | {:.1f} % | {:.1f} % | {:.1f} | {:.1f} % | {:.2f} % | "
        "{:.2f} |\n",
        name, count, lost, places, 100 * length / count, 100 * worst / count,
        180 / std::numbers::pi * angle / count, 100 * (std::exp(area / count) - 1),
        100 * turned / count, 1e3 * fit / count);
  }
};

constexpr const char* kColumns = "lost | length | 95th | angle deg | area | turned | fit mm |";

void printRow(const std::string& name, const NetChange& c) {
  fmt::print("| {} | {} | {:.1f} % | {:.1f} % | {:.1f} | {:.2f} | {:.2f} % | {:.2f} |\n", name,
             c.lost, 100 * c.length_mean, 100 * c.length_worst,
             180 / std::numbers::pi * c.angle_mean, c.area_ratio, 100 * c.turned_over,
             1e3 * c.fit_rms);
}

struct AxisBenchOptions {
  std::vector<std::string> hands;
  std::vector<std::string> contacts;
  bool all = false;
};

void compare(const Hand& hand,
             LongPatch item,
             bool print_each,
             Sum& root,
             Sum& axis,
             int& better,
             int& worse) {
  item.shape = shapeOf(*item.object_O, item.patch);
  item.patch.direction_O = item.shape.long_direction_O;
  const std::vector<SurfacePoint> knots = makeAxis(*item.object_O, item.patch);
  if (knots.empty()) return;
  const auto placement = placementOf(hand, item);
  if (!placement) return;
  const PatchNet net = netOf(*item.object_O, item.patch, kRings);
  const NetChange from_root = changeOn(hand, item, net, {}, *placement);
  const NetChange from_axis = changeOn(hand, item, net, knots, *placement);
  const int size = static_cast<int>(net.places.size());
  root.add(from_root, size);
  axis.add(from_axis, size);
  if (from_axis.length_mean < from_root.length_mean - 0.002) ++better;
  if (from_axis.length_mean > from_root.length_mean + 0.002) ++worse;
  if (!print_each) return;
  const std::string title =
      fmt::format("{}, {:.0f} x {:.0f} mm on {}", item.name, 1e3 * item.shape.length_m,
                  1e3 * item.shape.width_m, hand.name);
  printRow(title + ", root", from_root);
  printRow(title + ", axis", from_axis);
}

void runAxis(const AxisBenchOptions& options) {
  std::vector<LongPatch> real;
  for (const std::string& path : options.contacts) {
    for (const double threshold : {0.1, 0.2, 0.4})
      addPatchesOf(path, threshold, real);
  }
  const std::vector<LongPatch> made = strips();
  Sum made_root, made_axis, real_root, real_axis;
  int made_better = 0, made_worse = 0, real_better = 0, real_worse = 0;
  if (options.all) fmt::print("| patch | {}\n|---|---|---|---|---|---|---|---|\n", kColumns);
  for (const std::string& urdf : options.hands) {
    const Hand hand = loadHand(urdf);
    for (const LongPatch& item : made)
      compare(hand, item, options.all, made_root, made_axis, made_better, made_worse);
    for (const LongPatch& item : real)
      compare(hand, item, options.all, real_root, real_axis, real_better, real_worse);
  }
  fmt::print("| patches | count | {}\n|---|---|---|---|---|---|---|---|---|\n", kColumns);
  made_root.print("strips, root");
  made_axis.print("strips, axis");
  real_root.print("real, root");
  real_axis.print("real, axis");
  fmt::print("strips: {} better, {} worse of {}; real: {} better, {} worse of {}\n",
             made_better, made_worse, made_axis.count, real_better, real_worse,
             real_axis.count);
}

}  // namespace

void addAxisCommand(CLI::App& app) {
  auto options = std::make_shared<AxisBenchOptions>();
  CLI::App* command =
      app.add_subcommand("axis", "Long patches from a single root and along an axis");
  command->add_option("--hand", options->hands, "URDFs")->required();
  command->add_option("--contacts", options->contacts, "contact maps (PLY)");
  command->add_flag("--all", options->all, "print every patch");
  command->callback([options]() {
    runAxis(*options);
  });
}

}  // namespace handgraft::bench
