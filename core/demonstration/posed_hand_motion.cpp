#include "core/demonstration/posed_hand_motion.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/demonstration/posed_hand_contacts.h"
#include "core/demonstration/shown_posture.h"

namespace handgraft::demonstration {

namespace {

/// Cuts of one part of the hand, by the number of the cut.
using PartCuts = std::map<int, contact::Patch>;

constexpr int kGapBridged = 1;  // cuts
constexpr int kFewestCuts = 2;  // of a touch

/// The frames at which contacts are cut: the first, and then as soon as so much time is over.
std::vector<int> cutFrames(const std::vector<PosedFrame>& frames, double every_s) {
  std::vector<int> cuts;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const double last =
        cuts.empty() ? 0.0 : frames[static_cast<std::size_t>(cuts.back())].time_s;
    // Half a microsecond, for sums of steps.
    if (cuts.empty() || frames[k].time_s - last >= every_s - 5e-7)
      cuts.push_back(static_cast<int>(k));
  }
  return cuts;
}

/// Patches of a part from cut `first` to cut `last`, which is the last one with it.
manipulation::PatchTrack trackOf(const std::string& name,
                                 const PartCuts& part,
                                 int first,
                                 int last,
                                 const std::vector<int>& cuts,
                                 int frame_count) {
  manipulation::PatchTrack track;
  track.name = name;
  const auto behind = static_cast<std::size_t>(last) + 1;
  track.end = behind < cuts.size() ? cuts[behind] : frame_count;
  for (auto at = part.find(first); at != part.end() && at->first <= last; ++at) {
    manipulation::PatchKey key;
    key.frame = cuts[static_cast<std::size_t>(at->first)];
    key.patch = at->second;
    track.keys.push_back(std::move(key));
  }
  return track;
}

/// Times and object poses alone.
manipulation::Motion motionWithoutTracks(const std::vector<PosedFrame>& frames) {
  manipulation::Motion motion;
  for (const PosedFrame& frame : frames) {
    if (!std::isfinite(frame.time_s) ||
        (!motion.time_s.empty() && frame.time_s <= motion.time_s.back())) {
      rejectInput("frame {}: its time {} s does not lie behind the one before",
                  motion.time_s.size(), frame.time_s);
    }
    motion.time_s.push_back(frame.time_s);
    motion.X_WO.push_back(frame.X_WO);
  }
  return motion;
}

}  // namespace

manipulation::Motion motionOfPosedHand(const hand::Hand& hand,
                                       const std::vector<PosedFrame>& frames,
                                       const geometry::TriangleMesh& object_O,
                                       const PosedMotionOptions& options,
                                       const Progress& progress) {
  if (frames.empty()) rejectInput("a posed hand without frames is no motion");
  if (!(options.every_s > 0.0))
    rejectInput("contacts are cut every {} s; that must lie above 0", options.every_s);
  manipulation::Motion motion = motionWithoutTracks(frames);

  const std::vector<hand::TurnedPart> turned =
      turnedParts(hand::coordinatesOf(hand)->anatomy());
  for (int k = 0; k < motion.frameCount(); ++k) {
    if (!isDemonstratorDue(motion, k)) continue;
    const PosedFrame& frame = frames[static_cast<std::size_t>(k)];
    motion.demonstrator.push_back(shownAt(k, hand, turned, frame.pose, frame.X_WO));
  }

  // === What touches at each cut
  const std::vector<int> cuts = cutFrames(frames, options.every_s);
  std::map<std::string, PartCuts> parts;
  std::string fault;
  const ContactCutter cutter(hand, object_O, options.reach);
  for (std::size_t cut = 0; cut < cuts.size(); ++cut) {
    progress.checkpoint();
    progress.report("cutting contacts",
                    static_cast<double>(cut) / static_cast<double>(cuts.size()));
    const PosedFrame& frame = frames[static_cast<std::size_t>(cuts[cut])];
    try {
      PosedContacts contacts =
          cutter.at(frame.pose, frame.X_WO, options.segmentation, Progress());
      motion.side = contacts.set.side;
      for (contact::Patch& patch : contacts.set.patches)
        parts[patch.name].emplace(static_cast<int>(cut), std::move(patch));
    } catch (const InvalidInput& error) {
      fault = error.what();  // nothing touches then
    }
  }

  // === Each part from where it begins to touch until it does not
  int fleeting = 0;
  const auto frame_count = static_cast<int>(frames.size());
  for (const auto& [name, part] : parts) {
    for (auto at = part.begin(); at != part.end();) {
      const int first = at->first;
      int last = first;
      int count = 0;
      for (; at != part.end() && at->first <= last + 1 + kGapBridged; ++at) {
        last = at->first;
        ++count;
      }
      if (count < kFewestCuts && cuts.size() > 1) {
        ++fleeting;
        continue;
      }
      motion.tracks.push_back(trackOf(name, part, first, last, cuts, frame_count));
    }
  }
  if (motion.tracks.empty())
    rejectInput("the hand touches nothing for {:.0f} ms{}", 1e3 * options.every_s,
                fault.empty() ? "" : ": " + fault);
  std::stable_sort(motion.tracks.begin(), motion.tracks.end(),
                   [](const manipulation::PatchTrack& a, const manipulation::PatchTrack& b) {
                     return a.begin() < b.begin();
                   });
  if (fleeting > 0)
    motion.notes.push_back(fmt::format("left out {} areas that are there for {:.0f} ms alone",
                                       fleeting, 1e3 * options.every_s));
  validate(object_O, motion);
  return motion;
}

}  // namespace handgraft::demonstration
