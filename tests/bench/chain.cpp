#include "tests/bench/chain.h"

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/environment.h"
#include "core/base/error.h"

#include "tests/bench/chain_pair.h"
#include "tests/bench/skin_cache.h"

namespace handgraft::bench {

namespace {

namespace fs = std::filesystem;

struct ChainArguments {
  std::vector<std::string> hands;
  std::vector<std::string> objects;
  std::vector<std::string> contacts;
  std::string cache = defaultCache().string();
  bool joints = false;
  bool touch_only = false;
  bool json = false;
  bool markdown = false;
};

/// Where the pairs lie. Errors: InvalidInput if nobody says.
fs::path sharedData() {
  const fs::path shared = environment("HANDGRAFT_SHARED_DATA");
  if (shared.empty())
    rejectInput("--hand, --object and --contacts, or HANDGRAFT_SHARED_DATA, must be given");
  return shared;
}

std::vector<std::string> handsOf(const ChainArguments& arguments) {
  if (!arguments.hands.empty()) return arguments.hands;
  const fs::path hands = sharedData() / "hands";
  return {hands / "allegro_right/allegro_hand_right.urdf",
          hands / "barrett_bhand/bhand_model.urdf",
          hands / "human_hand_graspit20/human_hand_graspit20.urdf",
          hands / "mia_hand_right/mia_hand_description/urdf/mia_hand.urdf"};
}

std::vector<ScannedGrasp> graspsOf(const ChainArguments& arguments) {
  std::vector<ScannedGrasp> grasps;
  for (std::size_t i = 0; i < arguments.objects.size(); ++i) {
    grasps.push_back(readGrasp(fs::path(arguments.objects[i]).stem().string(),
                               arguments.objects[i], arguments.contacts[i], arguments.joints));
  }
  if (!grasps.empty()) return grasps;
  const fs::path shared = sharedData();
  const fs::path bulb = shared / "contacts/contactpose";
  grasps.push_back(readGrasp("light bulb", bulb / "light_bulb.glb",
                             bulb / "full28_use_light_bulb_contact.ply", arguments.joints));
  for (const auto& [name, file] :
       {std::pair{"mustard", "006_mustard_bottle"}, std::pair{"mug", "025_mug"},
        std::pair{"cracker box", "003_cracker_box"}}) {
    grasps.push_back(readGrasp(
        name, shared / fmt::format("objects/ycb/{}.obj", file),
        shared / fmt::format("contacts/dexycb/{}_grasp0_contact.ply", file), arguments.joints));
  }
  return grasps;
}

std::string droppedIn(const ChainOutcome& outcome) {
  std::string names;
  for (const PatchOutcome& patch : outcome.patches)
    if (!patch.dropped.empty()) names += (names.empty() ? "" : ", ") + patch.name;
  return names;
}

void printTable(const std::vector<ChainOutcome>& outcomes) {
  fmt::print(
      "| hand | object | mean mm | worst patch mm | normal deg | points lost | dropped | "
      "inside "
      "mm | deepest mm | cm3 | self mm | lay ms | solve ms "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const ChainOutcome& outcome : outcomes) {
    if (!outcome.refused.empty()) {
      fmt::print("| {} | {} | refused: {} | | | | | | | | | | |\n", outcome.hand, outcome.grasp,
                 outcome.refused);
      continue;
    }
    const PatchOutcome* worst = outcome.worst();
    fmt::print(
        "| {} | {} | {:.1f} | {:.1f} {} | {:.0f} | {} of {} | {} | {:.1f} | {:.1f} | {:.2f} | "
        "{:.1f} | {:.0f} | {:.0f} |\n",
        outcome.hand, outcome.grasp, outcome.mean_mm, worst == nullptr ? 0.0 : worst->mean_mm,
        worst == nullptr ? "" : worst->name, outcome.normal_deg, outcome.lost(),
        outcome.points() + outcome.lost(), droppedIn(outcome), outcome.depth_mm,
        1e3 * outcome.penetration.max_depth_m, 1e6 * outcome.penetration.volume_m3,
        1e3 * outcome.penetration.self_depth_m, outcome.ms_transfer, outcome.ms_solve);
  }
}

void printText(const std::vector<ChainOutcome>& outcomes) {
  for (const ChainOutcome& outcome : outcomes) {
    fmt::print("\n{} grasps {}\n", outcome.hand, outcome.grasp);
    if (!outcome.refused.empty()) fmt::print("refused: {}\n", outcome.refused);
    for (const PatchOutcome& patch : outcome.patches) {
      if (!patch.dropped.empty()) {
        fmt::print("  {:7} dropped: {}\n", patch.name, patch.dropped);
        continue;
      }
      fmt::print("  {:7} on {:7} {:6.1f} mm {:4.0f} deg, {} points, {} lost\n", patch.name,
                 patch.site, patch.mean_mm, patch.normal_deg, patch.points, patch.lost);
    }
    for (const std::string& note : outcome.notes)
      fmt::print("  note: {}\n", note);
    fmt::print("  objective {:.1f}, {}, {} joints at limits\n", outcome.objective,
               outcome.outcome, outcome.joints_at_limits);
  }
  fmt::print("\n");
  printTable(outcomes);
}

void printJson(const std::vector<ChainOutcome>& outcomes) {
  nlohmann::ordered_json document{{"chain", nlohmann::ordered_json::array()}};
  for (const ChainOutcome& outcome : outcomes) {
    nlohmann::ordered_json row{{"hand", outcome.hand},
                               {"grasp", outcome.grasp},
                               {"refused", outcome.refused},
                               {"mean_mm", outcome.mean_mm},
                               {"normal_deg", outcome.normal_deg},
                               {"points", outcome.points()},
                               {"lost", outcome.lost()},
                               {"depth_mm", outcome.depth_mm},
                               {"deepest_mm", 1e3 * outcome.penetration.max_depth_m},
                               {"shared_cm3", 1e6 * outcome.penetration.volume_m3},
                               {"self_mm", 1e3 * outcome.penetration.self_depth_m},
                               {"ms_penetration", outcome.ms_penetration},
                               {"objective", outcome.objective},
                               {"outcome", outcome.outcome},
                               {"joints_at_limits", outcome.joints_at_limits},
                               {"ms_transfer", outcome.ms_transfer},
                               {"ms_solve", outcome.ms_solve},
                               {"notes", outcome.notes},
                               {"patches", nlohmann::ordered_json::array()}};
    for (const PatchOutcome& patch : outcome.patches) {
      row["patches"].push_back({{"name", patch.name},
                                {"site", patch.site},
                                {"dropped", patch.dropped},
                                {"points", patch.points},
                                {"lost", patch.lost},
                                {"mean_mm", patch.mean_mm},
                                {"normal_deg", patch.normal_deg}});
    }
    document["chain"].push_back(row);
  }
  std::printf("%s\n", document.dump().c_str());
}

void run(const ChainArguments& arguments) {
  if (arguments.objects.size() != arguments.contacts.size())
    rejectInput("{} times --object, {} times --contacts; they come in pairs",
                arguments.objects.size(), arguments.contacts.size());
  const std::vector<ScannedGrasp> grasps = graspsOf(arguments);
  std::vector<ChainOutcome> outcomes;
  for (const std::string& urdf : handsOf(arguments)) {
    const hand::Hand hand = readHand(urdf, arguments.cache);
    for (const ScannedGrasp& grasp : grasps)
      outcomes.push_back(graspWith(hand, grasp, !arguments.touch_only));
  }
  if (arguments.json) {
    printJson(outcomes);
  } else if (arguments.markdown) {
    printTable(outcomes);
  } else {
    printText(outcomes);
  }
}

}  // namespace

void addChainCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "chain",
      "Hands by their URDF alone grasp objects by scanned contact alone, all defaults");
  const auto arguments = std::make_shared<ChainArguments>();
  command->add_option("--hand", arguments->hands,
                      "URDFs; unless given, four hands of HANDGRAFT_SHARED_DATA");
  command->add_option("--object", arguments->objects,
                      "Meshes; unless given, four of HANDGRAFT_SHARED_DATA");
  command->add_option("--contacts", arguments->contacts, "One contact map or set an object");
  command->add_option("--cache", arguments->cache, "Folder that keeps the skins")
      ->capture_default_str();
  command->add_flag("--joints", arguments->joints,
                    "Fingers and directions from the recorded joints of the hand that touched");
  command->add_flag("--touch-only", arguments->touch_only,
                    "Solve without charging depth in the object");
  command->add_flag("--json", arguments->json, "One JSON document, with every patch");
  command->add_flag("--markdown", arguments->markdown, "The table alone");
  command->callback([arguments] {
    run(*arguments);
  });
}

}  // namespace handgraft::bench
