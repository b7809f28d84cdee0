#include "core/io/trajectory_writer.h"

#include <algorithm>
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

/// The middle of a patch in W, and how much of it is there.
struct PatchAt {
  double presence = 0.0;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
};

std::vector<PatchAt> patchesAt(const HandTrajectory& trajectory,
                               const retargeting::MotionFits& fits,
                               std::size_t patch_count,
                               int frame) {
  std::vector<PatchAt> patches(patch_count);
  const manipulation::Motion& motion = *trajectory.contacts;
  for (const retargeting::PatchFrameFit& fit : fits.at(frame)) {
    PatchAt& patch = patches[static_cast<std::size_t>(fit.patch)];
    if (patch.presence >= fit.presence) continue;  // the same patch, on its way out
    const manipulation::PatchTrack& track = motion.tracks[static_cast<std::size_t>(fit.track)];
    const contact::Patch& shape =
        track.keyAt(std::clamp(frame, track.begin(), track.end - 1)).patch;
    patch.presence = fit.presence;
    patch.p_W = motion.X_WO[static_cast<std::size_t>(frame)] *
                positionOf(*trajectory.object_O, shape.root);
  }
  return patches;
}

}  // namespace

std::string trajectoryJson(const HandTrajectory& trajectory) {
  const TrajectoryRows rows = rowsOf(trajectory);
  const retargeting::MotionFits fits(*trajectory.contacts, *trajectory.solved);
  const auto joints = static_cast<Eigen::Index>(rows.joint_names.size());
  json document = {{"format", kTrajectoryFormat},
                   {"hand", trajectory.hand},
                   {"object", trajectory.object},
                   {"motion", trajectory.motion},
                   {"joint_names", rows.joint_names},
                   {"patches", retargeting::patchNames(*trajectory.contacts)},
                   {"notes", trajectory.solved->notes}};
  json frames = json::array();
  for (Eigen::Index k = 0; k < rows.qpos.cols(); ++k) {
    const auto at = static_cast<std::size_t>(k);
    json patches = json::array();
    for (const retargeting::PatchFrameFit& fit : fits.at(static_cast<int>(k))) {
      patches.push_back({{"patch", fit.patch},
                         {"presence", fit.presence},
                         {"mean_mm", fit.mean_mm},
                         {"normal_deg", fit.normal_deg},
                         {"reached", fit.reached}});
    }
    const Eigen::VectorXd q = rows.qpos.col(k).segment(7, joints);
    frames.push_back({{"time_s", rows.time_s[at]},
                      {"X_WH", poseJson(rows.qpos.col(k).head(7))},
                      {"X_WO", poseJson(rows.qpos.col(k).tail(7))},
                      {"joints", std::vector<double>(q.data(), q.data() + q.size())},
                      {"max_depth_m", trajectory.solved->depths[at].object_m},
                      {"self_depth_m", trajectory.solved->depths[at].self_m},
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
    fmt::format_to(
        std::back_inserter(text), "{:.9g},{},{},{},{:.6g},{:.6g}\n", rows.time_s[at],
        numbersOf(rows.qpos.col(k).segment(7, joints), ","),
        numbersOf(rows.qpos.col(k).head(7), ","), numbersOf(rows.qpos.col(k).tail(7), ","),
        trajectory.solved->depths[at].object_m, trajectory.solved->depths[at].self_m);
  }
  return text;
}

std::string trajectoryNpz(const HandTrajectory& trajectory) {
  const TrajectoryRows rows = rowsOf(trajectory);
  const retargeting::MotionFits fits(*trajectory.contacts, *trajectory.solved);
  ContactRows contacts;
  contacts.patch_names = retargeting::patchNames(*trajectory.contacts);
  const std::size_t patches = contacts.patch_names.size();
  for (int k = 0; k < static_cast<int>(rows.qpos.cols()); ++k) {
    for (const PatchAt& patch : patchesAt(trajectory, fits, patches, k)) {
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
