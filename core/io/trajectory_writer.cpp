#include "core/io/trajectory_writer.h"

#include <iterator>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/quoting.h"
#include "core/io/hand_trajectory_file.h"
#include "core/io/row_writer.h"
#include "core/io/trajectory_rows.h"

namespace handgraft::io {

namespace {

using nlohmann::json;

json poseJson(const Eigen::Ref<const Eigen::VectorXd>& free_joint) {
  return {{"p_m", {free_joint[0], free_joint[1], free_joint[2]}},
          {"q_wxyz", {free_joint[3], free_joint[4], free_joint[5], free_joint[6]}}};
}

}  // namespace

std::string trajectoryJson(const HandTrajectory& trajectory) {
  const TrajectoryRows rows = rowsOf(trajectory);
  const auto joints = static_cast<Eigen::Index>(rows.joint_names.size());
  json document = {{"format", kTrajectoryFormat},     {"hand", trajectory.hand},
                   {"object", trajectory.object},     {"motion", trajectory.motion},
                   {"joint_names", rows.joint_names}, {"patches", trajectory.patch_names},
                   {"notes", trajectory.notes}};
  json frames = json::array();
  for (Eigen::Index k = 0; k < rows.qpos.cols(); ++k) {
    const auto at = static_cast<std::size_t>(k);
    json patches = json::array();
    const TrajectoryFrame& frame = trajectory.frames[at];
    for (const TrajectoryPatch& patch : frame.patches) {
      patches.push_back({{"patch", patch.patch},
                         {"presence", patch.presence},
                         {"mean_mm", patch.mean_mm},
                         {"normal_deg", patch.normal_deg},
                         {"reached", patch.reached}});
    }
    const Eigen::VectorXd q = rows.qpos.col(k).segment(7, joints);
    frames.push_back({{"time_s", rows.time_s[at]},
                      {"X_WH", poseJson(rows.qpos.col(k).head(7))},
                      {"X_WO", poseJson(rows.qpos.col(k).tail(7))},
                      {"joints", std::vector<double>(q.data(), q.data() + q.size())},
                      {"max_depth_m", frame.depths.object_m},
                      {"self_depth_m", frame.depths.self_m},
                      {"patches", std::move(patches)}});
  }
  document["frames"] = std::move(frames);
  return document.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

std::string trajectoryCsv(const HandTrajectory& trajectory) {
  const TrajectoryRows rows = rowsOf(trajectory);
  const auto joints = static_cast<Eigen::Index>(rows.joint_names.size());
  std::string text = "time_s";
  for (const std::string& name : rows.joint_names)
    text += "," + csvCell(name);
  for (const char* pose : {"X_WH", "X_WO"})
    for (const char* entry : {"x", "y", "z", "qw", "qx", "qy", "qz"})
      text += fmt::format(",{}.{}", pose, entry);
  text += ",max_depth_m,self_depth_m\n";
  for (Eigen::Index k = 0; k < rows.qpos.cols(); ++k) {
    const auto at = static_cast<std::size_t>(k);
    fmt::format_to(std::back_inserter(text), "{:.9g},{},{},{},{:.6g},{:.6g}\n", rows.time_s[at],
                   numbersOf(rows.qpos.col(k).segment(7, joints), ","),
                   numbersOf(rows.qpos.col(k).head(7), ","),
                   numbersOf(rows.qpos.col(k).tail(7), ","),
                   trajectory.frames[at].depths.object_m, trajectory.frames[at].depths.self_m);
  }
  return text;
}

std::string trajectoryNpz(const HandTrajectory& trajectory) {
  const TrajectoryRows rows = rowsOf(trajectory);
  ContactRows contacts;
  contacts.patch_names = trajectory.patch_names;
  const std::size_t patches = contacts.patch_names.size();
  for (const TrajectoryFrame& frame : trajectory.frames) {
    std::vector<TrajectoryPatch> row(patches);
    for (TrajectoryPatch& patch : row)
      patch.presence = 0.0;
    for (const TrajectoryPatch& patch : frame.patches) {
      TrajectoryPatch& most = row.at(static_cast<std::size_t>(patch.patch));
      if (patch.presence > most.presence) most = patch;
    }
    for (const TrajectoryPatch& patch : row) {
      contacts.presence.push_back(patch.presence);
      contacts.p_W_m.insert(contacts.p_W_m.end(), patch.p_W.data(), patch.p_W.data() + 3);
    }
  }
  return npzOf(rows, contacts);
}

std::string trajectoryMjcf(const HandTrajectory& trajectory) {
  return mjcfOf(rowsOf(trajectory),
                fmt::format("{} follows {}", trajectory.hand, trajectory.motion), "frame");
}

std::string rosTrajectoryYaml(const HandTrajectory& trajectory) {
  return rosTrajectoryYaml(rowsOf(trajectory));
}

}  // namespace handgraft::io
