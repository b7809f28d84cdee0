#include "core/io/demonstration_file.h"

#include <string>

#include "core/base/error.h"
#include "core/formats/demonstration_arrays.h"
#include "core/formats/demonstration_text.h"
#include "core/io/file_bytes.h"

namespace handgraft::io {
namespace {

using hand::HandSide;
using manipulation::DemonstratedFrame;

std::vector<DemonstratedFrame> framesOf(const formats::Demonstration& demonstration) {
  const HandSide side = demonstration.is_left ? HandSide::kLeft : HandSide::kRight;
  std::vector<DemonstratedFrame> frames;
  for (const formats::DemonstrationFrame& read : demonstration.frames) {
    DemonstratedFrame frame;
    frame.time_s = read.time_s;
    frame.side = side;
    const auto& [x, y, z, qw, qx, qy, qz] = read.object_pose;
    frame.X_WO = poseFromQuaternion({x, y, z}, {qw, qx, qy, qz}, "object_pose");
    if (demonstration.is_mano) {
      using ManoPose = Eigen::Matrix<double, hand::kManoPoseSize, 1>;
      frame.joints_W = hand::manoJointPlaces(
          ManoPose::Map(read.values.data()),
          Eigen::Vector3d::Map(read.values.data() + hand::kManoPoseSize), side);
    } else {
      frame.joints_W = hand::JointPlaces::Map(read.values.data());
    }
    frames.push_back(frame);
  }
  return frames;
}

}  // namespace

std::string objectOfNpz(const std::filesystem::path& path) {
  try {
    return formats::objectOfNpz(readFileBytes(path));
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  }
}

std::vector<DemonstratedFrame> readDemonstration(const std::filesystem::path& path) {
  try {
    return framesOf(formats::parseDemonstration(readFileBytes(path)));
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
