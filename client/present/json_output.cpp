#include "client/present/json_output.h"

#include "client/link/server_link.h"
#include "client/present/json_parts.h"
#include "client/present/text_output.h"
#include "idl/fields.h"

namespace handgraft::client::json {

namespace {

Json summary(const v1::ModelSummary& model) {
  return {{"kind", nameOf(model.kind())},
          {"name", model.name()},
          {"built_in", model.built_in()},
          {"text", model.text()}};
}

Json modelList(const v1::ModelList& list) {
  Json models = Json::array();
  for (const v1::ModelSummary& model : list.models())
    models.push_back(summary(model));
  return models;
}

Json terms(const v1::Terms& t) {
  return {{"distance_m2", t.distance_m2()},
          {"normal", t.normal()},
          {"prior", t.prior()},
          {"objective", t.objective()}};
}

Json times(const std::vector<v1::StageTime>& stages) {
  Json list = Json::array();
  for (const v1::StageTime& stage : stages) {
    list.push_back({{"stage", stage.stage()}, {"duration_ms", stage.duration_ms()}});
  }
  return list;
}

Json joints(const std::vector<double>& values, const std::vector<std::string>& names) {
  Json object = Json::object();
  for (std::size_t i = 0; i < std::min(values.size(), names.size()); ++i) {
    object[names[i]] = values[i];
  }
  return object;
}

Json reliefs(const std::vector<v1::LimitSensitivity>& all) {
  Json list = Json::array();
  for (const v1::LimitSensitivity& relief : all) {
    list.push_back({{"joint", relief.limit().joint()},
                    {"side", nameOf(relief.limit().side())},
                    {"position", relief.position()},
                    {"slope", relief.slope()},
                    {"given", relief.given()},
                    {"gain", relief.gain()},
                    {"gain_mm", relief.gain_mm()}});
  }
  return list;
}

Json diagnosis(const v1::PatchDiagnosis& patch) {
  return {{"verdict", nameOf(patch.verdict())},
          {"miss_m", patch.miss_m()},
          {"alone_mm", patch.alone_mm()},
          {"sensitivities", reliefs(patch.sensitivities())},
          {"text", patch.text()}};
}

Json fit(const v1::PatchFit& patch) {
  return {{"name", patch.name()},
          {"point_count", patch.point_count()},
          {"mean_mm", patch.mean_mm()},
          {"rms_mm", patch.rms_mm()},
          {"max_mm", patch.max_mm()},
          {"normal_deg", patch.normal_deg()},
          {"within_2mm", patch.within_2mm()},
          {"within_5mm", patch.within_5mm()},
          {"diagnosis", diagnosis(patch.diagnosis())}};
}

Json state(const v1::SessionState& session) {
  return {{"session_id", session.session_id()}, {"revision", session.revision()},
          {"phase", nameOf(session.phase())},   {"hand", session.hand()},
          {"object", session.object()},         {"contacts", session.contacts()},
          {"message", session.message()},       {"progress", session.progress()}};
}

// One entry a patch of the contact set: how it fits, or why it was dropped.
Json graspPatches(const GraspResult& result) {
  Json patches = Json::array();
  for (const v1::PatchFit& patch : result.solution.patches()) {
    Json entry = fit(patch);
    entry["placed"] = true;
    if (const v1::PatchReport* report = reportOf(result, patch.name())) {
      entry["lost"] = lostPoints(report->lost());
      entry["fidelity"] = fidelity(report->fidelity());
      entry["folded"] = report->folded();
      entry["method_O"] = nameOf(report->method_O());
      entry["method_S"] = nameOf(report->method_S());
      entry["root_S"] = surfacePoint(report->root_S());
    }
    entry["hand_W_m"] = points(patch.hand_W_m());
    entry["object_W_m"] = points(patch.object_W_m());
    patches.push_back(entry);
  }
  for (const v1::PatchReport& report : result.transfer.patches()) {
    if (report.placed()) continue;
    patches.push_back(
        {{"name", report.name()}, {"placed", false}, {"reason", report.reason()}});
  }
  return patches;
}

/// Null where the server did not say.
Json penetration(const v1::PoseSolution& solution) {
  if (solution.penetration().empty()) return nullptr;
  const v1::Penetration& inside = solution.penetration().front();
  Json links = Json::object();
  for (const v1::LinkDepth& depth : inside.links())
    links[depth.link()] = depth.depth_m();
  return {{"max_depth_m", inside.max_depth_m()},   {"mean_depth_m", inside.mean_depth_m()},
          {"volume_m3", inside.volume_m3()},       {"links", links},
          {"self_depth_m", inside.self_depth_m()}, {"self_links", listOf(inside.self_links())}};
}

}  // namespace

std::string doctor(const DoctorReport& report, int indent) {
  Json document = {{"version", report.version},     {"protocol_version", v1::PROTOCOL_VERSION},
                   {"interface", report.interface}, {"address", report.address},
                   {"domain", report.domain},       {"server", nullptr}};
  if (report.server) {
    const v1::ServerStatus& status = *report.server;
    document["server"] = {{"server_id", status.server_id()},
                          {"version", status.version()},
                          {"protocol_version", status.protocol_version()},
                          {"host", status.host()},
                          {"process_id", status.process_id()},
                          {"uptime_s", status.uptime_s()},
                          {"model_count", status.model_count()},
                          {"session_count", status.session_count()},
                          {"requests_answered", status.requests_answered()},
                          {"requests_running", status.requests_running()},
                          {"stopping", status.stopping()}};
    document["found_ms"] = report.found_ms;
    document["round_trip_ms"] = report.round_trip_ms;
    document["models"] = modelList(report.models);
  }
  document["advice"] = report.advice;
  return written(document, indent);
}

std::string models(const v1::ModelList& list, int indent) {
  return written({{"models", modelList(list)}}, indent);
}

std::string loaded(const v1::ModelSummary& model,
                   const std::vector<std::string>& notes,
                   int indent) {
  Json document = summary(model);
  if (!notes.empty()) document["notes"] = listOf(notes);
  return written(document, indent);
}

std::string sessions(const v1::SessionList& list, int indent) {
  Json all = Json::array();
  for (const v1::SessionState& session : list.sessions())
    all.push_back(state(session));
  return written({{"sessions", all}}, indent);
}

std::string closed(std::uint64_t session_id, int indent) {
  return written({{"session_id", session_id}, {"closed", true}}, indent);
}

std::string unloaded(v1::ModelKind kind, const std::string& name, int indent) {
  return written({{"kind", nameOf(kind)}, {"name", name}, {"unloaded", true}}, indent);
}

std::string grasp(const GraspResult& result, int indent) {
  const v1::PoseSolution& solution = result.solution;
  std::vector<std::string> joint_names;
  for (const v1::JointInfo& joint : result.hand.joints())
    joint_names.push_back(joint.name());
  Json links = Json::object();
  for (std::size_t i = 0; i < std::min(result.hand.links().size(), solution.X_WL().size());
       ++i) {
    links[result.hand.links()[i].name()] = pose(solution.X_WL()[i]);
  }
  Json document = {{"format", "handgraft-grasp/1"},
                   {"hand", result.session.hand()},
                   {"object", result.session.object()},
                   {"contacts", result.session.contacts()},
                   {"session_id", result.kept ? Json(solution.session_id()) : Json(nullptr)},
                   {"outcome", nameOf(solution.outcome())},
                   {"solver", solution.solver()},
                   {"evaluations", solution.evaluations()},
                   {"X_WH", pose(solution.X_WH())},
                   {"X_WO", pose(solution.X_WO())},
                   {"joints", joints(solution.joint_positions(), joint_names)},
                   {"links_X_WL", links},
                   {"terms", terms(solution.terms())},
                   {"joints_at_limit", text::limitNames(solution.joints_at_limit())},
                   {"verdict", solution.verdict()},
                   {"too_large", solution.too_large()},
                   {"sensitivities", reliefs(solution.sensitivities())},
                   {"patches", graspPatches(result)},
                   {"notes", listOf(result.transfer.notes())},
                   {"hand_notes", listOf(result.hand.notes())},
                   {"minima", minima(solution, result.hand)},
                   {"penetration", penetration(solution)},
                   {"times", times(solution.times())},
                   {"transfer_ms", result.transfer.transfer_ms()},
                   {"total_ms", result.total_ms}};
  return written(document, indent);
}

std::string stateEvent(const v1::SessionState& session) {
  Json event = {{"event", "state"}};
  event.update(state(session));
  return written(event, -1);
}

std::string solutionEvent(const v1::PoseSolution& solution,
                          const std::vector<std::string>& joint_names) {
  Json patches = Json::array();
  for (const v1::PatchFit& patch : solution.patches())
    patches.push_back(fit(patch));
  return written({{"event", "solution"},
                  {"session_id", solution.session_id()},
                  {"revision", solution.revision()},
                  {"sequence_number", solution.sequence_number()},
                  {"is_final", solution.is_final()},
                  {"is_diagnosed", solution.is_diagnosed()},
                  {"verdict", solution.verdict()},
                  {"outcome", nameOf(solution.outcome())},
                  {"solver", solution.solver()},
                  {"X_WH", pose(solution.X_WH())},
                  {"X_WO", pose(solution.X_WO())},
                  {"joint_positions", listOf(solution.joint_positions())},
                  {"joints", joints(solution.joint_positions(), joint_names)},
                  {"terms", terms(solution.terms())},
                  {"patches", patches},
                  {"stamp_ns", solution.stamp_ns()}},
                 -1);
}

}  // namespace handgraft::client::json
