#include "server/handlers/follow.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/demonstration/posed_hand_tracker.h"
#include "core/hand/kinematics.h"
#include "core/hand/mano_joints.h"
#include "server/messages/convert.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kJointPlaceValues = 63;
constexpr std::size_t kManoValues = 51;

manipulation::DemonstratedFrame demonstratedFrom(const v1::DemonstratorFrame& message) {
  manipulation::DemonstratedFrame frame;
  frame.time_s = message.time_s();
  frame.side = message.chirality() == v1::CHIRALITY_LEFT ? hand::HandSide::kLeft
                                                         : hand::HandSide::kRight;
  frame.X_WO = poseFrom(message.X_WO(), "X_WO");
  const std::vector<double>& values = message.values();
  const auto require = [&](std::size_t count, const char* what) {
    if (values.size() != count)
      rejectInput("values: {} numbers; {} have {}", values.size(), what, count);
  };
  if (message.kind() == v1::DEMONSTRATOR_JOINT_PLACES) {
    require(kJointPlaceValues, "21 joints' places");
    frame.joints_W = Eigen::Map<const hand::JointPlaces>(values.data());
  } else if (message.kind() == v1::DEMONSTRATOR_MANO) {
    require(kManoValues, "MANO's pose and translation");
    frame.joints_W = hand::manoJointPlaces(
        Eigen::Map<const Eigen::Matrix<double, hand::kManoPoseSize, 1>>(values.data()),
        Eigen::Map<const Eigen::Vector3d>(values.data() + hand::kManoPoseSize), frame.side);
  } else {
    rejectInput("kind {}: it must be joint_places, mano or joints",
                static_cast<unsigned>(message.kind()));
  }
  hand::requireHand(frame.joints_W, frame.side);
  return frame;
}

hand::HandPose posedFrom(const v1::DemonstratorFrame& message, const hand::HandModel& model) {
  const std::vector<double>& values = message.values();
  if (values.size() != static_cast<std::size_t>(model.dofCount())) {
    rejectInput("values: {} numbers; hand {} has {} joints", values.size(),
                quoted(message.hand()), model.dofCount());
  }
  if (message.X_WH().empty())
    rejectInput("X_WH: missing; joints do not tell where the hand {} is",
                quoted(message.hand()));
  hand::HandPose pose;
  pose.q = Eigen::VectorXd::Map(values.data(), static_cast<Eigen::Index>(values.size()));
  if (!pose.q.allFinite()) rejectInput("values: one of them is not finite");
  pose.X_WH = poseFrom(message.X_WH(), "X_WH");
  return pose;
}

const std::vector<std::string>& partNamesOf(const Following& following) {
  return following.tracker ? following.tracker->partNames()
                           : manipulation::ContactTracker::partNames();
}

v1::PatchFit partFitMessage(const retargeting::LiveFollower::PartFit& fit,
                            const std::string& name) {
  v1::PatchFit message;
  message.name(name);
  message.point_count(1);
  message.mean_mm(fit.distance_mm);
  message.rms_mm(fit.distance_mm);
  message.max_mm(fit.distance_mm);
  message.normal_deg(fit.facing_deg);
  message.within_2mm(fit.distance_mm <= 2.0 ? 1.0 : 0.0);
  message.within_5mm(fit.distance_mm <= 5.0 ? 1.0 : 0.0);
  message.hand_W_m({fit.on_hand_W.x(), fit.on_hand_W.y(), fit.on_hand_W.z()});
  message.object_W_m({fit.on_object_W.x(), fit.on_object_W.y(), fit.on_object_W.z()});
  v1::PatchDiagnosis diagnosis;
  diagnosis.facing_deg(fit.facing_deg);
  const double miss_mm = std::max(0.0, fit.distance_mm - v1::REACHED_MM);
  diagnosis.miss_m(1e-3 * miss_mm);
  // Why a part is too far away is not looked for, frame by frame.
  if (fit.reached)
    diagnosis.verdict(v1::VERDICT_REACHED);
  else if (miss_mm == 0.0)
    diagnosis.verdict(v1::VERDICT_NORMALS_IN_CONFLICT);
  diagnosis.text(fmt::format("{} by {:.1f} mm, {:.0f} deg off",
                             fit.reached ? "reached" : "missed", fit.distance_mm,
                             fit.facing_deg));
  message.diagnosis(std::move(diagnosis));
  return message;
}

/// All that is said of such a pose: nothing follows it.
void judge(LiveSession& live,
           const retargeting::LiveFollower::Answer& answer,
           v1::PoseSolution& solution) {
  const hand::HandModel& model = *live.session().hand().model;
  int reached = 0;
  for (const retargeting::LiveFollower::PartFit& fit : answer.parts) {
    solution.patches().push_back(partFitMessage(
        fit, partNamesOf(live.following).at(static_cast<std::size_t>(fit.part))));
    reached += fit.reached ? 1 : 0;
  }
  v1::Penetration depths;
  depths.max_depth_m(answer.depths.object_m);
  depths.self_depth_m(answer.depths.self_m);
  solution.penetration({depths});
  solution.joints_at_limit(limitsMessage(model, answer.limits));
  solution.verdict(
      answer.touches == 0
          ? "the demonstrator touches nothing"
          : fmt::format("{} of {} touches reached{}", reached, answer.touches,
                        answer.is_on_its_way ? "; on its way to a better grasp" : ""));
  solution.is_diagnosed(true);
}

