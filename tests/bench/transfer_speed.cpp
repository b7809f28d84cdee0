#include "tests/bench/transfer_speed.h"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/hand/contact_site.h"
#include "core/io/contact_file.h"
#include "core/io/urdf_file.h"
#include "core/transfer/patch_transfer.h"
#include "core/transfer/staged_transfer.h"

#include "tests/bench/round_trip.h"
#include "tests/bench/skin_cache.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

using geometry::LogMap;
using geometry::LogMapInverse;
using geometry::LogMapMethod;
using geometry::SurfacePoint;
using geometry::TriangleMesh;

struct TransferArguments {
  std::string hand;
  std::string object;
  std::string contacts;
  int patches = 6;
  int vertices = 30'000;
  int smooth_vertices = 10'000;
  int repeats = 20;
  std::string cache = defaultCache().string();
  bool json = false;
};

/// A grasp ready to be transferred.
struct Task {
  std::shared_ptr<const hand::HandModel> model;
  std::shared_ptr<const hand::Skin> skin;
  TriangleMesh object_O;
  std::vector<contact::Patch> patches;
  std::vector<transfer::PatchPlacement> placements;
};

struct Stage {
  std::string name;
  double median_ms = 0.0;
  double low_ms = 0.0;
  double high_ms = 0.0;
};

struct MethodReport {
  std::string method;
  std::vector<Stage> stages;
  int points = 0;
  int lost = 0;
};

struct TransferReport {
  int object_vertices = 0;
  int skin_vertices = 0;
  int patches = 0;
  std::vector<MethodReport> methods;
  std::vector<RoundTrip> trips;
};

/// Patches that have no site of their own name take the sites in turn: what counts here is the
/// work.
Task readTask(const TransferArguments& arguments) {
  Task task;
  task.model = std::make_shared<const hand::HandModel>(io::readUrdf(arguments.hand).model);
  task.skin = std::make_shared<const hand::Skin>(
      skinOfSize(*task.model, arguments.vertices, arguments.cache));
  const io::MeshFile object = io::readMesh(arguments.object);
  task.object_O = object.mesh;
  const std::vector<contact::Patch> read = io::readContacts(arguments.contacts, object).patches;
  if (read.empty()) rejectInput("{}: holds no patch", quoted(arguments.contacts));
  for (int i = 0; i < arguments.patches; ++i) {
    task.patches.push_back(read[static_cast<std::size_t>(i) % read.size()]);
    contact::Patch& patch = task.patches.back();
    if (!patch.direction_O)
      patch.direction_O = normalOf(task.object_O, patch.root).unitOrthogonal();
  }
  const std::vector<hand::ContactSite> sites = findContactSites(*task.model, *task.skin);
  if (sites.empty()) rejectInput("{}: no contact site was found", quoted(arguments.hand));
  for (std::size_t i = 0; i < task.patches.size(); ++i) {
    auto site =
        std::find_if(sites.begin(), sites.end(), [&](const hand::ContactSite& candidate) {
          return candidate.name == task.patches[i].name;
        });
    if (site == sites.end())
      site = sites.begin() + static_cast<std::ptrdiff_t>(i % sites.size());
    task.placements.push_back(transfer::placementAt(*task.model, *task.skin, *site));
  }
  return task;
}

Stage stageOf(const std::string& name, int repeats, const std::function<void()>& work) {
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i)
    times.push_back(leastMilliseconds(1, work));
  return {name, quantile(times, 0.5), quantile(times, 0.1), quantile(times, 0.9)};
}

