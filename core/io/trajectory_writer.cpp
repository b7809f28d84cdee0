#include "core/io/trajectory_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/formats/npz_file.h"
#include "core/io/hand_trajectory_file.h"
#include "core/io/trajectory_rows.h"

namespace handgraft::io {

namespace {

using nlohmann::json;

/// RFC 4180: names with commas, quotes or line ends are quoted.
std::string csvCell(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string cell = "\"";
  for (const char c : name) {
    if (c == '"') cell += '"';
    cell += c;
  }
  return cell + "\"";
}

/// Text inside an attribute or a quoted YAML scalar of names that files may have.
std::string xmlText(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
  }
  return escaped;
}

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

std::string numbersOf(const Eigen::Ref<const Eigen::VectorXd>& values, const char* between) {
  std::string text;
  for (Eigen::Index i = 0; i < values.size(); ++i)
    fmt::format_to(std::back_inserter(text), "{}{:.9g}", i == 0 ? "" : between, values[i]);
  return text;
}

/// As YAML 1.1 reads numbers: without exponents.
std::string yamlNumbers(const Eigen::Ref<const Eigen::VectorXd>& values) {
  std::string text;
  for (Eigen::Index i = 0; i < values.size(); ++i)
    fmt::format_to(std::back_inserter(text), "{}{:.9f}", i == 0 ? "" : ", ", values[i]);
  return text;
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
  const std::vector<std::string> names = retargeting::patchNames(*trajectory.contacts);
  const retargeting::MotionFits fits(*trajectory.contacts, *trajectory.solved);
  const auto frames = static_cast<std::size_t>(rows.qpos.cols());
  const auto patches = names.size();
  std::vector<double> contact;
  std::vector<double> contact_pos;
  for (std::size_t k = 0; k < frames; ++k) {
    for (const PatchAt& patch : patchesAt(trajectory, fits, patches, static_cast<int>(k))) {
      contact.push_back(patch.presence);
      contact_pos.insert(contact_pos.end(), patch.p_W.data(), patch.p_W.data() + 3);
    }
  }
  formats::NpzFile file;
  file.add("time", rows.time_s, {frames});
  // Columns one behind the other are rows of what NumPy reads.
  file.add("qpos", {rows.qpos.data(), rows.qpos.data() + rows.qpos.size()},
           {frames, static_cast<std::size_t>(rows.qpos.rows())});
  file.add("qvel", {rows.qvel.data(), rows.qvel.data() + rows.qvel.size()},
           {frames, static_cast<std::size_t>(rows.qvel.rows())});
  file.add("contact", contact, {frames, patches});
  file.add("contact_pos", contact_pos, {frames, patches, 3});
  file.add("joint_names", rows.joint_names);
  file.add("patch_names", names);
  return file.bytes();
}

std::string trajectoryMjcf(const HandTrajectory& trajectory) {
  const TrajectoryRows rows = rowsOf(trajectory);
  std::string text = fmt::format(
      "<mujoco model=\"{} follows {}\">\n"
      "  <!-- qpos: the hand's free joint (x y z qw qx qy qz), then {} joints:\n",
      xmlText(trajectory.hand), xmlText(trajectory.motion), rows.joint_names.size());
  for (const std::string& name : rows.joint_names) {
    std::string word = xmlText(name);
    // A comment must not hold two dashes.
    for (std::size_t at = word.find("--"); at != std::string::npos; at = word.find("--"))
      word.replace(at, 2, "- ");
    text += "       " + word + "\n";
  }
  text += "       then the object's free joint. Times are s. -->\n  <keyframe>\n";
  for (Eigen::Index k = 0; k < rows.qpos.cols(); ++k) {
    fmt::format_to(std::back_inserter(text),
                   "    <key name=\"frame_{}\" time=\"{:.9g}\" qpos=\"{}\" qvel=\"{}\"/>\n", k,
                   rows.time_s[static_cast<std::size_t>(k)], numbersOf(rows.qpos.col(k), " "),
                   numbersOf(rows.qvel.col(k), " "));
  }
  return text + "  </keyframe>\n</mujoco>\n";
}

std::string rosTrajectoryYaml(const HandTrajectory& trajectory) {
  const TrajectoryRows rows = rowsOf(trajectory);
  std::string text = "header: {stamp: {sec: 0, nanosec: 0}, frame_id: ''}\njoint_names:\n";
  for (int i = 0; i < rows.independent; ++i) {
    text += "- " +
            json(rows.joint_names[static_cast<std::size_t>(i)])
                .dump(-1, ' ', false, json::error_handler_t::replace) +
            "\n";
  }
  text += "points:\n";
  constexpr double kNanoseconds = 1e9;
  for (Eigen::Index k = 0; k < rows.qpos.cols(); ++k) {
    const auto ns = static_cast<std::int64_t>(
        std::llround(rows.time_s[static_cast<std::size_t>(k)] * kNanoseconds));
    fmt::format_to(std::back_inserter(text),
                   "- positions: [{}]\n  velocities: [{}]\n"
                   "  time_from_start: {{sec: {}, nanosec: {}}}\n",
                   yamlNumbers(rows.qpos.col(k).segment(7, rows.independent)),
                   yamlNumbers(rows.qvel.col(k).segment(6, rows.independent)),
                   ns / static_cast<std::int64_t>(kNanoseconds),
                   ns % static_cast<std::int64_t>(kNanoseconds));
  }
  return text;
}

}  // namespace handgraft::io
