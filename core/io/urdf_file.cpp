#include "core/io/urdf_file.h"

#include <cmath>
#include <fstream>
#include <map>
#include <mutex>
#include <numbers>
#include <set>
#include <sstream>

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include "core/base/error.h"
#include "core/hand/floating_base.h"
#include "core/io/mesh_file.h"
#include "core/io/urdf_text.h"

namespace handgraft::io {

namespace fs = std::filesystem;

namespace {

/// Ours have up to 100 kB. An element of 4 bytes takes 120 when it is parsed.
constexpr std::uintmax_t kLargestUrdf = 4U << 20U;
/// Triangles of all shapes together: a small mesh may be named by many links.
constexpr long kMostFaces = 20'000'000;
/// Of any number (m, rad): poses along a chain of joints stay finite, whatever is multiplied.
constexpr double kLargestNumber = 1e30;

// === urdfdom, and the words it would otherwise print

class CaptureMessages : public console_bridge::OutputHandler {
 public:
  CaptureMessages() { console_bridge::useOutputHandler(this); }

  ~CaptureMessages() override { console_bridge::restorePreviousOutputHandler(); }

  CaptureMessages(const CaptureMessages&) = delete;
  CaptureMessages& operator=(const CaptureMessages&) = delete;

  void log(const std::string& text,
           console_bridge::LogLevel level,
           const char* /*file*/,
           int /*line*/) override {
    if (level < console_bridge::CONSOLE_BRIDGE_LOG_ERROR || text.empty()) return;
    if (!messages_.empty()) messages_ += "; ";
    messages_ += text;
  }

  [[nodiscard]] const std::string& messages() const { return messages_; }

 private:
  std::string messages_;
};

urdf::ModelInterfaceSharedPtr parseWithUrdfdom(const std::string& xml) {
  // console_bridge has one output handler per process.
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  const CaptureMessages capture;
  urdf::ModelInterfaceSharedPtr model;
  std::string thrown;
  try {
    model = urdf::parseURDF(xml);
  } catch (const std::exception& error) {
    thrown = error.what();
  }
  // A shape that it cannot parse is an error to urdfdom too, but one it goes on without.
  const std::string fault = thrown.empty() ? capture.messages() : thrown;
  if (!model || !fault.empty()) rejectInput("urdfdom: {}", handgraft::quoted(fault));
  return model;
}

Pose poseOf(const urdf::Pose& pose) {
  const urdf::Rotation& r = pose.rotation;
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(r.w, r.x, r.y, r.z).normalized().toRotationMatrix();
  X.translation() << pose.position.x, pose.position.y, pose.position.z;
  return X;
}

// === Joints

hand::Joint jointOf(const urdf::Joint& source, const hand::Joint& outline, bool unlimited) {
  hand::Joint joint = outline;
  joint.X_PJ = poseOf(source.parent_to_joint_origin_transform);
  if (joint.type == hand::JointType::kFixed) return joint;
  joint.axis_J << source.axis.x, source.axis.y, source.axis.z;
  if (source.type == urdf::Joint::REVOLUTE && unlimited) {
    joint.lower = -std::numbers::pi;
    joint.upper = std::numbers::pi;
  } else if (source.type != urdf::Joint::CONTINUOUS && !unlimited) {
    joint.lower = source.limits->lower;
    joint.upper = source.limits->upper;
  }
  if (source.mimic)
    joint.mimic =
        hand::Mimic{source.mimic->joint_name, source.mimic->multiplier, source.mimic->offset};
  return joint;
}

// === Shapes

/// Reads shapes; each mesh file once, whoever names it.
class ShapeReader {
 public:
  ShapeReader(const ResourceFinder& find, double mesh_unit_m, std::vector<std::string>& notes)
      : find_(find), mesh_unit_m_(mesh_unit_m), notes_(notes) {}

