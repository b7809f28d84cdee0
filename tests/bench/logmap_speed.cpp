#include "tests/bench/logmap_speed.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/hand/contact_site.h"
#include "core/io/urdf_file.h"

#include "tests/bench/disk_speed.h"
#include "tests/bench/skin_cache.h"

namespace handgraft::bench {

namespace {

using geometry::LogMapMethod;
using geometry::SurfacePoint;
using geometry::TriangleMesh;

constexpr double kPi = std::numbers::pi;
constexpr double kPatch = 0.02;              // m
constexpr double kSphereRadius = 0.2 * kPi;  // of the disk on the unit sphere
constexpr double kDiskVertices = 1000.0;     // where the disk is the same on every mesh
constexpr LogMapMethod kDirect[] = {LogMapMethod::kFast, LogMapMethod::kExact};
constexpr LogMapMethod kAll[] = {LogMapMethod::kFast, LogMapMethod::kExact, LogMapMethod::kAuto,
                                 LogMapMethod::kSmooth, LogMapMethod::kHeat};

struct SpeedOptions {
  std::string hand;
  int vertices = 30'000;
  int subdivisions = 7;
  int roots = 20;
  int repeats = 5;
  int whole_roots = 3;
  std::string cache = defaultCache().string();
  bool json = false;
};

/// How the time of one method grows with one thing.
struct Growth {
  std::string over;
  std::vector<DiskSpeed> points;
  double exponent = 0.0;
};

struct SpeedReport {
  std::vector<DiskSpeed> disks;
  std::vector<Growth> growths;
};

std::vector<SurfacePoint> drawRoots(const TriangleMesh& mesh, int count) {
  std::mt19937 random(5);
  std::vector<SurfacePoint> roots;
  while (static_cast<int>(roots.size()) < count) {
    const auto face = static_cast<int>(random() % static_cast<unsigned>(mesh.faceCount()));
    roots.push_back({face, {0.2, 0.5, 0.3}});
  }
  return roots;
}

/// The hand's own sites (pads and palm), then places at random.
std::vector<SurfacePoint> rootsOn(const hand::HandModel& model,
                                  const hand::Skin& skin,
                                  int count) {
  std::vector<SurfacePoint> roots;
  for (const hand::ContactSite& site : findContactSites(model, skin))
    roots.push_back(skin.skinPointOf(model.linkIndex(site.link), site.p_L));
  for (const SurfacePoint& root : drawRoots(skin.mesh(), count))
    roots.push_back(root);
  roots.resize(static_cast<std::size_t>(count));
  return roots;
}

template <class X>
Growth growthOf(const std::string& over, std::vector<DiskSpeed> points, const X& x_of) {
  std::vector<double> x;
  std::vector<double> y;
  for (const DiskSpeed& point : points) {
    x.push_back(x_of(point));
    y.push_back(point.times.median_ms);
  }
  return {over, std::move(points), growthExponent(x, y)};
}

double verticesOf(const DiskSpeed& point) {
  return point.vertices;
}

void measureHand(const SpeedOptions& options, SpeedReport& report) {
  const hand::HandModel model = io::readUrdf(options.hand).model;
  const hand::Skin skin = skinOfSize(model, options.vertices, options.cache);
  DiskTask task{"skin of " + model.name(), &skin.mesh(), rootsOn(model, skin, options.roots),
                kPatch, options.repeats};
  for (const LogMapMethod method : kAll)
    report.disks.push_back(measureDisk(task, method));
  report.disks.push_back(measureCgalCut(task));
  report.disks.push_back(measureCgalHeat(task));
  DiskTask few = task;
  few.roots.resize(static_cast<std::size_t>(std::min(options.roots, options.whole_roots)));
  report.disks.push_back(measureCgalWhole(few));

  for (const LogMapMethod method : kDirect) {
    std::vector<DiskSpeed> points;
    for (const double radius_m : {0.005, 0.01, 0.02, 0.04}) {
      task.radius_m = radius_m;
      points.push_back(measureDisk(task, method));
    }
    report.growths.push_back(growthOf("radius", points, [](const DiskSpeed& point) {
      return point.radius_m;
    }));
    report.growths.push_back(
        growthOf("vertices in the disk", points, [](const DiskSpeed& point) {
          return point.reached;
        }));
  }
}

void measureSpheres(const SpeedOptions& options, SpeedReport& report) {
  std::vector<TriangleMesh> spheres;
  for (int n = std::max(1, options.subdivisions - 3); n <= options.subdivisions; ++n)
    spheres.push_back(geometry::makeSphere(1.0, n));
  const auto task_on = [&](const TriangleMesh& sphere, double radius) {
    return DiskTask{"unit sphere", &sphere, drawRoots(sphere, std::min(options.roots, 10)),
                    radius, options.repeats};
  };
  for (const LogMapMethod method : kDirect) {
    std::vector<DiskSpeed> same_radius;
    std::vector<DiskSpeed> same_disk;
    for (const TriangleMesh& sphere : spheres) {
      same_radius.push_back(measureDisk(task_on(sphere, kSphereRadius), method));
      // A cap's area is 2 pi (1 - cos r) of 4 pi.
      const double share = std::min(0.2, kDiskVertices / sphere.vertexCount());
      same_disk.push_back(measureDisk(task_on(sphere, std::acos(1.0 - 2.0 * share)), method));
    }
    report.disks.push_back(same_radius.back());
    report.growths.push_back(growthOf("vertices, 0.2 pi", same_radius, verticesOf));
    report.growths.push_back(growthOf("vertices, equal disks", same_disk, verticesOf));
  }
  DiskTask few = task_on(spheres.back(), kSphereRadius);
  few.roots.resize(static_cast<std::size_t>(std::min(options.roots, options.whole_roots)));
  few.repeats = 1;
  report.disks.push_back(measureCgalCut(few));
}

const DiskSpeed* baselineOf(const SpeedReport& report, const DiskSpeed& disk) {
  for (const DiskSpeed& other : report.disks) {
    if (other.surface == disk.surface && other.method == "cgal exact cut") return &other;
  }
  return nullptr;
}

double ratioOf(const SpeedReport& report, const DiskSpeed& disk) {
  const DiskSpeed* baseline = baselineOf(report, disk);
  return baseline != nullptr && disk.times.median_ms > 0.0
             ? baseline->times.median_ms / disk.times.median_ms
             : 0.0;
}

nlohmann::ordered_json jsonOf(const DiskSpeed& disk) {
  return {{"surface", disk.surface},
          {"vertices", disk.vertices},
          {"radius_m", disk.radius_m},
          {"method", disk.method},
          {"roots", disk.roots},
          {"reached", disk.reached},
          {"ms_setup", disk.setup_ms},
          {"ms_median", disk.times.median_ms},
          {"ms_low", disk.times.low_ms},
          {"ms_high", disk.times.high_ms},
          {"r_difference_m", disk.r_difference_m},
          {"exact_maps", disk.exact_maps}};
}

void printJson(const SpeedReport& report) {
  nlohmann::ordered_json document{{"disks", nlohmann::ordered_json::array()},
                                  {"growth", nlohmann::ordered_json::array()}};
  for (const DiskSpeed& disk : report.disks) {
    nlohmann::ordered_json line = jsonOf(disk);
    line["times_faster_than_cgal_cut"] = ratioOf(report, disk);
    document["disks"].push_back(std::move(line));
  }
  for (const Growth& growth : report.growths) {
    nlohmann::ordered_json points = nlohmann::ordered_json::array();
    for (const DiskSpeed& point : growth.points)
      points.push_back(jsonOf(point));
    document["growth"].push_back(
        {{"over", growth.over}, {"exponent", growth.exponent}, {"points", std::move(points)}});
  }
  std::printf("%s\n", document.dump().c_str());
}

void printText(const SpeedReport& report) {
  fmt::print(
      "one thread, its processor time; least of each root, then over roots the median and "
      "10-90 %; ratio: "
      "time "
      "of CGAL's exact\ndistances on the disk cut out beforehand over ours; |dr|: largest "
      "difference of r to `exact`, disk by disk\n\n");
  fmt::print("{:22} {:>8} {:>8} {:15} {:>6} {:>8} {:>9} {:>10} {:>20} {:>7} {:>9}\n", "surface",
             "vertices", "radius", "method", "roots", "reached", "setup ms", "median ms",
             "10-90 % ms", "ratio", "|dr| m");
  for (const DiskSpeed& disk : report.disks) {
    fmt::print("{:22} {:8} {:8.3f} {:15} {:6} {:8.0f} {:9.1f} {:10.3f} {:>20} {:7.1f} {:9.1e}",
               disk.surface, disk.vertices, disk.radius_m, disk.method, disk.roots,
               disk.reached, disk.setup_ms, disk.times.median_ms,
               fmt::format("{:.3f}-{:.3f}", disk.times.low_ms, disk.times.high_ms),
               ratioOf(report, disk), disk.r_difference_m);
    if (disk.method == geometry::nameOf(LogMapMethod::kAuto))
      fmt::print("  took exact for {} of {}", disk.exact_maps, disk.roots);
    fmt::print("\n");
  }
  fmt::print("\n{:22} {:7} {:22} {:>8}  {}\n", "surface", "method", "grows with", "exponent",
             "radius or vertices: reached, median ms");
  for (const Growth& growth : report.growths) {
    std::string points;
    for (const DiskSpeed& point : growth.points) {
      const std::string x = growth.over.rfind("vertices,", 0) == 0
                                ? fmt::format("{}", point.vertices)
                                : fmt::format("{}", point.radius_m);
      points += fmt::format("  {}: {:.0f}, {:.3f}", x, point.reached, point.times.median_ms);
    }
    fmt::print("{:22} {:7} {:22} {:8.2f}{}\n", growth.points.front().surface,
               growth.points.front().method, growth.over, growth.exponent, points);
  }
}

void check(int value, const char* name, int low, int high) {
  if (value < low || value > high)
    rejectInput("{}: {} must lie in {} to {}", name, value, low, high);
}

void run(const SpeedOptions& options) {
  check(options.vertices, "--vertices", 500, 1'000'000);
  check(options.subdivisions, "--subdivisions", 1, 8);
  check(options.roots, "--roots", 1, 1000);
  check(options.repeats, "--repeats", 1, 1000);
  check(options.whole_roots, "--whole-roots", 1, 1000);
  SpeedReport report;
  if (!options.hand.empty()) measureHand(options, report);
  measureSpheres(options, report);
  if (options.json) {
    printJson(report);
  } else {
    printText(report);
  }
}

}  // namespace

void addLogMapSpeedCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "logmap-speed", "Time of log maps on a hand's skin and on spheres, beside CGAL's");
  const auto options = std::make_shared<SpeedOptions>();
  command->add_option("--hand", options->hand,
                      "URDF whose skin is measured; else spheres alone");
  command->add_option("--vertices", options->vertices, "Of the skin, about")
      ->capture_default_str();
  command->add_option("--subdivisions", options->subdivisions, "Of the largest icosphere")
      ->capture_default_str();
  command->add_option("--roots", options->roots, "Places to start from")->capture_default_str();
  command->add_option("--repeats", options->repeats, "Of which the least time counts")
      ->capture_default_str();
  command
      ->add_option("--whole-roots", options->whole_roots,
                   "Roots of CGAL's exact distances over a whole skin, which take seconds")
      ->capture_default_str();
  command->add_option("--cache", options->cache, "Folder for skins")->capture_default_str();
  command->add_flag("--json", options->json, "One JSON document");
  command->callback([options] {
    run(*options);
  });
}

}  // namespace handgraft::bench
