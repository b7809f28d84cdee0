#include "core/io/motion_import.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/utf8.h"
#include "core/formats/json_keys.h"
#include "core/geometry/surface_locator.h"
#include "core/io/file_bytes.h"

namespace handgraft::io {
namespace {

using formats::finiteFrom;
using formats::memberOf;
using manipulation::Motion;
using manipulation::PatchKey;
using manipulation::PatchTrack;
using nlohmann::json;

constexpr double kSequenceReach = 0.01;  // m
constexpr double kSameSpan = 0.05;       // of a recording's time; its last frame has a length
constexpr double kHighestRate = 1e5;     // frames a second

Eigen::Vector3d placeIn(const json& object, const char* name) {
  const json& value = memberOf(object, name);
  if (!value.is_array() || value.size() != 3)
    rejectInput("field '{}' must be an array of 3 numbers", name);
  return {finiteFrom(value[0], name), finiteFrom(value[1], name), finiteFrom(value[2], name)};
}

template <class Read>
auto namingFile(const std::filesystem::path& path, const Read& read) {
  try {
    return read(json::parse(readFileBytes(path)));
  } catch (const json::exception& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  }
}

/// Factor to metres or radians.
double unitOf(const json& spline) {
  const std::string unit = memberOf(spline, "units").get<std::string>();
  if (unit == "centimeters") return 0.01;
  if (unit == "meters" || unit == "radians") return 1.0;
  if (unit == "degrees") return std::numbers::pi / 180.0;
  rejectInput("field 'units' is {}; permitted are centimeters, meters, degrees, radians",
              handgraft::quoted(unit));
}

SplineTrajectory splinesFrom(const json& root) {
  constexpr std::size_t kFewestControls = 4;
  SplineTrajectory trajectory;
  trajectory.duration_s = finiteFrom(memberOf(root, "time"), "time");
  const json& data = memberOf(root, "data");
  if (!data.is_array() || data.empty()) rejectInput("field 'data' is no list of splines");
  const std::size_t rows = memberOf(data[0], "controlPointData").size() / 2;
  if (rows < kFewestControls)
    rejectInput("field 'controlPointData' has {} points; 4 at least are needed", rows);
  trajectory.controls.resize(static_cast<Eigen::Index>(rows),
                             static_cast<Eigen::Index>(data.size()));
  for (std::size_t d = 0; d < data.size(); ++d) {
    const json& controls = memberOf(data[d], "controlPointData");
    if (!controls.is_array() || controls.size() != 2 * rows) {
      rejectInput("spline {}: field 'controlPointData' has {} numbers; it must have {}", d,
                  controls.size(), 2 * rows);
    }
    const double unit = unitOf(data[d]);
    for (std::size_t i = 0; i < rows; ++i) {
      trajectory.controls(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(d)) =
          unit * finiteFrom(controls[2 * i + 1], "controlPointData");
    }
  }
  return trajectory;
}

/// Where a point of a link of the right MANO hand is, as on any hand. Its links' frames are
/// turned alike at rest: fingers to -x, palm to -y, the thumb's side to +z. Bones and lengths
/// are those of the recordings' own MJCF. Where the thumb's pad is, its frames do not tell.
std::optional<hand::HandLocation> placeOnMano(const std::string& link,
                                              const Eigen::Vector3d& p_L) {
  struct Digit {
    std::string mano;
    const char* name;
    Eigen::Vector3d bone;  ///< of its middle segment
    std::array<double, 3> length_m;
  };

  static const std::array<Digit, 5> mano_digits{
      {{"thumb", "thumb", {-0.0222, -0.0054, 0.0145}, {0.031, 0.027, 0.030}},
       {"index", "index", {-0.0222, -0.0013, -0.0001}, {0.033, 0.022, 0.024}},
       {"middle", "middle", {-0.0229, -0.0013, -0.0039}, {0.032, 0.023, 0.025}},
       {"ring", "ring", {-0.0235, -0.0017, -0.0076}, {0.029, 0.025, 0.025}},
       {"pinky", "little", {-0.0159, -0.0007, -0.0103}, {0.021, 0.019, 0.020}}}};
  static constexpr std::array<const char*, 3> kSegments{"proximal", "middle", "distal"};
  constexpr double kKnuckles = 0.088;  // m; from the wrist
  constexpr double kFirst = 0.026;     // m; z of the first knuckle; the last one's is -0.043
  constexpr double kAcross = 0.069;    // m

  hand::HandLocation place;
  if (link == "wrist") {
    place.digit = hand::kPalmPart;
    place.along = std::clamp(1.0 + p_L.x() / kKnuckles, 0.0, 1.0);
    place.across = std::clamp((kFirst - p_L.z()) / kAcross, 0.0, 1.0);
    return place;
  }
  for (const Digit& digit : mano_digits) {
    if (link.size() != digit.mano.size() + 1 || !link.starts_with(digit.mano)) continue;
    const int segment = link.back() - '1';
    if (segment < 0 || segment > 2) return std::nullopt;
    const auto at = static_cast<std::size_t>(segment);
    place.digit = digit.name;
    place.segment = kSegments[at];
    place.segment_count = 3;
    const Eigen::Vector3d bone = digit.bone.normalized();
    place.along = std::clamp(p_L.dot(bone) / digit.length_m[at], 0.0, 1.0);
    const Eigen::Vector3d thumbward = Eigen::Vector3d::UnitY().cross(bone).normalized();
    if (digit.mano != "thumb")
      place.around_rad = std::atan2(p_L.dot(thumbward), p_L.dot(-Eigen::Vector3d::UnitY()));
    return place;
  }
  return std::nullopt;
}

/// A point of a frame, of one link.
struct LinkPoint {
  Eigen::Vector3d p_O = Eigen::Vector3d::Zero();
  PatchKey key;
};

/// The tracks of one link's points. A point goes on in the open track whose last point is
/// nearest on object and hand together, nearest pairs first; it begins one where none is near.
class LinkTracks {
 public:
  void add(int frame, std::vector<LinkPoint> points, std::vector<PatchTrack>& done) {
    struct Match {
      double distance;
      std::size_t point;
      std::size_t track;
    };

    std::vector<Match> matches;
    for (std::size_t t = 0; t < open_.size(); ++t) {
      if (open_[t].track.end != frame) continue;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double distance =
            (points[i].p_O - open_[t].p_O).norm() +
            (points[i].key.hand_points[0].p_L - open_[t].track.keys.back().hand_points[0].p_L)
                .norm();
        if (distance <= kSamePoint) matches.push_back({distance, i, t});
      }
    }
    std::stable_sort(matches.begin(), matches.end(), [](const Match& a, const Match& b) {
      return a.distance < b.distance;
    });
    std::vector<char> placed(points.size(), 0);
    for (const Match& match : matches) {
      if (placed[match.point] != 0 || open_[match.track].track.end != frame) continue;
      placed[match.point] = 1;
      append(open_[match.track], frame, std::move(points[match.point]));
    }
    close(frame + 1, done);
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (placed[i] != 0) continue;
      open_.emplace_back();
      open_.back().track.name = points[i].key.patch.name;
      append(open_.back(), frame, std::move(points[i]));
    }
  }

