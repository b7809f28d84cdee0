#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/base/progress.h"
#include "core/contact/contact_set.h"
#include "core/contact/segmentation.h"
#include "core/hand/contact_site.h"
#include "core/hand/hand_model.h"
#include "core/hand/named_pose.h"
#include "core/hand/skin.h"
#include "core/io/contact_map_file.h"
#include "core/io/mesh_file.h"
#include "core/io/motion_plan.h"
#include "core/manipulation/motion.h"

/// From the files of an upload to a model: plain structs in and out, no message, no server, so
/// that it can run in a process of its own.
namespace handgraft::server {

/// How a hand is to be read.
struct HandReading {
  bool mirrored = false;  ///< the other hand (core/hand/mirror.h)
  std::string srdf_uri;   ///< of its named poses; empty: none
  std::string rest_pose;  ///< one of them; empty: zero, moved into the limits
  hand::SkinOptions skin;
};

/// How contacts are to be read.
struct ContactReading {
  contact::SegmentationOptions segmentation;  ///< joints_O comes from the file below
  io::ContactMapSource source;                ///< its picture comes from the file below
  std::string picture_uri;                    ///< empty: none
  std::string joints_uri;                     ///< empty: none
  std::optional<int> joints_hand;             ///< io/hand_joints_file.h
  /// The object they lie on, and the units it was read in (units.h). Motions need it, too.
  std::shared_ptr<const io::MeshFile> object;
  std::string object_units;
};

enum class ReadKind {
  kHand,
  kObject,
  kContacts,
  kObjectName,  ///< of contacts and motions: which object they say they lie on, nothing else
  kMotion,
  kHandTrajectory,  ///< nobody asks for it: what reading a motion may bring instead
};

struct ReadRequest {
  ReadKind kind = ReadKind::kObject;
  std::string name;      ///< of the model, for messages
  std::string main_uri;  ///< of the file to read first
  /// Where the file of each URI lies; no other file is opened.
  std::map<std::string, std::filesystem::path> files;
  /// Of meshes, points and maps: m, cm, mm or in; empty: metres, unless the size says otherwise
  /// (units.h).
  std::string units;
  HandReading hand;
  ContactReading contacts;
};

/// All that reading it may open.
std::vector<std::filesystem::path> filesOf(const ReadRequest& request);

struct ReadHand {
  hand::HandModel model;  ///< its rest pose is the one asked for
  /// Joints of the file that place the whole hand, cut off (hand/floating_base.h).
  std::optional<hand::HandModel> floating_base;
  std::string urdf;  ///< the file's text
  std::vector<std::string> notes;
  std::optional<std::vector<hand::ContactSite>> sites;  ///< missing: the hand brings none
  std::vector<hand::NamedPose> poses;
};

struct ReadContacts {
  contact::ContactSet set;
  /// What the patches were found in: on its own mesh, or on the surface laid through or near
  /// its points. Missing for sets. And the threshold, as given or found.
  std::optional<contact::ContactMap> map;
  double threshold = 0.0;
};

struct ObjectName {
  std::string name;  ///< empty: the file does not say
};

struct ReadMotion {
  manipulation::Motion motion;
};

/// What a hand of the server did: it is yet to be told what that hand touched.
struct ReadHandTrajectory {
  io::HandTrajectoryPlan plan;
};

/// In the order of ReadKind.
using ReadModel = std::
    variant<ReadHand, io::MeshFile, ReadContacts, ObjectName, ReadMotion, ReadHandTrajectory>;

/// Whether reading what was asked for may bring such a model.
bool answers(const ReadModel& model, ReadKind asked);

/// Reads what is asked for.
///
/// Units and frames: metres and radians, as the files' formats have them; objects and maps in
/// other units are scaled (units.h). Errors: InvalidInput naming the file, or UnitsInDoubt;
/// Cancelled. Cost: seconds for large meshes, minutes for large clouds.
ReadModel readModel(const ReadRequest& request, const Progress& progress);

/// Most joints of a hand: the bound of `joint_rad` in sessions.idl.
inline constexpr int kMostJoints = 512;

/// The file of an upload in which a hand may bring its contact sites.
inline constexpr const char* kSitesUri = "sites.yaml";

}  // namespace handgraft::server
