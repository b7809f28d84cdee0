#include "core/io/urdf_text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <locale>
#include <numbers>
#include <sstream>

#include <tinyxml2.h>

#include "core/base/error.h"
#include "core/hand/joint_numbers.h"

namespace handgraft::io {

namespace {

using tinyxml2::XMLDocument;
using tinyxml2::XMLElement;

std::string attributeOf(const XMLElement* element, const char* attribute) {
  const char* value = element == nullptr ? nullptr : element->Attribute(attribute);
  return value == nullptr ? "" : value;
}

/// The attribute `name` of a link or a joint.
std::string nameOf(const XMLElement& element) {
  const char* kind = element.Name();
  std::string name = attributeOf(&element, "name");
  if (name.empty()) rejectInput("line {}: a {} has no name", element.GetLineNum(), kind);
  if (name.size() > kLongestUrdfName) {
    rejectInput("line {}: the name of a {}, {}, has {} bytes; permitted are {}",
                element.GetLineNum(), kind, handgraft::quoted(name), name.size(),
                kLongestUrdfName);
  }
  return name;
}

template <class Things>
void requireFew(const Things& things, const char* kind) {
  if (std::ssize(things) > kMostUrdfLinks) rejectInput("more than {} {}", kMostUrdfLinks, kind);
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

/// urdfdom says of others neither the link nor what there is.
void requireKnownGeometry(const XMLElement& shape, const std::string& link) {
  const XMLElement* geometry = shape.FirstChildElement("geometry");
  const XMLElement* kind = geometry == nullptr ? nullptr : geometry->FirstChildElement();
  if (kind == nullptr || std::strcmp(kind->Name(), "capsule") != 0) return;
  rejectInput(
      "link {}: line {}: a capsule, which URDF 1.0 does not have; write a cylinder of its "
      "radius and length and a sphere of its radius at each end, or a mesh",
      handgraft::quoted(link), kind->GetLineNum());
}

void copyLink(const XMLElement& link, bool with_shapes, XMLElement& robot, UrdfText& result) {
  const std::string name = nameOf(link);
  result.links.push_back(name);
  requireFew(result.links, "links");

  XMLElement* copy = robot.InsertNewChildElement("link");
  copy->SetAttribute("name", name.c_str());
  for (const XMLElement* shape = link.FirstChildElement(); shape != nullptr;
       shape = shape->NextSiblingElement()) {
    const bool is_shape = std::strcmp(shape->Name(), "visual") == 0 ||
                          std::strcmp(shape->Name(), "collision") == 0;
    if (!is_shape) continue;
    result.solid_links.insert(name);
    if (!with_shapes) continue;
    requireKnownGeometry(*shape, name);
    copyChildren(*shape, *copy->InsertNewChildElement(shape->Name()), {"origin", "geometry"});
  }
}

hand::JointType typeOf(const std::string& type, const std::string& joint) {
  if (type == "fixed") return hand::JointType::kFixed;
  if (type == "revolute" || type == "continuous") return hand::JointType::kRevolute;
  if (type == "prismatic") return hand::JointType::kPrismatic;
  rejectInput(
      "joint {}: there is no type {} (fixed, revolute, continuous, prismatic, planar, "
      "floating)",
      handgraft::quoted(joint), handgraft::quoted(type));
}

/// No joint of a hand goes round more than once.
void noteLimitsInDegrees(const std::string& name, const XMLElement& limit, UrdfText& result) {
  const double lower = limit.DoubleAttribute("lower", 0.0);
  const double upper = limit.DoubleAttribute("upper", 0.0);
  if (std::max(std::abs(lower), std::abs(upper)) <= 2.0 * std::numbers::pi) return;
  result.notes.push_back(
      fmt::format("joint {}: its limits, {} to {} rad, are more than a whole turn; "
                  "unless a motor makes these: URDF's angles are radians, not degrees",
                  handgraft::quoted(name), lower, upper));
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
      result.notes.push_back(fmt::format("joint {}: no limit, taken as {}",
                                         handgraft::quoted(name),
                                         type == "revolute" ? "+-pi" : "unbounded"));
    } else if (!has_lower || !has_upper) {
      result.notes.push_back(fmt::format("joint {}: no {} limit, taken as 0 as URDF has it",
                                         handgraft::quoted(name),
                                         has_lower ? "upper" : "lower"));
    }
  }
  if (type == "revolute") noteLimitsInDegrees(name, *limit, result);
  bool amended = false;
  for (const char* field : {"effort", "velocity"}) {
    if (limit->Attribute(field) != nullptr) continue;
    limit->SetAttribute(field, "0");
    amended = true;
  }
  return amended;
}

void readNumbers(const XMLElement& source, hand::Joint& joint) {
  for (const hand::JointNumber& number : hand::kJointNumbers) {
    if (number.urdf_element == nullptr) continue;
    const XMLElement* element = source.FirstChildElement(number.urdf_element);
    const std::string text = attributeOf(element, number.urdf_attribute);
    if (text.empty()) continue;
    std::istringstream words(text);
    words.imbue(std::locale::classic());
    if (!(words >> joint.*number.value) || !(words >> std::ws).eof())
      rejectInput("joint {}: {} {} is no number", handgraft::quoted(joint.name),
                  number.urdf_attribute, handgraft::quoted(text));
  }
}

// === Joints of several freedoms, as chains of joints of one each

struct Freedom {
  const char* suffix;
  const char* type;
  Eigen::Vector3d axis;
};

Eigen::Vector3d axisOf(const XMLElement& joint, const std::string& name) {
  const XMLElement* axis = joint.FirstChildElement("axis");
  if (axis == nullptr) return Eigen::Vector3d::UnitX();  // as URDF has it
  const std::string text = attributeOf(axis, "xyz");
  Eigen::Vector3d n;
  int end = 0;
  if (std::sscanf(text.c_str(), "%lf %lf %lf %n", &n.x(), &n.y(), &n.z(), &end) != 3 ||
      static_cast<std::size_t>(end) != text.size() || !n.allFinite() || n.norm() < 1e-12)
    rejectInput("joint {}: axis {} is not three numbers with a direction",
                handgraft::quoted(name), handgraft::quoted(text));
  return n.normalized();
}

std::vector<Freedom> freedomsOf(const XMLElement& joint,
                                const std::string& name,
                                const std::string& type) {
  using Eigen::Vector3d;
  if (type == "floating")
    return {{"_x", "prismatic", Vector3d::UnitX()},
            {"_y", "prismatic", Vector3d::UnitY()},
            {"_z", "prismatic", Vector3d::UnitZ()},
            {"_yaw", "continuous", Vector3d::UnitZ()},
            {"_pitch", "continuous", Vector3d::UnitY()},
            {"_roll", "continuous", Vector3d::UnitX()}};
  const Vector3d n = axisOf(joint, name);
  int flattest = 0;
  n.cwiseAbs().minCoeff(&flattest);
  const Vector3d u = Vector3d::Unit(flattest).cross(n).normalized();
  return {{"_x", "prismatic", u}, {"_y", "prismatic", n.cross(u)}, {"_yaw", "continuous", n}};
}

void addFreedom(const std::string& name,
                const Freedom& freedom,
                const std::string& parent,
                const std::string& child,
                const XMLElement* origin,
                XMLElement& robot,
                UrdfText& result) {
  XMLElement* copy = robot.InsertNewChildElement("joint");
  copy->SetAttribute("name", name.c_str());
  copy->SetAttribute("type", freedom.type);
  if (origin != nullptr) copy->InsertEndChild(origin->DeepClone(copy->GetDocument()));
  copy->InsertNewChildElement("parent")->SetAttribute("link", parent.c_str());
  copy->InsertNewChildElement("child")->SetAttribute("link", child.c_str());
  copy->InsertNewChildElement("axis")->SetAttribute(
      "xyz", fmt::format("{:.17g} {:.17g} {:.17g}", freedom.axis.x(), freedom.axis.y(),
                         freedom.axis.z())
                 .c_str());
  XMLElement* limit = copy->InsertNewChildElement("limit");
  limit->SetAttribute("effort", "0");
  limit->SetAttribute("velocity", "0");
  result.unlimited_joints.push_back(name);

  hand::Joint outline;
  outline.name = name;
  outline.type = typeOf(freedom.type, name);
  outline.parent_link = parent;
  outline.child_link = child;
  result.joints.push_back(std::move(outline));
}

void expandJoint(const XMLElement& joint,
                 const hand::Joint& whole,
                 const std::string& type,
                 XMLElement& robot,
                 UrdfText& result) {
  if (joint.FirstChildElement("mimic") != nullptr)
    rejectInput("joint {}: a {} joint cannot mimic another", handgraft::quoted(whole.name),
                type);
  const std::vector<Freedom> freedoms = freedomsOf(joint, whole.name, type);
  std::string parent = whole.parent_link;
  std::string names;
  for (std::size_t i = 0; i < freedoms.size(); ++i) {
    const std::string name = whole.name + freedoms[i].suffix;
    const bool is_last = i + 1 == freedoms.size();
    const std::string child = is_last ? whole.child_link : name;
    if (!is_last) {
      robot.InsertNewChildElement("link")->SetAttribute("name", child.c_str());
      result.links.push_back(child);
    }
    addFreedom(name, freedoms[i], parent, child,
               i == 0 ? joint.FirstChildElement("origin") : nullptr, robot, result);
    names += (i == 0 ? "" : ", ") + handgraft::quoted(name);
    parent = child;
  }
  result.notes.push_back(fmt::format("joint {}: {}, taken as {} without limits",
                                     handgraft::quoted(whole.name), type, names));
}

/// Returns whether the effort or velocity limit had to be amended.
bool copyJoint(const XMLElement& joint, XMLElement& robot, UrdfText& result) {
  hand::Joint outline;
  outline.name = nameOf(joint);
  const std::string type = attributeOf(&joint, "type");
  const bool has_several = type == "planar" || type == "floating";
  if (!has_several) outline.type = typeOf(type, outline.name);
  outline.parent_link = attributeOf(joint.FirstChildElement("parent"), "link");
  outline.child_link = attributeOf(joint.FirstChildElement("child"), "link");
  if (outline.parent_link.empty() || outline.child_link.empty())
    rejectInput("joint {}: it names no {} link", handgraft::quoted(outline.name),
                outline.parent_link.empty() ? "parent" : "child");
  if (has_several) {
    expandJoint(joint, outline, type, robot, result);
    return false;
  }

  XMLElement* copy = robot.InsertNewChildElement("joint");
  copy->SetAttribute("name", outline.name.c_str());
  copy->SetAttribute("type", type.c_str());
  copyChildren(joint, *copy, {"origin", "parent", "child", "axis", "limit"});
  if (outline.type != hand::JointType::kFixed) copyChildren(joint, *copy, {"mimic"});
  const bool amended = amendLimit(outline.name, type, *copy, result);
  if (outline.type != hand::JointType::kFixed) readNumbers(joint, outline);
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
                handgraft::quoted(robot == nullptr ? "missing" : robot->Name()));

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
    if (name == "joint") {
      if (copyJoint(*child, *copy, result)) ++without_effort;
      requireFew(result.links, "links");
      requireFew(result.joints, "joints");
    }
    if (name.starts_with("xacro:"))
      rejectInput("line {}: {} is xacro, not URDF; expand it first: xacro FILE > hand.urdf",
                  child->GetLineNum(), handgraft::quoted(name));
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

std::map<std::string, double> effortLimitsOf(const std::string& urdf_text) {
  std::map<std::string, double> efforts;
  XMLDocument source;
  if (source.Parse(urdf_text.data(), urdf_text.size()) != tinyxml2::XML_SUCCESS ||
      source.RootElement() == nullptr)
    return efforts;
  for (const XMLElement* joint = source.RootElement()->FirstChildElement("joint");
       joint != nullptr; joint = joint->NextSiblingElement("joint")) {
    std::istringstream words(attributeOf(joint->FirstChildElement("limit"), "effort"));
    words.imbue(std::locale::classic());
    double effort = 0.0;
    if (words >> effort && std::isfinite(effort) && effort >= 0.0)
      efforts.emplace(attributeOf(joint, "name"), effort);
  }
  return efforts;
}

}  // namespace handgraft::io
