#include "tests/bench/retargeting/demonstration.h"

#include <algorithm>
#include <fstream>
#include <iterator>
#include <optional>
#include <random>
#include <set>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/demonstration/posed_hand_contacts.h"
#include "core/hand/floating_base.h"
#include "core/io/mesh_file.h"

#include "tests/bench/retargeting/exact_penetration.h"

namespace handgraft::bench {

namespace {

namespace fs = std::filesystem;

std::optional<fs::path> meshOf(const std::string& object, std::vector<fs::path> folders) {
  const std::vector<fs::path> given = folders;
  for (const fs::path& folder : given) {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
      if (entry.is_directory()) folders.push_back(entry.path());
  }
  std::sort(folders.begin() + std::ssize(given), folders.end());
  for (const fs::path& one : folders) {
    for (const char* extension : {".obj", ".stl", ".ply", ".glb"}) {
      fs::path file = one / (object + extension);
      if (fs::exists(file)) return file;
    }
  }
  return std::nullopt;
}

std::shared_ptr<const GraspedObject> readObject(const std::string& name, const fs::path& file) {
  auto object = std::make_shared<GraspedObject>();
  object->name = name;
  object->mesh_O = std::make_shared<const geometry::TriangleMesh>(io::readMesh(file).mesh);
  object->solid_O =
      std::make_shared<const ExactSolid>(*object->mesh_O, ExactPenetration::kObjectSpacing);
  return object;
}

Pose poseOf(const std::vector<double>& xyz_qwxyz) {
  if (xyz_qwxyz.size() != 7)
    rejectInput("object_pose_xyz_qwxyz has {} numbers; it must have 7", xyz_qwxyz.size());
  Pose X = Pose::Identity();
  X.translation() = Eigen::Vector3d(xyz_qwxyz[0], xyz_qwxyz[1], xyz_qwxyz[2]);
  X.linear() = Eigen::Quaterniond(xyz_qwxyz[3], xyz_qwxyz[4], xyz_qwxyz[5], xyz_qwxyz[6])
                   .normalized()
                   .toRotationMatrix();
  return X;
}

nlohmann::json parsed(const fs::path& file) {
  std::ifstream stream(file);
  if (!stream) rejectInput("{}: cannot be read", quoted(file.string()));
  nlohmann::json document = nlohmann::json::parse(stream, nullptr, false);
  if (!document.is_object() || !document.contains("grasps"))
    rejectInput("{}: is no JSON file of grasps", quoted(file.string()));
  return document;
}

/// The finger of a patch's name: what stands before the first underscore.
std::string fingerOf(const std::string& patch) {
  return patch.substr(0, patch.find('_'));
}

}  // namespace

std::string DemonstrationFile::Entry::name() const {
  return fmt::format("{}/{}", object->name, number);
}

DemonstrationFile::DemonstrationFile(const fs::path& grasps,
                                     const std::vector<fs::path>& objects) {
  for (const fs::path& folder : objects)
    if (!fs::is_directory(folder)) rejectInput("{}: is no folder", quoted(folder.string()));
  const nlohmann::json document = parsed(grasps);
  try {
    hand_file_ = fs::path(document.at("hand_urdf").get<std::string>()).filename().string();
    joints_ = document.at("qpos_joint_names").get<std::vector<std::string>>();
    for (const auto& [name, list] : document.at("grasps").items()) {
      const std::optional<fs::path> file = meshOf(name, objects);
      if (!file) continue;
      objects_.push_back(readObject(name, *file));
      int number = 0;
      for (const nlohmann::json& grasp : list) {
        entries_.push_back(
            {objects_.back().get(), number++, grasp.at("qpos").get<std::vector<double>>(),
             poseOf(grasp.at("object_pose_xyz_qwxyz").get<std::vector<double>>())});
      }
    }
  } catch (const nlohmann::json::exception& error) {
    rejectInput("{}: {}", quoted(grasps.string()), error.what());
  }
  if (entries_.empty()) {
    rejectInput("{}: none of its objects has a mesh in {}", quoted(grasps.string()),
                quoted(objects.front().string()));
  }
}

std::vector<DemonstrationFile::Entry> DemonstrationFile::draw(int per_object,
                                                              unsigned seed) const {
  if (per_object == 0) return entries_;
  std::vector<Entry> drawn;
  std::mt19937 random(seed);
  for (const auto& object : objects_) {
    std::vector<const Entry*> of_object;
    for (const Entry& entry : entries_)
      if (entry.object == object.get()) of_object.push_back(&entry);
    // Not std::shuffle, whose answer differs from library to library.
    for (std::size_t i = of_object.size(); i > 1; --i)
      std::swap(of_object[i - 1], of_object[random() % i]);
    of_object.resize(std::min(of_object.size(), static_cast<std::size_t>(per_object)));
    for (const Entry* entry : of_object)
      drawn.push_back(*entry);
  }
  return drawn;
}

Demonstration DemonstrationFile::read(const Entry& entry,
                                      const hand::Hand& hand,
                                      const hand::HandModel* carrier) const {
  if (entry.qpos.size() != joints_.size()) {
    rejectInput("grasp {}: {} values for {} joints", entry.name(), entry.qpos.size(),
                joints_.size());
  }
  Demonstration demonstration;
  demonstration.name = entry.name();
  demonstration.object = entry.object;
  demonstration.pose.q = hand.model->restPose();
  Eigen::VectorXd q_root;
  std::vector<std::string> of_root;
  if (carrier != nullptr) {
    q_root = carrier->restPose();
    of_root = carrier->dofNames();
  }
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const auto at = std::find(of_root.begin(), of_root.end(), joints_[i]);
    if (at != of_root.end()) {
      q_root[at - of_root.begin()] = entry.qpos[i];
    } else {
      demonstration.pose.q[hand.model->dofIndex(joints_[i])] = entry.qpos[i];
    }
  }
  const Pose X_WH = carrier == nullptr ? Pose::Identity() : hand::carriedPose(*carrier, q_root);
  demonstration.pose.X_WH = inverse(entry.X_WO) * X_WH;
  demonstration.contacts =
      demonstration::contactsOfPosedHand(hand, demonstration.pose, *entry.object->mesh_O,
                                         Pose::Identity(), {}, {}, Progress())
          .set;
  demonstration.contacts.name = entry.name();
  std::set<std::string> digits;
  for (const contact::Patch& patch : demonstration.contacts.patches)
    if (fingerOf(patch.name) != "palm") digits.insert(fingerOf(patch.name));
  demonstration.digits_touching = static_cast<int>(digits.size());
  return demonstration;
}

}  // namespace handgraft::bench
