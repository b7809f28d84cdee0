#include "tests/bench/thin_walls.h"

#include <filesystem>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/environment.h"
#include "core/contact/reproject.h"

#include "tests/bench/chain_pair.h"
#include "tests/bench/grasp_problems.h"
#include "tests/bench/skin_cache.h"

namespace handgraft::bench {

namespace {

namespace fs = std::filesystem;
using geometry::TriangleMesh;

struct Arguments {
  std::string models = "server/models";
  std::string cache = defaultCache().string();
};

TriangleMesh withFaces(const TriangleMesh& mesh, const std::vector<Eigen::Vector3i>& kept) {
  Eigen::Matrix3Xi faces(3, std::ssize(kept));
  for (Eigen::Index f = 0; f < faces.cols(); ++f)
    faces.col(f) = kept[static_cast<std::size_t>(f)];
  return {mesh.vertices(), faces};
}

/// One layer of the object, cut off beyond `share` of its extent along an axis.
ScannedGrasp cutOpen(const std::string& name,
                     const ScannedGrasp& whole,
                     int axis,
                     double share) {
  const TriangleMesh& mesh = *whole.object_O;
  const double low = mesh.vertices().row(axis).minCoeff();
  const double border = low + share * (mesh.vertices().row(axis).maxCoeff() - low);
  std::vector<Eigen::Vector3i> kept;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i face = mesh.face(f);
    if ((mesh.vertex(face[0]) + mesh.vertex(face[1]) + mesh.vertex(face[2]))[axis] / 3.0 <
        border)
      kept.push_back(face);
  }
  ScannedGrasp open;
  open.name = name;
  open.object_O = std::make_shared<const TriangleMesh>(withFaces(mesh, kept));
  open.contacts = contact::reproject(whole.contacts, mesh, *open.object_O);
  return open;
}

/// Three fingertips on one side of a sheet of 200 x 200 mm.
ScannedGrasp onSheet() {
  constexpr int kCells = 80;
  constexpr double kCell = 0.0025;  // m
  const auto number_of = [](int i, int j) {
    return i * (kCells + 1) + j;
  };
  Eigen::Matrix3Xd vertices(3, (kCells + 1) * (kCells + 1));
  std::vector<Eigen::Vector3i> faces;
  for (int i = 0; i <= kCells; ++i) {
    for (int j = 0; j <= kCells; ++j) {
      vertices.col(number_of(i, j)) << kCell * (i - kCells / 2), kCell * (j - kCells / 2), 0.0;
      if (i == kCells || j == kCells) continue;
      faces.emplace_back(number_of(i, j), number_of(i + 1, j), number_of(i + 1, j + 1));
      faces.emplace_back(number_of(i, j), number_of(i + 1, j + 1), number_of(i, j + 1));
    }
  }
  ScannedGrasp grasp;
  grasp.name = "sheet of one layer";
  const TriangleMesh plain(vertices, Eigen::Matrix3Xi());
  grasp.object_O = std::make_shared<const TriangleMesh>(withFaces(plain, faces));
  for (const auto& [name, x, y] : {std::tuple{"thumb", 0, -20}, std::tuple{"index", 6, 12},
                                   std::tuple{"middle", -6, 14}}) {
    contact::Patch patch;
    patch.name = name;
    const int i = kCells / 2 + x;
    const int j = kCells / 2 + y;
    // A square of five cells about the root, on edges of the mesh.
    for (int k = -2; k < 2; ++k)
      patch.boundary.push_back(number_of(i + k, j - 2));
    for (int k = -2; k < 2; ++k)
      patch.boundary.push_back(number_of(i + 2, j + k));
    for (int k = 2; k > -2; --k)
      patch.boundary.push_back(number_of(i + k, j + 2));
    for (int k = 2; k > -2; --k)
      patch.boundary.push_back(number_of(i - 2, j + k));
    patch.root.face = 2 * (i * kCells + j);
    patch.root.barycentric = {1.0, 0.0, 0.0};
    patch.interpolation_boundary = contact::sampleLoop(*grasp.object_O, patch.boundary);
    grasp.contacts.patches.push_back(patch);
  }
  return grasp;
}

std::vector<std::pair<hand::Hand, ScannedGrasp>> casesOf(const Arguments& arguments) {
  std::vector<std::pair<hand::Hand, ScannedGrasp>> cases;
  const ScannedGrasp glass = builtInGrasp(arguments.models, "wine_glass", "wine_glass_4");
  const ScannedGrasp carton =
      cutOpen("box without a lid", builtInGrasp(arguments.models, "box", "box_5"), 2, 0.98);
  const ScannedGrasp bowl = cutOpen(
      "half a lemon's skin", builtInGrasp(arguments.models, "lemon", "lemon_6"), 2, 0.75);
  const ScannedGrasp sheet = onSheet();
  const auto built_in = [&](const std::string& name) {
    return builtInHand(arguments.models, name, arguments.cache).hand;
  };
  for (const char* name : {"human20", "tendon16", "allegro16", "barrett8"})
    cases.emplace_back(built_in(name), glass);
  for (const char* name : {"human20", "allegro16"}) {
    cases.emplace_back(built_in(name), carton);
    cases.emplace_back(built_in(name), bowl);
    cases.emplace_back(built_in(name), sheet);
  }
  const fs::path data = environment("HANDGRAFT_SHARED_DATA");
  if (data.empty()) return cases;
  const ScannedGrasp mug = readGrasp("mug", data / "objects/ycb/025_mug.obj",
                                     data / "contacts/dexycb/025_mug_grasp0_contact.ply", true);
  for (const char* urdf :
       {"mano_mean/mano_mean_fixed.urdf", "allegro_right/allegro_hand_right.urdf"})
    cases.emplace_back(readHand(data / "hands" / urdf, arguments.cache), mug);
  return cases;
}

std::string deepest(const hand::Hand& hand, const ChainOutcome& outcome) {
  const quality::Penetration& found = outcome.penetration;
  if (found.links.empty()) return "0.0";
  return fmt::format("{:.1f} {}", 1e3 * found.max_depth_m,
                     hand.model->links()[static_cast<std::size_t>(found.links[0].link)].name);
}

void run(const Arguments& arguments) {
  fmt::print(
      "| hand | object | touch only: mean mm | deepest mm, link | by default: mean mm | "
      "deepest "
      "mm, link | self mm | solve ms |\n|---|---|---|---|---|---|---|---|\n");
  for (const auto& [hand, grasp] : casesOf(arguments)) {
    const ChainOutcome touching = graspWith(hand, grasp, false);
    const ChainOutcome out = graspWith(hand, grasp, true);
    if (!out.refused.empty()) {
      fmt::print("| {} | {} | refused: {} | | | | | |\n", out.hand, out.grasp, out.refused);
      continue;
    }
    fmt::print("| {} | {} | {:.1f} | {} | {:.1f} | {} | {:.1f} | {:.0f} |\n", out.hand,
               out.grasp, touching.mean_mm, deepest(hand, touching), out.mean_mm,
               deepest(hand, out), 1e3 * out.penetration.self_depth_m, out.ms_solve);
  }
}

}  // namespace

void addThinWallsCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "thin-walls", "Grasps of glasses, mugs, cups and sheets: how deep in their walls");
  const auto arguments = std::make_shared<Arguments>();
  command->add_option("--models", arguments->models, "Folder of the built-in library")
      ->capture_default_str();
  command->add_option("--cache", arguments->cache, "Folder that keeps the skins")
      ->capture_default_str();
  command->callback([arguments] {
    run(*arguments);
  });
}

}  // namespace handgraft::bench
