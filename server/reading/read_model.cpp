#include "server/reading/read_model.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/hand/mirror.h"
#include "core/io/contact_file.h"
#include "core/io/object_file.h"
#include "core/io/sites_file.h"
#include "core/io/srdf_file.h"
#include "core/io/urdf_file.h"

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

ReadHand readHand(const ReadRequest& request) {
  io::UrdfFile file = io::readUrdf(fileOf(request, request.main_uri),
                                   ResourceFinder([&](const std::string& uri) {
                                     return fileOf(request, uri);
                                   }));
  if (file.model.dofCount() > kMostJoints) {
    rejectInput("hand {}: {} joints; at most {} are supported", handgraft::quoted(request.name),
                file.model.dofCount(), kMostJoints);
  }
  ReadHand read{std::move(file.model), std::move(file.free_root),
                std::move(file.text),  std::move(file.notes),
                std::nullopt,          {}};
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
    if (read.free_root)
      read.free_root = hand::mirrored(*read.free_root, read.free_root->name());
  }
  if (request.files.count(kSitesUri) != 0)
    read.sites = io::readSites(fileOf(request, kSitesUri), read.model);
  return read;
}

// === Objects

/// Sizes of what a hand can hold; outside them a mesh is in other units than metres.
constexpr double kSmallestObject_m = 0.001;
constexpr double kLargestObject_m = 10.0;

io::MeshFile readObject(const ReadRequest& request, const Progress& progress) {
  io::MeshFile file = io::readObject(fileOf(request, request.main_uri), progress);
  const double size = file.mesh.diagonal();
  if (!(size >= kSmallestObject_m && size <= kLargestObject_m)) {
    rejectInput("object {}: {:.4g} m across, outside {} to {} m; is its mesh in metres?",
                handgraft::quoted(request.name), size, kSmallestObject_m, kLargestObject_m);
  }
  return file;
}

// === Contacts

ReadContacts readContacts(const ReadRequest& request) {
  HANDGRAFT_REQUIRE(request.contacts.object != nullptr);
  ReadContacts read;
  read.set = io::readContacts(fileOf(request, request.main_uri), *request.contacts.object,
                              request.contacts.segmentation, request.contacts.source);
  return read;
}

}  // namespace

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
  }
  HANDGRAFT_REQUIRE(false);
}

}  // namespace handgraft::server