v1::PoseSolution answerOf(LiveSession& live,
                          const v1::DemonstratorFrame& frame,
                          const retargeting::LiveFollower::Answer& answer) {
  v1::PoseSolution solution;
  solution.is_final(true);
  solution.solver("causal");
  solution.X_WH(toMessage(answer.pose.X_WH));
  solution.X_WO(frame.X_WO());
  solution.joint_positions().assign(answer.pose.q.data(),
                                    answer.pose.q.data() + answer.pose.q.size());
  for (const Pose& X_WL : hand::forwardKinematics(*live.session().hand().model, answer.pose))
    solution.X_WL().push_back(toMessage(X_WL));
  solution.terms().objective(answer.objective);
  solution.evaluations(static_cast<std::uint32_t>(answer.evaluations));
  solution.time_s().push_back(frame.time_s());
  judge(live, answer, solution);
  return solution;
}

/// The hand that follows, and the object.
io::HandTrajectory followedBy(LiveSession& live) {
  io::HandTrajectory of;
  of.hand = live.session().document().hand;
  of.object = live.session().document().object;
  of.model = live.session().hand().model;
  of.object_O = live.session().sharedObject();
  return of;
}

/// Whose frames they are, not what is in them, is why they are refused.
class AnotherIsFollowed : public InvalidInput {
  using InvalidInput::InvalidInput;
};

/// Frames of one demonstrator alone: of another one when the first has stopped, and of a writer
/// that counts anew, the hand begins anew, with its clock and with what touches.
void heed(LiveSession& live, const v1::DemonstratorFrame& frame) {
  constexpr std::chrono::milliseconds kStopped(500);
  Following& following = live.following;
  const SolveCycle::Clock::time_point now = live.now();
  const bool is_same = frame.client() == following.client;
  if (following.follower && !is_same && now - following.heard < kStopped)
    throw AnotherIsFollowed(fmt::format(
        "another one is followed, until it has stopped for {} ms", kStopped.count()));
  if (!is_same || frame.sequence_number() <= following.sequence_number) {
    following = Following();
    // What the one before was told is no word of this one, though it may be told the same.
    live.tellDemonstrator({});
  }
  following.client = frame.client();
  following.sequence_number = frame.sequence_number();
  following.heard = now;
}

/// Of the session as it stands, and of who is followed: an edit, or somebody else, makes
/// another one, which begins anew. `hand` null: a human's joints.
Following& followingOf(LiveSession& live, const std::shared_ptr<const StoredHand>& hand) {
  session::Session& session = live.session();
  Following& following = live.following;
  if (following.follower && following.revision == session.revision() && following.hand == hand)
    return following;
  Following fresh;  // all of it or nothing: making it may fail
  if (hand != nullptr) {
    fresh.tracker = std::make_shared<demonstration::PosedHandTracker>(
        hand->hand->get(live.solves()), session.sharedObject(), live.solves());
  }
  fresh.follower = std::make_shared<retargeting::LiveFollower>(
      session.document(), session.hand(), session.sharedObject(), live.solves());
  fresh.revision = session.revision();
  fresh.hand = hand;
  fresh.client = following.client;
  fresh.sequence_number = following.sequence_number;
  fresh.heard = following.heard;
  fresh.run = std::move(following.run);
  return following = std::move(fresh);
}

std::optional<retargeting::LiveFollower::Answer> answerTo(LiveSession& live,
                                                          const ModelStore& models,
                                                          const v1::DemonstratorFrame& frame) {
  heed(live, frame);
  if (frame.kind() != v1::DEMONSTRATOR_JOINTS) {
    const manipulation::DemonstratedFrame demonstrated = demonstratedFrom(frame);
    return followingOf(live, nullptr).follower->follow(demonstrated, live.solves());
  }
  const std::shared_ptr<const StoredHand> hand = models.hand(frame.hand());
  const hand::HandPose pose = posedFrom(frame, hand->hand->model());
  const Pose X_WO = poseFrom(frame.X_WO(), "X_WO");
  const Following& following = followingOf(live, hand);
  return following.follower->follow(frame.time_s(), X_WO, following.tracker->see(pose, X_WO),
                                    following.tracker->shownBy(pose, X_WO), live.solves());
}

std::string whyNotBegun(const retargeting::LiveFollower& follower) {
  constexpr int kEnough = retargeting::LiveFollower::kTouchesToBegin;
  const int touches = follower.touches();
  std::string why =
      touches < kEnough
          ? fmt::format(
                "touches the object with {} of the {} parts that a hand begins with; "
                "two of two fingers that stay do, too",
                touches, kEnough)
          : fmt::format(
                "touches the object with {} parts; the hand begins when no more come "
                "and a pose out of the object is found",
                touches);
  if (!follower.knowsHowHeld())
    why += "; its knuckles lie in one line, so that the hand does not know how to come near";
  return why;
}

v1::FollowState said(v1::FollowVerdict verdict, const std::string& text) {
  v1::FollowState state;
  state.verdict(verdict);
  state.text("demonstrator: " + text);
  return state;
}

}  // namespace

void followFrame(LiveSession& live,
                 const ModelStore& models,
                 const v1::DemonstratorFrame& frame) {
  v1::FollowState told;
  try {
    if (const auto answer = answerTo(live, models, frame)) {
      live.recallFrom(0);
      live.following.run.add(followedBy(live), frame.time_s(), poseFrom(frame.X_WO(), "X_WO"),
                             *answer, partNamesOf(live.following));
      live.publish(answerOf(live, frame, *answer));
    } else {
      told = said(v1::FOLLOW_WAITS, whyNotBegun(*live.following.follower));
    }
  } catch (const Cancelled&) {
    return;  // it is being closed
  } catch (const AnotherIsFollowed& error) {
    told = said(v1::FOLLOW_ANOTHER, error.what());
  } catch (const std::exception& error) {
    told = said(v1::FOLLOW_REFUSED, error.what());
  }
  live.tellDemonstrator(told);
}

}  // namespace handgraft::server
