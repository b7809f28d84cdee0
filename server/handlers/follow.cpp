#include "server/handlers/follow.h"

#include <memory>
#include <string>

#include "core/base/error.h"
#include "core/hand/kinematics.h"
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
    rejectInput("kind {}: only 21 joints' places and MANO's pose are followed",
                static_cast<unsigned>(message.kind()));
  }
  return frame;
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
  solution.evaluations(static_cast<std::uint32_t>(answer.evaluations));
  solution.time_s().push_back(frame.time_s());
  return solution;
}

/// Of the session as it stands: an edit makes another one, which begins anew.
retargeting::LiveFollower& followerOf(LiveSession& live) {
  session::Session& session = live.session();
  Following& following = live.following;
  if (!following.follower || following.revision != session.revision()) {
    following.follower = std::make_shared<retargeting::LiveFollower>(
        session.document(), session.hand(), session.sharedObject(), live.solves());
    following.revision = session.revision();
  }
  return *following.follower;
}

}  // namespace

void followFrame(LiveSession& live, const v1::DemonstratorFrame& frame) {
  std::string trouble;
  try {
    const manipulation::DemonstratedFrame demonstrated = demonstratedFrom(frame);
    const auto answer = followerOf(live).follow(demonstrated, live.solves());
    if (answer) live.publish(answerOf(live, frame, *answer));
  } catch (const Cancelled&) {
    return;  // it is being closed
  } catch (const std::exception& error) {
    trouble = std::string("demonstrator: ") + error.what();
  }
  if (trouble == live.following.trouble) return;
  live.following.trouble = trouble;
  live.warn(trouble);
}

}  // namespace handgraft::server
