#include "core/formats/demonstration_arrays.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <vector>

#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/pose.h"

namespace handgraft::formats {
namespace {

using nlohmann::json;
using Arrays = std::map<std::string, NpzArray>;

constexpr std::size_t kManoPoseSize = 48;

/// The first of `names` that is there, as rows of `columns` numbers; nullptr if none is.
const NpzArray* rowsNamed(const Arrays& arrays,
                          std::initializer_list<const char*> names,
                          std::size_t columns) {
  for (const char* name : names) {
    const auto found = arrays.find(name);
    if (found == arrays.end()) continue;
    const NpzArray& array = found->second;
    const bool is_empty = std::count(array.shape.begin(), array.shape.end(), 0) > 0;
    if (is_empty) continue;
    if (array.values.empty())
      rejectInput("array {} holds no numbers: its type is {}, its shape ({})", quoted(name),
                  quoted(array.type), fmt::join(array.shape, ", "));
    const std::size_t rows = array.shape.empty() ? 1 : array.shape.front();
    if (rows == 0 || array.values.size() != rows * columns)
      rejectInput("array {} has {} numbers in {} rows; a row has {}", quoted(name),
                  array.values.size(), rows, columns);
    return &array;
  }
  return nullptr;
}

/// A single text, or "" where there is none of that name. Errors: InvalidInput for what is
/// there and no text, such as an object array: whoever wrote it wanted to say something.
std::string textNamed(const Arrays& arrays, const char* name) {
  const auto found = arrays.find(name);
  if (found == arrays.end()) return "";
  if (found->second.text.empty())
    rejectInput("array {} is no single text: its type is {}, its shape ({})", quoted(name),
                quoted(found->second.type), fmt::join(found->second.shape, ", "));
  return found->second.text;
}

/// The object's name; recordings call arrays of numbers so, too.
std::string objectIn(const Arrays& arrays) {
  const auto found = arrays.find("object");
  if (found != arrays.end() && !found->second.values.empty()) return "";
  return textNamed(arrays, "object");
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

/// Rows of a MANO pose whose root and fingers stand in arrays of their own.
json joinedPoses(const NpzArray& turns, const NpzArray& fingers) {
  constexpr std::size_t kFingers = kManoPoseSize - 3;
  const std::size_t frames = turns.values.size() / 3;
  if (fingers.values.size() != frames * kFingers)
    rejectInput("'global_orient' has {} rows, 'hand_pose' {}", frames,
                fingers.values.size() / kFingers);
  json rows = json::array();
  for (std::size_t k = 0; k < frames; ++k) {
    const auto turn = turns.values.begin() + static_cast<std::ptrdiff_t>(3 * k);
    const auto finger = fingers.values.begin() + static_cast<std::ptrdiff_t>(kFingers * k);
    std::vector<double> row(turn, turn + 3);
    row.insert(row.end(), finger, finger + static_cast<std::ptrdiff_t>(kFingers));
    rows.push_back(std::move(row));
  }
  return rows;
}

/// Puts in the hand's joints or poses; of how many frames.
std::size_t putHand(const Arrays& arrays, json& root) {
  if (const NpzArray* joints = rowsNamed(arrays, {"joints_W_m"}, 63)) {
    json rows = json::array();
    for (const json& row : jsonRows(*joints, 63)) {
      json places = json::array();
      for (std::size_t i = 0; i < 63; i += 3)
        places.push_back({row[i], row[i + 1], row[i + 2]});
      rows.push_back(std::move(places));
    }
    root["joints_W_m"] = std::move(rows);
    return joints->values.size() / 63;
  }
  if (const NpzArray* poses =
          rowsNamed(arrays, {"mano_pose_rad", "pose", "poses", "fullpose"}, kManoPoseSize)) {
    root["mano_pose_rad"] = jsonRows(*poses, kManoPoseSize);
    return poses->values.size() / kManoPoseSize;
  }
  const NpzArray* turns = rowsNamed(arrays, {"global_orient"}, 3);
  const NpzArray* fingers = rowsNamed(arrays, {"hand_pose"}, kManoPoseSize - 3);
  if (turns == nullptr || fingers == nullptr)
    rejectInput(
        "neither 'mano_pose_rad' ('pose', 'poses', 'fullpose': 48 numbers a row), nor "
        "'global_orient' and 'hand_pose', nor 'joints_W_m' is there");
  root["mano_pose_rad"] = joinedPoses(*turns, *fingers);
  return turns->values.size() / 3;
}

json timesFrom(const Arrays& arrays, std::size_t frames) {
  if (const NpzArray* times = rowsNamed(arrays, {"time_s"}, 1)) return times->values;
  const NpzArray* rate =
      rowsNamed(arrays, {"fps", "mocap_framerate", "mocap_frame_rate", "framerate"}, 1);
  if (rate == nullptr) rejectInput("neither 'time_s' nor 'fps' is there");
  if (!(rate->values[0] > 0.0) || !std::isfinite(rate->values[0]))
    rejectInput("frames a second: {}; they must lie above 0", rate->values[0]);
  json times = json::array();
  for (std::size_t k = 0; k < frames; ++k)
    times.push_back(static_cast<double>(k) / rate->values[0]);
  return times;
}

json objectPosesFrom(const Arrays& arrays) {
  if (const NpzArray* poses = rowsNamed(arrays, {"object_pose"}, 7)) return jsonRows(*poses, 7);
  const NpzArray* turns = rowsNamed(arrays, {"object_global_orient", "object_rot"}, 3);
  const NpzArray* places = rowsNamed(arrays, {"object_transl", "object_trans"}, 3);
  if (turns == nullptr || places == nullptr)
    rejectInput(
        "neither 'object_pose' (x y z qw qx qy qz) nor 'object_global_orient' with "
        "'object_transl' is there");
  return posesFrom(*turns, *places);
}

}  // namespace

Demonstration demonstrationFrom(const Arrays& arrays) {
  json root = {{"format", kDemonstrationFormat}};
  if (const std::string object = objectIn(arrays); !object.empty()) root["object"] = object;
  if (const std::string side = textNamed(arrays, "side"); !side.empty()) root["side"] = side;
  const std::size_t frames = putHand(arrays, root);
  if (const NpzArray* places = rowsNamed(arrays, {"mano_translation_m", "trans", "transl"}, 3))
    root["mano_translation_m"] = jsonRows(*places, 3);
  root["time_s"] = timesFrom(arrays, frames);
  root["object_pose"] = objectPosesFrom(arrays);
  Demonstration demonstration = demonstrationFrom(root);
  if (arrays.contains("betas"))
    demonstration.notes.emplace_back(
        "array 'betas' is not read: MANO's pose is that of the mean hand");
  return demonstration;
}

std::string objectOfNpz(std::string_view bytes) {
  return objectIn(readNpz(bytes));
}

}  // namespace handgraft::formats
