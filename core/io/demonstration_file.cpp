#include "core/io/demonstration_file.h"

#include <cmath>
#include <string>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/io/file_bytes.h"
#include "core/io/json_keys.h"

namespace handgraft::io {
namespace {

using hand::HandSide;
using manipulation::DemonstratedFrame;
using nlohmann::json;

const json& listIn(const json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end()) rejectInput("field '{}' is missing", name);
  if (!found->is_array()) rejectInput("field '{}' is no list", name);
  return *found;
}

/// Row `index` of a list, as so many finite numbers.
template <int kSize>
Eigen::Matrix<double, kSize, 1> rowOf(const json& list, const char* name, std::size_t index) {
  if (index >= list.size())
    rejectInput("field '{}' has {} frames, fewer than 'time_s'", name, list.size());
  const json& row = list[index];
  if (!row.is_array() || row.size() != kSize)
    rejectInput("field '{}', frame {}: it must be a list of {} numbers", name, index, kSize);
  Eigen::Matrix<double, kSize, 1> numbers;
  for (int i = 0; i < kSize; ++i) {
    const json& number = row[static_cast<std::size_t>(i)];
    if (!number.is_number() || !std::isfinite(number.get<double>()))
      rejectInput("field '{}', frame {}: {} is no finite number", name, index, shown(number));
    numbers[i] = number.get<double>();
  }
  return numbers;
}

hand::JointPlaces placesOf(const json& list, std::size_t index) {
  constexpr const char* kName = "joints_W_m";
  if (index >= list.size() || !list[index].is_array() || list[index].size() != 21)
    rejectInput("field '{}', frame {}: it must be a list of 21 places", kName, index);
  hand::JointPlaces places;
  for (int joint = 0; joint < 21; ++joint)
    places.col(joint) = rowOf<3>(list[index], kName, static_cast<std::size_t>(joint));
  return places;
}

std::vector<double> timesIn(const json& root) {
  std::vector<double> times;
  const json& list = listIn(root, "time_s");
  for (const json& time : list) {
    if (!time.is_number() || !std::isfinite(time.get<double>()))
      rejectInput("field 'time_s', frame {}: {} is no finite number", times.size(),
                  shown(time));
    times.push_back(time.get<double>());
    const std::size_t count = times.size();
    if (count > 1 && times[count - 1] <= times[count - 2])
      rejectInput("field 'time_s', frame {}: {} s does not lie behind the one before",
                  count - 1, times.back());
  }
  if (times.empty()) rejectInput("field 'time_s' has no frames");
  return times;
}

HandSide sideIn(const json& root) {
  const std::string side = root.value("side", std::string("right"));
  if (side == "right") return HandSide::kRight;
  if (side == "left") return HandSide::kLeft;
  rejectInput("field 'side' is {}; it is right or left", handgraft::quoted(side));
}

std::vector<DemonstratedFrame> framesFrom(const json& root) {
  if (!root.is_object() || root.value("format", json()) != kDemonstrationFormat)
    rejectInput("field 'format' must be '{}'", kDemonstrationFormat);
  if (const auto fault =
          unknownKeyIn(root, {"format", "object", "side", "time_s", "object_pose", "joints_W_m",
                              "mano_pose_rad", "mano_translation_m"}))
    rejectInput("{}", *fault);
  const HandSide side = sideIn(root);
  const std::vector<double> times = timesIn(root);
  const bool is_mano = root.contains("mano_pose_rad");
  if (is_mano == root.contains("joints_W_m"))
    rejectInput("one of the fields 'joints_W_m' and 'mano_pose_rad' must be there");
  // One pose: the object stands still.
  const json& objects = listIn(root, "object_pose");
  std::vector<DemonstratedFrame> frames;
  for (std::size_t k = 0; k < times.size(); ++k) {
    DemonstratedFrame frame;
    frame.time_s = times[k];
    frame.side = side;
    const auto pose = rowOf<7>(objects, "object_pose", objects.size() == 1 ? 0 : k);
    frame.X_WO = poseFromQuaternion({pose[0], pose[1], pose[2]},
                                    {pose[3], pose[4], pose[5], pose[6]}, "object_pose");
    if (is_mano) {
      frame.joints_W = hand::manoJointPlaces(
          rowOf<hand::kManoPoseSize>(listIn(root, "mano_pose_rad"), "mano_pose_rad", k),
          rowOf<3>(listIn(root, "mano_translation_m"), "mano_translation_m", k), side);
    } else {
      frame.joints_W = placesOf(listIn(root, "joints_W_m"), k);
    }
    frames.push_back(frame);
  }
  return frames;
}

}  // namespace

std::vector<DemonstratedFrame> readDemonstration(const std::filesystem::path& path) {
  try {
    return framesFrom(json::parse(readFileBytes(path)));
  } catch (const json::exception& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  }
}

manipulation::Motion readDemonstratedMotion(const std::filesystem::path& path,
                                            const geometry::TriangleMesh& object_O) {
  const std::vector<DemonstratedFrame> frames = readDemonstration(path);
  try {
    manipulation::Motion motion = manipulation::motionOfDemonstration(frames, object_O);
    motion.name = path.stem().string();
    return motion;
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  }
}

}  // namespace handgraft::io
