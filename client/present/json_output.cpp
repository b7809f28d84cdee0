#include "client/present/json_output.h"

#include "client/present/minima_text.h"
#include "idl/grasp_file.h"
#include "idl/service.h"

namespace handgraft::client::json {

namespace {

template <class Named>
std::vector<std::string> namesOf(const std::vector<Named>& all) {
  std::vector<std::string> names;
  names.reserve(all.size());
  for (const Named& one : all)
    names.push_back(one.name());
  return names;
}

}  // namespace

Json doctor(const DoctorReport& report) {
  Json document = {{"version", report.version},     {"protocol_version", v1::PROTOCOL_VERSION},
                   {"interface", report.interface}, {"address", report.address},
                   {"domain", report.domain},       {"server", nullptr}};
  if (report.server) {
    document["server"] = jsonOf(*report.server);
    document["found_ms"] = report.found_ms;
    document["round_trip_ms"] = report.round_trip_ms;
    document.update(jsonOf(report.models));
  }
  document["advice"] = report.advice;
  return document;
}

Json loaded(const v1::ModelSummary& summary, const std::vector<std::string>& notes) {
  Json document = jsonOf(summary);
  if (!notes.empty()) document["notes"] = notes;
  return document;
}

Json description(v1::ModelDescription description) {
  Json sizes = Json::object();
  if (description._d() == v1::MODEL_HAND) {
    v1::HandDescription& hand = description.hand();
    hand.skin_S(v1::Mesh());
    hand.skin_face_links().clear();
    for (v1::LinkInfo& link : hand.links())
      link.surface_L(v1::Mesh());
  } else if (description._d() == v1::MODEL_OBJECT) {
    v1::Mesh& mesh = description.object().mesh_O();
    sizes = {{"vertices", mesh.vertices_m().size() / 3},
             {"triangles", mesh.triangles().size() / 3}};
    mesh = v1::Mesh();
  } else if (description._d() == v1::MODEL_CONTACTS) {
    for (v1::MapInfo& map : description.contacts().contact_map()) {
      map.mesh_O(v1::Mesh());
      map.value().clear();
    }
  }
  if (description._d() == v1::MODEL_MOTION) description.motion().file("");
  const Json all = jsonOf(description);
  Json document = {{"kind", all["kind"]}};
  document.update(all[all["kind"].get<std::string>()]);
  document.update(sizes);
  return document;
}

Json grasp(const GraspResult& result) {
  const v1::SessionState& session = result.session;
  Json document = idl::graspFile(
      {session.hand(), session.object(), session.contacts(), namesOf(result.hand.joints()),
       namesOf(result.hand.links()), result.weights},
      result.solution, result.transfer.patches());
  if (!result.kept) document["session_id"] = nullptr;
  const auto& minima = result.solution.minima();
  for (std::size_t i = 0; i < minima.size(); ++i) {
    const PoseGap gap = gapBetween(minima.front(), minima[i], result.hand);
    document["minima"][i].update({{"rank", i + 1},
                                  {"taken", i == result.solution.chosen_minimum()},
                                  {"moved_mm", gap.moved_mm},
                                  {"turned_deg", gap.turned_deg}});
  }
  document["notes"] = result.transfer.notes();
  document["hand_notes"] = result.hand.notes();
  document["object_notes"] = result.object_notes;
  document["transfer_ms"] = result.transfer.transfer_ms();
  document["total_ms"] = result.total_ms;
  return document;
}

Json suggestions(const v1::SuggestReply& reply, const std::optional<Applied>& applied) {
  Json document = jsonOf(reply);
  document["applied"] = nullptr;
  if (applied) {
    document["applied"] = {{"suggestion", applied->number},
                           {"revision", applied->revision},
                           {"report", jsonOf(applied->report)}};
  }
  return document;
}

std::string motionEvent(const v1::MotionFrames& frames) {
  return written(Json{{"event", "motion"},
                      {"session_id", frames.session_id()},
                      {"revision", frames.revision()},
                      {"frame_count", frames.frame_count()}},
                 -1);
}

std::string stateEvent(const v1::SessionState& state) {
  Json event = {{"event", "state"}};
  event.update(jsonOf(state));
  return written(event, -1);
}

std::string solutionEvent(const v1::PoseSolution& solution,
                          const std::vector<std::string>& joint_names) {
  Json event = {{"event", "solution"}};
  event.update(jsonOf(solution));
  event["joints"] = idl::byName(joint_names, event["joint_positions"]);
  return written(event, -1);
}

}  // namespace handgraft::client::json
