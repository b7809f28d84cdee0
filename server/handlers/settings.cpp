#include "server/handlers/settings.h"

#include "core/base/error.h"
#include "core/hand/kinematics.h"
#include "server/messages/convert.h"
#include "server/messages/session_messages.h"

namespace handgraft::server {

v1::SessionSettings sessionSettings(LiveSession& live) {
  v1::SessionSettings message = settingsMessage(live.session());
  message.state(live.state());
  if (const LiveMotion* motion = live.motion())
    for (v1::TimedState& timed : message.timed())
      timed.time_s(timed.time_s() - motion->motion->time_s.front());  // from its begin
  return message;
}

v1::LinkPosesReply linkPoses(LiveSession& live, const v1::LinkPosesRequest& request) {
  const hand::HandModel& model = *live.session().hand().model;
  const std::vector<double>& joints = request.joint_positions();
  if (joints.size() != static_cast<std::size_t>(model.dofCount()))
    rejectInput("joint_positions: {} of them; hand {} has {} joints", joints.size(),
                handgraft::quoted(live.session().document().hand), model.dofCount());
  hand::HandPose pose;
  pose.X_WH = poseFrom(request.X_WH(), "X_WH");
  pose.q = Eigen::Map<const Eigen::VectorXd>(joints.data(), model.dofCount());
  v1::LinkPosesReply reply;
  for (const Pose& X_WL : hand::forwardKinematics(model, pose))
    reply.X_WL().push_back(toMessage(X_WL));
  return reply;
}

v1::CompareReply compareSnapshots(LiveSession& live,
                                  const v1::CompareRequest& request,
                                  const Progress& progress) {
  return toMessage(live.session().compare(request.a(), request.b(), progress));
}

}  // namespace handgraft::server
