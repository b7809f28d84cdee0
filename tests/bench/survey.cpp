#include "tests/bench/survey.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/io/mesh_file.h"

#include "tests/bench/disk_check.h"

namespace handgraft::bench {

namespace {

namespace fs = std::filesystem;
using geometry::LogMapMethod;
using geometry::TriangleMesh;

struct SurveyArguments {
  std::vector<std::string> folders;
  int patches = 24;
  unsigned seed = 1;
  std::vector<std::string> methods = {"fast", "exact", "auto", "smooth", "heat"};
  bool damaged = false;
  bool json = false;
};

/// One mesh, whole or damaged, by one method, disks of one radius.
struct MeshSurvey {
  std::string path;
  std::string kind;  ///< the folders that say what sort of mesh it is
  Damage damage = Damage::kNone;
  LogMapMethod method = LogMapMethod::kFast;
  double radius_mm = 0.0;
  int vertices = 0;
  bool closed = false;
  int non_manifold_edges = 0;
  DiskTally tally;
};

struct Survey {
  std::vector<MeshSurvey> meshes;
  std::vector<std::pair<std::string, std::string>> unread;  ///< path and why
};

/// A mesh of more than 2 m is taken to be in millimetres, as hands' STLs often are.
TriangleMesh inMetres(TriangleMesh mesh) {
  constexpr double kMostMetres = 2.0;
  constexpr double kMetresPerMillimetre = 1e-3;
  if (!(mesh.diagonal() > kMostMetres)) return mesh;
  return transformed(mesh, Eigen::Affine3d(Eigen::Scaling(kMetresPerMillimetre)));
}

/// All meshes below `folder`, with the first two folders on the way to each.
std::vector<std::pair<fs::path, std::string>> meshesIn(const fs::path& folder) {
  if (!fs::is_directory(folder)) rejectInput("{}: is no folder", quoted(folder.string()));
  std::vector<std::pair<fs::path, std::string>> found;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    std::string extension = entry.path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
      return static_cast<char>(std::tolower(c));
    });
    constexpr std::array kExtensions = {".stl", ".obj", ".ply", ".dae"};
    if (!entry.is_regular_file() ||
        std::find(kExtensions.begin(), kExtensions.end(), extension) == kExtensions.end())
      continue;
    std::string kind;
    int depth = 0;
    for (const fs::path& part : fs::relative(entry.path(), folder).parent_path()) {
      if (++depth > 2) break;
      kind += (kind.empty() ? "" : "/") + part.string();
    }
    found.emplace_back(entry.path(), kind.empty() ? folder.filename().string() : kind);
  }
  std::sort(found.begin(), found.end());
  return found;
}

void surveyMesh(const fs::path& path,
                const std::string& kind,
                const SurveyArguments& arguments,
                Survey& survey) {
  TriangleMesh whole;
  try {
    whole = inMetres(io::readMesh(path).mesh);
  } catch (const InvalidInput& error) {
    survey.unread.emplace_back(path.string(), error.what());
    return;
  }
  for (const Damage damage : kDamages) {
    if (damage != Damage::kNone && !arguments.damaged) break;
    const TriangleMesh mesh = broken(whole, damage, arguments.seed);
    const auto maps = geometry::LogMapper::borrowing(mesh);
    const std::vector<Root> roots = randomRoots(mesh, arguments.patches, arguments.seed);
    for (const std::string& name : arguments.methods) {
      const LogMapMethod method = geometry::logMapMethodFrom(name);
      std::map<double, DiskTally> by_radius;
      for (const Root& root : roots)
        by_radius[root.radius] += checkDisk(*maps, root.point, root.radius, method);
      for (const auto& [radius, tally] : by_radius) {
        survey.meshes.push_back({path.string(), kind, damage, method, 1e3 * radius,
                                 mesh.vertexCount(), mesh.isClosed(),
                                 mesh.nonManifoldEdgeCount(), tally});
      }
    }
  }
}

// === What is printed

struct Row {
  std::set<std::string> meshes;
  std::set<std::string> open;
  std::set<std::string> non_manifold;
  DiskTally tally;

  void add(const MeshSurvey& mesh) {
    meshes.insert(mesh.path);
    if (!mesh.closed) open.insert(mesh.path);
    if (mesh.non_manifold_edges > 0) non_manifold.insert(mesh.path);
    tally += mesh.tally;
  }
};

void printRow(const std::string& name, const Row& row) {
  const DiskTally& t = row.tally;
  const auto share = [](long count, long of) {
    return of > 0 ? 100.0 * static_cast<double>(count) / static_cast<double>(of) : 0.0;
  };
  fmt::print(
      "| {} | {}, {}, {} | {} | {} | {:.2f} % | {:.2f} % | {:.2f} % | {:.2f} % | {:.2f} % | {} "
      "| "
      "{} | {:.2f} |\n",
      name, row.meshes.size(), row.open.size(), row.non_manifold.size(), t.disks, t.refused,
      share(t.lost_at_edge, t.queries), share(t.lost_at_cut_locus, t.queries),
      share(t.lost_beyond, t.queries), share(t.folded, t.queries),
      share(t.turned_over, t.faces), t.unreported, t.not_finite, t.medianMs());
}

