#include "idl/grasp_file.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

namespace handgraft::idl {

namespace {

/// The patches with what became of them, then those that were dropped.
Json patchesWithReports(Json patches, const std::vector<v1::PatchReport>& reports) {
  for (Json& patch : patches) {
    const auto report =
        std::find_if(reports.begin(), reports.end(), [&](const v1::PatchReport& one) {
          return one.name() == patch["name"].get<std::string>();
        });
    if (report != reports.end()) patch.update(jsonOf(*report));
  }
  for (const v1::PatchReport& report : reports)
    if (!report.placed()) patches.push_back(jsonOf(report));
  return patches;
}

}  // namespace

double penetrationCharge(const v1::Terms& terms, const v1::Weights& weights) {
  constexpr double kRounding = 1e-12;  // of the objective
  const double others = weights.distance() * terms.distance_m2() +
                        weights.normal() * terms.normal() + weights.prior() * terms.prior();
  const double charge = terms.objective() - others;
  return charge < kRounding * std::abs(terms.objective()) ? 0.0 : charge;
}

Json byName(const std::vector<std::string>& names, const Json& values) {
  Json all = Json::object();
  for (std::size_t i = 0; i < std::min(names.size(), values.size()); ++i)
    all[names[i]] = values[i];
  return all;
}

Json graspFile(const GraspNames& names,
               const v1::PoseSolution& solution,
               const std::vector<v1::PatchReport>& reports) {
  Json said = jsonOf(solution);
  Json file = {{"format", "handgraft-grasp/1"},
               {"hand", names.hand},
               {"object", names.object},
               {"contacts", names.contacts},
               {"joints", byName(names.joints, said["joint_positions"])},
               {"links_X_WL", byName(names.links, said["X_WL"])}};
  if (names.weights) {
    said["terms"]["penetration"] = penetrationCharge(solution.terms(), *names.weights);
    for (std::size_t i = 0; i < solution.minima().size(); ++i)
      said["minima"][i]["terms"]["penetration"] =
          penetrationCharge(solution.minima()[i].terms(), *names.weights);
    file["weights"] = jsonOf(*names.weights);
  }
  for (Json& minimum : said["minima"]) {
    minimum["joints"] = byName(names.joints, minimum["joint_positions"]);
    minimum.erase("joint_positions");
  }
  for (const auto& [key, value] : said.items())
    if (key != "joint_positions" && key != "X_WL") file[key] = value;
  file["patches"] = patchesWithReports(std::move(file["patches"]), reports);
  return file;
}

std::string graspText(const GraspNames& names,
                      const v1::PoseSolution& solution,
                      const std::vector<v1::PatchReport>& reports) {
  return textOf(graspFile(names, solution, reports), 2) + "\n";
}

}  // namespace handgraft::idl
