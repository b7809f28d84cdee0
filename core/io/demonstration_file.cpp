#include "core/io/demonstration_file.h"

#include <string>
#include <utility>
#include <vector>

#include <fmt/ranges.h>

#include "core/base/error.h"
#include "core/formats/demonstration_arrays.h"
#include "core/formats/demonstration_text.h"
#include "core/hand/mano_joints.h"
#include "core/io/file_bytes.h"
#include "core/manipulation/contact_tracker.h"

namespace handgraft::io {
namespace {

using hand::HandSide;
using manipulation::DemonstratedFrame;

DemonstratedFrame frameOf(const formats::Demonstration& demonstration,
                          const formats::DemonstrationFrame& read) {
  DemonstratedFrame frame;
  frame.time_s = read.time_s;
  frame.side = demonstration.is_left ? HandSide::kLeft : HandSide::kRight;
  const auto& [x, y, z, qw, qx, qy, qz] = read.object_pose;
  frame.X_WO = poseFromQuaternion({x, y, z}, {qw, qx, qy, qz}, "object_pose");
  if (demonstration.is_mano) {
    using ManoPose = Eigen::Matrix<double, hand::kManoPoseSize, 1>;
    frame.joints_W = hand::manoJointPlaces(
        ManoPose::Map(read.values.data()),
        Eigen::Vector3d::Map(read.values.data() + hand::kManoPoseSize), frame.side);
  } else {
    frame.joints_W = hand::JointPlaces::Map(read.values.data());
  }
  return frame;
}

std::vector<DemonstratedFrame> framesOf(const formats::Demonstration& demonstration) {
  std::vector<DemonstratedFrame> frames;
  for (const formats::DemonstrationFrame& read : demonstration.frames) {
    try {
      frames.push_back(frameOf(demonstration, read));
    } catch (const InvalidInput& error) {
      rejectInput("at {:.3f} s: {}", read.time_s, error.what());
    }
  }
  return frames;
}

/// Parts that touch, of all frames together in which no joint lies too deep inside the object.
std::size_t touchesOf(const std::vector<DemonstratedFrame>& frames,
                      const geometry::TriangleMesh& object_O) {
  const std::vector<double> depths = manipulation::depthsOfJoints(frames, object_O);
  manipulation::ContactTracker tracker(object_O);
  std::size_t count = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const std::size_t touches = tracker.see(frames[k]).size();
    if (depths[k] <= manipulation::kImpossibleDepth) count += touches;
  }
  return count;
}

/// That the hand touches far more where its translation is read as the wrist's place, which it
/// is to some recorders; empty: it does not.
std::string noteOfWristsPlace(std::vector<DemonstratedFrame> frames,
                              const geometry::TriangleMesh& object_O) {
  constexpr std::size_t kFarMore = 2;
  const std::size_t as_read = touchesOf(frames, object_O);
  const Eigen::Vector3d rest = hand::manoRestWrist(frames.front().side);
  for (DemonstratedFrame& frame : frames)
    frame.joints_W.colwise() -= rest;
  const std::size_t as_place = touchesOf(frames, object_O);
  if (as_place <= kFarMore * as_read) return "";
  return fmt::format(
      "is the translation the wrist's place? It is read as MANO's own, to which the rest wrist "
      "({:.4f}, {:.4f}, {:.4f}) m is added; without that {} touches of all frames, but for "
      "those inside the object, would be {}",
      rest.x(), rest.y(), rest.z(), as_read, as_place);
}

/// An error tells the notes as well: they may be its reason.
manipulation::Motion motionTelling(const std::vector<std::string>& notes,
                                   const std::vector<DemonstratedFrame>& frames,
                                   const geometry::TriangleMesh& object_O) {
  try {
    return manipulation::motionOfDemonstration(frames, object_O);
  } catch (const InvalidInput& error) {
    std::vector<std::string> all = {error.what()};
    all.insert(all.end(), notes.begin(), notes.end());
    rejectInput("{}", fmt::join(all, "; "));
  }
}

}  // namespace

std::string objectOfNpz(const std::filesystem::path& path) {
  try {
    return formats::objectOfNpz(readFileBytes(path));
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  }
}

manipulation::Motion readDemonstratedMotion(const std::filesystem::path& path,
                                            const geometry::TriangleMesh& object_O) {
  try {
    const formats::Demonstration read = formats::parseDemonstration(readFileBytes(path));
    const std::vector<DemonstratedFrame> frames = framesOf(read);
    std::vector<std::string> notes = read.notes;
    if (read.is_mano)
      if (std::string note = noteOfWristsPlace(frames, object_O); !note.empty())
        notes.push_back(std::move(note));
    manipulation::Motion motion = motionTelling(notes, frames, object_O);
    motion.notes.insert(motion.notes.begin(), notes.begin(), notes.end());
    motion.name = path.stem().string();
    return motion;
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  }
}

}  // namespace handgraft::io