void printText(const Survey& survey) {
  fmt::print(
      "| meshes | all, open, non-manifold | disks | refused | lost: edge | cut locus | beyond "
      "| "
      "folded | faces turned over | unreported | not finite | ms |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|\n");

  // By method and damage: the kinds of meshes, then radii, then all.
  struct Table {
    std::map<std::string, Row> kinds;
    std::map<double, Row> radii;
    Row all;
  };

  std::map<std::pair<LogMapMethod, Damage>, Table> tables;
  for (const MeshSurvey& mesh : survey.meshes) {
    Table& table = tables[{mesh.method, mesh.damage}];
    table.kinds[mesh.kind].add(mesh);
    table.radii[mesh.radius_mm].add(mesh);
    table.all.add(mesh);
  }
  for (const auto& [what, table] : tables) {
    const std::string title =
        fmt::format("{}, {}", geometry::nameOf(what.first), nameOf(what.second));
    for (const auto& [kind, row] : table.kinds)
      printRow(title + ": " + kind, row);
    for (const auto& [radius_mm, row] : table.radii)
      printRow(fmt::format("{}: {:.0f} mm", title, radius_mm), row);
    printRow("**" + title + "**", table.all);
  }
  for (const auto& [path, why] : survey.unread)
    fmt::print("not read: {}: {}\n", path, why);
}

void printJson(const Survey& survey) {
  nlohmann::ordered_json document{{"meshes", nlohmann::ordered_json::array()},
                                  {"unread", nlohmann::ordered_json::array()}};
  for (const MeshSurvey& mesh : survey.meshes) {
    const DiskTally& t = mesh.tally;
    document["meshes"].push_back({{"path", mesh.path},
                                  {"kind", mesh.kind},
                                  {"damage", nameOf(mesh.damage)},
                                  {"method", geometry::nameOf(mesh.method)},
                                  {"radius_mm", mesh.radius_mm},
                                  {"vertices", mesh.vertices},
                                  {"closed", mesh.closed},
                                  {"non_manifold_edges", mesh.non_manifold_edges},
                                  {"disks", t.disks},
                                  {"refused", t.refused},
                                  {"points", t.queries},
                                  {"placed", t.placed},
                                  {"lost_at_edge", t.lost_at_edge},
                                  {"lost_at_cut_locus", t.lost_at_cut_locus},
                                  {"lost_beyond", t.lost_beyond},
                                  {"folded", t.folded},
                                  {"faces", t.faces},
                                  {"turned_over", t.turned_over},
                                  {"collapsed", t.collapsed},
                                  {"fell_back", t.fell_back},
                                  {"unreported", t.unreported},
                                  {"not_finite", t.not_finite},
                                  {"ms_median", t.medianMs()}});
  }
  for (const auto& [path, why] : survey.unread)
    document["unread"].push_back({{"path", path}, {"why", why}});
  std::printf("%s\n", document.dump().c_str());
}

void run(SurveyArguments arguments) {
  if (arguments.patches < 1 || arguments.patches > 100'000)
    rejectInput("--patches: {} must lie in 1 to 100000", arguments.patches);
  for (const std::string& name : arguments.methods)
    static_cast<void>(geometry::logMapMethodFrom(name));
  if (arguments.folders.empty()) {
    const char* shared = std::getenv("HANDGRAFT_SHARED_DATA");
    if (shared == nullptr)
      rejectInput("no folder is given and HANDGRAFT_SHARED_DATA is not set; name one");
    arguments.folders.emplace_back(shared);
  }
  Survey survey;
  for (const std::string& folder : arguments.folders) {
    for (const auto& [path, kind] : meshesIn(folder))
      surveyMesh(path, kind, arguments, survey);
  }
  if (arguments.json) {
    printJson(survey);
  } else {
    printText(survey);
  }
  long wrong = 0;
  for (const MeshSurvey& mesh : survey.meshes)
    wrong += mesh.tally.unreported + mesh.tally.not_finite;
  if (wrong > 0)
    throw std::runtime_error(fmt::format("{} answers are wrong without a word", wrong));
}

}  // namespace

void addSurveyCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "survey", "Disks at random places of every mesh in folders: points lost, and why");
  const auto arguments = std::make_shared<SurveyArguments>();
  command->add_option("folders", arguments->folders,
                      "With STL, OBJ, PLY and DAE files anywhere below; HANDGRAFT_SHARED_DATA");
  command->add_option("--patches", arguments->patches, "Disks a mesh: 5, 10, 20, 40 mm in turn")
      ->capture_default_str();
  command->add_option("--seed", arguments->seed, "Of places and damage")->capture_default_str();
  command->add_option("--methods", arguments->methods, "Of log maps")->capture_default_str();
  command->add_flag("--damaged", arguments->damaged,
                    "Each mesh also with faces deleted, doubled and flipped, vertices merged");
  command->add_flag("--json", arguments->json, "One JSON document, by mesh, method and radius");
  command->callback([arguments] {
    run(*arguments);
  });
}

}  // namespace handgraft::bench