  void read(const urdf::Geometry* geometry,
            const urdf::Pose& origin,
            const std::string& link,
            std::vector<hand::Shape>& shapes) {
    if (geometry == nullptr)
      rejectInput("link {}: a shape has no geometry", handgraft::quoted(link));
    Eigen::Affine3d X_LG(poseOf(origin).matrix());
    hand::Shape shape;
    geometry::TriangleMesh mesh;
    if (const auto* file = dynamic_cast<const urdf::Mesh*>(geometry)) {
      const Eigen::Vector3d scale(file->scale.x, file->scale.y, file->scale.z);
      if (!scale.allFinite() || (scale.array() == 0.0).any())
        rejectInput("link {}: mesh {} has scale ({} {} {}); no part of it may be 0",
                    handgraft::quoted(link), handgraft::quoted(file->filename), scale.x(),
                    scale.y(), scale.z());
      // A scale that is written says already what the file's units are.
      X_LG = X_LG * Eigen::Scaling(scale.isOnes(0.0)
                                       ? Eigen::Vector3d::Constant(mesh_unit_m_).eval()
                                       : scale);
      shape.source = file->filename;
      mesh = meshOf(file->filename, link);
    } else if (const auto* box = dynamic_cast<const urdf::Box*>(geometry)) {
      shape.source = "box";
      const Eigen::Vector3d size(box->dim.x, box->dim.y, box->dim.z);
      if (isEmpty(size, link, "box")) return;
      mesh = geometry::makeBox(size);
    } else if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(geometry)) {
      shape.source = "cylinder";
      if (isEmpty({cylinder->radius, cylinder->radius, cylinder->length}, link, "cylinder"))
        return;
      mesh = geometry::makeCylinder(cylinder->radius, cylinder->length);
    } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(geometry)) {
      shape.source = "sphere";
      if (isEmpty(Eigen::Vector3d::Constant(sphere->radius), link, "sphere")) return;
      mesh = geometry::makeSphere(sphere->radius);
    } else {
      rejectInput("link {}: a shape is none of mesh, box, cylinder, sphere",
                  handgraft::quoted(link));
    }

    face_count_ += mesh.faceCount();
    if (face_count_ > kMostFaces)
      rejectInput("link {}: the shapes have more than {} triangles together",
                  handgraft::quoted(link), kMostFaces);
    shape.mesh_L = geometry::transformed(mesh, X_LG);
    const double reach = shape.mesh_L.vertices().cwiseAbs().maxCoeff();
    if (!(reach <= kLargestNumber))
      rejectInput("link {}: shape {} reaches out to {} m; permitted is {}",
                  handgraft::quoted(link), handgraft::quoted(shape.source), reach,
                  kLargestNumber);
    shapes.push_back(std::move(shape));
  }

 private:
  /// Placeholders of size 0 are common; they have no surface and are left out.
  bool isEmpty(const Eigen::Vector3d& size, const std::string& link, const char* kind) {
    if (!size.allFinite() || (size.array() < 0.0).any())
      rejectInput("link {}: a {} of size ({} {} {}): sizes must be positive",
                  handgraft::quoted(link), kind, size.x(), size.y(), size.z());
    if ((size.array() > 0.0).all()) return false;
    notes_.push_back(fmt::format("link {}: a {} without volume was left out",
                                 handgraft::quoted(link), kind));
    return true;
  }

  const geometry::TriangleMesh& meshOf(const std::string& uri, const std::string& link) {
    try {
      const fs::path path = find_(uri);
      const auto known = meshes_.find(path.string());
      if (known != meshes_.end()) return known->second;
      return meshes_.emplace(path.string(), readMesh(path).mesh).first->second;
    } catch (const InvalidInput& error) {
      rejectInput("link {}: {}", handgraft::quoted(link), error.what());
    }
  }

  const ResourceFinder& find_;
  double mesh_unit_m_;
  std::vector<std::string>& notes_;
  std::map<std::string, geometry::TriangleMesh> meshes_;
  long face_count_ = 0;
};

// === The whole

void requireModestNumbers(const hand::HandModel& model) {
  const auto require = [](double value, const std::string& joint, const char* what) {
    if (std::abs(value) <= kLargestNumber || std::isinf(value)) return;
    rejectInput("joint {}: its {} is {}; permitted is {} either way", handgraft::quoted(joint),
                what, value, kLargestNumber);
  };
  for (const hand::HandModel::Node& node : model.nodes()) {
    for (const double coordinate : node.X_PJ.translation())
      require(coordinate, node.joint_name, "origin");
    require(node.multiplier, node.joint_name, "multiplier along the mimics");
    require(node.offset, node.joint_name, "offset along the mimics");
  }
  for (int i = 0; i < model.dofCount(); ++i) {
    require(model.lower()[i], model.dofJoint(i).name, "lower limit");
    require(model.upper()[i], model.dofJoint(i).name, "upper limit");
  }
}