  /// Those that did not reach `end`.
  void close(int end, std::vector<PatchTrack>& done) {
    for (Open& open : open_)
      if (open.track.end != end) done.push_back(std::move(open.track));
    std::erase_if(open_, [end](const Open& open) {
      return open.track.end != end;
    });
  }

 private:
  static constexpr double kSamePoint = 0.03;  // m

  struct Open {
    PatchTrack track;
    Eigen::Vector3d p_O = Eigen::Vector3d::Zero();
  };

  static void append(Open& open, int frame, LinkPoint point) {
    open.p_O = point.p_O;
    open.track.keys.push_back(std::move(point.key));
    open.track.end = frame + 1;
  }

  std::vector<Open> open_;
};

int frameNumberOf(const json& frame) {
  const json& number = memberOf(frame, "frame");
  if (!number.is_number_unsigned() ||
      number.get<std::uint64_t>() >= static_cast<std::uint64_t>(manipulation::kMostFrames))
    rejectInput("field 'frame' is {}; permitted are 0 to {}", formats::shown(number),
                manipulation::kMostFrames - 1);
  return number.get<int>();
}

/// What a sequence says of itself: its frames' times, with the object where it stands.
Motion motionWithoutContacts(const json& root, const json& frames) {
  const double rate = finiteFrom(memberOf(root, "fps"), "fps");
  if (!(rate > 0.0) || rate > kHighestRate)
    rejectInput("field 'fps' is {}; permitted are above 0 to {}", rate, kHighestRate);
  int count = frameNumberOf(frames.back()) + 1;
  if (root.contains("n_frames") && root["n_frames"].is_number_unsigned())
    count = std::max(count, std::min(root["n_frames"].get<int>(), manipulation::kMostFrames));
  Motion motion;
  motion.hand = root.value("hand", std::string());
  motion.object =
      std::filesystem::path(root.value("object_mesh", std::string())).stem().string();
  for (int k = 0; k < count; ++k)
    motion.time_s.push_back(k / rate);
  motion.X_WO.assign(motion.time_s.size(), Pose::Identity());
  return motion;
}