/// Every stage for all patches, each by itself, then the product's own transfer of all.
MethodReport measureMethod(const Task& task, LogMapMethod method, int repeats) {
  const TriangleMesh& skin_S = task.skin->mesh();
  const std::size_t count = task.patches.size();
  transfer::TransferOptions options;
  options.method = method;
  MethodReport report;
  report.method = geometry::nameOf(method);

  std::vector<double> reach(count);
  for (std::size_t i = 0; i < count; ++i) {
    const contact::Patch& patch = task.patches[i];
    const Eigen::Vector3d p_root = positionOf(task.object_O, patch.root);
    for (const SurfacePoint& point : patch.interpolation_boundary) {
      // Bent ways are longer than straight ones; a fifth covers the patches of a grasp.
      reach[i] = std::max(reach[i], 1.2 * (positionOf(task.object_O, point) - p_root).norm());
    }
  }
  std::vector<LogMap> maps_O(count);
  std::vector<LogMap> maps_S(count);
  std::vector<LogMapInverse::Place> places;
  report.stages.push_back(stageOf("object maps", repeats, [&] {
    for (std::size_t i = 0; i < count; ++i) {
      const contact::Patch& patch = task.patches[i];
      maps_O[i] =
          computeLogMap(task.object_O, patch.root, *patch.direction_O, reach[i], method);
    }
  }));
  report.stages.push_back(stageOf("skin maps", repeats, [&] {
    for (std::size_t i = 0; i < count; ++i) {
      const transfer::PatchPlacement& placement = task.placements[i];
      maps_S[i] =
          computeLogMap(skin_S, placement.root_S, placement.direction_S, reach[i], method);
    }
  }));
  report.stages.push_back(stageOf("inverse", repeats, [&] {
    places.clear();
    for (std::size_t i = 0; i < count; ++i) {
      const LogMapInverse inverse(skin_S, maps_S[i]);
      for (const SurfacePoint& point : task.patches[i].interpolation_boundary) {
        const Eigen::Vector2d uv = logCoordinates(task.object_O, maps_O[i], point);
        places.push_back(inverse.at({uv.x(), -uv.y()}));
      }
    }
  }));
  double sink = 0.0;
  report.stages.push_back(stageOf("projection", repeats, [&] {
    for (const LogMapInverse::Place& place : places) {
      if (!place.point.valid()) continue;
      const auto on_link =
          task.skin->project(positionOf(skin_S, place.point), normalOf(skin_S, place.point));
      if (on_link) sink += on_link->distance_m;
    }
  }));
  HANDGRAFT_REQUIRE(sink >= 0.0);

  report.stages.push_back(stageOf("whole transfer", repeats, [&] {
    report.points = report.lost = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const transfer::PatchTransfer laid = transferPatch(
          task.object_O, task.patches[i], *task.skin, task.placements[i], options);
      report.points += static_cast<int>(laid.correspondences.size());
      report.lost += static_cast<int>(laid.lost.size());
    }
  }));

  // === What one edit costs: the patch is laid again as the product does, which keeps what did
  // not change; every repeat changes it back or forth
  const transfer::Surfaces surfaces = transfer::borrowedSurfaces(task.object_O, *task.skin);
  const auto edited = [&](const std::string& name, const transfer::PatchPlacement& other) {
    transfer::StagedTransfer staged;
    bool moved = false;
    const auto lay = [&] {
      moved = !moved;
      static_cast<void>(
          staged.lay(surfaces, task.patches[0], moved ? other : task.placements[0], options));
    };
    lay();
    report.stages.push_back(stageOf(name, repeats, lay));
  };
  const SurfacePoint beside = task.skin->locator()
                                  .nearest(positionOf(skin_S, task.placements[0].root_S) +
                                           0.003 * task.placements[0].direction_S)
                                  .point;
  edited("edit: one root moved", movedTo(skin_S, task.placements[0], beside));
  edited("edit: one direction turned", turned(skin_S, task.placements[0], 0.2));
  return report;
}

TransferReport measure(const TransferArguments& arguments) {
  TransferReport report;
  report.trips = smoothRoundTrips(arguments.smooth_vertices);
  if (arguments.hand.empty()) return report;
  const Task task = readTask(arguments);
  report.object_vertices = task.object_O.vertexCount();
  report.skin_vertices = task.skin->mesh().vertexCount();
  report.patches = static_cast<int>(task.patches.size());
  for (const LogMapMethod method :
       {LogMapMethod::kFast, LogMapMethod::kExact, LogMapMethod::kAuto}) {
    report.methods.push_back(measureMethod(task, method, arguments.repeats));
    RoundTrip trip;
    trip.from = "object";
    trip.to = "skin of " + task.model->name();
    trip.method = geometry::nameOf(method);
    for (std::size_t i = 0; i < task.patches.size(); ++i)
      goRoundTrip(task.object_O, task.patches[i], *task.skin, task.placements[i], method, trip);
    report.trips.push_back(trip);
  }
  return report;
}

