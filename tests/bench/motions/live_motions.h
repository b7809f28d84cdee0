#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/contact/contact_set.h"
#include "core/demonstration/posed_hand_motion.h"
#include "core/geometry/triangle_mesh.h"
#include "core/hand/hand.h"
#include "core/retargeting/live_follower.h"

namespace handgraft::bench {

/// What a live hand did, of one sequence or of several: how many of the demonstrator's touches
/// it reached, how deep it was, how far it was led about, what a frame took of one core.
struct LiveFigures {
  int frames = 0;
  int answered = 0;
  int touches = 0;  ///< of frames before it began, too
  int reached = 0;
  int places = 0;
  double sum_mm = 0.0;
  double sum_deg = 0.0;
  double deepest_m = 0.0;
  int past = 0;
  double largest_step = 0.0;
  /// How often the hand set out for another pose about the object, how long it was on its way,
  /// and how far that took it.
  int ways = 0;
  int frames_led = 0;
  double led_m = 0.0;
  std::vector<double> first_ms;
  std::vector<double> ms;

  void add(const retargeting::LiveFollower::Answer& answer);
};

/// What a live hand showed in one frame.
struct LiveFrame {
  std::optional<hand::HandPose> pose_O;  ///< none: it waits
  int touches = 0;
  int reached = 0;
  double mean_mm = 0.0;  ///< of the touches that it shows
  bool is_led = false;   ///< on its way to another pose
};

/// Adds a recorded hand followed live, frame by frame, as a session does it. Poses of the hand
/// in O, one a frame; none where there is no answer.
///
/// `contacts`: a session has some; a live hand takes nothing of them.
std::vector<LiveFrame> followLive(const contact::ContactSet& contacts,
                                  const std::vector<demonstration::PosedFrame>& frames,
                                  const std::shared_ptr<const geometry::TriangleMesh>& object_O,
                                  const hand::Hand& demonstrator,
                                  const hand::Hand& hand,
                                  LiveFigures& figures);

/// The heading of the rows.
void printLiveHeading();

void printLiveRow(const std::string& name, const hand::Hand& hand, const LiveFigures& figures);

}  // namespace handgraft::bench
