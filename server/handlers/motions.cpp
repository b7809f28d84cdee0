#include "server/handlers/motions.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/hand/kinematics.h"
#include "core/io/session_file.h"
#include "core/io/solved_trajectory.h"
#include "core/io/trajectory_writer.h"
#include "core/retargeting/motion_solving.h"
#include "core/session/timed_edit.h"
#include "idl/fields.h"
#include "server/base/rejection.h"
#include "server/handlers/solving_phase.h"
#include "server/messages/convert.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kMostFramesSent = 4096;
constexpr std::size_t kMostBytesSent = 8u << 20;

/// Zeros stand for defaults.
retargeting::MotionSolving motionSolvingFrom(const v1::SolveMotionRequest& request) {
  if (request.options().empty()) return retargeting::motionSolving(false);
  const v1::MotionOptions& options = request.options().front();
  retargeting::MotionSolving solving = retargeting::motionSolving(options.causal());
  if (options.smoothness() > 0.0) solving.options.smoothness = options.smoothness();
  if (options.fade_s() > 0.0) solving.options.fade.seconds = options.fade_s();
  if (options.solving().starts() > 0)
    solving.options.starts = static_cast<int>(options.solving().starts());
  solving.options.seed = options.solving().seed();
  solving.acceleration_limit = options.acceleration_limit();
  return solving;
}

v1::MotionOptions motionMessage(const retargeting::MotionSolving& solving) {
  v1::MotionOptions options;
  options.causal(solving.causal);
  options.smoothness(solving.options.smoothness);
  options.fade_s(solving.options.fade.seconds);
  options.acceleration_limit(solving.acceleration_limit);
  options.solving().starts(static_cast<std::uint32_t>(solving.options.starts));
  options.solving().seed(solving.options.seed);
  return options;
}

v1::MotionSummary summaryOf(const LiveSession& live,
                            const LiveMotion& motion,
                            const Progress& progress) {
  constexpr int kToldEvery = 256;  // frames: a long motion takes seconds
  const retargeting::SolvedMotion& solved = *motion.solved;
  const std::vector<hand::HandPose>& poses = solved.trajectory.poses;
  v1::MotionSummary summary;
  summary.session_id(live.id());
  summary.revision(motion.solved_revision);
  summary.frame_count(static_cast<std::uint32_t>(poses.size()));
  summary.duration_s(motion.motion->duration());
  const manipulation::FrameFit fit =
      manipulation::meanFit(manipulation::fitFrames(solved.problem, poses));
  summary.mean_mm(fit.mean_mm);
  summary.normal_deg(fit.normal_deg);
  quality::Depths deepest;
  for (const quality::Depths& one : solved.depths)
    deepest = deeperOf(deepest, one);
  summary.max_depth_m(deepest.object_m);
  summary.self_depth_m(deepest.self_m);
  const manipulation::Smoothness smoothness =
      manipulation::measureSmoothness(solved.problem, poses);
  summary.max_step(smoothness.max_step);
  summary.max_velocity(smoothness.max_velocity);
  summary.max_acceleration(smoothness.max_acceleration);
  summary.rms_jerk(smoothness.rms_jerk);
  const retargeting::MotionFits fits(*motion.motion, solved);
  std::uint32_t reached = 0;
  for (int k = 0; k < static_cast<int>(poses.size()); ++k) {
    if (k % kToldEvery == 0)
      progress.report("judging frames",
                      static_cast<double>(k) / static_cast<double>(poses.size()));
    int there = 0;
    int reached_there = 0;
    for (const retargeting::PatchFrameFit& patch : fits.at(k)) {
      if (patch.presence < v1::PRESENCE_COUNTED) continue;
      ++there;
      reached_there += patch.reached ? 1 : 0;
    }
    reached += there > 0 && reached_there == there ? 1 : 0;
  }
  summary.frames_reached(reached);
  summary.options(motionMessage(solved.solving));
  summary.solve_ms(motion.solve_ms);
  summary.notes(solved.notes);
  return summary;
}

/// How much of a frame is told: numbers; where the links are, too; patches' outlines, too.
enum class Detail { kNumbers, kLinks, kShapes };

