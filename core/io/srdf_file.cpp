#include "core/io/srdf_file.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>

#include <tinyxml2.h>

#include "core/base/error.h"
#include "core/io/file_bytes.h"

namespace handgraft::io {

namespace {

using tinyxml2::XMLDocument;
using tinyxml2::XMLElement;

std::string attributeOf(const XMLElement& element, const char* attribute) {
  const char* value = element.Attribute(attribute);
  return value == nullptr ? "" : value;
}

double valueOf(const XMLElement& joint, const std::string& state, const std::string& name) {
  const std::string text = attributeOf(joint, "value");
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || end != text.c_str() + text.size() || !std::isfinite(value))
    rejectInput("state {}: joint {}: value {} is not one finite number", quoted(state),
                quoted(name), quoted(text));
  return value;
}

class StateReader {
 public:
  StateReader(const hand::HandModel& model, std::vector<std::string>& notes)
      : model_(model), notes_(notes) {
    const std::vector<std::string> names = model.dofNames();
    for (std::size_t i = 0; i < names.size(); ++i)
      dofs_.emplace(names[i], static_cast<int>(i));
  }

  hand::NamedPose read(const XMLElement& state, const std::string& name) {
    hand::NamedPose pose{name, model_.restPose()};
    for (const XMLElement* joint = state.FirstChildElement("joint"); joint != nullptr;
         joint = joint->NextSiblingElement("joint")) {
      const std::string joint_name = attributeOf(*joint, "name");
      const auto found = dofs_.find(joint_name);
      if (found == dofs_.end()) {
        unknown_.insert(joint_name);
        continue;
      }
      const double value = valueOf(*joint, name, joint_name);
      const double kept =
          std::clamp(value, model_.lower()[found->second], model_.upper()[found->second]);
      if (kept != value)
        notes_.push_back(fmt::format("state {}: joint {}: {} moved to its limit {}",
                                     quoted(name), quoted(joint_name), value, kept));
      pose.q[found->second] = kept;
    }
    return pose;
  }

  /// Joints of the file that the hand lacks, or that follow others.
  [[nodiscard]] const std::set<std::string>& unknown() const { return unknown_; }

 private:
  const hand::HandModel& model_;
  std::vector<std::string>& notes_;
  std::map<std::string, int> dofs_;
  std::set<std::string> unknown_;
};

SrdfFile parse(const std::string& text, const hand::HandModel& model) {
  XMLDocument document;
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
    rejectInput("not well-formed XML: line {}: {}", document.ErrorLineNum(),
                XMLDocument::ErrorIDToName(document.ErrorID()));
  const XMLElement* robot = document.RootElement();
  if (robot == nullptr || std::string(robot->Name()) != "robot")
    rejectInput("not an SRDF: its outermost element is {}, not 'robot'",
                quoted(robot == nullptr ? "missing" : robot->Name()));

  std::vector<const XMLElement*> states;
  std::map<std::string, int> uses;
  for (const XMLElement* state = robot->FirstChildElement("group_state"); state != nullptr;
       state = state->NextSiblingElement("group_state")) {
    if (states.size() >= static_cast<std::size_t>(kMostNamedPoses))
      rejectInput("more than {} states", kMostNamedPoses);
    const std::string name = attributeOf(*state, "name");
    if (name.empty()) rejectInput("line {}: a group_state has no name", state->GetLineNum());
    ++uses[name];
    states.push_back(state);
  }

  SrdfFile file;
  StateReader reader(model, file.notes);
  for (const XMLElement* state : states) {
    const std::string name = attributeOf(*state, "name");
    const std::string group = attributeOf(*state, "group");
    file.poses.push_back(
        reader.read(*state, uses[name] > 1 ? fmt::format("{}/{}", group, name) : name));
  }
  if (states.empty()) file.notes.emplace_back("the SRDF has no group_state, so no named pose");
  if (!reader.unknown().empty())
    file.notes.push_back(fmt::format(
        "{} joint{} of the states are no joints of the hand: {}", reader.unknown().size(),
        reader.unknown().size() == 1 ? "" : "s", fmt::join(reader.unknown(), ", ")));
  return file;
}

}  // namespace

SrdfFile readSrdf(const std::filesystem::path& path, const hand::HandModel& model) {
  constexpr std::uintmax_t kMostBytes = 4U << 20U;  // an element of 4 bytes takes 120, parsed
  if (const std::uintmax_t size = requireFile(path); size > kMostBytes)
    rejectInput("{}: {} bytes; permitted are {}", handgraft::quoted(path.string()), size,
                kMostBytes);
  const std::string text = readFileBytes(path);
  try {
    return parse(text, model);
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", handgraft::quoted(path.string()), error.what());
  }
}

}  // namespace handgraft::io
