#include "client/present/transfer_json.h"

#include "client/present/json_parts.h"
#include "idl/fields.h"

namespace handgraft::client::json {

namespace {

Json report(const v1::PatchReport& patch) {
  if (!patch.placed()) {
    return {{"name", patch.name()}, {"placed", false}, {"reason", patch.reason()}};
  }
  return {{"name", patch.name()},
          {"placed", true},
          {"root_S", surfacePoint(patch.root_S())},
          {"direction_S", listOf(patch.direction_S())},
          {"point_count", patch.point_count()},
          {"boundary_count", patch.boundary_count()},
          {"lost", lostPoints(patch.lost())},
          {"fidelity", fidelity(patch.fidelity())},
          {"folded", patch.folded()},
          {"method_O", nameOf(patch.method_O())},
          {"method_S", nameOf(patch.method_S())}};
}

Json suggestion(const v1::PlacementSuggestion& one) {
  Json lost = Json::array();
  for (const v1::LostCount& count : one.lost())
    lost.push_back({{"reason", count.reason()}, {"count", count.count()}});
  return {{"root_S", surfacePoint(one.root_S())},     {"p_S_m", listOf(one.p_S_m())},
          {"direction_S", listOf(one.direction_S())}, {"moved_m", one.moved_m()},
          {"turned_rad", one.turned_rad()},           {"point_count", one.point_count()},
          {"lost_count", one.lost_count()},           {"lost", lost},
          {"fidelity", fidelity(one.fidelity())}};
}

}  // namespace

std::string transfer(const v1::TransferReply& reply, int indent) {
  Json patches = Json::array();
  for (const v1::PatchReport& patch : reply.patches())
    patches.push_back(report(patch));
  return written({{"session_id", reply.session_id()},
                  {"revision", reply.revision()},
                  {"method", nameOf(reply.options().method())},
                  {"interior_rings", reply.options().interior_rings()},
                  {"patches", patches},
                  {"notes", listOf(reply.notes())},
                  {"transfer_ms", reply.transfer_ms()}},
                 indent);
}

std::string suggestions(const v1::SuggestReply& reply,
                        const std::optional<Applied>& applied,
                        int indent) {
  Json list = Json::array();
  for (const v1::PlacementSuggestion& one : reply.suggestions())
    list.push_back(suggestion(one));
  Json document = {{"session_id", reply.session_id()},
                   {"revision", reply.revision()},
                   {"patch", reply.patch()},
                   {"present", report(reply.present())},
                   {"suggestions", list},
                   {"applied", nullptr}};
  if (applied) {
    document["applied"] = {{"suggestion", applied->number},
                           {"revision", applied->revision},
                           {"report", report(applied->report)}};
  }
  return written(document, indent);
}

}  // namespace handgraft::client::json
