#include "core/io/urdf_writer.h"

#include <cmath>
#include <map>

#include <Eigen/Geometry>

#include "core/base/error.h"
#include "core/base/quoting.h"
#include "core/hand/joint_numbers.h"

namespace handgraft::io {

namespace {

/// Angles about the fixed axes x, y, z in turn, as URDF has them. The last one is read off what
/// the others leave, so that the three together are right also where x and z turn alike.
Eigen::Vector3d rollPitchYaw(const Eigen::Matrix3d& R) {
  const double roll = std::atan2(R(2, 1), R(2, 2));
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(2, 1), R(2, 2)));
  const double s = std::sin(roll);
  const double c = std::cos(roll);
  const double yaw = std::atan2(s * R(0, 2) - c * R(0, 1), c * R(1, 1) - s * R(1, 2));
  return {roll, pitch, yaw};
}

const char* typeOf(const hand::Joint& joint) {
  switch (joint.type) {
    case hand::JointType::kFixed:
      return "fixed";
    case hand::JointType::kPrismatic:
      return "prismatic";
    case hand::JointType::kRevolute:
      return std::isfinite(joint.lower) && std::isfinite(joint.upper) ? "revolute"
                                                                      : "continuous";
  }
  throw BrokenContract("a joint type that does not exist");
}

/// The attributes of each element that says numbers of a joint, <limit> among them.
std::map<std::string, std::string> numberElements(const hand::Joint& joint, double effort) {
  std::map<std::string, std::string> attributes;
  const bool is_limited = std::isfinite(joint.lower) && std::isfinite(joint.upper);
  // A slider without a range is one without a limit.
  if (is_limited || joint.type == hand::JointType::kRevolute) {
    attributes["limit"] =
        is_limited ? fmt::format(" lower=\"{}\" upper=\"{}\"", joint.lower, joint.upper) : "";
  }
  for (const hand::JointNumber& number : hand::kJointNumbers) {
    if (number.urdf_element == nullptr) continue;
    if (number.urdf_element == std::string_view("limit") && !attributes.contains("limit"))
      continue;
    attributes[number.urdf_element] +=
        fmt::format(" {}=\"{}\"", number.urdf_attribute, joint.*number.value);
  }
  if (const auto limit = attributes.find("limit"); limit != attributes.end())
    limit->second += fmt::format(" effort=\"{}\"", effort);
  return attributes;
}

std::string jointText(const hand::Joint& joint, double effort) {
  const Eigen::Vector3d p = joint.X_PJ.translation();
  const Eigen::Vector3d rpy = rollPitchYaw(joint.X_PJ.linear());
  std::string out = fmt::format(
      "  <joint name=\"{}\" type=\"{}\">\n    <parent link=\"{}\"/>\n    <child link=\"{}\"/>\n"
      "    <origin xyz=\"{} {} {}\" rpy=\"{} {} {}\"/>\n",
      xmlText(joint.name), typeOf(joint), xmlText(joint.parent_link), xmlText(joint.child_link),
      p.x(), p.y(), p.z(), rpy.x(), rpy.y(), rpy.z());
  if (joint.type != hand::JointType::kFixed) {
    out += fmt::format("    <axis xyz=\"{} {} {}\"/>\n", joint.axis_J.x(), joint.axis_J.y(),
                       joint.axis_J.z());
    for (const auto& [element, attributes] : numberElements(joint, effort))
      out += fmt::format("    <{}{}/>\n", element, attributes);
  }
  if (joint.mimic) {
    out += fmt::format("    <mimic joint=\"{}\" multiplier=\"{}\" offset=\"{}\"/>\n",
                       xmlText(joint.mimic->source_joint), joint.mimic->multiplier,
                       joint.mimic->offset);
  }
  return out + "  </joint>\n";
}

}  // namespace

std::string kinematicUrdfText(const hand::HandModel& model,
                              const std::string& comment,
                              const std::map<std::string, double>& efforts) {
  HANDGRAFT_REQUIRE(comment.find("--") == std::string::npos);
  const auto effort_of = [&](const hand::Joint& joint) {
    const auto told = efforts.find(joint.name);
    return told == efforts.end() ? 0.0 : told->second;
  };
  std::string out = fmt::format("<?xml version=\"1.0\"?>\n<!-- {} -->\n<robot name=\"{}\">\n",
                                comment, xmlText(model.name()));
  for (const hand::Link& link : model.links())
    out += fmt::format("  <link name=\"{}\"/>\n", xmlText(link.name));
  for (const hand::Joint& joint : model.joints())
    out += jointText(joint, effort_of(joint));
  return out + "</robot>\n";
}

}  // namespace handgraft::io
