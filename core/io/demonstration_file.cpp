#include "core/io/demonstration_file.h"

#include <cmath>
#include <initializer_list>
#include <map>
#include <string>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/io/file_bytes.h"
#include "core/io/json_keys.h"
#include "core/io/npz_file.h"

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

// === MANO parameter sequences as NumPy writes them

using Arrays = std::map<std::string, NpzArray>;

/// The first of `names` that is there, as rows of `columns` numbers; nullptr if none is.
const NpzArray* rowsNamed(const Arrays& arrays,
                          std::initializer_list<const char*> names,
                          std::size_t columns) {
  for (const char* name : names) {
    const auto found = arrays.find(name);
    if (found == arrays.end() || found->second.values.empty()) continue;
    const NpzArray& array = found->second;
    const std::size_t rows = array.shape.empty() ? 1 : array.shape.front();
    if (rows == 0 || array.values.size() != rows * columns)
      rejectInput("array '{}' has {} numbers in {} rows; a row has {}", name,
                  array.values.size(), rows, columns);
    return &array;
  }
  return nullptr;
}

json jsonRows(const NpzArray& array, std::size_t columns) {
  json rows = json::array();
  for (std::size_t at = 0; at < array.values.size(); at += columns)
    rows.push_back(
        std::vector<double>(array.values.begin() + static_cast<std::ptrdiff_t>(at),
                            array.values.begin() + static_cast<std::ptrdiff_t>(at + columns)));
  return rows;
}

/// Poses of an object told by rotation vectors and places.
json posesFrom(const NpzArray& turns, const NpzArray& places) {
  json rows = json::array();
  if (turns.values.size() != places.values.size())
    rejectInput("the object's rotations and places have {} and {} rows",
                turns.values.size() / 3, places.values.size() / 3);
  for (std::size_t at = 0; at + 3 <= turns.values.size(); at += 3) {
    const Eigen::Quaterniond q(
        rotationFromVector(Eigen::Vector3d::Map(turns.values.data() + at)));
    const double* p = places.values.data() + at;
    rows.push_back({p[0], p[1], p[2], q.w(), q.x(), q.y(), q.z()});
  }
  return rows;
}

/// The same fields as JSON has, from the names that MANO sequences go by.
json rootFrom(const Arrays& arrays) {
  json root = {{"format", kDemonstrationFormat}};
  for (const char* name : {"object", "side"})
    if (const auto text = arrays.find(name); text != arrays.end() && !text->second.text.empty())
      root[name] = text->second.text;
  std::size_t frames = 0;
  if (const NpzArray* joints = rowsNamed(arrays, {"joints_W_m"}, 63)) {
    frames = joints->values.size() / 63;
    json rows = json::array();
    for (const json& row : jsonRows(*joints, 63)) {
      json places = json::array();
      for (std::size_t i = 0; i < 63; i += 3)
        places.push_back({row[i], row[i + 1], row[i + 2]});
      rows.push_back(std::move(places));
    }
    root["joints_W_m"] = std::move(rows);
  } else if (const NpzArray* poses = rowsNamed(
                 arrays, {"mano_pose_rad", "pose", "poses", "fullpose"}, hand::kManoPoseSize)) {
    frames = poses->values.size() / hand::kManoPoseSize;
    root["mano_pose_rad"] = jsonRows(*poses, hand::kManoPoseSize);
  } else {
    constexpr std::size_t kFingers = hand::kManoPoseSize - 3;
    const NpzArray* turns = rowsNamed(arrays, {"global_orient"}, 3);
    const NpzArray* fingers = rowsNamed(arrays, {"hand_pose"}, kFingers);
    if (turns == nullptr || fingers == nullptr)
      rejectInput(
          "neither 'mano_pose_rad' ('pose', 'poses', 'fullpose': 48 numbers a row), nor "
          "'global_orient' and 'hand_pose', nor 'joints_W_m' is there");
    frames = turns->values.size() / 3;
    if (fingers->values.size() != frames * kFingers)
      rejectInput("'global_orient' has {} rows, 'hand_pose' {}", frames,
                  fingers->values.size() / kFingers);
    json rows = json::array();
    for (std::size_t k = 0; k < frames; ++k) {
      std::vector<double> row(turns->values.begin() + static_cast<std::ptrdiff_t>(3 * k),
                              turns->values.begin() + static_cast<std::ptrdiff_t>(3 * k + 3));
      row.insert(row.end(), fingers->values.begin() + static_cast<std::ptrdiff_t>(kFingers * k),
                 fingers->values.begin() + static_cast<std::ptrdiff_t>(kFingers * (k + 1)));
      rows.push_back(std::move(row));
    }
    root["mano_pose_rad"] = std::move(rows);
  }
  if (const NpzArray* places = rowsNamed(arrays, {"mano_translation_m", "trans", "transl"}, 3))
    root["mano_translation_m"] = jsonRows(*places, 3);
  if (const NpzArray* times = rowsNamed(arrays, {"time_s"}, 1)) {
    root["time_s"] = times->values;
  } else if (const NpzArray* rate = rowsNamed(
                 arrays, {"fps", "mocap_framerate", "mocap_frame_rate", "framerate"}, 1)) {
    if (!(rate->values[0] > 0.0) || !std::isfinite(rate->values[0]))
      rejectInput("frames a second: {}; they must lie above 0", rate->values[0]);
    root["time_s"] = json::array();
    for (std::size_t k = 0; k < frames; ++k)
      root["time_s"].push_back(static_cast<double>(k) / rate->values[0]);
  } else {
    rejectInput("neither 'time_s' nor 'fps' is there");
  }
  if (const NpzArray* poses = rowsNamed(arrays, {"object_pose"}, 7)) {
    root["object_pose"] = jsonRows(*poses, 7);
  } else {
    const NpzArray* turns = rowsNamed(arrays, {"object_global_orient", "object_rot"}, 3);
    const NpzArray* places = rowsNamed(arrays, {"object_transl", "object_trans"}, 3);
    if (turns == nullptr || places == nullptr)
      rejectInput(
          "neither 'object_pose' (x y z qw qx qy qz) nor 'object_global_orient' with "
          "'object_transl' is there");
    root["object_pose"] = posesFrom(*turns, *places);
  }
  return root;
}

json demonstrationRoot(const std::filesystem::path& path) {
  const std::string bytes = readFileBytes(path);
  return isNpz(bytes) ? rootFrom(readNpz(bytes)) : json::parse(bytes);
}

}  // namespace

std::string objectOfNpz(const std::filesystem::path& path) {
  const Arrays arrays = readNpz(readFileBytes(path));
  const auto object = arrays.find("object");
  return object == arrays.end() ? "" : object->second.text;
}

std::vector<DemonstratedFrame> readDemonstration(const std::filesystem::path& path) {
  try {
    return framesFrom(demonstrationRoot(path));
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
