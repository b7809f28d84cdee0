#include "core/io/row_writer.h"

#include <cmath>
#include <cstdint>
#include <iterator>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/quoting.h"
#include "core/formats/npz_file.h"
#include "core/io/grasp_writer.h"

namespace handgraft::io {

namespace {

/// As YAML 1.1 reads numbers: without exponents.
std::string yamlNumbers(const Eigen::Ref<const Eigen::VectorXd>& values) {
  std::string text;
  for (Eigen::Index i = 0; i < values.size(); ++i)
    fmt::format_to(std::back_inserter(text), "{}{:.9f}", i == 0 ? "" : ", ", values[i]);
  return text;
}

}  // namespace

std::string numbersOf(const Eigen::Ref<const Eigen::VectorXd>& values, const char* between) {
  std::string text;
  for (Eigen::Index i = 0; i < values.size(); ++i)
    fmt::format_to(std::back_inserter(text), "{}{:.9g}", i == 0 ? "" : between, values[i]);
  return text;
}

std::string npzOf(const TrajectoryRows& rows, const ContactRows& contacts) {
  const auto frames = static_cast<std::size_t>(rows.qpos.cols());
  const std::size_t patches = contacts.patch_names.size();
  HANDGRAFT_REQUIRE(contacts.presence.size() == frames * patches &&
                    contacts.p_W_m.size() == 3 * frames * patches);
  formats::NpzFile file;
  file.add("time", rows.time_s, {frames});
  // Columns one behind the other are rows of what NumPy reads.
  file.add("qpos", {rows.qpos.data(), rows.qpos.data() + rows.qpos.size()},
           {frames, static_cast<std::size_t>(rows.qpos.rows())});
  file.add("qvel", {rows.qvel.data(), rows.qvel.data() + rows.qvel.size()},
           {frames, static_cast<std::size_t>(rows.qvel.rows())});
  file.add("contact", contacts.presence, {frames, patches});
  file.add("contact_pos", contacts.p_W_m, {frames, patches, 3});
  file.add("joint_names", rows.joint_names);
  file.add("patch_names", contacts.patch_names);
  return file.bytes();
}

std::string mjcfOf(const TrajectoryRows& rows,
                   const std::string& title,
                   const std::string& key) {
  std::string text = fmt::format(
      "<mujoco model=\"{}\">\n"
      "  <!-- qpos: the hand's free joint (x y z qw qx qy qz), then {} joints:\n",
      xmlText(title), rows.joint_names.size());
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
                   "    <key name=\"{}_{}\" time=\"{:.9g}\" qpos=\"{}\" qvel=\"{}\"/>\n", key,
                   k, rows.time_s[static_cast<std::size_t>(k)],
                   numbersOf(rows.qpos.col(k), " "), numbersOf(rows.qvel.col(k), " "));
  }
  return text + "  </keyframe>\n</mujoco>\n";
}

std::string rosTrajectoryYaml(const TrajectoryRows& rows) {
  std::string text = "header: {stamp: {sec: 0, nanosec: 0}, frame_id: ''}\njoint_names:\n";
  for (int i = 0; i < rows.independent; ++i)
    text += "- " + yamlName(rows.joint_names[static_cast<std::size_t>(i)]) + "\n";
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