/// A patch as it lies in a frame, edited as it may be: as many of its correspondences as an
/// outline has points.
void putShape(const retargeting::SolvedMotion& solved,
              const manipulation::PatchTrack& track,
              int motion_track,
              int frame,
              const hand::LinkPoses& X_WL,
              v1::FramePatch& patch) {
  const auto index = std::find(solved.track_of.begin(), solved.track_of.end(), motion_track);
  if (index == solved.track_of.end()) return;
  const auto& spans =
      solved.problem.tracks[static_cast<std::size_t>(index - solved.track_of.begin())].spans;
  const auto after = std::find_if(spans.begin(), spans.end(), [&](const auto& span) {
    return span.begin > frame;
  });
  const auto& pairs = (after == spans.begin() ? after : std::prev(after))->pairs;
  const int shown = std::clamp(frame, track.begin(), track.end - 1);
  const std::size_t count =
      std::min(pairs.size(), track.keyAt(shown).patch.interpolation_boundary.size());
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d& p_O = pairs[i].p_W;  // motions are laid in O
    const Eigen::Vector3d p_W = X_WL[static_cast<std::size_t>(pairs[i].link)] * pairs[i].p_L;
    patch.outline_O_m().insert(patch.outline_O_m().end(), p_O.data(), p_O.data() + 3);
    patch.hand_W_m().insert(patch.hand_W_m().end(), p_W.data(), p_W.data() + 3);
  }
}

v1::MotionFrame frameMessage(const LiveMotion& motion,
                             const retargeting::SolvedMotion& solved,
                             const retargeting::MotionFits& fits,
                             int frame,
                             Detail detail) {
  const auto at = static_cast<std::size_t>(frame);
  const hand::HandPose& pose = solved.trajectory.poses[at];
  const Pose& X_WO = motion.motion->X_WO[at];
  v1::MotionFrame message;
  message.index(static_cast<std::uint32_t>(frame));
  message.time_s(motion.motion->time_s[at] - motion.motion->time_s.front());
  message.X_WO(toMessage(X_WO));
  const Pose X_WH = X_WO * pose.X_WH;
  message.X_WH(toMessage(X_WH));
  message.joint_positions().assign(pose.q.data(), pose.q.data() + pose.q.size());
  message.max_depth_m(solved.depths[at].object_m);
  message.self_depth_m(solved.depths[at].self_m);
  message.objective(solved.trajectory.objective[at]);
  const manipulation::MotionProblem& problem = solved.problem;
  message.joints_at_limit(limitsMessage(
      *problem.model, optimize::activeLimits(problem.lower, problem.upper, pose.q)));
  hand::LinkPoses links_W;
  if (detail != Detail::kNumbers)
    links_W = hand::forwardKinematics(*solved.problem.model, {X_WH, pose.q});
  for (const retargeting::PatchFrameFit& fit : fits.at(frame)) {
    v1::FramePatch patch;
    patch.patch(static_cast<std::uint32_t>(fit.patch));
    patch.presence(fit.presence);
    patch.point_count(static_cast<std::uint32_t>(fit.points));
    patch.mean_mm(fit.mean_mm);
    patch.normal_deg(fit.normal_deg);
    patch.reached(fit.reached);
    const manipulation::PatchTrack& track =
        motion.motion->tracks[static_cast<std::size_t>(fit.track)];
    if (detail == Detail::kShapes) putShape(solved, track, fit.track, frame, links_W, patch);
    message.patches().push_back(std::move(patch));
  }
  for (const Pose& X_WL : links_W)
    message.X_WL().push_back(toMessage(X_WL));
  return message;
}

/// About as many bytes as a frame takes on the wire.
std::size_t bytesOfFrame(const LiveMotion& motion, bool with_shapes) {
  const hand::HandModel& model = *motion.solved->problem.model;
  constexpr std::size_t kPatchBytes = 64;
  constexpr std::size_t kOutlineBytes = std::size_t{2} * 25 * 24;
  constexpr std::size_t kPoseBytes = 56;
  const auto patches = motion.motion->tracks.size();
  std::size_t bytes = 256 + 48 * static_cast<std::size_t>(model.dofCount());
  bytes +=
      std::min<std::size_t>(patches, 64) * (kPatchBytes + (with_shapes ? kOutlineBytes : 0));
  if (with_shapes) bytes += kPoseBytes * static_cast<std::size_t>(model.linkCount());
  return bytes;
}

}  // namespace

LiveMotion& motionOf(LiveSession& live) {
  if (LiveMotion* motion = live.motion()) return *motion;
  rejectInput("session {} holds contacts, no motion", live.id());
}

const retargeting::SolvedMotion& solvedOf(LiveSession& live) {
  const LiveMotion& motion = motionOf(live);
  if (motion.solved) return *motion.solved;
  rejectInput("the motion of session {} has no answer yet; solve it first", live.id());
}

