// The text of a URDF and, behind a mark, that of an SRDF for it: read as the server reads an
// uploaded hand, then posed, mirrored and searched for fingers.

#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/hand/digits.h"
#include "core/hand/floating_base.h"
#include "core/hand/kinematics.h"
#include "core/hand/mirror.h"
#include "core/io/srdf_file.h"
#include "core/io/urdf_file.h"

#include "tests/fuzz/promise.h"
#include "tests/fuzz/scratch_file.h"

namespace {

namespace fs = std::filesystem;
namespace hand = handgraft::hand;
namespace io = handgraft::io;
using handgraft::Pose;

constexpr std::string_view kSrdfMark = "<!--SRDF-->";
/// Beyond these, fingers are not looked for and nothing is mirrored: the sanitizers make it
/// slow.
constexpr int kMostLinks = 400;
constexpr int kMostFaces = 20'000;

/// The files that a hand may name; whatever else it names was not uploaded.
fs::path uploadedFile(const std::string& uri) {
  static const std::map<std::string, fs::path> mesh_files = {
      {"tip.obj", handgraft::fuzz::scratchFile(
                      "tip.obj",
                      "v 0 0 0\nv 0.02 0 0\nv 0 0.02 0\nv 0 0 0.02\nf 1 3 2\nf 1 2 4\nf 2 3 4\n"
                      "f 3 1 4\n")},
      {"package://hand/palm.stl",
       handgraft::fuzz::scratchFile(
           "palm.stl",
           "solid palm\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
           "vertex 0 1 0\nendloop\nendfacet\nendsolid palm\n")},
      {"cut.ply", handgraft::fuzz::scratchFile("cut.ply", "ply\nformat ascii 1.0\nelement ")}};
  const auto found = mesh_files.find(uri);
  if (found == mesh_files.end())
    handgraft::rejectInput("{}: not among the files sent", handgraft::quoted(uri));
  return found->second;
}

int faceCountOf(const hand::HandModel& model) {
  int count = 0;
  for (const hand::Link& link : model.links()) {
    for (const std::vector<hand::Shape>* shapes : {&link.visuals, &link.collisions}) {
      for (const hand::Shape& shape : *shapes)
        count += shape.mesh_L.faceCount();
    }
  }
  return count;
}

bool isPose(const Pose& X) {
  const Eigen::Matrix3d R = X.linear();
  // NaN fails, too. A chain of joints adds up what each file's digits leave.
  return X.matrix().allFinite() && (R.transpose() * R).isIdentity(1e-2);
}

/// Finite poses of the hand: at rest, and at its limits as far as it has any.
std::vector<Eigen::VectorXd> posesOf(const hand::HandModel& model) {
  const Eigen::VectorXd rest = model.restPose();
  std::vector<Eigen::VectorXd> poses = {rest};
  for (const Eigen::VectorXd* limits : {&model.lower(), &model.upper()})
    poses.push_back(limits->array().isFinite().select(*limits, rest));
  return poses;
}

void requireSaneTree(const hand::HandModel& model) {
  HANDGRAFT_PROMISE(model.linkCount() > 0);
  HANDGRAFT_PROMISE(std::ssize(model.nodes()) + 1 == model.linkCount());
  for (const hand::HandModel::Node& node : model.nodes()) {
    HANDGRAFT_PROMISE(node.parent_link >= 0 && node.parent_link < node.link);
    HANDGRAFT_PROMISE((node.dof < 0) == (node.type == hand::JointType::kFixed));
    HANDGRAFT_PROMISE(node.dof < model.dofCount());
  }
  const Eigen::VectorXd rest = model.restPose();
  for (int i = 0; i < model.dofCount(); ++i) {
    HANDGRAFT_PROMISE(model.lower()[i] <= model.upper()[i]);
    HANDGRAFT_PROMISE(std::isfinite(rest[i]));
    HANDGRAFT_PROMISE(rest[i] >= model.lower()[i] && rest[i] <= model.upper()[i]);
  }
  for (const hand::Link& link : model.links()) {
    for (const hand::Shape& shape : link.surface())
      HANDGRAFT_PROMISE(shape.mesh_L.vertices().allFinite());
  }
}

void requireFinitePoses(const hand::HandModel& model) {
  for (const Eigen::VectorXd& q : posesOf(model)) {
    for (const Pose& X : hand::forwardKinematics(model, {Pose::Identity(), q}))
      HANDGRAFT_PROMISE(isPose(X));
  }
}

/// X' = S X S in every link, and mirrored twice the same hand.
void requireMirrorImage(const hand::HandModel& model) {
  const hand::HandModel other = hand::mirrored(model, "other");
  const hand::HandModel back = hand::mirrored(other, "back");
  const Eigen::Vector4d S(-1.0, 1.0, 1.0, 1.0);
  for (const Eigen::VectorXd& q : posesOf(model)) {
    const auto X = hand::forwardKinematics(model, {Pose::Identity(), q});
    const auto X_other = hand::forwardKinematics(other, {Pose::Identity(), q});
    const auto X_back = hand::forwardKinematics(back, {Pose::Identity(), q});
    double size = 1.0;
    for (std::size_t i = 0; i < X.size(); ++i) {
      size = std::max(size, X[i].matrix().cwiseAbs().maxCoeff());
      const Eigen::Matrix4d image = S.asDiagonal() * X[i].matrix() * S.asDiagonal();
      HANDGRAFT_PROMISE((X_other[i].matrix() - image).cwiseAbs().maxCoeff() <= 1e-6 * size);
      HANDGRAFT_PROMISE((X_back[i].matrix() - X[i].matrix()).cwiseAbs().maxCoeff() <=
                        1e-6 * size);
    }
  }
}

bool isUnitOrZero(const Eigen::Vector3d& v) {
  return v.isZero(0.0) || std::abs(v.norm() - 1.0) <= 1e-6;
}

void requireSaneDigits(const hand::HandModel& model) {
  const auto X = hand::forwardKinematics(model, {Pose::Identity(), model.restPose()});
  const hand::Digits digits = hand::findDigits(model, X);
  HANDGRAFT_PROMISE(digits.palm_link >= 0 && digits.palm_link < model.linkCount());
  for (const hand::Digit& digit : digits.digits) {
    HANDGRAFT_PROMISE(!digit.nodes.empty() && !digit.tip_links.empty());
    for (const int node : digit.nodes)
      HANDGRAFT_PROMISE(node >= 0 && node < std::ssize(model.nodes()));
    HANDGRAFT_PROMISE(isUnitOrZero(digit.outward));
    HANDGRAFT_PROMISE(isUnitOrZero(digit.flexion_axis) && !digit.flexion_axis.isZero(0.0));
    HANDGRAFT_PROMISE(isUnitOrZero(digit.closing) && !digit.closing.isZero(0.0));
    HANDGRAFT_PROMISE(digit.base.allFinite() && digit.tip.allFinite());
  }
}

/// What a problem file sees of the same hand.
void requireSameKinematics(const fs::path& urdf, const hand::HandModel& model) {
  const hand::HandModel bare = io::readUrdfKinematics(urdf);
  HANDGRAFT_PROMISE(bare.dofNames() == model.dofNames());
  const auto X = hand::forwardKinematics(model, {Pose::Identity(), model.restPose()});
  const auto X_bare = hand::forwardKinematics(bare, {Pose::Identity(), bare.restPose()});
  HANDGRAFT_PROMISE(X.size() == X_bare.size());
  for (std::size_t i = 0; i < X.size(); ++i)
    HANDGRAFT_PROMISE(X[i].matrix() == X_bare[i].matrix());
}

void readNamedPoses(std::string_view text, const hand::HandModel& model) {
  const fs::path path = handgraft::fuzz::scratchFile("hand.srdf", text);
  try {
    for (const hand::NamedPose& pose : io::readSrdf(path, model).poses) {
      HANDGRAFT_PROMISE(!pose.name.empty());
      HANDGRAFT_PROMISE(pose.q.size() == model.dofCount());
      HANDGRAFT_PROMISE((pose.q.array() >= model.lower().array()).all());
      HANDGRAFT_PROMISE((pose.q.array() <= model.upper().array()).all());
      HANDGRAFT_PROMISE(pose.q.allFinite());
    }
  } catch (const handgraft::InvalidInput&) {
    // No SRDF, or one with a fault.
  }
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(bytes), size);
  const std::size_t mark = text.find(kSrdfMark);
  const fs::path path = handgraft::fuzz::scratchFile("hand.urdf", text.substr(0, mark));
  try {
    const io::UrdfFile file = io::readUrdf(path, uploadedFile);
    requireSaneTree(file.model);
    requireFinitePoses(file.model);
    requireSameKinematics(path, file.model);
    if (faceCountOf(file.model) <= kMostFaces) requireMirrorImage(file.model);
    if (file.floating_base) {
      requireSaneTree(*file.floating_base);
      requireFinitePoses(*file.floating_base);
    }
    if (file.model.linkCount() <= kMostLinks) requireSaneDigits(file.model);
    if (mark != std::string_view::npos)
      readNamedPoses(text.substr(mark + kSrdfMark.size()), file.model);
  } catch (const handgraft::InvalidInput&) {
    // The answer that most bytes deserve.
  }
  return 0;
}