/// Moves the object along a trajectory, from its begin to its end.
void moveAlong(const std::filesystem::path& object_path, Motion& motion) {
  const SplineTrajectory path = readSplineTrajectory(object_path);
  if (path.controls.cols() != 6)
    rejectInput("{}: has {} splines; an object has 6", quoted(object_path.string()),
                path.controls.cols());
  const std::size_t last = motion.X_WO.size() - 1;
  const double span_s = motion.time_s.back() - motion.time_s.front();
  if (std::abs(path.duration_s - span_s) > kSameSpan * span_s)
    motion.notes.push_back(
        fmt::format("the object's path {} lasts {:.3f} s and the recording {:.3f} s: the path "
                    "is followed in "
                    "the recording's time; is it of another recording?",
                    quoted(object_path.filename().string()), path.duration_s, span_s));
  for (std::size_t k = 0; k <= last; ++k)
    motion.X_WO[k] = poseFromSpline(
        path.at(last > 0 ? static_cast<double>(k) / static_cast<double>(last) : 0.0));
}

/// A contact of a frame; none where it is too far off the object to lie on it.
std::optional<LinkPoint> linkPointFrom(const json& contact,
                                       int frame,
                                       bool is_mano,
                                       const geometry::SurfaceLocator& object_O) {
  manipulation::HandPoint point;
  Eigen::Vector3d p_O;
  try {
    p_O = placeIn(contact, "object_point");
    point.p_L = placeIn(contact, "hand_point");
    point.link = memberOf(contact, "link").get<std::string>();
  } catch (const InvalidInput& error) {
    rejectInput("frame {}: {}", frame, error.what());
  }
  const auto hit = object_O.nearest(p_O);
  if (hit.distance > kSequenceReach) return std::nullopt;
  PatchKey key;
  key.frame = frame;
  key.patch.name = point.link;
  key.patch.root = hit.point;
  key.patch.interpolation_boundary = {hit.point};
  key.patch.place = is_mano ? placeOnMano(point.link, point.p_L) : hand::placeNamed(point.link);
  key.hand_points = {std::move(point)};
  return LinkPoint{p_O, std::move(key)};
}

Motion sequenceFrom(const json& root,
                    const geometry::TriangleMesh& mesh_O,
                    const std::filesystem::path& object_path) {
  const json& frames = memberOf(root, "frames");
  if (!frames.is_array() || frames.empty()) rejectInput("field 'frames' is no list of frames");
  Motion motion = motionWithoutContacts(root, frames);
  if (!object_path.empty()) {
    moveAlong(object_path, motion);
  } else {
    motion.notes.emplace_back(
        "no path of the object was given (--object-path): it stands still throughout");
  }

  const geometry::SurfaceLocator object_O(mesh_O);
  std::map<std::string, LinkTracks> links;
  int far = 0;
  int before = -1;
  for (const json& value : frames) {
    const int frame = frameNumberOf(value);
    if (frame <= before) rejectInput("frame {} does not lie behind frame {}", frame, before);
    before = frame;
    std::map<std::string, std::vector<LinkPoint>> seen;
    const json& contacts = memberOf(value, "contacts");
    if (!contacts.is_array()) rejectInput("frame {}: field 'contacts' is no list", frame);
    for (const json& contact : contacts) {
      auto point = linkPointFrom(contact, frame, motion.hand == "MANO", object_O);
      if (!point) {
        ++far;
        continue;
      }
      std::vector<LinkPoint>& of_link = seen[point->key.patch.name];
      of_link.push_back(*std::move(point));
    }
    for (auto& [link, points] : seen)
      links[link].add(frame, std::move(points), motion.tracks);
  }
  for (auto& [name, tracks] : links)
    tracks.close(-1, motion.tracks);
  std::stable_sort(motion.tracks.begin(), motion.tracks.end(),
                   [](const PatchTrack& a, const PatchTrack& b) {
                     return a.begin() < b.begin();
                   });
  nameByParts(motion);
  if (far > 0)
    motion.notes.push_back(fmt::format(
        "left out {} points farther than {:.0f} mm off the object", far, 1e3 * kSequenceReach));
  validate(mesh_O, motion);
  return motion;
}

}  // namespace

