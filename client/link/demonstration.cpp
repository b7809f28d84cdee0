#include "client/link/demonstration.h"

#include <array>
#include <cmath>
#include <string>

#include <nlohmann/json.hpp>

#include "client/link/model_files.h"
#include "client/link/wire_pose.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

using DemoJson = nlohmann::json;

constexpr const char* kDemoFormat = "handgraft-demonstration/1";

/// All numbers in `value`, however deep in lists, behind those in `numbers`.
void flatten(const DemoJson& value, const std::string& where, std::vector<double>& numbers) {
  if (value.is_array()) {
    for (const DemoJson& item : value)
      flatten(item, where, numbers);
  } else if (value.is_number() && std::isfinite(value.get<double>())) {
    numbers.push_back(value.get<double>());
  } else {
    rejectInput("{}: {} is no finite number", where, value.dump());
  }
}

/// Row `frame` of a field, `count` numbers, behind those in `numbers`.
void appendRow(const DemoJson& root,
               const char* field,
               std::size_t frame,
               std::size_t count,
               std::vector<double>& numbers) {
  const auto list = root.find(field);
  if (list == root.end() || !list->is_array())
    rejectInput("field '{}' must be a list of frames", field);
  const std::string where = fmt::format("field '{}', frame {}", field, frame);
  if (frame >= list->size()) rejectInput("{}: there are fewer frames", where);
  const std::size_t before = numbers.size();
  flatten((*list)[frame], where, numbers);
  if (numbers.size() - before != count)
    rejectInput("{}: {} numbers; it must have {}", where, numbers.size() - before, count);
}

v1::DemonstratorFrame frameFrom(const DemoJson& root, std::size_t index, double time_s) {
  v1::DemonstratorFrame frame;
  frame.time_s(time_s);
  frame.chirality(root.value("side", std::string("right")) == "left" ? v1::CHIRALITY_LEFT
                                                                     : v1::CHIRALITY_RIGHT);
  if (root.contains("mano_pose_rad")) {
    frame.kind(v1::DEMONSTRATOR_MANO);
    appendRow(root, "mano_pose_rad", index, 48, frame.values());
    appendRow(root, "mano_translation_m", index, 3, frame.values());
  } else {
    frame.kind(v1::DEMONSTRATOR_JOINT_PLACES);
    appendRow(root, "joints_W_m", index, 63, frame.values());
  }
  // One pose: the object stands still.
  const auto objects = root.find("object_pose");
  const bool stands = objects != root.end() && objects->is_array() && objects->size() == 1;
  std::vector<double> pose;
  appendRow(root, "object_pose", stands ? 0 : index, 7, pose);
  frame.X_WO(placeOf({pose[0], pose[1], pose[2], pose[3], pose[4], pose[5], pose[6]},
                     "field 'object_pose'"));
  return frame;
}

std::vector<v1::DemonstratorFrame> framesFrom(const DemoJson& root) {
  if (!root.is_object() || root.value("format", DemoJson()) != kDemoFormat)
    rejectInput("field 'format' must be '{}'", kDemoFormat);
  std::vector<double> times;
  if (const auto list = root.find("time_s"); list != root.end())
    flatten(*list, "field 'time_s'", times);
  if (times.empty()) rejectInput("field 'time_s' has no frames");
  std::vector<v1::DemonstratorFrame> frames;
  for (std::size_t k = 0; k < times.size(); ++k) {
    if (k > 0 && times[k] <= times[k - 1])
      rejectInput("field 'time_s', frame {}: {} s does not lie behind the one before", k,
                  times[k]);
    frames.push_back(frameFrom(root, k, times[k]));
  }
  return frames;
}

}  // namespace

std::vector<v1::DemonstratorFrame> readDemonstration(const std::filesystem::path& path) {
  const std::string text = readFile(path);
  try {
    return framesFrom(DemoJson::parse(text));
  } catch (const DemoJson::exception& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  }
}

}  // namespace handgraft::client
