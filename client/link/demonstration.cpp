#include "client/link/demonstration.h"

#include "client/link/model_files.h"
#include "client/link/wire_pose.h"
#include "core/base/error.h"
#include "core/formats/demonstration_text.h"

namespace handgraft::client {

namespace {

std::vector<v1::DemonstratorFrame> framesOf(const formats::Demonstration& demonstration) {
  std::vector<v1::DemonstratorFrame> frames;
  for (const formats::DemonstrationFrame& read : demonstration.frames) {
    v1::DemonstratorFrame frame;
    frame.time_s(read.time_s);
    frame.chirality(demonstration.is_left ? v1::CHIRALITY_LEFT : v1::CHIRALITY_RIGHT);
    frame.kind(demonstration.is_mano ? v1::DEMONSTRATOR_MANO : v1::DEMONSTRATOR_JOINT_PLACES);
    frame.values(read.values);
    frame.X_WO(placeOf(read.object_pose, "field 'object_pose'"));
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace

std::vector<v1::DemonstratorFrame> readDemonstration(const std::filesystem::path& path) {
  const std::string text = readFile(path);
  try {
    return framesOf(formats::parseDemonstration(text));
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  }
}

}  // namespace handgraft::client
