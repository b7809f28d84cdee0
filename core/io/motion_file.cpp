#include "core/io/motion_file.h"

#include <cmath>
#include <exception>
#include <initializer_list>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/formats/json_keys.h"
#include "core/geometry/surface_locator.h"
#include "core/io/file_bytes.h"
#include "core/io/posture_json.h"

namespace handgraft::io {
namespace {

using geometry::SurfaceLocator;
using geometry::SurfacePoint;
using manipulation::DemonstratorKey;
using manipulation::HandPoint;
using manipulation::Motion;
using manipulation::PatchKey;
using manipulation::PatchTrack;
using nlohmann::json;

constexpr const char* kMotionFormat = "handgraft-motion/1";
constexpr std::uintmax_t kMostMotionBytes = std::uintmax_t{1} << 30;
constexpr double kFarthestPlaceOfMotion = 100.0;

/// The fields of one object of the file: each is asked for by name, and none may be left over.
class Fields {
 public:
  Fields(const json& object, const char* what, std::initializer_list<const char*> permitted)
      : object_(object) {
    if (!object.is_object()) rejectInput("{} is no object", what);
    if (const auto fault = formats::unknownKeyIn(object, permitted)) rejectInput("{}", *fault);
  }

  [[nodiscard]] bool has(const char* name) const { return object_.contains(name); }

  [[nodiscard]] const json& at(const char* name) const {
    const auto field = object_.find(name);
    if (field == object_.end()) rejectInput("field '{}' is missing", name);
    return *field;
  }

  [[nodiscard]] const json& list(const char* name) const {
    const json& value = at(name);
    if (!value.is_array()) rejectInput("field '{}' is no array", name);
    return value;
  }

  [[nodiscard]] std::string text(const char* name) const {
    if (!has(name)) return "";
    const json& value = at(name);
    if (!value.is_string())
      rejectInput("field '{}' is {}; it must be a text", name, formats::shown(value));
    return value.get<std::string>();
  }

  [[nodiscard]] int whole(const char* name) const {
    const json& value = at(name);
    if (!value.is_number_unsigned() ||
        value.get<std::uint64_t>() >
            static_cast<std::uint64_t>(std::numeric_limits<int>::max())) {
      rejectInput("field '{}' is {}; it must be a whole number from 0", name,
                  formats::shown(value));
    }
    return value.get<int>();
  }

  [[nodiscard]] double number(const char* name, double otherwise) const {
    if (!has(name)) return otherwise;
    const json& value = at(name);
    if (!value.is_number())
      rejectInput("field '{}' is {}; it must be a number", name, formats::shown(value));
    return value.get<double>();
  }

