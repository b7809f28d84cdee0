#include "server/handlers/motions.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/hand/kinematics.h"
#include "core/io/trajectory_writer.h"
#include "core/session/motion_solving.h"
#include "idl/fields.h"
#include "server/admission/rejection.h"
#include "server/messages/convert.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kMostFramesSent = 4096;
constexpr std::size_t kMostBytesSent = 8u << 20;
constexpr double kJointAtLimit = 1e-6;  // rad or m, as manipulation::jointsAtLimits

LiveMotion& motionOf(LiveSession& live) {
  if (LiveMotion* motion = live.motion()) return *motion;
  rejectInput("session {} holds contacts, no motion", live.id());
}

const session::SolvedMotion& solvedOf(LiveSession& live) {
  const LiveMotion& motion = motionOf(live);
  if (motion.solved) return *motion.solved;
  rejectInput("the motion of session {} has no answer yet; solve it first", live.id());
}

/// Zeros stand for defaults.
session::MotionSolving motionSolvingFrom(const v1::SolveMotionRequest& request) {
  if (request.options().empty()) return session::motionSolving(false);
  const v1::MotionOptions& options = request.options().front();
  session::MotionSolving solving = session::motionSolving(options.causal());
  if (options.smoothness() > 0.0) solving.options.smoothness = options.smoothness();
  if (options.fade_s() > 0.0) solving.options.fade.seconds = options.fade_s();
  if (options.solving().starts() > 0)
    solving.options.starts = static_cast<int>(options.solving().starts());
  solving.options.seed = options.solving().seed();
  solving.acceleration_limit = options.acceleration_limit();
  return solving;
}

v1::MotionOptions motionMessage(const session::MotionSolving& solving) {
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
  const session::SolvedMotion& solved = *motion.solved;
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
  summary.max_depth_m(*std::max_element(solved.depth_m.begin(), solved.depth_m.end()));
  const manipulation::Smoothness smoothness =
      manipulation::measureSmoothness(solved.problem, poses);
  summary.max_step(smoothness.max_step);
  summary.max_velocity(smoothness.max_velocity);
  summary.max_acceleration(smoothness.max_acceleration);
  summary.rms_jerk(smoothness.rms_jerk);
  const session::MotionFits fits(*motion.motion, solved);
  std::uint32_t reached = 0;
  for (int k = 0; k < static_cast<int>(poses.size()); ++k) {
    if (k % kToldEvery == 0)
      progress.report("judging frames",
                      static_cast<double>(k) / static_cast<double>(poses.size()));
    const std::vector<session::PatchFrameFit> patches = fits.at(k);
    reached += std::all_of(patches.begin(), patches.end(),
                           [](const session::PatchFrameFit& patch) {
                             return patch.reached || patch.presence < 1.0;
                           })
                   ? 1
                   : 0;
  }
  summary.frames_reached(reached);
  summary.options(motionMessage(solved.solving));
  summary.solve_ms(motion.solve_ms);
  summary.notes(solved.notes);
  return summary;
}

std::vector<v1::JointLimit> limitsReached(const manipulation::MotionProblem& problem,
                                          const Eigen::VectorXd& q) {
  std::vector<v1::JointLimit> limits;
  for (int i = 0; i < problem.model->dofCount(); ++i) {
    if (problem.lower[i] == problem.upper[i]) continue;  // locked
    const std::string& name = problem.model->dofJoint(i).name;
    if (q[i] <= problem.lower[i] + kJointAtLimit) limits.push_back(limitOf(name, false));
    if (q[i] >= problem.upper[i] - kJointAtLimit) limits.push_back(limitOf(name, true));
  }
  return limits;
}

std::vector<double> outlineOf(const geometry::TriangleMesh& object_O,
                              const contact::Patch& patch) {
  std::vector<double> outline;
  for (const geometry::SurfacePoint& point : patch.interpolation_boundary) {
    const Eigen::Vector3d p_O = positionOf(object_O, point);
    outline.insert(outline.end(), p_O.data(), p_O.data() + 3);
  }
  return outline;
}

