#include "client/present/model_json.h"

#include <algorithm>

#include "client/present/json_parts.h"
#include "idl/fields.h"
#include "idl/json.h"

namespace handgraft::client::json {

namespace {

Json skinReport(const v1::SkinReport& report) {
  Json steps = Json::array();
  for (const v1::SkinStep& step : report.steps()) {
    steps.push_back({{"action", step.action()},
                     {"verdict", step.verdict()},
                     {"alpha_m", step.alpha_m()},
                     {"offset_m", step.offset_m()},
                     {"edge_m", step.edge_m()},
                     {"time_s", step.time_s()},
                     {"vertices", step.vertices()},
                     {"pieces", step.pieces()},
                     {"genus", step.genus()},
                     {"covering_share", step.covering_share()},
                     {"sheets", step.sheets()},
                     {"sheets_area_m2", step.sheets_area_m2()},
                     {"crossing_faces", step.crossing_faces()}});
  }
  return {{"valid", report.valid()},
          {"closed", report.closed()},
          {"pieces", report.pieces()},
          {"genus", report.genus()},
          {"crossing_faces", report.crossing_faces()},
          {"vertices", report.vertices()},
          {"faces", report.faces()},
          {"shortest_edge_m", report.shortest_edge_m()},
          {"mean_edge_m", report.mean_edge_m()},
          {"longest_edge_m", report.longest_edge_m()},
          {"smallest_angle_rad", report.smallest_angle_rad()},
          {"mean_clearance_m", report.mean_clearance_m()},
          {"max_clearance_m", report.max_clearance_m()},
          {"projected_share", report.projected_share()},
          {"from_cache", report.from_cache()},
          {"time_s", report.time_s()},
          {"steps", steps},
          {"notes", listOf(report.notes())}};
}

Json handDocument(const v1::HandDescription& hand) {
  Json all_joints = Json::array();
  for (const v1::JointInfo& joint : hand.joints()) {
    all_joints.push_back(
        {{"name", joint.name()},
         {"parent_link", joint.parent_link()},
         {"child_link", joint.child_link()},
         {"kind", nameOf(joint.kind())},
         {"lower", joint.lower()},
         {"upper", joint.upper()},
         {"velocity_limit",
          joint.velocity_limit() > 0.0 ? Json(joint.velocity_limit()) : Json(nullptr)}});
  }
  Json links = Json::array();
  for (const v1::LinkInfo& link : hand.links())
    links.push_back(link.name());
  Json sites = Json::array();
  for (const v1::SiteInfo& site : hand.sites()) {
    sites.push_back({{"name", site.name()},
                     {"link", site.link()},
                     {"p_L_m", listOf(site.p_L_m())},
                     {"n_L", listOf(site.n_L())},
                     {"direction_L", listOf(site.direction_L())}});
  }
  Json mimics = Json::array();
  for (const v1::MimicInfo& mimic : hand.mimics()) {
    mimics.push_back({{"joint", mimic.joint()},
                      {"source", mimic.source()},
                      {"multiplier", mimic.multiplier()},
                      {"offset", mimic.offset()}});
  }
  Json poses = Json::object();
  for (const v1::NamedPose& pose : hand.poses()) {
    Json& values = poses[pose.name()] = Json::object();
    for (std::size_t i = 0; i < std::min(pose.joint_positions().size(), hand.joints().size());
         ++i) {
      values[hand.joints()[i].name()] = pose.joint_positions()[i];
    }
  }
  return {{"kind", "hand"},
          {"name", hand.name()},
          {"mirrored", hand.mirrored()},
          {"joints", all_joints},
          {"mimics", mimics},
          {"free_root_joints", listOf(hand.free_root_joints())},
          {"poses", poses},
          {"links", links},
          {"sites", sites},
          {"sites_found", hand.sites_found()},
          {"rest_positions", listOf(hand.rest_positions())},
          {"skin",
           hand.skin_report().empty() ? Json(nullptr) : skinReport(hand.skin_report().front())},
          {"notes", listOf(hand.notes())}};
}

// The set as a document, not as text in one.
Json contactSet(const std::string& file) {
  Json document = Json::parse(file, nullptr, false);
  return document.is_discarded() ? Json(nullptr) : document;
}

Json contactsDocument(const v1::ContactsDescription& contacts) {
  Json patches = Json::array();
  for (const v1::PatchInfo& patch : contacts.patches()) {
    patches.push_back(
        {{"name", patch.name()},
         {"root", surfacePoint(patch.root())},
         {"direction_O",
          patch.direction_O().empty() ? Json(nullptr) : listOf(patch.direction_O())},
         {"point_count", patch.point_count()},
         {"outline_O_m", points(patch.outline_O_m())},
         {"weight", patch.weight()}});
  }
  return {{"kind", "contacts"},
          {"name", contacts.name()},
          {"object", contacts.object()},
          {"threshold", contacts.contact_map().empty()
                            ? Json(nullptr)
                            : Json(contacts.contact_map().front().threshold())},
          {"patches", patches},
          {"set", contactSet(contacts.file())},
          {"notes", listOf(contacts.notes())}};
}

}  // namespace

std::string description(const v1::ModelDescription& description, int indent) {
  switch (description._d()) {
    case v1::MODEL_HAND:
      return written(handDocument(description.hand()), indent);
    case v1::MODEL_CONTACTS:
      return written(contactsDocument(description.contacts()), indent);
    case v1::MODEL_MOTION:
      return idl::jsonText(description, indent);
    case v1::MODEL_OBJECT:
      break;
  }
  const v1::ObjectDescription& object = description.object();
  return written({{"kind", "object"},
                  {"name", object.name()},
                  {"vertices", object.mesh_O().vertices_m().size() / 3},
                  {"triangles", object.mesh_O().triangles().size() / 3},
                  {"notes", listOf(object.notes())}},
                 indent);
}

std::string skin(const std::string& hand, const v1::SkinReport& report, int indent) {
  return written({{"hand", hand}, {"skin", skinReport(report)}}, indent);
}

}  // namespace handgraft::client::json