 private:
  const json& object_;
};

template <int count>
Eigen::Matrix<double, count, 1> numbersFrom(const json& value, const char* name) {
  if (!value.is_array() || value.size() != count)
    rejectInput("field '{}' must be an array of {} numbers", name, count);
  Eigen::Matrix<double, count, 1> numbers;
  for (int i = 0; i < count; ++i) {
    const json& number = value[static_cast<std::size_t>(i)];
    if (!number.is_number())
      rejectInput("field '{}' has {}; it must have numbers", name, formats::shown(number));
    numbers[i] = number.get<double>();
  }
  return numbers;
}

SurfacePoint onSurface(const json& value, const char* name, const SurfaceLocator& object_O) {
  const Eigen::Vector3d p_O = numbersFrom<3>(value, name);
  if (!p_O.allFinite()) rejectInput("field '{}' is not finite", name);
  const SurfaceLocator::Hit hit = object_O.nearest(p_O);
  if (hit.distance > kMotionReach) {
    rejectInput("field '{}': a point lies {:.2f} mm off the object; permitted are {:.0f} mm",
                name, 1e3 * hit.distance, 1e3 * kMotionReach);
  }
  return hit.point;
}

hand::HandLocation placeOfMotion(const json& value) {
  const Fields fields(
      value, "field 'place'",
      {"digit", "segment", "segments", "along", "around_rad", "across", "from_tip"});
  hand::HandLocation place;
  place.digit = fields.text("digit");
  place.segment = fields.text("segment");
  if (fields.has("segments")) place.segment_count = fields.whole("segments");
  place.along = fields.number("along", place.along);
  place.around_rad = fields.number("around_rad", place.around_rad);
  place.across = fields.number("across", place.across);
  place.from_tip = fields.number("from_tip", place.from_tip);
  for (const double number : {place.along, place.around_rad, place.across, place.from_tip}) {
    if (!(std::abs(number) <= kFarthestPlaceOfMotion))
      rejectInput("field 'place' has {}; permitted are {} to {}", number,
                  -kFarthestPlaceOfMotion, kFarthestPlaceOfMotion);
  }
  return place;
}

json placeOfMotionJson(const hand::HandLocation& place) {
  return {{"digit", place.digit},
          {"segment", place.segment},
          {"segments", place.segment_count},
          {"along", place.along},
          {"around_rad", place.around_rad},
          {"across", place.across},
          {"from_tip", place.from_tip}};
}

PatchKey keyFrom(const json& value, const std::string& name, const SurfaceLocator& object_O) {
  const Fields fields(value, "a key",
                      {"frame", "root", "direction", "points", "hand", "place", "weight"});
  PatchKey key;
  key.frame = fields.whole("frame");
  key.patch.name = name;
  key.patch.root = onSurface(fields.at("root"), "root", object_O);
  if (fields.has("direction"))
    key.patch.direction_O = numbersFrom<3>(fields.at("direction"), "direction");
  for (const json& point : fields.list("points"))
    key.patch.interpolation_boundary.push_back(onSurface(point, "points", object_O));
  if (fields.has("hand")) {
    for (const json& point : fields.list("hand")) {
      const Fields own(point, "a point of field 'hand'", {"link", "point"});
      key.hand_points.push_back({own.text("link"), numbersFrom<3>(own.at("point"), "point")});
    }
  }
  if (fields.has("place")) key.patch.place = placeOfMotion(fields.at("place"));
  key.patch.weight = fields.number("weight", key.patch.weight);
  return key;
}

PatchTrack trackFrom(const json& value, const SurfaceLocator& object_O) {
  const Fields fields(value, "a track", {"name", "end", "keys"});
  PatchTrack track;
  track.name = fields.text("name");
  track.end = fields.whole("end");
  for (const json& key : fields.list("keys"))
    track.keys.push_back(keyFrom(key, track.name, object_O));
  return track;
}

Pose poseFromNumbers(const json& value, const char* label) {
  const Eigen::Matrix<double, 7, 1> numbers = numbersFrom<7>(value, label);
  return poseFromQuaternion(numbers.head<3>(), numbers.tail<4>(), label);
}

DemonstratorKey demonstratorFrom(const json& value) {
  const Fields fields(value, "a key", {"frame", "hand_pose", "posture"});
  DemonstratorKey key;
  key.frame = fields.whole("frame");
  key.X_OD = poseFromNumbers(fields.at("hand_pose"), "hand_pose");
  if (fields.has("posture")) key.posture = postureFrom(fields.at("posture"));
  return key;
}

Motion motionFrom(const json& root, const geometry::TriangleMesh& mesh_O) {
  const Fields fields(root, "the file",
                      {"format", "name", "object", "side", "hand", "time_s", "object_pose",
                       "tracks", "demonstrator", "notes"});
  if (const std::string format = fields.text("format"); format != kMotionFormat)
    rejectInput("field 'format' is {}; it must be '{}'", quoted(format), kMotionFormat);
  const SurfaceLocator object_O(mesh_O);
  Motion motion;
  motion.name = fields.text("name");
  motion.object = fields.text("object");
  if (fields.has("side")) motion.side = hand::sideNamed(fields.text("side"), "side");
  motion.hand = fields.text("hand");
  for (const json& time : fields.list("time_s")) {
    if (!time.is_number())
      rejectInput("frame {}: field 'time_s' has {}; it must have numbers", motion.time_s.size(),
                  formats::shown(time));
    motion.time_s.push_back(time.get<double>());
  }
  for (const json& pose : fields.list("object_pose")) {
    const std::string label = fmt::format("frame {}: object_pose", motion.X_WO.size());
    motion.X_WO.push_back(poseFromNumbers(pose, label.c_str()));
  }
  for (const json& track : fields.list("tracks")) {
    try {
      motion.tracks.push_back(trackFrom(track, object_O));
    } catch (const InvalidInput& error) {
      rejectInput("track {}: {}", motion.tracks.size(), error.what());
    }
  }
  if (fields.has("demonstrator")) {
    for (const json& key : fields.list("demonstrator")) {
      try {
        motion.demonstrator.push_back(demonstratorFrom(key));
      } catch (const InvalidInput& error) {
        rejectInput("demonstrator, key {}: {}", motion.demonstrator.size(), error.what());
      }
    }
  }
  if (fields.has("notes"))
    for (const json& note : fields.list("notes"))
      if (note.is_string()) motion.notes.push_back(note.get<std::string>());
  validate(mesh_O, motion);
  nameByParts(motion);
  return motion;
}

json vectorJson(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

json numbersOf(const Pose& X) {
  const Eigen::Vector3d p = X.translation();
  const Eigen::Vector4d q = quaternionOf(X);
  return {p.x(), p.y(), p.z(), q[0], q[1], q[2], q[3]};
}

json keyJson(const PatchKey& key, const geometry::TriangleMesh& mesh_O) {
  json value = {{"frame", key.frame}, {"root", vectorJson(positionOf(mesh_O, key.patch.root))}};
  if (key.patch.direction_O) value["direction"] = vectorJson(*key.patch.direction_O);
  json points = json::array();
  for (const SurfacePoint& point : key.patch.interpolation_boundary)
    points.push_back(vectorJson(positionOf(mesh_O, point)));
  value["points"] = std::move(points);
  if (!key.hand_points.empty()) {
    json hand = json::array();
    for (const HandPoint& point : key.hand_points)
      hand.push_back({{"link", point.link}, {"point", vectorJson(point.p_L)}});
    value["hand"] = std::move(hand);
  }
  if (key.patch.place) value["place"] = placeOfMotionJson(*key.patch.place);
  if (key.patch.weight != 1.0) value["weight"] = key.patch.weight;
  return value;
}

}  // namespace

Motion motionFromText(const std::string& text, const geometry::TriangleMesh& object_O) {
  try {
    return motionFrom(json::parse(text), object_O);
  } catch (const json::exception& error) {
    rejectInput("{}", error.what());
  }
}

Motion readMotion(const std::filesystem::path& path, const geometry::TriangleMesh& object_O) {
  if (requireFile(path) > kMostMotionBytes)
    rejectInput("{}: is larger than {} bytes", quoted(path.string()), kMostMotionBytes);
  try {
    return motionFromText(readFileBytes(path), object_O);
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  }
}

std::string motionText(const Motion& motion, const geometry::TriangleMesh& object_O) {
  validate(object_O, motion);
  json root = {{"format", kMotionFormat}, {"name", motion.name}, {"object", motion.object}};
  if (motion.side != hand::Chirality::kUnknown) root["side"] = nameOf(motion.side);
  if (!motion.hand.empty()) root["hand"] = motion.hand;
  if (!motion.notes.empty()) root["notes"] = motion.notes;
  root["time_s"] = motion.time_s;
  json poses = json::array();
  for (const Pose& X : motion.X_WO)
    poses.push_back(numbersOf(X));
  root["object_pose"] = std::move(poses);
  json tracks = json::array();
  for (const PatchTrack& track : motion.tracks) {
    json keys = json::array();
    for (const PatchKey& key : track.keys)
      keys.push_back(keyJson(key, object_O));
    tracks.push_back({{"name", track.name}, {"end", track.end}, {"keys", std::move(keys)}});
  }
  root["tracks"] = std::move(tracks);
  for (const DemonstratorKey& key : motion.demonstrator) {
    json entry = {{"frame", key.frame}, {"hand_pose", numbersOf(key.X_OD)}};
    if (!key.posture.empty()) entry["posture"] = postureJson(key.posture);
    root["demonstrator"].push_back(std::move(entry));
  }
  return root.dump() + "\n";
}

}  // namespace handgraft::io
