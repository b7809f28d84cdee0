#include "core/io/motion_plan.h"

#include <array>
#include <cmath>
#include <exception>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/formats/demonstration_text.h"
#include "core/formats/json_keys.h"
#include "core/formats/zip_file.h"
#include "core/io/contact_file.h"
#include "core/io/demonstration_file.h"
#include "core/io/file_bytes.h"
#include "core/io/motion_file.h"
#include "core/io/motion_import.h"
#include "core/manipulation/grasp_interpolation.h"

namespace handgraft::io {
namespace {

using manipulation::Motion;
using nlohmann::json;

constexpr const char* kPlanFormat = "handgraft-motion-plan/1";

json rootOf(const std::filesystem::path& path) {
  try {
    json root = formats::parsedJson(readFileBytes(path));
    if (!root.is_object()) rejectInput("is no JSON object");
    return root;
  } catch (const json::exception& error) {
    rejectInput("{}: is no JSON: {}", quoted(path.string()), error.what());
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  }
}

std::string textIn(const json& root, const char* name) {
  const auto field = root.find(name);
  if (field == root.end()) return "";
  if (!field->is_string())
    rejectInput("field '{}' is {}; it must be a text", name, formats::shown(*field));
  return field->get<std::string>();
}

std::optional<double> numberIn(const json& root, const char* name) {
  const auto field = root.find(name);
  if (field == root.end()) return std::nullopt;
  if (!field->is_number())
    rejectInput("field '{}' is {}; it must be a number", name, formats::shown(*field));
  return field->get<double>();
}

bool isPlan(const json& root) {
  const auto format = root.find("format");
  return format != root.end() && *format == kPlanFormat;
}

Motion joinedFrom(const json& root, const MeshFile& object, const FileOf& file_of) {
  if (const auto fault = formats::unknownKeyIn(
          root, {"format", "name", "object", "first", "last", "path", "rate_hz",
                 "slide_begin_share", "slide_end_share", "vanish_share", "appear_share"}))
    rejectInput("{}", *fault);
  const std::string first = textIn(root, "first");
  const std::string last = textIn(root, "last");
  const std::string path = textIn(root, "path");
  if (first.empty() || path.empty())
    rejectInput("field '{}' is missing", first.empty() ? "first" : "path");
  manipulation::TwoGraspOptions options;
  options.rate = numberIn(root, "rate_hz").value_or(options.rate);
  options.slide_begin = numberIn(root, "slide_begin_share").value_or(options.slide_begin);
  options.slide_end = numberIn(root, "slide_end_share").value_or(options.slide_end);
  options.vanish = numberIn(root, "vanish_share").value_or(options.vanish);
  options.appear = numberIn(root, "appear_share").value_or(options.appear);
  std::vector<manipulation::ObjectKey> keys;
  for (const TimedPose& pose : readKeyframes(file_of(path)))
    keys.push_back({pose.time_s, pose.X_WO});
  const contact::ContactSet begin = readContactSet(file_of(first), object);
  const contact::ContactSet end = last.empty() ? begin : readContactSet(file_of(last), object);
  return manipulation::interpolateGrasps(object.mesh, begin, end, keys, options);
}

Motion plannedFrom(const json& root, const MeshFile& object, const FileOf& file_of) {
  const std::string recording = textIn(root, "recording");
  if (recording.empty()) return joinedFrom(root, object, file_of);
  if (const auto fault =
          formats::unknownKeyIn(root, {"format", "name", "object", "recording", "object_path"}))
    rejectInput("{}", *fault);
  const std::string object_path = textIn(root, "object_path");
  return readContactSequence(file_of(recording), object.mesh,
                             object_path.empty() ? "" : file_of(object_path));
}

}  // namespace

Motion readMotionFrom(const std::filesystem::path& path,
                      const MeshFile& object,
                      const FileOf& file_of) {
  if (formats::isZip(readFileBytes(path))) return readDemonstratedMotion(path, object.mesh);
  const json root = rootOf(path);
  if (root.value("format", json()) == kTrajectoryFormat)
    rejectInput("{}: is what a hand did; it takes that hand to tell what it touched",
                quoted(path.string()));
  if (root.contains("frames")) return readContactSequence(path, object.mesh, "");
  const auto format = root.find("format");
  if (format != root.end() && *format == formats::kDemonstrationFormat)
    return readDemonstratedMotion(path, object.mesh);
  if (!isPlan(root)) return readMotion(path, object.mesh);
  std::string name;
  Motion motion = [&] {
    try {
      name = textIn(root, "name");
      return plannedFrom(root, object, file_of);
    } catch (const InvalidInput& error) {
      rejectInput("{}: {}", quoted(path.string()), error.what());
    }
  }();
  if (!name.empty()) motion.name = name;
  return motion;
}

std::optional<HandTrajectoryPlan> readHandTrajectoryPlan(const std::filesystem::path& path,
                                                         const FileOf& file_of) {
  if (formats::isZip(readFileBytes(path))) return std::nullopt;
  const json root = rootOf(path);
  if (!isPlan(root) || !root.contains("hand_trajectory")) return std::nullopt;
  HandTrajectoryPlan plan;
  std::string trajectory;
  try {
    if (const auto fault = formats::unknownKeyIn(
            root,
            {"format", "name", "object", "hand", "hand_trajectory", "reach_m", "every_s"}))
      rejectInput("{}", *fault);
    plan.name = textIn(root, "name");
    plan.hand = textIn(root, "hand");
    if (plan.hand.empty()) rejectInput("field 'hand' is missing");
    trajectory = textIn(root, "hand_trajectory");
    plan.reach_m = numberIn(root, "reach_m");
    plan.every_s = numberIn(root, "every_s");
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  }
  plan.trajectory = readHandTrajectory(file_of(trajectory));
  return plan;
}

}  // namespace handgraft::io
