#include "core/io/urdf_text.h"

#include <cstring>

#include <tinyxml2.h>

#include "core/base/error.h"

namespace handgraft::io {

namespace {

using tinyxml2::XMLDocument;
using tinyxml2::XMLElement;

std::string attributeOf(const XMLElement* element, const char* attribute) {
  const char* value = element == nullptr ? nullptr : element->Attribute(attribute);
  return value == nullptr ? "" : value;
}

/// Copies the children called one of `names`, whole, under `to`.
void copyChildren(const XMLElement& from,
                  XMLElement& to,
                  std::initializer_list<const char*> names) {
  for (const XMLElement* child = from.FirstChildElement(); child != nullptr;
       child = child->NextSiblingElement()) {
    for (const char* name : names)
      if (std::strcmp(child->Name(), name) == 0)
        to.InsertEndChild(child->DeepClone(to.GetDocument()));
  }
}

void copyLink(const XMLElement& link, bool with_shapes, XMLElement& robot, UrdfText& result) {
  const std::string name = attributeOf(&link, "name");
  if (name.empty()) rejectInput("line {}: a link has no name", link.GetLineNum());
  if (result.links.size() >= static_cast<std::size_t>(kMostUrdfLinks))
    rejectInput("more than {} links", kMostUrdfLinks);
  result.links.push_back(name);

  XMLElement* copy = robot.InsertNewChildElement("link");
  copy->SetAttribute("name", name.c_str());
  if (!with_shapes) return;
  for (const XMLElement* shape = link.FirstChildElement(); shape != nullptr;
       shape = shape->NextSiblingElement()) {
    const bool is_shape = std::strcmp(shape->Name(), "visual") == 0 ||
                          std::strcmp(shape->Name(), "collision") == 0;
    if (!is_shape) continue;
    copyChildren(*shape, *copy->InsertNewChildElement(shape->Name()), {"origin", "geometry"});
  }
}

hand::JointType typeOf(const std::string& type, const std::string& joint) {
  if (type == "fixed") return hand::JointType::kFixed;
  if (type == "revolute" || type == "continuous") return hand::JointType::kRevolute;
  if (type == "prismatic") return hand::JointType::kPrismatic;
  rejectInput("joint {}: type {} is not supported (fixed, revolute, continuous, prismatic)",
              quoted(joint), quoted(type));
}

/// Gives urdfdom the limit that it insists on. Returns whether effort or velocity were missing.
bool amendLimit(const std::string& name,
                const std::string& type,
                XMLElement& joint,
                UrdfText& result) {
  if (type == "fixed") return false;
  XMLElement* limit = joint.FirstChildElement("limit");
  const bool ranged = type == "revolute" || type == "prismatic";
  if (limit == nullptr) {
    if (!ranged) return false;
    limit = joint.InsertNewChildElement("limit");
  }
  if (ranged) {
    const bool has_lower = limit->Attribute("lower") != nullptr;
    const bool has_upper = limit->Attribute("upper") != nullptr;
    if (!has_lower && !has_upper) {
      result.unlimited_joints.push_back(name);
      result.notes.push_back(fmt::format("joint {}: no limit, taken as {}", quoted(name),
                                         type == "revolute" ? "+-pi" : "unbounded"));
    } else if (!has_lower || !has_upper) {
      result.notes.push_back(fmt::format("joint {}: no {} limit, taken as 0 as URDF has it",
                                         quoted(name), has_lower ? "upper" : "lower"));
    }
  }
  bool amended = false;
  for (const char* field : {"effort", "velocity"}) {
    if (limit->Attribute(field) != nullptr) continue;
    limit->SetAttribute(field, "0");
    amended = true;
  }
  return amended;
}

/// Returns whether the effort or velocity limit had to be amended.
bool copyJoint(const XMLElement& joint, XMLElement& robot, UrdfText& result) {
  hand::Joint outline;
  outline.name = attributeOf(&joint, "name");
  if (outline.name.empty()) rejectInput("line {}: a joint has no name", joint.GetLineNum());
  const std::string type = attributeOf(&joint, "type");
  outline.type = typeOf(type, outline.name);
  outline.parent_link = attributeOf(joint.FirstChildElement("parent"), "link");
  outline.child_link = attributeOf(joint.FirstChildElement("child"), "link");
  if (outline.parent_link.empty() || outline.child_link.empty())
    rejectInput("joint {}: it names no {} link", quoted(outline.name),
                outline.parent_link.empty() ? "parent" : "child");

  XMLElement* copy = robot.InsertNewChildElement("joint");
  copy->SetAttribute("name", outline.name.c_str());
  copy->SetAttribute("type", type.c_str());
  copyChildren(joint, *copy, {"origin", "parent", "child", "axis", "limit"});
  if (outline.type != hand::JointType::kFixed) copyChildren(joint, *copy, {"mimic"});
  const bool amended = amendLimit(outline.name, type, *copy, result);
  result.joints.push_back(std::move(outline));
  return amended;
}

}  // namespace

UrdfText prepareUrdf(const std::string& text, bool with_shapes) {
  XMLDocument source;
  if (source.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
    rejectInput("not well-formed XML: line {}: {}", source.ErrorLineNum(),
                XMLDocument::ErrorIDToName(source.ErrorID()));
  const XMLElement* robot = source.RootElement();
  if (robot == nullptr || std::strcmp(robot->Name(), "robot") != 0)
    rejectInput("not a URDF: its outermost element is {}, not 'robot'",
                quoted(robot == nullptr ? "missing" : robot->Name()));

  UrdfText result;
  result.robot_name = attributeOf(robot, "name");
  XMLDocument reduced;
  XMLElement* copy = reduced.NewElement("robot");
  reduced.InsertEndChild(copy);
  copy->SetAttribute("name", result.robot_name.empty() ? "hand" : result.robot_name.c_str());

  int without_effort = 0;
  for (const XMLElement* child = robot->FirstChildElement(); child != nullptr;
       child = child->NextSiblingElement()) {
    const std::string name = child->Name();
    if (name == "link") copyLink(*child, with_shapes, *copy, result);
    if (name == "joint" && copyJoint(*child, *copy, result)) ++without_effort;
    if (name.starts_with("xacro:"))
      rejectInput("line {}: <{}> is xacro, not URDF; expand the file first",
                  child->GetLineNum(), name);
  }
  if (result.links.empty()) rejectInput("it has no links");
  if (without_effort > 0)
    result.notes.push_back(fmt::format("{} joint{} without effort or velocity limit",
                                       without_effort, without_effort == 1 ? "" : "s"));

  tinyxml2::XMLPrinter printer(nullptr, true);
  reduced.Print(&printer);
  result.xml = printer.CStr();
  return result;
}

}  // namespace handgraft::io
