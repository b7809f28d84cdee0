#include "client/link/pose_file.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "client/link/model_files.h"
#include "client/link/wire_pose.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

using Json = nlohmann::json;

constexpr const char* kGraspFormat = "handgraft-grasp/1";

template <std::size_t kCount>
std::array<double, kCount> numbersOf(const Json& parent,
                                     const char* key,
                                     const std::string& where) {
  const auto list = parent.find(key);
  if (list == parent.end() || !list->is_array() || list->size() != kCount) {
    rejectInput("{}: '{}' must be a list of {} numbers", where, key, kCount);
  }
  std::array<double, kCount> numbers{};
  for (std::size_t i = 0; i < kCount; ++i) {
    const Json& item = (*list)[i];
    if (!item.is_number() || !std::isfinite(item.get<double>())) {
      rejectInput("{}: entry {} of '{}' is {}; it must be a finite number", where, i, key,
                  item.dump());
    }
    numbers[i] = item.get<double>();
  }
  return numbers;
}

v1::Pose poseFrom(const Json& value, const std::string& where) {
  if (!value.is_object()) rejectInput("{}: it must be an object with p_m and q_wxyz", where);
  const auto p = numbersOf<3>(value, "p_m", where);
  const auto q = numbersOf<4>(value, "q_wxyz", where);
  return placeOf({p[0], p[1], p[2], q[0], q[1], q[2], q[3]}, where);
}

Json parsed(const std::filesystem::path& path) {
  const std::string text = readFile(path);
  try {
    return Json::parse(text);
  } catch (const Json::exception& error) {
    rejectInput("{}: no JSON ({})", quoted(path.string()), quoted(error.what()));
  }
}

}  // namespace

PoseFile readPose(const std::filesystem::path& path) {
  const std::string name = quoted(path.string());
  const Json document = parsed(path);
  if (!document.is_object()) rejectInput("{}: the file must hold one object", name);
  const bool is_grasp = document.contains("format");
  if (is_grasp && document["format"] != kGraspFormat) {
    rejectInput("{}: format {}; it must be {} or absent", name, document["format"].dump(),
                kGraspFormat);
  }
  if (!is_grasp) {  // a misspelt field must not count as absent
    for (const auto& [key, value] : document.items()) {
      if (key == "joints" || key == "X_WH" || key == "X_WO") continue;
      rejectInput("{}: field {}; a pose has joints, X_WH and X_WO", name, quoted(key));
    }
  }
  const auto joints = document.find("joints");
  if (joints == document.end() || !joints->is_object()) {
    rejectInput("{}: 'joints' must be an object of numbers", name);
  }
  PoseFile pose;
  for (const auto& [joint, value] : joints->items()) {
    if (!value.is_number() || !std::isfinite(value.get<double>())) {
      rejectInput("{}: joint {} is {}; it must be a finite number", name, quoted(joint),
                  value.dump());
    }
    pose.joints.push_back(joint);
    pose.joint_rad.push_back(value.get<double>());
  }
  if (document.contains("X_WH")) pose.X_WH = poseFrom(document["X_WH"], name + ": X_WH");
  if (document.contains("X_WO")) pose.X_WO = poseFrom(document["X_WO"], name + ": X_WO");
  if (const auto links = document.find("links_X_WL");
      links != document.end() && links->is_object()) {
    for (const auto& [link, X_WL] : links->items())
      pose.links_X_WL[link] = poseFrom(X_WL, fmt::format("{}: links_X_WL {}", name, link));
  }
  return pose;
}

}  // namespace handgraft::client
