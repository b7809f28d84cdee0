#include "tests/bench/motions/mjcf_hand.h"

#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <tinyxml2.h>

#include "core/base/error.h"
#include "core/io/mesh_file.h"

namespace handgraft::bench {

namespace {

using tinyxml2::XMLElement;

/// What a class of joints, and of shapes, says.
struct JointClass {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitY();  // of the outermost class
  double lower = 0.0;
  double upper = 0.0;
  std::string mesh;
};

std::vector<double> numbersOf(const char* text) {
  std::istringstream words(text == nullptr ? "" : text);
  std::vector<double> numbers;
  for (double number = 0.0; words >> number;)
    numbers.push_back(number);
  return numbers;
}

void readClasses(const XMLElement& element,
                 JointClass inherited,
                 std::map<std::string, JointClass>& classes) {
  if (const XMLElement* joint = element.FirstChildElement("joint")) {
    if (const auto axis = numbersOf(joint->Attribute("axis")); axis.size() == 3)
      inherited.axis = {axis[0], axis[1], axis[2]};
    if (const auto range = numbersOf(joint->Attribute("range")); range.size() == 2) {
      inherited.lower = range[0];
      inherited.upper = range[1];
    }
  }
  if (const XMLElement* geom = element.FirstChildElement("geom"))
    if (const char* mesh = geom->Attribute("mesh")) inherited.mesh = mesh;
  if (const char* name = element.Attribute("class")) classes[name] = inherited;
  for (const XMLElement* child = element.FirstChildElement("default"); child != nullptr;
       child = child->NextSiblingElement("default"))
    readClasses(*child, inherited, classes);
}

/// Reads one tree of bodies into links and joints.
class BodyReader {
 public:
  BodyReader(std::map<std::string, JointClass> classes, std::filesystem::path meshes)
      : classes_(std::move(classes)), meshes_(std::move(meshes)) {}

  /// Shapes stand where their `pos` says; ball joints are three hinges about x, y and z, in
  /// this order, with these ranges.
  static BodyReader ofBalls(std::filesystem::path meshes, Eigen::Matrix2Xd ranges) {
    BodyReader reader({}, std::move(meshes));
    reader.has_balls_ = true;
    reader.ranges_ = std::move(ranges);
    return reader;
  }

  void read(const XMLElement& body, const std::string& parent) {
    const std::string name = body.Attribute("name");
    if (!parent.empty() && has_balls_) {
      addBall(body, name, parent);
    } else if (!parent.empty()) {
      joints.push_back(jointOf(body, name, parent));
    }
    links.push_back({name, shapesOf(body), {}});
    for (const XMLElement* child = body.FirstChildElement("body"); child != nullptr;
         child = child->NextSiblingElement("body"))
      read(*child, name);
  }

  std::vector<hand::Link> links;
  std::vector<hand::Joint> joints;

 private:
  hand::Joint jointOf(const XMLElement& body,
                      const std::string& name,
                      const std::string& parent) {
    hand::Joint joint;
    joint.name = name + "_fixed";
    joint.parent_link = parent;
    joint.child_link = name;
    if (const auto p = numbersOf(body.Attribute("pos")); p.size() == 3)
      joint.X_PJ.translation() = Eigen::Vector3d(p[0], p[1], p[2]);
    if (const auto q = numbersOf(body.Attribute("quat")); q.size() == 4)
      joint.X_PJ.linear() =
          Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
    if (const XMLElement* hinge = body.FirstChildElement("joint")) {
      const JointClass& own = classes_.at(hinge->Attribute("class"));
      joint.name = hinge->Attribute("name");
      joint.type = hand::JointType::kRevolute;
      joint.axis_J = own.axis;
      joint.lower = own.lower;
      joint.upper = own.upper;
    }
    return joint;
  }

