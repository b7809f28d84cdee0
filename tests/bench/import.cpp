#include "tests/bench/import.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/base/environment.h"
#include "core/base/error.h"

#include "tests/bench/contact_import.h"
#include "tests/bench/hand_import.h"

namespace handgraft::bench {

namespace {

struct ImportArguments {
  std::vector<std::string> folders;
  int poses = 100;
  bool json = false;
  bool markdown = false;
};

struct Imports {
  std::vector<HandImport> hands;
  std::vector<ContactImport> maps;
};

double degrees(double radians) {
  return radians * 180.0 / std::numbers::pi;
}

double farthestOff(const HandImport& hand) {
  double most = 0.0;
  for (const FoundSite& site : hand.sites)
    most = std::max(most, site.off_closing_deg);
  return most;
}

/// "-" for what nobody could measure.
std::string numberOr(double value, const char* format) {
  return std::isnan(value) ? "-" : fmt::format(fmt::runtime(format), value);
}

double farthestFromGiven(const HandImport& hand) {
  double most = std::numeric_limits<double>::quiet_NaN();
  for (const FoundSite& site : hand.sites)
    if (!std::isnan(site.to_given_mm) && !(site.to_given_mm <= most)) most = site.to_given_mm;
  return most;
}

void printHands(const std::vector<HandImport>& hands) {
  if (hands.empty()) return;
  fmt::print(
      "| hand | joints, followers, free root | off DART | time s | vertices | smallest angle "
      "deg "
      "| clearance mean, max mm | on a link % | pieces, genus, valid | pads of digits | on the "
      "back | off closing deg | off given mm |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const HandImport& hand : hands) {
    if (!hand.refused.empty()) {
      fmt::print("| {} | refused: {} | | | | | | | | | | | |\n", hand.name, hand.refused);
      continue;
    }
    const hand::SkinReport& skin = hand.skin;
    fmt::print(
        "| {} | {}, {}, {} | {} | {:.1f} | {} | {:.0f} | {:.2f}, {:.1f} | {:.1f} | {}, {}, {} "
        "| "
        "{} of {} | {} | {:.0f} | {} |\n",
        hand.name, hand.dofs, hand.mimics, hand.root_dofs,
        numberOr(hand.pose_difference, "{:.0e}"), hand.skin_s, skin.vertices,
        degrees(skin.smallest_angle_rad), 1e3 * skin.mean_clearance_m,
        1e3 * skin.max_clearance_m, 100.0 * skin.projected_share, skin.pieces, skin.genus,
        skin.isValid() ? "yes" : "no", hand.pads(), hand.digits, hand.sitesOnTheBack(),
        farthestOff(hand), numberOr(farthestFromGiven(hand), "{:.1f}"));
  }
}

void printMaps(const std::vector<ContactImport>& maps) {
  if (maps.empty()) return;
  fmt::print(
      "\n| contact map | touching by labels | patches | by the map alone | named as the "
      "nearest "
      "joint | points | off the boundary mm | mean area mm2 "
      "|\n|---|---|---|---|---|---|---|---|\n");
  for (const ContactImport& map : maps) {
    if (!map.refused.empty()) {
      fmt::print("| {} | refused: {} | | | | | | |\n", map.name, map.refused);
      continue;
    }
    fmt::print("| {} | {} | {} | {} | {} of {} | {} | {:.1e} | {:.0f} |\n", map.name,
               map.touching.empty() ? "-" : fmt::format("{}", fmt::join(map.touching, ", ")),
               fmt::join(map.patches, ", "), map.without_help, map.confirmed, map.compared,
               map.points, map.off_boundary_mm, map.area_mm2);
  }
}

void printText(const Imports& imports) {
  for (const HandImport& hand : imports.hands) {
    fmt::print("{}: {}\n", hand.name, hand.path.string());
    for (const std::string& note : hand.notes)
      fmt::print("  note: {}\n", note);
    for (const std::string& note : hand.skin.notes)
      fmt::print("  skin: {}\n", note);
    for (const FoundSite& site : hand.sites)
      fmt::print("  {:7} on {}, {:.0f} deg off its closing direction{}\n", site.name, site.link,
                 site.off_closing_deg,
                 std::isnan(site.to_given_mm)
                     ? ""
                     : fmt::format(", {:.1f} mm from the one given", site.to_given_mm));
  }
  for (const ContactImport& map : imports.maps)
    for (const std::string& note : map.notes)
      fmt::print("{}: note: {}\n", map.name, note);
  fmt::print("\n");
  printHands(imports.hands);
  printMaps(imports.maps);
}

nlohmann::ordered_json jsonOf(const HandImport& hand) {
  const hand::SkinReport& skin = hand.skin;
  nlohmann::ordered_json row{{"name", hand.name},
                             {"path", hand.path.string()},
                             {"refused", hand.refused},
                             {"links", hand.links},
                             {"dofs", hand.dofs},
                             {"mimics", hand.mimics},
                             {"root_dofs", hand.root_dofs},
                             {"notes", hand.notes},
                             {"read_s", hand.read_s},
                             {"pose_difference", hand.pose_difference},
                             {"skin",
                              {{"time_s", hand.skin_s},
                               {"vertices", skin.vertices},
                               {"pieces", skin.pieces},
                               {"genus", skin.genus},
                               {"valid", skin.isValid()},
                               {"smallest_angle_deg", degrees(skin.smallest_angle_rad)},
                               {"mean_clearance_mm", 1e3 * skin.mean_clearance_m},
                               {"max_clearance_mm", 1e3 * skin.max_clearance_m},
                               {"projected_share", skin.projected_share},
                               {"notes", skin.notes}}},
                             {"digits", hand.digits},
                             {"pads", hand.pads()},
                             {"sites_on_the_back", hand.sitesOnTheBack()},
                             {"sites", nlohmann::ordered_json::array()}};
  for (const FoundSite& site : hand.sites)
    row["sites"].push_back({{"name", site.name},
                            {"link", site.link},
                            {"off_closing_deg", site.off_closing_deg},
                            {"to_given_mm", site.to_given_mm}});
  return row;
}

nlohmann::ordered_json jsonOf(const ContactImport& map) {
  return {{"name", map.name},
          {"refused", map.refused},
          {"touching", map.touching},
          {"patches", map.patches},
          {"without_help", map.without_help},
          {"confirmed", map.confirmed},
          {"compared", map.compared},
          {"points", map.points},
          {"off_boundary_mm", map.off_boundary_mm},
          {"mean_area_mm2", map.area_mm2},
          {"notes", map.notes}};
}

void printJson(const Imports& imports) {
  nlohmann::ordered_json document{{"hands", nlohmann::ordered_json::array()},
                                  {"contact_maps", nlohmann::ordered_json::array()}};
  for (const HandImport& hand : imports.hands)
    document["hands"].push_back(jsonOf(hand));
  for (const ContactImport& map : imports.maps)
    document["contact_maps"].push_back(jsonOf(map));
  std::printf("%s\n", document.dump().c_str());
}

void run(ImportArguments arguments) {
  if (arguments.poses < 1 || arguments.poses > 100'000)
    rejectInput("--poses: {} must lie in 1 to 100000", arguments.poses);
  if (arguments.folders.empty()) {
    const std::string shared = environment("HANDGRAFT_SHARED_DATA");
    if (shared.empty())
      rejectInput("no folder is given and HANDGRAFT_SHARED_DATA is not set; name one");
    arguments.folders = {shared + "/hands", shared + "/contacts"};
  }
  Imports imports;
  for (const auto& urdf : urdfsIn(arguments.folders))
    imports.hands.push_back(importHand(urdf, arguments.poses));
  for (const auto& map : contactMapsIn(arguments.folders))
    imports.maps.push_back(importContacts(map));
  if (arguments.json) {
    printJson(imports);
  } else if (arguments.markdown) {
    printHands(imports.hands);
    printMaps(imports.maps);
  } else {
    printText(imports);
  }
}

}  // namespace

void addImportCommand(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "import",
      "Every URDF and contact map below folders: joints, poses, skin, sites, patches");
  const auto arguments = std::make_shared<ImportArguments>();
  command->add_option("folders", arguments->folders,
                      "With *.urdf and *_contact.ply; hands and contacts of "
                      "HANDGRAFT_SHARED_DATA");
  command->add_option("--poses", arguments->poses, "Compared with DART's, each hand")
      ->capture_default_str();
  command->add_flag("--json", arguments->json, "One JSON document");
  command->add_flag("--markdown", arguments->markdown, "The tables alone");
  command->callback([arguments] {
    run(*arguments);
  });
}

}  // namespace handgraft::bench