v1::MotionFrame frameMessage(const LiveMotion& motion,
                             const session::MotionFits& fits,
                             const geometry::TriangleMesh& object_O,
                             int frame,
                             bool with_shapes) {
  const session::SolvedMotion& solved = *motion.solved;
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
  message.max_depth_m(solved.depth_m[at]);
  message.objective(solved.trajectory.objective[at]);
  message.joints_at_limit(limitsReached(solved.problem, pose.q));
  for (const session::PatchFrameFit& fit : fits.at(frame)) {
    v1::FramePatch patch;
    patch.patch(static_cast<std::uint32_t>(fit.patch));
    patch.presence(fit.presence);
    patch.point_count(static_cast<std::uint32_t>(fit.points));
    patch.mean_mm(fit.mean_mm);
    patch.normal_deg(fit.normal_deg);
    patch.reached(fit.reached);
    const manipulation::PatchTrack& track =
        motion.motion->tracks[static_cast<std::size_t>(fit.track)];
    if (with_shapes) {
      const int shown = std::clamp(frame, track.begin(), track.end - 1);
      patch.outline_O_m(outlineOf(object_O, track.keyAt(shown).patch));
    }
    message.patches().push_back(std::move(patch));
  }
  if (!with_shapes) return message;
  for (const Pose& X_WL : hand::forwardKinematics(*solved.problem.model, {X_WH, pose.q}))
    message.X_WL().push_back(toMessage(X_WL));
  return message;
}

/// About as many bytes as a frame takes on the wire.
std::size_t bytesOfFrame(const LiveMotion& motion, bool with_shapes) {
  const hand::HandModel& model = *motion.solved->problem.model;
  constexpr std::size_t kPatchBytes = 64;
  constexpr std::size_t kOutlineBytes = 25 * 24;
  constexpr std::size_t kPoseBytes = 56;
  const auto patches = motion.motion->tracks.size();
  std::size_t bytes = 256 + 48 * static_cast<std::size_t>(model.dofCount());
  bytes +=
      std::min<std::size_t>(patches, 64) * (kPatchBytes + (with_shapes ? kOutlineBytes : 0));
  if (with_shapes) bytes += kPoseBytes * static_cast<std::size_t>(model.linkCount());
  return bytes;
}

}  // namespace

v1::MotionSummary solveMotion(LiveSession& live,
                              const v1::SolveMotionRequest& request,
                              Workshop& workshop,
                              const Progress& progress) {
  LiveMotion& motion = motionOf(live);
  session::Session& session = live.session();
  if (session.sharedObject() != motion.object_O) {
    rejectInput("motion {} lies on another object than {}; swap that back first",
                handgraft::quoted(motion.name), handgraft::quoted(session.document().object));
  }
  const session::MotionSolving solving = motionSolvingFrom(request);
  Progress stoppable(progress, [&](std::string_view stage, double fraction) {
    progress.report(stage, fraction);
  });
  LiveSession::SolveInFlight flight(live, stoppable, std::chrono::hours(1));
  try {
    runPhase(live, v1::PHASE_OPTIMIZING, v1::PHASE_READY, stoppable, [&](const Progress& told) {
      told.checkpoint();
      const auto begin = std::chrono::steady_clock::now();
      const Workshop::Share share(workshop);
      auto solved = std::make_shared<session::SolvedMotion>(
          session::solveMotion(session.document(), session.hand(), session.sharedObject(),
                               *motion.motion, solving, share.threads(), told));
      const std::chrono::duration<double, std::milli> spent =
          std::chrono::steady_clock::now() - begin;
      motion.solved = std::move(solved);
      motion.solved_revision = session.revision();
      motion.solve_ms = spent.count();
    });
  } catch (const Cancelled&) {
    if (flight.wasStopped())
      reject(v1::ERROR_CANCELLED, "session {}: {}", live.id(), live.whoStopped());
    throw;
  }
  return summaryOf(live, motion, progress);
}

v1::MotionFrames motionFrames(LiveSession& live, const v1::MotionFramesRequest& request) {
  const session::SolvedMotion& solved = solvedOf(live);
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
  const session::MotionFits fits(*motion.motion, solved);
  v1::MotionFrames reply;
  reply.session_id(live.id());
  reply.revision(motion.solved_revision);
  reply.frame_count(static_cast<std::uint32_t>(count));
  std::size_t frame = request.first();
  for (; frame < count && reply.frames().size() < most; frame += every) {
    reply.frames().push_back(frameMessage(motion, fits, *motion.object_O,
                                          static_cast<int>(frame), request.with_shapes()));
  }
  reply.is_last(frame >= count);
  return reply;
}

std::string motionExport(LiveSession& live, v1::ExportFormat format) {
  const session::SolvedMotion& solved = solvedOf(live);
  const LiveMotion& motion = *live.motion();
  const session::Document& document = live.session().document();
  io::HandTrajectory trajectory;
  trajectory.hand = document.hand;
  trajectory.object = document.object;
  trajectory.motion = motion.name;
  trajectory.model = solved.problem.model;
  trajectory.object_O = motion.object_O;
  trajectory.contacts = motion.motion;
  trajectory.solved = motion.solved;
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

}  // namespace handgraft::server
