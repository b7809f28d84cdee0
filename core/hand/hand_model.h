#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/pose.h"
#include "core/geometry/triangle_mesh.h"

namespace handgraft::hand {

enum class JointType { kFixed, kRevolute, kPrismatic };

/// A joint follows another one: q = multiplier * q_source + offset.
struct Mimic {
  std::string source_joint;
  double multiplier = 1.0;
  double offset = 0.0;
};

/// One joint of the tree. Revolute in rad, prismatic in m; continuous joints are revolute ones
/// without limits.
struct Joint {
  std::string name;
  JointType type = JointType::kFixed;
  std::string parent_link;
  std::string child_link;
  /// Pose of the joint's frame J (the child link's at q = 0) in the parent link P.
  Pose X_PJ = Pose::Identity();
  /// Unit axis in J.
  Eigen::Vector3d axis_J = Eigen::Vector3d::UnitX();
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  /// rad/s or m/s; 0 where the model does not say.
  double velocity_limit = 0.0;
  std::optional<Mimic> mimic;
};

/// One solid of a link: a mesh already scaled and moved into the link's frame.
struct Shape {
  geometry::TriangleMesh mesh_L;
  std::string source;  ///< file or primitive, for messages: "meshes/palm.stl", "cylinder"
};

struct Link {
  std::string name;
  std::vector<Shape> visuals;
  std::vector<Shape> collisions;

  /// What stands for the link's surface: its visuals, or its collisions where it has none.
  [[nodiscard]] const std::vector<Shape>& surface() const {
    return visuals.empty() ? collisions : visuals;
  }
};

/// A hand: a tree of links and joints, its independent joints (dofs) and their limits.
///
/// Links are sorted so that parents come before children; link 0 is the root, frame H. Dofs are
/// the movable joints that mimic no other, in the order of the file. The free root is not part
/// of the model: poses carry it as X_WH.
class HandModel {
 public:
  /// Errors: InvalidInput, naming the joint or link, for: no link, more than one root, a loop,
  /// a joint with two parents or an unknown link, duplicate names, an axis without length,
  /// lower above upper, a mimic of an unknown joint or a mimic loop.
  HandModel(std::string name, std::vector<Link> links, std::vector<Joint> joints);

  /// A joint as kinematics sees it. Column i of the tree: link i+1's joint.
  struct Node {
    int link = 0;  ///< child link
    int parent_link = 0;
    JointType type = JointType::kFixed;
    int dof = -1;             ///< -1 when fixed
    double multiplier = 1.0;  ///< q_joint = multiplier * q[dof] + offset
    double offset = 0.0;
    Pose X_PJ = Pose::Identity();
    Eigen::Vector3d axis_J = Eigen::Vector3d::UnitX();
    std::string joint_name;
  };

  [[nodiscard]] const std::string& name() const { return name_; }

  [[nodiscard]] const std::vector<Link>& links() const { return links_; }

  [[nodiscard]] const std::vector<Joint>& joints() const { return joints_; }

  /// One per link but the root, parents first; nodes()[i].link == i + 1.
  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }

  [[nodiscard]] int linkCount() const { return static_cast<int>(links_.size()); }

  [[nodiscard]] int dofCount() const { return static_cast<int>(dof_joints_.size()); }

  [[nodiscard]] int mimicCount() const;
  /// The joint of dof i, and its name.
  [[nodiscard]] const Joint& dofJoint(int dof) const;
  [[nodiscard]] std::vector<std::string> dofNames() const;

  /// Limits of the dofs (infinite where there are none). A follower's own limits narrow its
  /// source's, where that leaves a range at all.
  [[nodiscard]] const Eigen::VectorXd& lower() const { return lower_; }

  [[nodiscard]] const Eigen::VectorXd& upper() const { return upper_; }

  /// Index, or InvalidInput naming it and what there is.
  [[nodiscard]] int linkIndex(const std::string& link_name) const;
  [[nodiscard]] int dofIndex(const std::string& joint_name) const;
  [[nodiscard]] std::optional<int> maybeLinkIndex(const std::string& link_name) const;

  /// Zero, moved into the limits: what the geometry of the model alone says.
  [[nodiscard]] Eigen::VectorXd zeroPose() const;

  /// Where the fingers are when nobody says otherwise, where searches start, and what they stay
  /// close to: the zero pose, or the one given to `withRestPose`.
  [[nodiscard]] const Eigen::VectorXd& restPose() const { return rest_; }

  /// The same hand with another rest pose; its skin stays the same. Errors: InvalidInput,
  /// naming the joint, unless `q` has an entry per dof, finite and within the limits.
  [[nodiscard]] HandModel withRestPose(const Eigen::VectorXd& q) const;

  /// Whether its links have the names of the other hand, which it is the mirror of.
  [[nodiscard]] bool isMirror() const { return is_mirror_; }

  [[nodiscard]] HandModel asMirror(bool is_mirror) const;

 private:
  std::string name_;
  std::vector<Link> links_;
  std::vector<Joint> joints_;
  std::vector<Node> nodes_;
  std::vector<int> dof_joints_;
  Eigen::VectorXd lower_;
  Eigen::VectorXd upper_;
  Eigen::VectorXd rest_;
  bool is_mirror_ = false;
};

}  // namespace handgraft::hand