namespace {

/// How a motion was solved, as the session's log has it.
session::FollowedMotion followedBy(const retargeting::MotionSolving& solving) {
  return {solving.causal,
          solving.options.smoothness,
          solving.options.fade.seconds,
          solving.acceleration_limit,
          solving.options.starts,
          solving.options.seed};
}

/// Solves the session's motion as it stands; the answer is kept.
void follow(LiveSession& live,
            LiveMotion& motion,
            const retargeting::MotionSolving& solving,
            HandlerContext& context,
            const Progress& told,
            const retargeting::EditedMotion::OnStretch& on_stretch = {}) {
  session::Session& session = live.session();
  if (!motion.edited)
    motion.edited = std::make_shared<retargeting::EditedMotion>(motion.motion, motion.object_O);
  told.checkpoint();
  const auto begin = std::chrono::steady_clock::now();
  const HandlerContext::Share share(context);
  motion.solved = motion.edited->solve(session.document(), session.hand(), solving,
                                       share.threads(), told, on_stretch, !on_stretch);
  motion.solved_revision = session.revision();
  motion.solve_ms =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
          .count();
}

/// Tells frames of an answer; the last of a revision are none, and say that there are no more.
class FramesTold {
 public:
  FramesTold(LiveSession& live, LiveMotion& motion)
      : live_(live), motion_(motion), before_(motion.solved) {}

  /// Those that differ from what was told before, in `range`.
  void tell(const retargeting::SolvedMotion& solved, retargeting::FrameRange range) {
    constexpr std::size_t kFramesAtOnce = 256;
    if (told_.empty()) told_.assign(solved.trajectory.poses.size(), false);
    const retargeting::MotionFits fits(*motion_.motion, solved);
    v1::MotionFrames frames = begun(solved);
    for (int k = range.first; k < range.end; ++k) {
      const auto at = static_cast<std::size_t>(k);
      if (told_[at] || isAsBefore(solved, at)) continue;
      told_[at] = true;
      frames.frames().push_back(frameMessage(motion_, solved, fits, k, Detail::kLinks));
      if (frames.frames().size() < kFramesAtOnce) continue;
      live_.publish(std::move(frames));
      frames = begun(solved);
    }
    if (!frames.frames().empty()) live_.publish(std::move(frames));
  }

  /// Of long motions the changed frames are asked for.
  void end(const retargeting::SolvedMotion& solved) {
    constexpr int kMostTold = 4096;
    const auto count = static_cast<int>(solved.trajectory.poses.size());
    if (count <= kMostTold) tell(solved, {0, count});
    v1::MotionFrames last = begun(solved);
    last.is_last(true);
    live_.publish(std::move(last));
  }

 private:
  [[nodiscard]] v1::MotionFrames begun(const retargeting::SolvedMotion& solved) const {
    v1::MotionFrames frames;
    frames.revision(live_.session().revision());
    frames.frame_count(static_cast<std::uint32_t>(solved.trajectory.poses.size()));
    return frames;
  }

  [[nodiscard]] bool isAsBefore(const retargeting::SolvedMotion& solved, std::size_t at) const {
    if (!before_ || before_->trajectory.poses.size() != solved.trajectory.poses.size())
      return false;
    const hand::HandPose& a = before_->trajectory.poses[at];
    const hand::HandPose& b = solved.trajectory.poses[at];
    return a.q == b.q && a.X_WH.matrix() == b.X_WH.matrix();
  }

  LiveSession& live_;
  LiveMotion& motion_;
  std::shared_ptr<const retargeting::SolvedMotion> before_;
  std::vector<bool> told_;
};

void requireOwnObject(LiveSession& live, const LiveMotion& motion) {
  if (live.session().sharedObject() == motion.object_O) return;
  rejectInput("motion {} lies on another object than {}; swap that back first",
              handgraft::quoted(motion.name),
              handgraft::quoted(live.session().document().object));
}

}  // namespace

v1::MotionSummary solveMotion(LiveSession& live,
                              const v1::SolveMotionRequest& request,
                              HandlerContext& context,
                              const Progress& progress) {
  LiveMotion& motion = motionOf(live);
  requireOwnObject(live, motion);
  const retargeting::MotionSolving solving = request.options().empty() && motion.solving
                                                 ? *motion.solving
                                                 : motionSolvingFrom(request);
  FramesTold told_frames(live, motion);
  const SolveEnd end = runInPhase(live, v1::PHASE_OPTIMIZING, Preemption::kUnhurried, progress,
                                  [&](SolveCycle::Run&, const Progress& told) {
                                    follow(live, motion, solving, context, told);
                                  });
  requireDone(end, live);
  motion.solving = solving;
  const session::FollowedMotion followed = followedBy(solving);
  live.session().noteFollowed(followed);
  if (live.journal) live.journal->keep(io::entryText(followed));
  told_frames.end(*motion.solved);
  return summaryOf(live, motion, progress);
}

