#include "tests/bench/motions/live_grasps.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "core/base/error.h"

#include "tests/bench/hand_import.h"
#include "tests/bench/motions/live_motions.h"
#include "tests/bench/motions/live_pictures.h"
#include "tests/bench/retargeting/demonstration.h"
#include "tests/bench/retargeting/retargeted_grasp.h"

namespace handgraft::bench {

namespace {

namespace fs = std::filesystem;

constexpr int kPerObject = 2;
constexpr double kFrames = 60.0;  // a second
constexpr double kClosing = 0.4;  // s
constexpr double kHolding = 0.8;  // s
constexpr double kLift = 0.1;     // m

/// From 0 to 1 at rest in both.
double eased(double share) {
  return 0.5 - 0.5 * std::cos(std::numbers::pi * std::clamp(share, 0.0, 1.0));
}

std::vector<demonstration::PosedFrame> closingOn(const Demonstration& grasp) {
  std::vector<demonstration::PosedFrame> frames;
  for (int k = 0; k <= kFrames * (kClosing + kHolding); ++k) {
    demonstration::PosedFrame& frame = frames.emplace_back();
    frame.time_s = k / kFrames;
    frame.X_WO.translation().z() = kLift * eased((frame.time_s - kClosing) / kHolding);
    frame.pose.X_WH = frame.X_WO * grasp.pose.X_WH;
    frame.pose.q = eased(frame.time_s / kClosing) * grasp.pose.q;
  }
  return frames;
}

}  // namespace

void runLiveGrasps(const fs::path& data,
                   const fs::path& cache,
                   const std::vector<hand::Hand>& hands,
                   const fs::path& pictures) {
  const DemonstrationFile file(data / "contacts/dexycb/dexycb_grasps.json",
                               {data / "objects/ycb", data / "objects/ycb_dexycb"});
  const std::vector<fs::path> urdfs = urdfsIn({(data / "hands").string()});
  const auto of_file = std::find_if(urdfs.begin(), urdfs.end(), [&](const fs::path& urdf) {
    return urdf.filename().string() == file.handFile();
  });
  if (of_file == urdfs.end()) rejectInput("{}: is not among the hands", file.handFile());
  const MeasuredHand demonstrator = readMeasuredHand(*of_file, cache);
  std::vector<Demonstration> grasps;
  for (const DemonstrationFile::Entry& entry : file.draw(kPerObject, 0)) {
    try {
      grasps.push_back(file.read(entry, demonstrator.hand, demonstrator.carrier.get()));
    } catch (const InvalidInput& error) {
      std::printf("%s: left out: %s\n", entry.name().c_str(), error.what());
    }
  }
  for (const hand::Hand& hand : hands) {
    LiveFigures figures;
    for (const Demonstration& grasp : grasps) {
      const std::vector<demonstration::PosedFrame> frames = closingOn(grasp);
      const std::vector<LiveFrame> shown = followLive(
          grasp.contacts, frames, grasp.object->mesh_O, demonstrator.hand, hand, figures);
      if (!pictures.empty())
        drawLiveGrasp(pictures, grasp, *demonstrator.hand.model, *hand.model, frames, shown);
    }
    printLiveRow("recorded grasps", hand, figures);
  }
}

}  // namespace handgraft::bench