void printJson(const TransferReport& report) {
  nlohmann::ordered_json document{{"object_vertices", report.object_vertices},
                                  {"skin_vertices", report.skin_vertices},
                                  {"patches", report.patches},
                                  {"transfer", nlohmann::ordered_json::array()},
                                  {"round_trips", nlohmann::ordered_json::array()}};
  for (const MethodReport& method : report.methods) {
    nlohmann::ordered_json stages;
    for (const Stage& stage : method.stages) {
      stages[stage.name] = {
          {"ms_median", stage.median_ms}, {"ms_low", stage.low_ms}, {"ms_high", stage.high_ms}};
    }
    document["transfer"].push_back({{"method", method.method},
                                    {"points", method.points},
                                    {"lost", method.lost},
                                    {"stages", stages}});
  }
  for (const RoundTrip& trip : report.trips) {
    document["round_trips"].push_back({{"from", trip.from},
                                       {"to", trip.to},
                                       {"method", trip.method},
                                       {"points", trip.points},
                                       {"lost", trip.lost},
                                       {"mean_mm", trip.mean_mm},
                                       {"max_mm", trip.max_mm}});
  }
  std::printf("%s\n", document.dump().c_str());
}

void printText(const TransferReport& report) {
  if (report.patches > 0) {
    fmt::print(
        "{} patches, object of {} vertices, skin of {}; one thread, its processor time, median "
        "and 10-90 % of "
        "repeats, ms\n",
        report.patches, report.object_vertices, report.skin_vertices);
  }
  for (const MethodReport& method : report.methods) {
    fmt::print("\n{}: {} points, {} lost\n", method.method, method.points, method.lost);
    for (const Stage& stage : method.stages) {
      fmt::print("  {:28} {:9.3f}  {:.3f}-{:.3f}\n", stage.name, stage.median_ms, stage.low_ms,
                 stage.high_ms);
    }
  }
  fmt::print("\n{:10} {:22} {:7} {:>6} {:>5} {:>10} {:>10}\n", "round trip", "by way of",
             "method", "points", "lost", "mean mm", "max mm");
  for (const RoundTrip& trip : report.trips) {
    fmt::print("{:10} {:22} {:7} {:6} {:5} {:10.2e} {:10.2e}\n", trip.from, trip.to,
               trip.method, trip.points, trip.lost, trip.mean_mm, trip.max_mm);
  }
}

void check(int value, const char* name, int low, int high) {
  if (value < low || value > high)
    rejectInput("{}: {} must lie in {} to {}", name, value, low, high);
}

void run(const TransferArguments& arguments) {
  check(arguments.patches, "--patches", 1, 100);
  check(arguments.vertices, "--vertices", 500, 1'000'000);
  check(arguments.smooth_vertices, "--smooth-vertices", 100, 1'000'000);
  check(arguments.repeats, "--repeats", 1, 10'000);
  const bool any =
      !arguments.hand.empty() || !arguments.object.empty() || !arguments.contacts.empty();
  const bool all =
      !arguments.hand.empty() && !arguments.object.empty() && !arguments.contacts.empty();
  if (any && !all) rejectInput("--hand, --object and --contacts come together or not at all");
  const TransferReport report = measure(arguments);
  if (arguments.json) {
    printJson(report);
  } else {
    printText(report);
  }
}

}  // namespace

void addTransferCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("transfer", "Patches onto a skin, stage by stage, and back again");
  const auto arguments = std::make_shared<TransferArguments>();
  command->add_option("--hand", arguments->hand, "URDF; without it round trips alone");
  command->add_option("--object", arguments->object, "Mesh");
  command->add_option("--contacts", arguments->contacts, "Contact set or map");
  command
      ->add_option("--patches", arguments->patches,
                   "As many are transferred: the file's, from the first again if it has fewer")
      ->capture_default_str();
  command->add_option("--vertices", arguments->vertices, "Of the skin, about")
      ->capture_default_str();
  command
      ->add_option("--smooth-vertices", arguments->smooth_vertices,
                   "Of the smooth surfaces of the round trips, about")
      ->capture_default_str();
  command->add_option("--repeats", arguments->repeats, "Of which the median counts")
      ->capture_default_str();
  command->add_option("--cache", arguments->cache, "Folder for skins")->capture_default_str();
  command->add_flag("--json", arguments->json, "One JSON document");
  command->callback([arguments] {
    run(*arguments);
  });
}

}  // namespace handgraft::bench
