#include "server/handlers/hand_trajectory.h"

#include <iterator>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/error.h"
#include "core/demonstration/posed_hand_motion.h"
#include "server/handlers/named_joints.h"
#include "server/handlers/pose_contacts.h"

namespace handgraft::server {

namespace {

constexpr double kMostOften = 1e-3;   // s
constexpr double kLeastOften = 10.0;  // s

demonstration::PosedMotionOptions optionsFrom(const io::HandTrajectoryPlan& plan) {
  demonstration::PosedMotionOptions options;
  if (plan.reach_m) options.reach = reachFrom(*plan.reach_m);
  if (!plan.every_s) return options;
  if (!(*plan.every_s >= kMostOften && *plan.every_s <= kLeastOften)) {
    rejectInput("contacts are cut every {} s; permitted are {} to {}", *plan.every_s,
                kMostOften, kLeastOften);
  }
  options.every_s = *plan.every_s;
  return options;
}

}  // namespace

manipulation::Motion motionOfTrajectory(const io::HandTrajectoryPlan& plan,
                                        const StoredHand& hand,
                                        const std::string& object,
                                        const geometry::TriangleMesh& object_O,
                                        const Progress& progress) {
  const demonstration::PosedMotionOptions options = optionsFrom(plan);
  const io::HandTrajectoryFile& file = plan.trajectory;
  const NamedJoints joints(hand, file.joints, NamedJoints::Followers::kLeftOut);
  const Eigen::VectorXd rest = hand.hand->model().restPose();
  std::vector<demonstration::PosedFrame> frames;
  std::vector<hand::HandPose> poses;
  for (const io::HandTrajectoryFile::Frame& from : file.frames) {
    poses.push_back(joints.poseAt(from.q, rest, from.X_WH, file.tells_root));
    frames.push_back({from.time_s, poses.back(), from.X_WO});
  }
  const hand::Hand ready = hand.hand->get(progress);
  std::vector<std::string> beyond = beyondLimits(hand.hand->model(), poses);
  manipulation::Motion motion = tellingWhatIsBeyond(beyond, [&] {
    return demonstration::motionOfPosedHand(ready, frames, object_O, options, progress);
  });
  motion.name = plan.name;
  std::vector<std::string> notes = {fmt::format(
      "what hand {} touches on its way, by distance up to {:.3g} mm, every {:.3g} ms",
      handgraft::quoted(hand.name), 1e3 * options.reach.reach_m, 1e3 * options.every_s)};
  if (const std::vector<std::string> missing = joints.missing(); !missing.empty())
    notes.push_back(fmt::format("joints that the file does not name stay at rest: {}",
                                fmt::join(missing, ", ")));
  if (!file.object.empty() && file.object != object)
    notes.push_back(fmt::format("the file says that it was about object {}",
                                handgraft::quoted(file.object)));
  notes.insert(notes.end(), std::make_move_iterator(beyond.begin()),
               std::make_move_iterator(beyond.end()));
  motion.notes.insert(motion.notes.begin(), std::make_move_iterator(notes.begin()),
                      std::make_move_iterator(notes.end()));
  return motion;
}

}  // namespace handgraft::server
