#include "server/reading/packed_trajectory.h"

#include <optional>

#include "core/base/error.h"
#include "server/reading/packed_parts.h"

namespace handgraft::server {

namespace {

void put(ByteWriter& out, const Pose& X) {
  out.numbers(X.translation().data(), 3);
  const Eigen::Vector4d q_wxyz = quaternionOf(X);
  out.numbers(q_wxyz.data(), 4);
}

Pose takePose(ByteReader& in) {
  Eigen::Vector3d p;
  for (double& coordinate : p)
    coordinate = in.finite();
  Eigen::Vector4d q_wxyz;
  for (double& number : q_wxyz)
    number = in.finite();
  return poseFromQuaternion(p, q_wxyz, "pose");
}

void put(ByteWriter& out, const std::optional<double>& number) {
  out.number(static_cast<std::uint8_t>(number.has_value()));
  if (number) out.number(*number);
}

std::optional<double> takeOptional(ByteReader& in) {
  if (!in.flag()) return std::nullopt;
  return in.finite();
}

}  // namespace

void put(ByteWriter& out, const io::HandTrajectoryPlan& plan) {
  out.text(plan.name);
  out.text(plan.hand);
  put(out, plan.reach_m);
  put(out, plan.every_s);
  const io::HandTrajectoryFile& file = plan.trajectory;
  out.text(file.object);
  put(out, file.joints);
  out.number(static_cast<std::uint8_t>(file.tells_root));
  out.count(file.frames.size());
  for (const io::HandTrajectoryFile::Frame& frame : file.frames) {
    out.number(frame.time_s);
    put(out, frame.X_WH);
    put(out, frame.X_WO);
    out.numbers(frame.q.data(), file.joints.size());
  }
}

io::HandTrajectoryPlan takeHandTrajectoryPlan(ByteReader& in) {
  io::HandTrajectoryPlan plan;
  plan.name = in.text();
  plan.hand = in.text();
  plan.reach_m = takeOptional(in);
  plan.every_s = takeOptional(in);
  io::HandTrajectoryFile& file = plan.trajectory;
  file.object = in.text();
  file.joints = takeTexts(in);
  file.tells_root = in.flag();
  const std::size_t joints = file.joints.size();
  file.frames.resize(in.count(manipulation::kMostFrames, (15 + joints) * sizeof(double)));
  for (io::HandTrajectoryFile::Frame& frame : file.frames) {
    frame.time_s = in.finite();
    frame.X_WH = takePose(in);
    frame.X_WO = takePose(in);
    frame.q.resize(static_cast<Eigen::Index>(joints));
    in.numbers(frame.q.data(), joints);
    if (!frame.q.allFinite()) rejectInput("a joint of a hand's trajectory is not finite");
  }
  if (file.frames.empty()) rejectInput("a hand's trajectory has no frames");
  return plan;
}

}  // namespace handgraft::server