bool followsEdits(LiveSession& live) {
  return live.motion() != nullptr && live.motion()->solving.has_value();
}

SolveEnd solveMotionAfterEdit(LiveSession& live,
                              HandlerContext& context,
                              const Progress& progress) {
  LiveMotion& motion = motionOf(live);
  FramesTold told_frames(live, motion);
  const auto tell = [&](const retargeting::SolvedMotion& as_far,
                        retargeting::FrameRange range) {
    told_frames.tell(as_far, range);
  };
  const SolveEnd end = runInPhase(live, v1::PHASE_OPTIMIZING, Preemption::kAnswer, progress,
                                  [&](SolveCycle::Run&, const Progress& told) {
                                    requireOwnObject(live, motion);
                                    follow(live, motion, *motion.solving, context, told, tell);
                                  });
  if (end == SolveEnd::kDone) told_frames.end(*motion.solved);
  return end;
}

void resumeFollowing(LiveSession& live, const session::FollowedMotion& followed) {
  LiveMotion* motion = live.motion();
  if (motion == nullptr) return;
  retargeting::MotionSolving solving = retargeting::motionSolving(followed.causal);
  solving.options.smoothness = followed.smoothness;
  solving.options.fade.seconds = followed.fade_s;
  solving.options.starts = followed.starts;
  solving.options.seed = followed.seed;
  solving.acceleration_limit = followed.acceleration_limit;
  motion->solving = solving;
}

v1::MotionFrames motionFrames(LiveSession& live, const v1::MotionFramesRequest& request) {
  const retargeting::SolvedMotion& solved = solvedOf(live);
  const LiveMotion& motion = *live.motion();
  const std::size_t count = solved.trajectory.poses.size();
  if (request.first() >= count) {
    rejectInput("frame {}: the motion has frames 0 to {}", request.first(), count - 1);
  }
  const std::size_t every = std::max<std::size_t>(1, request.every());
  const std::size_t fitting = std::clamp<std::size_t>(
      kMostBytesSent / bytesOfFrame(motion, request.with_shapes()), 1, kMostFramesSent);
  const std::size_t most =
      request.count() == 0 ? fitting : std::min<std::size_t>(fitting, request.count());
  const retargeting::MotionFits fits(*motion.motion, solved);
  const Detail detail = request.with_shapes() ? Detail::kShapes : Detail::kNumbers;
  v1::MotionFrames reply;
  reply.session_id(live.id());
  reply.revision(motion.solved_revision);
  reply.frame_count(static_cast<std::uint32_t>(count));
  std::size_t frame = request.first();
  for (; frame < count && reply.frames().size() < most; frame += every) {
    reply.frames().push_back(
        frameMessage(motion, solved, fits, static_cast<int>(frame), detail));
  }
  reply.is_last(frame >= count);
  return reply;
}

namespace {

std::string written(const io::HandTrajectory& trajectory, v1::ExportFormat format) {
  switch (format) {
    case v1::EXPORT_JSON:
      return io::trajectoryJson(trajectory);
    case v1::EXPORT_CSV:
      return io::trajectoryCsv(trajectory);
    case v1::EXPORT_GLB:
      return io::trajectoryGlb(trajectory);
    case v1::EXPORT_NPZ:
      return io::trajectoryNpz(trajectory);
    case v1::EXPORT_MJCF:
      return io::trajectoryMjcf(trajectory);
    case v1::EXPORT_ROS_TRAJECTORY:
      return io::rosTrajectoryYaml(trajectory);
    default:
      rejectInput(
          "export: motions have no format {}; they have json, csv, glb, npz, mjcf and "
          "ros_trajectory",
          nameOf(format));
  }
}

}  // namespace

std::string motionExport(LiveSession& live, v1::ExportFormat format) {
  const LiveMotion& motion = *live.motion();
  io::HandTrajectory trajectory =
      io::trajectoryOf(*motion.motion, solvedOf(live), motion.object_O);
  trajectory.hand = live.session().document().hand;
  trajectory.object = live.session().document().object;
  trajectory.motion = motion.name;
  return written(trajectory, format);
}

std::string liveRunExport(LiveSession& live,
                          v1::ExportFormat format,
                          std::vector<std::string>& notes) {
  const LiveRun& run = live.following.run;
  if (run.isEmpty())
    rejectInput("export: session {} has followed no demonstrator yet", live.id());
  const io::HandTrajectory trajectory = run.trajectory();
  notes.insert(notes.end(), trajectory.notes.begin(), trajectory.notes.end());
  return written(trajectory, format);
}

}  // namespace handgraft::server