  void addBall(const XMLElement& body, const std::string& name, const std::string& parent) {
    const XMLElement* ball = body.FirstChildElement("joint");
    if (ball == nullptr || ball->Attribute("name") == nullptr)
      rejectInput("body {}: has no joint with a name", quoted(name));
    hand::Joint joint;
    joint.type = hand::JointType::kRevolute;
    joint.parent_link = parent;
    if (const auto p = numbersOf(body.Attribute("pos")); p.size() == 3)
      joint.X_PJ.translation() = Eigen::Vector3d(p[0], p[1], p[2]);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Index dof = hinges_++;
      if (dof >= ranges_.cols())
        rejectInput("body {}: is one more than there are ranges", quoted(name));
      joint.lower = ranges_(0, dof);
      joint.upper = ranges_(1, dof);
      const std::string letter(1, "xyz"[axis]);
      joint.name = ball->Attribute("name") + ("_" + letter);
      joint.child_link = axis == 2 ? name : name + "_" + letter;
      joint.axis_J = Eigen::Vector3d::Unit(axis);
      if (axis != 2) links.push_back({joint.child_link, {}, {}});
      joints.push_back(joint);
      joint.parent_link = joint.child_link;
      joint.X_PJ = Pose::Identity();
    }
  }

  std::vector<hand::Shape> shapesOf(const XMLElement& body) {
    std::vector<hand::Shape> shapes;
    for (const XMLElement* geom = body.FirstChildElement("geom"); geom != nullptr;
         geom = geom->NextSiblingElement("geom")) {
      const std::string kind = geom->Attribute("class") ? geom->Attribute("class") : "";
      if (kind.find("visual") == std::string::npos) continue;
      std::string mesh = geom->Attribute("mesh") ? geom->Attribute("mesh") : "";
      if (mesh.empty()) mesh = classes_.at(kind).mesh;
      if (mesh.find("_tip") != std::string::npos) mesh = "link_tip";
      const auto path = meshes_ / (mesh + ".obj");
      if (!std::filesystem::exists(path)) continue;
      shapes.push_back({io::readMesh(path).mesh, mesh});
      const auto p = numbersOf(geom->Attribute("pos"));
      if (!has_balls_ || p.size() != 3) continue;
      shapes.back().mesh_L = geometry::transformed(
          shapes.back().mesh_L,
          Eigen::Affine3d(Eigen::Translation3d(Eigen::Vector3d(p[0], p[1], p[2]))));
    }
    return shapes;
  }

  std::map<std::string, JointClass> classes_;
  std::filesystem::path meshes_;
  bool has_balls_ = false;
  Eigen::Matrix2Xd ranges_;  ///< of hinges, lower and upper
  Eigen::Index hinges_ = 0;
};

}  // namespace

hand::HandModel readAllegroMjcf(const std::filesystem::path& folder,
                                const std::filesystem::path& meshes) {
  const auto load = [](const std::filesystem::path& path, tinyxml2::XMLDocument& document) {
    if (document.LoadFile(path.string().c_str()) != tinyxml2::XML_SUCCESS)
      rejectInput("{}: cannot be read as XML", path.string());
  };
  tinyxml2::XMLDocument defaults;
  load(folder / "allegro_right_hand_template.mjcf.xml", defaults);
  std::map<std::string, JointClass> classes;
  readClasses(*defaults.RootElement()->FirstChildElement("default"), {}, classes);
  tinyxml2::XMLDocument bodies;
  load(folder / "allegro_right_hand_body.mjcf.xml", bodies);
  const XMLElement* root = bodies.RootElement()->FirstChildElement("body");
  if (root == nullptr) rejectInput("{}: has no body", folder.string());
  BodyReader reader(std::move(classes), meshes);
  reader.read(*root, "");
  return {"allegro_of_sequences", std::move(reader.links), std::move(reader.joints)};
}

hand::HandModel readManoMjcf(const std::filesystem::path& folder,
                             const Eigen::Matrix2Xd& ranges) {
  const auto path = folder / "MANO_right_hand_body.mjcf.xml";
  tinyxml2::XMLDocument bodies;
  if (bodies.LoadFile(path.string().c_str()) != tinyxml2::XML_SUCCESS)
    rejectInput("{}: cannot be read as XML", path.string());
  const XMLElement* root = bodies.RootElement()->FirstChildElement("body");
  if (root == nullptr) rejectInput("{}: has no body", path.string());
  BodyReader reader = BodyReader::ofBalls(folder / "MANO_assets", ranges);
  reader.read(*root, "");
  return {"mano_of_sequences", std::move(reader.links), std::move(reader.joints)};
}

}  // namespace handgraft::bench
