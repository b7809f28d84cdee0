#include "server/reading/read_model.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/contact/threshold.h"
#include "core/geometry/main_extent.h"
#include "core/hand/mirror.h"
#include "core/io/contact_file.h"
#include "core/io/hand_joints_file.h"
#include "core/io/motion_plan.h"
#include "core/io/object_file.h"
#include "core/io/sites_file.h"
#include "core/io/srdf_file.h"
#include "core/io/urdf_file.h"
#include "server/reading/units.h"

namespace handgraft::server {

namespace {

namespace fs = std::filesystem;

const fs::path& fileOf(const ReadRequest& request, const std::string& uri) {
  const auto found = request.files.find(uri);
  if (found == request.files.end())
    rejectInput("{}: this file was not uploaded", handgraft::quoted(uri));
  return found->second;
}

// === Hands

void append(std::vector<std::string>& notes, std::vector<std::string> more) {
  notes.insert(notes.end(), std::make_move_iterator(more.begin()),
               std::make_move_iterator(more.end()));
}

/// The names of poses, for messages: "'open', 'pinch'".
std::string namesOf(const std::vector<hand::NamedPose>& poses) {
  constexpr std::size_t kMost = 24;
  std::string names;
  for (std::size_t i = 0; i < std::min(poses.size(), kMost); ++i)
    names += (i == 0 ? "" : ", ") + handgraft::quoted(poses[i].name);
  if (poses.size() > kMost) names += fmt::format(" and {} more", poses.size() - kMost);
  return names.empty() ? "none" : names;
}

const Eigen::VectorXd& poseCalled(const std::string& name,
                                  const std::vector<hand::NamedPose>& poses) {
  for (const hand::NamedPose& pose : poses) {
    if (pose.name == name) return pose.q;
  }
  rejectInput("rest pose {} is none of the hand's named poses: {}", handgraft::quoted(name),
              namesOf(poses));
}

/// A URDF is in metres; a mesh wider than what can be grasped with is not.
void requireMetres(const hand::HandModel& model) {
  static const std::set<std::string> primitive_shapes = {"box", "cylinder", "sphere"};
  const auto require = [](const hand::Link& link, const hand::Shape& shape) {
    const double size = shape.mesh_L.diagonal();
    if (!(size > kLargestUnasked) || primitive_shapes.count(shape.source) != 0) return;
    rejectInput(
        "link {}: mesh {} is {:.4g} m across, and a URDF is in metres; write "
        "scale=\"0.001 0.001 0.001\" at the mesh if its file is in millimetres, or load the "
        "hand with --units mm if all of its meshes are",
        handgraft::quoted(link.name), handgraft::quoted(shape.source), size);
  };
  for (const hand::Link& link : model.links()) {
    for (const hand::Shape& shape : link.visuals)
      require(link, shape);
    for (const hand::Shape& shape : link.collisions)
      require(link, shape);
  }
}

/// Of sliders that go farther than any of a hand's. A floating base may be anywhere; it is none
/// of the model's joints.
void noteTravelInMillimetres(const hand::HandModel& model, std::vector<std::string>& notes) {
  constexpr double kLongestTravel = 1.0;  // m
  for (const hand::Joint& joint : model.joints()) {
    if (joint.type != hand::JointType::kPrismatic) continue;
    const double farthest = std::max(std::abs(joint.lower), std::abs(joint.upper));
    if (!std::isfinite(farthest) || farthest <= kLongestTravel) continue;
    notes.push_back(
        fmt::format("joint {}: its limits, {} to {} m, are beyond {} m; URDF's lengths are "
                    "metres, not millimetres",
                    handgraft::quoted(joint.name), joint.lower, joint.upper, kLongestTravel));
  }
}

ReadHand readHand(const ReadRequest& request) {
  io::UrdfFile file = io::readUrdf(fileOf(request, request.main_uri),
                                   ResourceFinder([&](const std::string& uri) {
                                     return fileOf(request, uri);
                                   }),
                                   metresPer(request.units));
  if (file.model.dofCount() > kMostJoints) {
    rejectInput("hand {}: {} joints; at most {} are supported", handgraft::quoted(request.name),
                file.model.dofCount(), kMostJoints);
  }
  requireMetres(file.model);
  const auto& links = file.model.links();
  if (std::none_of(links.begin(), links.end(), [](const hand::Link& link) {
        return !link.surface().empty();
      })) {
    rejectInput("hand {}: none of its links has a surface", handgraft::quoted(request.name));
  }
  ReadHand read{std::move(file.model), std::move(file.floating_base),
                std::move(file.text),  std::move(file.notes),
                std::nullopt,          {}};
  noteTravelInMillimetres(read.model, read.notes);
  if (!request.hand.srdf_uri.empty()) {
    io::SrdfFile srdf = io::readSrdf(fileOf(request, request.hand.srdf_uri), read.model);
    read.poses = std::move(srdf.poses);
    append(read.notes, std::move(srdf.notes));
  }
  if (!request.hand.rest_pose.empty()) {
    read.model = read.model.withRestPose(poseCalled(request.hand.rest_pose, read.poses));
  }
  if (request.hand.mirrored) {
    read.model = hand::mirrored(read.model, read.model.name());
    if (read.floating_base)
      read.floating_base = hand::mirrored(*read.floating_base, read.floating_base->name());
  }
  if (request.files.count(kSitesUri) != 0)
    read.sites = io::readSites(fileOf(request, kSitesUri), read.model, request.hand.mirrored);
  return read;
}

// === Objects

io::MeshFile readObject(const ReadRequest& request, const Progress& progress) {
  return io::readObject(fileOf(request, request.main_uri), progress, {}, [&](double size) {
    return objectScale(size, request.units, "object " + handgraft::quoted(request.name));
  });
}

// === Contacts

contact::ContactMap scaledMap(contact::ContactMap map,
                              const ReadRequest& request,
                              std::vector<std::string>& notes) {
  const MapScale scale =
      mapScale(geometry::mainExtent(map.mesh_O), request.units, request.contacts.object_units,
               geometry::mainExtent(request.contacts.object->mesh),
               "contact map " + handgraft::quoted(request.name));
  if (!scale.note.empty()) notes.push_back(scale.note);
  if (scale.scale != 1.0) {
    map.mesh_O =
        geometry::transformed(map.mesh_O, Eigen::Affine3d(Eigen::Scaling(scale.scale)));
  }
  return map;
}

ReadContacts readMap(const ReadRequest& request,
                     const fs::path& path,
                     const io::ContactMapSource& source) {
  const ContactReading& how = request.contacts;
  contact::SegmentationOptions options = how.segmentation;
  if (!how.joints_uri.empty()) {
    io::HandsOfFile hands = io::readHands(fileOf(request, how.joints_uri), how.joints_hand);
    options.joints_O = hands.joints;
    options.other_joints_O = std::move(hands.others);
  }
  std::vector<std::string> notes;
  contact::ContactMap map =
      io::onFaces(scaledMap(io::readContactMap(path, source), request, notes), *how.object);
  ReadContacts read;
  read.set = io::contactsFromMap(map, *how.object, options);
  read.set.name = request.name;
  append(read.set.notes, std::move(notes));
  contact::ContactMap even = map;
  even.value = contact::smoothed(map.mesh_O, map.value, options.smoothing_steps);
  read.threshold = contact::thresholdOf(even, options);
  read.map = std::move(map);
  return read;
}

ReadContacts readContacts(const ReadRequest& request) {
  const ContactReading& how = request.contacts;
  HANDGRAFT_REQUIRE(how.object != nullptr);
  const fs::path& path = fileOf(request, request.main_uri);
  io::ContactMapSource source = how.source;
  if (!how.picture_uri.empty()) source.picture = fileOf(request, how.picture_uri);
  if (io::isContactMap(path, source)) {
    try {
      return readMap(request, path, source);
    } catch (const UnitsInDoubt&) {
      throw;
    } catch (const InvalidInput& error) {
      // Errors of files name them already.
      const std::string name = path.string();
      if (std::string(error.what()).find(name) != std::string::npos) throw;
      rejectInput("{}: {}", name, error.what());
    }
  }
  ReadContacts read;
  read.set = io::readContactSet(path, *how.object);
  if (!how.joints_uri.empty()) {
    read.set.notes.push_back(fmt::format(
        "the hand's joints ({}) are not used: they name the areas of a map, and {} is a set, "
        "whose patches have their names",
        handgraft::quoted(how.joints_uri), handgraft::quoted(request.main_uri)));
  }
  return read;
}

// === Motions

ReadModel readMotion(const ReadRequest& request) {
  HANDGRAFT_REQUIRE(request.contacts.object != nullptr);
  const std::filesystem::path path = fileOf(request, request.main_uri);
  const io::FileOf named = [&](const std::string& uri) {
    return fileOf(request, uri);
  };
  if (auto plan = io::readHandTrajectoryPlan(path, named))
    return ReadHandTrajectory{std::move(*plan)};
  return ReadMotion{io::readMotionFrom(path, *request.contacts.object, named)};
}

}  // namespace

std::vector<std::filesystem::path> filesOf(const ReadRequest& request) {
  std::vector<std::filesystem::path> files;
  files.reserve(request.files.size());
  for (const auto& [uri, file] : request.files)
    files.push_back(file);
  return files;
}

bool answers(const ReadModel& model, ReadKind asked) {
  const auto kind = static_cast<ReadKind>(model.index());
  return kind == asked || (asked == ReadKind::kMotion && kind == ReadKind::kHandTrajectory);
}

ReadModel readModel(const ReadRequest& request, const Progress& progress) {
  progress.report("reading the model", 0.0);
  progress.checkpoint();
  switch (request.kind) {
    case ReadKind::kHand:
      return readHand(request);
    case ReadKind::kObject:
      return readObject(request, progress);
    case ReadKind::kContacts:
      return readContacts(request);
    case ReadKind::kObjectName:
      return ObjectName{io::objectNameIn(fileOf(request, request.main_uri))};
    case ReadKind::kMotion:
      return readMotion(request);
    case ReadKind::kHandTrajectory:
      break;
  }
  throw BrokenContract("a kind of model that does not exist");
}

}  // namespace handgraft::server
