#include "idl/grasp_file.h"

#include <algorithm>

#include <nlohmann/json.hpp>

namespace handgraft::idl {

Json byName(const std::vector<std::string>& names, const Json& values) {
  Json all = Json::object();
  for (std::size_t i = 0; i < std::min(names.size(), values.size()); ++i)
    all[names[i]] = values[i];
  return all;
}

Json graspFile(const GraspNames& names, const v1::PoseSolution& solution) {
  Json said = jsonOf(solution);
  Json file = {{"format", "handgraft-grasp/1"},
               {"hand", names.hand},
               {"object", names.object},
               {"contacts", names.contacts},
               {"joints", byName(names.joints, said["joint_positions"])},
               {"links_X_WL", byName(names.links, said["X_WL"])}};
  for (Json& minimum : said["minima"]) {
    minimum["joints"] = byName(names.joints, minimum["joint_positions"]);
    minimum.erase("joint_positions");
  }
  for (const auto& [key, value] : said.items())
    if (key != "joint_positions" && key != "X_WL") file[key] = value;
  return file;
}

std::string graspText(const GraspNames& names, const v1::PoseSolution& solution) {
  return textOf(graspFile(names, solution), 2) + "\n";
}

}  // namespace handgraft::idl
