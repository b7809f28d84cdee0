#include "core/retargeting/motion_grasps.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "core/base/error.h"
#include "core/retargeting/motion_solving.h"
#include "core/session/derived_state.h"
#include "core/session/patch_matching.h"

namespace handgraft::retargeting {

namespace {

using manipulation::Motion;
using manipulation::PatchKey;
using manipulation::PatchTrack;

constexpr int kParts = 3;

bool isThere(const PatchTrack& track, int frame) {
  return frame >= track.begin() && frame < track.end;
}

/// Of each part of the time in which something touches the frame in which most does; the middle
/// one of the longest stretch of equals, since what has just come may still be on its way.
std::vector<int> fullestFrames(const Motion& motion) {
  std::vector<int> counts(static_cast<std::size_t>(motion.frameCount()), 0);
  int begin = motion.frameCount();
  int end = 0;
  for (const PatchTrack& track : motion.tracks) {
    begin = std::min(begin, track.begin());
    end = std::max(end, track.end);
    for (int k = track.begin(); k < track.end; ++k)
      ++counts[static_cast<std::size_t>(k)];
  }
  std::vector<int> frames;
  for (int part = 0; part < kParts; ++part) {
    const int from = begin + part * (end - begin) / kParts;
    const int to = begin + (part + 1) * (end - begin) / kParts;
    if (from >= to) continue;
    const auto first = counts.begin() + from;
    const int most = *std::max_element(first, counts.begin() + to);
    if (most == 0) continue;
    int longest = 0;
    int best = from;
    for (int k = from; k < to;) {
      int after = k;
      while (after < to && counts[static_cast<std::size_t>(after)] == most)
        ++after;
      if (after - k > longest) {
        longest = after - k;
        best = (k + after) / 2;
      }
      k = std::max(after, k + 1);
    }
    frames.push_back(best);
  }
  return frames;
}

/// The grasp as its patches are in a frame.
session::FrameContacts contactsAt(const Motion& motion,
                                  const std::vector<std::string>& names,
                                  const contact::ContactSet& grasp,
                                  const geometry::TriangleMesh& object_O,
                                  int frame) {
  const geometry::SurfaceLocator locator(object_O);
  auto contacts = std::make_shared<contact::ContactSet>(grasp);
  session::FrameContacts in_frame;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto track =
        std::find_if(motion.tracks.begin(), motion.tracks.end(), [&](const PatchTrack& one) {
          return one.name == names[i] && isThere(one, frame);
        });
    in_frame.is_there.push_back(track != motion.tracks.end());
    if (!in_frame.is_there.back()) continue;
    contact::Patch& patch = contacts->patches[i];
    std::string name = std::move(patch.name);
    patch = patchOfGrasp(track->keyAt(frame), object_O, locator);
    patch.name = std::move(name);
  }
  if (!motion.demonstrator.empty()) contacts->posture = demonstratorNear(motion, frame).posture;
  in_frame.contacts = std::move(contacts);
  return in_frame;
}

}  // namespace

std::vector<session::FrameContacts> frameContactsOf(const Motion& motion,
                                                    const contact::ContactSet& grasp,
                                                    const geometry::TriangleMesh& object_O) {
  std::vector<session::FrameContacts> frames;
  const std::vector<std::string> names = patchNames(motion);
  for (const int frame : fullestFrames(motion))
    frames.push_back(contactsAt(motion, names, grasp, object_O, frame));
  return frames;
}

session::SessionModels modelsOfMotion(
    hand::Hand hand,
    const std::shared_ptr<const geometry::TriangleMesh>& object_O,
    const Motion& motion) {
  session::SessionModels models =
      session::modelsOf(std::move(hand), object_O, graspOf(motion, *object_O));
  models.frames = frameContactsOf(motion, *models.contacts, *object_O);
  return models;
}

std::vector<FrameGrasp> graspFrames(
    const session::Document& document,
    const hand::Hand& hand,
    const std::shared_ptr<const geometry::TriangleMesh>& object_O,
    const contact::ContactSet& grasp,
    const Motion& motion,
    int threads,
    const Progress& progress) {
  const std::vector<std::string> names = patchNames(motion);
  std::vector<FrameGrasp> grasps;
  for (const int frame : fullestFrames(motion)) {
    progress.report("finding grasps", static_cast<double>(frame) / motion.frameCount());
    const session::FrameContacts in_frame = contactsAt(motion, names, grasp, *object_O, frame);
    session::Document there = session::atFrame(document, in_frame);
    there.timed.clear();
    there.start_is_known = there.is_solved = false;
    if (std::none_of(there.patches.begin(), there.patches.end(), [](const auto& patch) {
          return patch.enabled && patch.placement;
        }))
      continue;
    session::DerivedState state(std::make_shared<session::ModelCache>(
        session::modelsFor(document, hand, object_O, in_frame.contacts)));
    try {
      state.follow(there, progress);
      session::SolveRun run;
      run.threads = threads;
      const session::Solution solution = state.solve(there.solving, run, progress);
      FrameGrasp found;
      found.frame = frame;
      found.pose_O = solution.report.pose;
      found.pose_O.X_WH = inverse(document.X_WO) * found.pose_O.X_WH;
      found.placements.resize(motion.tracks.size());
      for (std::size_t t = 0; t < motion.tracks.size(); ++t) {
        if (!isThere(motion.tracks[t], frame)) continue;
        const auto i = static_cast<std::size_t>(
            std::find(names.begin(), names.end(), motion.tracks[t].name) - names.begin());
        if (there.patches[i].root_is_open) found.placements[t] = solution.patches[i].placement;
      }
      grasps.push_back(std::move(found));
    } catch (const InvalidInput&) {
      // No point of this frame finds a place on the hand: others may.
    }
  }
  return grasps;
}

std::vector<manipulation::FramePose> posesOf(const std::vector<FrameGrasp>& grasps) {
  std::vector<manipulation::FramePose> poses_O;
  poses_O.reserve(grasps.size());
  for (const FrameGrasp& grasp : grasps)
    poses_O.push_back({grasp.frame, grasp.pose_O});
  return poses_O;
}

void placeAsGrasped(const std::vector<FrameGrasp>& grasps, Motion& motion) {
  for (std::size_t t = 0; t < motion.tracks.size(); ++t) {
    for (PatchKey& key : motion.tracks[t].keys) {
      const FrameGrasp* nearest = nullptr;
      for (const FrameGrasp& grasp : grasps) {
        if (!grasp.placements[t]) continue;
        if (nearest == nullptr ||
            std::abs(grasp.frame - key.frame) < std::abs(nearest->frame - key.frame))
          nearest = &grasp;
      }
      if (nearest != nullptr) key.placement = nearest->placements[t];
    }
  }
}

}  // namespace handgraft::retargeting
