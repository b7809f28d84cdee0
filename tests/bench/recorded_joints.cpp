#include "tests/bench/recorded_joints.h"

#include <fstream>
#include <regex>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/pose.h"
#include "core/io/hand_joints_file.h"

namespace handgraft::bench {

namespace fs = std::filesystem;

namespace {

contact::HandJoints dexYcbJoints(const fs::path& file, const std::string& object, int grasp) {
  std::ifstream stream(file);
  contact::HandJoints joints;
  try {
    const nlohmann::json entry =
        nlohmann::json::parse(stream).at("grasps").at(object).at(grasp);
    const auto o = entry.at("object_pose_xyz_qwxyz").get<std::vector<double>>();
    Pose X_WO = Pose::Identity();
    X_WO.linear() =
        Eigen::Quaterniond(o.at(3), o.at(4), o.at(5), o.at(6)).normalized().toRotationMatrix();
    X_WO.translation() << o.at(0), o.at(1), o.at(2);
    const auto places = entry.at("joints21").get<std::vector<std::vector<double>>>();
    for (int i = 0; i < 21; ++i) {
      // MANO's order, the thumb last, turned into ours, the thumb first.
      const int from = i == 0 ? 0 : i <= 4 ? i + 16 : i - 4;
      const std::vector<double>& p_W = places.at(static_cast<std::size_t>(from));
      joints.p_O.col(i) = inverse(X_WO) * Eigen::Vector3d(p_W.at(0), p_W.at(1), p_W.at(2));
    }
  } catch (const std::exception& error) {
    rejectInput("{}: no joints of grasp {} of {}: {}", file.string(), grasp, object,
                error.what());
  }
  return joints;
}

}  // namespace

std::optional<contact::HandJoints> recordedJoints(const fs::path& map) {
  static const std::regex map_name("(.+)_contact");
  static const std::regex dexycb_name("(.+)_grasp([0-9]{1,4})");
  const std::string stem = map.stem().string();
  std::smatch match;
  if (!std::regex_match(stem, match, map_name)) return std::nullopt;
  const std::string name = match[1];
  if (const fs::path own = map.parent_path() / (name + ".json"); fs::exists(own))
    return io::readHandJoints(own);
  const fs::path all = map.parent_path() / "dexycb_grasps.json";
  if (fs::exists(all) && std::regex_match(name, match, dexycb_name))
    return dexYcbJoints(all, match[1], std::stoi(match[2]));
  return std::nullopt;
}

}  // namespace handgraft::bench