Eigen::VectorXd SplineTrajectory::at(double share) const {
  // De Boor's algorithm over knots 0 0 0 0 1 2 ... n-3 n-3 n-3 n-3.
  const int spans = static_cast<int>(controls.rows()) - 3;
  const double u = std::clamp(share, 0.0, 1.0) * spans;
  const int span = std::min(static_cast<int>(u), spans - 1);
  const auto knot = [spans](int i) {
    return static_cast<double>(std::clamp(i - 3, 0, spans));
  };
  Eigen::Matrix<double, Eigen::Dynamic, 4> points(controls.cols(), 4);
  for (int i = 0; i < 4; ++i)
    points.col(i) = controls.row(span + i).transpose();
  for (int level = 1; level <= 3; ++level) {
    for (int i = 3; i >= level; --i) {
      const double left = knot(span + i);
      const double right = knot(span + i + 4 - level);
      const double share_of_right = (u - left) / (right - left);
      points.col(i) =
          (1.0 - share_of_right) * points.col(i - 1) + share_of_right * points.col(i);
    }
  }
  return points.col(3);
}

SplineTrajectory readSplineTrajectory(const std::filesystem::path& path) {
  return namingFile(path, splinesFrom);
}

Pose poseFromSpline(const Eigen::VectorXd& coordinates) {
  HANDGRAFT_REQUIRE(coordinates.size() >= 6);
  Pose X = Pose::Identity();
  X.translation() = coordinates.head<3>();
  X.linear() = rotationFromVector(coordinates[5] * Eigen::Vector3d::UnitZ()) *
               rotationFromVector(coordinates[4] * Eigen::Vector3d::UnitY()) *
               rotationFromVector(coordinates[3] * Eigen::Vector3d::UnitX());
  return X;
}

Motion readContactSequence(const std::filesystem::path& path,
                           const geometry::TriangleMesh& object_O,
                           const std::filesystem::path& object_path) {
  Motion motion = namingFile(path, [&](const json& root) {
    return sequenceFrom(root, object_O, object_path);
  });
  motion.name = path.stem().string();
  return motion;
}

std::vector<TimedPose> readKeyframes(const std::filesystem::path& path) {
  constexpr const char* kHeading = "time_s,x,y,z,qw,qx,qy,qz";
  std::istringstream lines{std::string(withoutByteOrderMark(readFileBytes(path)))};
  std::string line;
  std::vector<TimedPose> poses;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (number == 1) {
      if (line != kHeading)
        rejectInput("{}: line 1 is {}; it must be '{}'", quoted(path.string()),
                    handgraft::quoted(line), kHeading);
      continue;
    }
    if (line.empty()) continue;
    std::istringstream words(line);
    std::string word;
    std::vector<double> numbers;
    while (std::getline(words, word, ',')) {
      char* end = nullptr;
      const double value = std::strtod(word.c_str(), &end);
      if (end == word.c_str() || !std::isfinite(value))
        rejectInput("{}: line {}: {} is no finite number", quoted(path.string()), number,
                    handgraft::quoted(word));
      numbers.push_back(value);
    }
    if (numbers.size() != 8)
      rejectInput("{}: line {} has {} numbers; it must have 8", quoted(path.string()), number,
                  numbers.size());
    if (!poses.empty() && !(numbers[0] > poses.back().time_s))
      rejectInput("{}: line {}: time {} s does not lie behind the one before it, {} s",
                  quoted(path.string()), number, numbers[0], poses.back().time_s);
    const std::string label = fmt::format("{}: line {}", quoted(path.string()), number);
    poses.push_back(
        {numbers[0],
         poseFromQuaternion({numbers[1], numbers[2], numbers[3]},
                            {numbers[4], numbers[5], numbers[6], numbers[7]}, label.c_str())});
  }
  if (poses.empty()) rejectInput("{}: has no keyframes", quoted(path.string()));
  return poses;
}

}  // namespace handgraft::io
