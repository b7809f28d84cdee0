#include "server/messages/descriptions.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/contact/touching_side.h"
#include "core/hand/anatomy.h"
#include "core/hand/hand_location.h"
#include "core/hand/joint_numbers.h"
#include "core/hand/kinematics.h"
#include "core/io/contact_file.h"
#include "core/io/motion_file.h"
#include "core/io/sites_file.h"
#include "core/io/urdf_text.h"
#include "core/io/urdf_writer.h"
#include "core/retargeting/motion_solving.h"
#include "idl/fields.h"
#include "server/base/rejection.h"
#include "server/messages/convert.h"

namespace handgraft::server {

namespace {

std::size_t bytesOf(const v1::Mesh& mesh) {
  return 4 * (mesh.vertices_m().size() + mesh.triangles().size());
}

std::size_t bytesOf(const geometry::TriangleMesh& mesh) {
  return 12 * static_cast<std::size_t>(mesh.vertexCount() + mesh.faceCount());
}

void requireSendable(const char* kind, const std::string& name, std::size_t bytes) {
  if (bytes <= kMostMeshBytes) return;
  reject(v1::ERROR_OVERLOADED,
         "{} {}: its meshes take {} MiB; at most {} are sent; ask without meshes", kind,
         handgraft::quoted(name), bytes >> 20, kMostMeshBytes >> 20);
}

v1::SegmentInfo segmentInfo(const hand::HandModel& model,
                            const hand::LinkPoses& X_SL,
                            const hand::Segment& segment) {
  // Frames without a surface may follow, and say nothing of where it is.
  const auto has_surface = [&](int link) {
    return !model.links()[static_cast<std::size_t>(link)].surface().empty();
  };
  const auto body = std::find_if(segment.links.rbegin(), segment.links.rend(), has_surface);
  const int link = body != segment.links.rend() ? *body : segment.links.back();
  v1::SegmentInfo info;
  info.name(segment.name);
  info.link(model.links()[static_cast<std::size_t>(link)].name);
  info.length_m(segment.length());
  const Eigen::Vector3d palmar_L =
      X_SL[static_cast<std::size_t>(link)].linear().transpose() * segment.palmar_S;
  info.palmar_L({palmar_L.x(), palmar_L.y(), palmar_L.z()});
  return info;
}

/// What its names and its shape say of a hand's fingers, and what they do not.
void addFingers(v1::HandDescription& message, const hand::Hand& hand, bool is_mirrored) {
  hand::LinkPoses X_SL;
  forwardKinematics(*hand.model, Pose::Identity(), hand.skin->qReference(), X_SL);
  const hand::Anatomy anatomy = anatomyOf(*hand.model, X_SL, hand.sites);
  for (const hand::NamedDigit& digit : anatomy.digits) {
    v1::DigitInfo info;
    info.name(digit.name);
    // A site that was found has the name that the digit had.
    info.named_by_file(digit.named_by_parts || (digit.named_by_site && !hand.sites_are_found));
    for (const hand::Segment& segment : digit.segments)
      info.segments().push_back(segmentInfo(*hand.model, X_SL, segment));
    message.digits().push_back(std::move(info));
  }
  for (const std::string& note : anatomy.notes)
    message.notes().push_back(note);
  if (!is_mirrored && !anatomy.side_note.empty()) message.notes().push_back(anatomy.side_note);
  if (const hand::Chirality side = sideOf(anatomy); side != hand::Chirality::kUnknown) {
    message.chirality(toMessage(side));
    message.notes().push_back(fmt::format("a {} hand", nameOf(side)));
  }
  const auto has_site = [&](const std::string& name) {
    return std::any_of(hand.sites.begin(), hand.sites.end(),
                       [&](const hand::ContactSite& site) {
                         return site.name == name;
                       });
  };
  for (const hand::NamedDigit& digit : anatomy.digits) {
    if (hand.sites_are_found && !hand.sites.empty() && !has_site(digit.name))
      message.notes().push_back(
          fmt::format("no pad was found on its {}: a sites file beside the URDF may say where "
                      "it touches",
                      digit.name));
  }
  if (!has_site(hand::kPalmPart) && !anatomy.palm)
    message.notes().emplace_back(
        "no place of its palm is known: patches of a palm are dropped");
}

std::vector<double> entries(const Eigen::VectorXd& values) {
  return {values.data(), values.data() + values.size()};
}

/// Places as x y z of each.
std::vector<double> positionsOf(const geometry::TriangleMesh& mesh,
                                const std::vector<geometry::SurfacePoint>& places) {
  std::vector<double> positions;
  positions.reserve(3 * places.size());
  for (const geometry::SurfacePoint& place : places) {
    const Eigen::Vector3d p = geometry::positionOf(mesh, place);
    positions.insert(positions.end(), p.data(), p.data() + 3);
  }
  return positions;
}

/// All surfaces of a link as one mesh.
v1::Mesh surfaceOf(const hand::Link& link) {
  v1::Mesh all;
  for (const hand::Shape& shape : link.surface()) {
    const v1::Mesh part = toMessage(shape.mesh_L);
    const auto first = static_cast<std::uint32_t>(all.vertices_m().size() / 3);
    all.vertices_m().insert(all.vertices_m().end(), part.vertices_m().begin(),
                            part.vertices_m().end());
    for (const std::uint32_t corner : part.triangles())
      all.triangles().push_back(first + corner);
  }
  return all;
}

v1::JointInfo jointInfo(const hand::HandModel& model, int dof) {
  const hand::Joint& joint = model.dofJoint(dof);
  v1::JointInfo info;
  info.name(joint.name);
  info.parent_link(joint.parent_link);
  info.child_link(joint.child_link);
  info.kind(kindOf(joint));
  for (const hand::JointNumber& number : hand::kJointNumbers) {
    const idl::Field* field = idl::fieldOf(idl::typeOf<v1::JointInfo>(), number.name);
    HANDGRAFT_REQUIRE(field != nullptr && field->type->kind == idl::Kind::kDouble);
    *static_cast<double*>(field->in(&info)) = joint.*number.value;
  }
  // Followers narrow the range.
  info.lower(model.lower()[dof]);
  info.upper(model.upper()[dof]);
  return info;
}

v1::SiteInfo siteInfo(const hand::ContactSite& site) {
  v1::SiteInfo info;
  info.name(site.name);
  info.link(site.link);
  info.p_L_m(toMessage(site.p_L));
  info.n_L(toMessage(site.n_L));
  info.direction_L(toMessage(site.direction_L));
  return info;
}

v1::MimicInfo mimicInfo(const hand::Joint& joint) {
  v1::MimicInfo info;
  info.joint(joint.name);
  info.kind(kindOf(joint));
  info.source(joint.mimic->source_joint);
  info.multiplier(joint.mimic->multiplier);
  info.offset(joint.mimic->offset);
  return info;
}

v1::NamedPose namedPose(const hand::NamedPose& pose) {
  v1::NamedPose message;
  message.name(pose.name);
  message.joint_positions(entries(pose.q));
  return message;
}

v1::SkinStep skinStep(const hand::SkinStep& step) {
  v1::SkinStep message;
  message.action(step.action);
  message.verdict(step.verdict);
  message.alpha_m(step.alpha_m);
  message.offset_m(step.offset_m);
  message.edge_m(step.edge_m);
  message.time_s(step.time_s);
  message.vertices(static_cast<std::uint32_t>(step.vertices));
  message.pieces(static_cast<std::uint32_t>(step.pieces));
  message.genus(step.genus);
  message.covering_share(step.covering_share);
  message.sheets(static_cast<std::uint32_t>(step.sheets));
  message.sheets_area_m2(step.sheets_area_m2);
  message.crossing_faces(static_cast<std::uint32_t>(step.crossing_faces));
  return message;
}

v1::SkinReport skinReport(const hand::SkinReport& report) {
  v1::SkinReport message;
  for (const hand::SkinStep& step : report.steps)
    message.steps().push_back(skinStep(step));
  message.text(hand::describe(report));
  message.time_s(report.time_s);
  message.from_cache(report.from_cache);
  message.valid(report.isValid());
  message.closed(report.is_closed);
  message.vertices(static_cast<std::uint32_t>(report.vertices));
  message.faces(static_cast<std::uint32_t>(report.faces));
  message.pieces(static_cast<std::uint32_t>(report.pieces));
  message.genus(report.genus);
  message.crossing_faces(static_cast<std::uint32_t>(report.crossing_faces));
  message.shortest_edge_m(report.shortest_edge_m);
  message.mean_edge_m(report.mean_edge_m);
  message.longest_edge_m(report.longest_edge_m);
  message.smallest_angle_rad(report.smallest_angle_rad);
  message.mean_clearance_m(report.mean_clearance_m);
  message.max_clearance_m(report.max_clearance_m);
  message.projected_share(report.projected_share);
  message.notes(report.notes);
  return message;
}

/// Meshes, and all that is known of the skin alone.
void addSkin(v1::HandDescription& message, const SkinnedHand& skinned) {
  const hand::HandModel& model = *skinned.hand.model;
  const hand::Skin& skin = *skinned.hand.skin;
  std::size_t bytes = bytesOf(skin.mesh());
  for (int i = 0; i < model.linkCount(); ++i) {
    v1::Mesh surface = surfaceOf(model.links()[static_cast<std::size_t>(i)]);
    bytes += bytesOf(surface);
    requireSendable("hand", message.name(), bytes);
    message.links()[static_cast<std::size_t>(i)].surface_L(std::move(surface));
  }
  message.skin_S(toMessage(skin.mesh()));
  message.skin_face_links(skin.faceLinks());
  for (const Pose& X_SL :
       hand::forwardKinematics(model, {Pose::Identity(), skin.qReference()})) {
    message.X_SL().push_back(toMessage(X_SL));
  }
  message.skin_report().push_back(skinReport(skinned.report));
}

v1::MapInfo mapInfo(const contact::ContactMap& map, double threshold) {
  v1::MapInfo info;
  info.mesh_O(toMessage(map.mesh_O));
  const Eigen::VectorXf values = map.value.cast<float>();
  info.value().assign(values.data(), values.data() + values.size());
  info.threshold(threshold);
  return info;
}

}  // namespace

std::string urdfOf(const StoredHand& hand) {
  if (!hand.mirrored) return hand.urdf;
  return io::kinematicUrdfText(
      hand.hand->model(),
      "Links and joints of a mirrored hand, written by handgraft; no meshes",
      io::effortLimitsOf(hand.urdf));
}

v1::HandDescription describe(const StoredHand& hand,
                             const std::optional<SkinnedHand>& skinned) {
  const hand::HandModel& model = hand.hand->model();
  v1::HandDescription message;
  message.name(hand.name);
  message.mirrored(hand.mirrored);
  for (int dof = 0; dof < model.dofCount(); ++dof)
    message.joints().push_back(jointInfo(model, dof));
  for (const hand::Joint& joint : model.joints())
    if (joint.mimic) message.mimics().push_back(mimicInfo(joint));
  if (hand.floating_base) message.free_root_joints(hand.floating_base->dofNames());
  for (const hand::NamedPose& pose : hand.poses)
    message.poses().push_back(namedPose(pose));
  for (const hand::Link& link : model.links()) {
    v1::LinkInfo info;
    info.name(link.name);
    message.links().push_back(std::move(info));
  }
  message.notes(hand.notes);
  message.sites_found(!hand.hand->ownSites());
  auto sites = hand.hand->ownSites();
  if (const auto ready = hand.hand->ready()) sites = ready->sites;
  if (sites && sites->empty())
    message.notes().emplace_back(
        "no contact site was found, so no patch can be laid on this hand: fingers that are not "
        "found by their joints need a sites.yaml beside the URDF");
  if (sites) {
    for (const hand::ContactSite& site : *sites)
      message.sites().push_back(siteInfo(site));
    message.sites_file(io::sitesText(*sites, hand.mirrored));
  }
  if (skinned) addSkin(message, *skinned);
  message.rest_positions(entries(model.restPose()));
  message.urdf(urdfOf(hand));
  if (hand.mirrored) message.notes().emplace_back("mirrored: the other hand of its file");
  for (const std::string& note : hand.hand->skinNotes())
    message.notes().push_back(note);
  if (const auto ready = hand.hand->ready()) addFingers(message, *ready, hand.mirrored);
  return message;
}

v1::ObjectDescription describe(const StoredObject& object, bool with_meshes) {
  v1::ObjectDescription message;
  message.name(object.name);
  if (with_meshes) {
    requireSendable("object", object.name, bytesOf(object.file->mesh));
    message.mesh_O(toMessage(object.file->mesh));
  }
  message.notes(object.file->notes);
  return message;
}

v1::ContactsDescription describe(const StoredContacts& contacts, bool with_meshes) {
  const geometry::TriangleMesh& mesh = contacts.object->mesh;
  v1::ContactsDescription message;
  message.name(contacts.name);
  message.object(contacts.set.object);
  message.demonstrator(toMessage(contact::touchingSide(contacts.set, mesh)));
  message.notes(contacts.set.notes);
  for (const contact::Patch& patch : contacts.set.patches) {
    v1::PatchInfo info;
    info.name(patch.name);
    info.root(toMessage(patch.root));
    if (patch.direction_O) info.direction_O(entries(*patch.direction_O));
    info.point_count(static_cast<std::uint32_t>(patch.interpolation_boundary.size()));
    info.outline_O_m(positionsOf(mesh, patch.interpolation_boundary));
    info.weight(patch.weight);
    if (patch.place) info.place().push_back(toMessage(*patch.place));
    message.patches().push_back(std::move(info));
  }
  // A cloud's surface has no indices in the object's file that a set could name.
  if (contacts.object->cloud_O.cols() == 0)
    message.file(io::contactSetText(contacts.set, *contacts.object));
  if (with_meshes && contacts.map) {
    requireSendable("contacts", contacts.name,
                    bytesOf(contacts.map->mesh_O) + 4 * contacts.map->label.size());
    message.contact_map().push_back(mapInfo(*contacts.map, contacts.threshold));
  }
  return message;
}

v1::MotionDescription describe(const StoredMotion& stored, bool with_file) {
  const manipulation::Motion& motion = *stored.motion;
  const auto since_begin = [&](int frame) {
    return motion.time_s[static_cast<std::size_t>(std::min(frame, motion.frameCount() - 1))] -
           motion.time_s.front();
  };
  v1::MotionDescription message;
  message.name(stored.name);
  message.object(stored.object_name);
  const geometry::TriangleMesh& object_O = stored.object->mesh;
  message.demonstrator(
      toMessage(contact::touchingSide(retargeting::graspOf(motion, object_O), object_O)));
  message.duration_s(motion.duration());
  message.frame_count(static_cast<std::uint32_t>(motion.frameCount()));
  message.patches(retargeting::patchNames(motion));
  for (const manipulation::PatchTrack& track : motion.tracks) {
    v1::PresenceInfo presence;
    presence.patch(track.name);
    presence.begin(static_cast<std::uint32_t>(track.begin()));
    presence.end(static_cast<std::uint32_t>(track.end));
    presence.begin_s(since_begin(track.begin()));
    presence.end_s(since_begin(track.end));
    message.presence().push_back(std::move(presence));
  }
  if (with_file) {
    message.file(io::motionText(motion, stored.object->mesh));
    if (message.file().size() > kMostMeshBytes) {
      reject(v1::ERROR_OVERLOADED, "motion {}: its file takes {} MiB; at most {} are sent",
             handgraft::quoted(stored.name), message.file().size() >> 20, kMostMeshBytes >> 20);
    }
  }
  message.notes(motion.notes);
  for (std::string& remark : remarksOn(motion))
    message.notes().push_back(std::move(remark));
  return message;
}

}  // namespace handgraft::server