std::string readText(const fs::path& path) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error) rejectInput("{}", error.message());
  if (size > kLargestUrdf)
    rejectInput("{} bytes, more than the {} a URDF may have", size, kLargestUrdf);
  std::ifstream file(path, std::ios::binary);
  std::string text(static_cast<std::size_t>(size), '\0');
  if (!file.read(text.data(), static_cast<std::streamsize>(size)))
    rejectInput("cannot be read");
  return text;
}

hand::HandModel readModel(const UrdfText& prepared, ShapeReader* shapes) {
  // The tree first: urdfdom does not say which joints form a loop, and overlooks some.
  std::vector<hand::Link> links;
  for (const std::string& name : prepared.links)
    links.push_back({name, {}, {}});
  [[maybe_unused]] const hand::HandModel tree(prepared.robot_name, links, prepared.joints);

  const urdf::ModelInterfaceSharedPtr source = parseWithUrdfdom(prepared.xml);
  const std::set<std::string> unlimited(prepared.unlimited_joints.begin(),
                                        prepared.unlimited_joints.end());
  std::vector<hand::Joint> joints;
  for (const hand::Joint& outline : prepared.joints) {
    const auto found = source->joints_.find(outline.name);
    if (found == source->joints_.end())
      rejectInput("urdfdom does not know joint {}", handgraft::quoted(outline.name));
    joints.push_back(jointOf(*found->second, outline, unlimited.contains(outline.name)));
  }
  if (shapes != nullptr) {
    for (hand::Link& link : links) {
      const auto found = source->links_.find(link.name);
      if (found == source->links_.end())
        rejectInput("urdfdom does not know link {}", handgraft::quoted(link.name));
      for (const auto& visual : found->second->visual_array)
        shapes->read(visual->geometry.get(), visual->origin, link.name, link.visuals);
      for (const auto& collision : found->second->collision_array)
        shapes->read(collision->geometry.get(), collision->origin, link.name, link.collisions);
    }
  }
  hand::HandModel model(prepared.robot_name, std::move(links), std::move(joints));
  requireModestNumbers(model);
  return model;
}

/// Of joints that may not go as far as they say, for what mimics them.
void noteNarrowedLimits(const hand::HandModel& model, std::vector<std::string>& notes) {
  constexpr double kTold = 1e-3;  // rad or m; less is how files round
  for (int dof = 0; dof < model.dofCount(); ++dof) {
    const hand::Joint& joint = model.dofJoint(dof);
    const double lower = model.lower()[dof];
    const double upper = model.upper()[dof];
    if (lower <= joint.lower + kTold && upper >= joint.upper - kTold) continue;
    notes.push_back(fmt::format(
        "joint {} goes from {:.4g} to {:.4g} {} instead of {:.4g} to {:.4g}: beyond, joints "
        "that mimic it would leave their own limits",
        handgraft::quoted(joint.name), lower, upper,
        joint.type == hand::JointType::kPrismatic ? "m" : "rad", joint.lower, joint.upper));
  }
}

}  // namespace

UrdfFile readUrdf(const fs::path& path, const PackageMap& packages) {
  return readUrdf(path, [&](const std::string& uri) {
    return resolveResource(uri, path.parent_path(), packages);
  });
}

UrdfFile readUrdf(const fs::path& path, const ResourceFinder& find, double mesh_unit_m) {
  try {
    std::string text = readText(path);
    UrdfText prepared = prepareUrdf(text, true);
    ShapeReader shapes(find, mesh_unit_m, prepared.notes);
    hand::RootedHand rooted =
        hand::cutFloatingBase(readModel(prepared, &shapes), prepared.solid_links);
    if (rooted.carrier)
      prepared.notes.push_back(fmt::format(
          "joints {} place the whole hand: they are its floating base, not joints of the hand",
          fmt::join(rooted.carrier->dofNames(), ", ")));
    noteNarrowedLimits(rooted.hand, prepared.notes);
    return {std::move(rooted.hand), std::move(rooted.carrier), std::move(text),
            std::move(prepared.notes)};
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", handgraft::quoted(path.string()), error.what());
  }
}

hand::HandModel readUrdfKinematics(const fs::path& path, FloatingBase floating_base) {
  try {
    const UrdfText prepared = prepareUrdf(readText(path), false);
    hand::HandModel model = readModel(prepared, nullptr);
    if (floating_base == FloatingBase::kKept) return model;
    return hand::cutFloatingBase(model, prepared.solid_links).hand;
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", handgraft::quoted(path.string()), error.what());
  }
}

}  // namespace handgraft::io
