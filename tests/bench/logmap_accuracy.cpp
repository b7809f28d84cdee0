#include "tests/bench/logmap_accuracy.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"

#include "tests/bench/accuracy.h"
#include "tests/bench/mesh_versions.h"

namespace handgraft::bench {

namespace {

using geometry::LogMapMethod;

constexpr int kFewestVertices = 100;
constexpr int kMostVertices = 1'000'000;
constexpr LogMapMethod kMethods[] = {LogMapMethod::kFast, LogMapMethod::kExact,
                                     LogMapMethod::kAuto, LogMapMethod::kSmooth,
                                     LogMapMethod::kHeat};

struct AccuracyOptions {
  int vertices = 10'000;
  bool json = false;
  bool markdown = false;
};

struct Row {
  std::string surface;
  std::string version;
  int vertices = 0;
  double obtuse = 0.0;
  std::string method;
  Accuracy accuracy;
};

std::vector<Row> measureAll(int vertex_count) {
  std::vector<Row> rows;
  for (const MeasuredSurface& surface : measuredSurfaces(vertex_count)) {
    for (const LogMapMethod method : kMethods) {
      for (const Accuracy& accuracy : measureAccuracy(surface, method)) {
        rows.push_back({surface.surface, surface.version, surface.mesh.vertexCount(),
                        obtuseShare(surface.mesh), std::string(geometry::nameOf(method)),
                        accuracy});
      }
    }
  }
  return rows;
}

void printJson(const std::vector<Row>& rows) {
  nlohmann::ordered_json lines = nlohmann::ordered_json::array();
  for (const Row& row : rows) {
    const Accuracy& a = row.accuracy;
    lines.push_back({{"surface", row.surface},
                     {"version", row.version},
                     {"vertices", row.vertices},
                     {"obtuse", row.obtuse},
                     {"method", row.method},
                     {"source", a.source},
                     {"r_mean", a.r_mean},
                     {"r_max", a.r_max},
                     {"phi_mean", a.phi_mean},
                     {"phi_max", a.phi_max},
                     {"compared", a.compared},
                     {"missing", a.missing},
                     {"maps", a.maps},
                     {"exact_maps", a.exact_maps},
                     {"refusal", a.refusal}});
  }
  std::printf("%s\n", nlohmann::ordered_json{{"accuracy", lines}}.dump().c_str());
}

void printText(const std::vector<Row>& rows) {
  fmt::print("{:18} {:12} {:>8} {:7} {:7} {:>9} {:>9} {:>9} {:>9} {:>8} {:>7}\n", "surface",
             "version", "vertices", "method", "source", "r mean", "r max", "phi mean",
             "phi max", "compared", "missing");
  for (const Row& row : rows) {
    const Accuracy& a = row.accuracy;
    fmt::print("{:18} {:12} {:8} {:7} {:7} {:9.2e} {:9.2e} {:9.2e} {:9.2e} {:8} {:7}{}\n",
               row.surface, row.version, row.vertices, row.method, a.source, a.r_mean, a.r_max,
               a.phi_mean, a.phi_max, a.compared, a.missing,
               a.refusal.empty() ? "" : "  refused: " + a.refusal);
  }
}

/// Rounding is no news: below 1e-9 the figure says so.
std::string errorText(double value) {
  constexpr double kRounding = 1e-9;
  if (value < kRounding) return "0";
  return fmt::format("{:.1e}", value);
}

std::string cellOf(const Accuracy& a) {
  if (a.compared == 0) return "refused";
  std::string text = fmt::format("{} / {}, {} / {}", errorText(a.r_mean), errorText(a.r_max),
                                 errorText(a.phi_mean), errorText(a.phi_max));
  if (a.missing > 0) {
    text += fmt::format(", {:.1f} % lost", 100.0 * static_cast<double>(a.missing) /
                                               static_cast<double>(a.missing + a.compared));
  }
  return text;
}

/// The table of core/geometry/DECISIONS.md: of all sources together.
void printMarkdown(const std::vector<Row>& rows) {
  fmt::print(
      "| surface | version | vertices | `fast` | `exact` | `auto` takes | `smooth` | `heat` "
      "|\n");
  fmt::print("|---|---|---|---|---|---|---|---|\n");
  const auto find = [&](const Row& like, LogMapMethod method) -> const Accuracy& {
    return std::find_if(rows.begin(), rows.end(),
                        [&](const Row& row) {
                          return row.surface == like.surface && row.version == like.version &&
                                 row.method == geometry::nameOf(method) &&
                                 row.accuracy.source == like.accuracy.source;
                        })
        ->accuracy;
  };
  for (const Row& row : rows) {
    if (row.method != geometry::nameOf(kMethods[0])) continue;
    // The sphere as it is shows what the kind of source does.
    const bool wanted = row.accuracy.source == "all" ||
                        (row.surface == "sphere" && row.version == mesh_versions.front());
    if (!wanted) continue;
    const std::string source =
        row.accuracy.source == "all" ? "" : ", source: " + row.accuracy.source;
    const Accuracy& taken = find(row, LogMapMethod::kAuto);
    const std::string choice =
        taken.exact_maps == taken.maps ? "`exact`"
        : taken.exact_maps == 0        ? "`fast`"
                                : fmt::format("`exact` {} of {}", taken.exact_maps, taken.maps);
    fmt::print(
        "| {} | {}{} | {} | {} | {} | {} | {} | {} |\n", row.surface, row.version, source,
        row.vertices, cellOf(row.accuracy), cellOf(find(row, LogMapMethod::kExact)), choice,
        cellOf(find(row, LogMapMethod::kSmooth)), cellOf(find(row, LogMapMethod::kHeat)));
  }
}

void run(const AccuracyOptions& options) {
  if (options.vertices < kFewestVertices || options.vertices > kMostVertices) {
    rejectInput("--vertices: {} must lie in {} to {}", options.vertices, kFewestVertices,
                kMostVertices);
  }
  const std::vector<Row> rows = measureAll(options.vertices);
  if (options.json) {
    printJson(rows);
  } else if (options.markdown) {
    printMarkdown(rows);
  } else {
    printText(rows);
  }
}

}  // namespace

void addLogMapAccuracyCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "logmap-accuracy", "Log maps against planes, cylinders, cones and spheres");
  const auto options = std::make_shared<AccuracyOptions>();
  command->add_option("--vertices", options->vertices, "About as many a mesh")
      ->capture_default_str();
  command->add_flag("--json", options->json, "One JSON document");
  command->add_flag("--markdown", options->markdown, "The table of core/geometry/DECISIONS.md");
  command->callback([options] {
    run(*options);
  });
}

}  // namespace handgraft::bench
