#include "client/present/typed_words.h"

#include <regex>
#include <string_view>

namespace handgraft::client {

namespace {

struct TypedField {
  std::string_view path;  ///< how it ends, without indices
  std::string_view typed;
};

/// Options of commands, and words of the prompt, whose range the server alone checks. The first
/// one that fits counts.
constexpr TypedField kTyped[] = {
    {"open_session.weights.distance", "--weights, distance"},
    {"open_session.weights.normal", "--weights, normal"},
    {"open_session.weights.prior", "--weights, prior"},
    {"transfer.interior_rings", "--interior"},
    {"starts", "--starts"},
    {"max_evaluations", "--max-evaluations"},
    {"patch_weight.weight", "weight"},
    {"body.weights.distance", "weights, distance"},
    {"body.weights.normal", "weights, normal"},
    {"body.weights.prior", "weights, prior"},
    {"joint_soft.weight", "soft, the last number"},
    {"drag.weight", "--weight"},
    {"prior_shares.root_rotation", "prior shares, rotation"},
    {"prior_shares.root_translation", "prior shares, place"},
    {"prior_shares.joints", "prior shares, joints"},
    {"prior_shares.posture", "prior posture"},
    {"steps.count", "undo or redo"},
};

bool endsWith(std::string_view path, std::string_view end) {
  if (path.size() == end.size()) return path == end;
  return path.ends_with(end) && path[path.size() - end.size() - 1] == '.';
}

}  // namespace

std::string asTyped(const std::string& complaint) {
  static const std::regex field_path(R"(^(body\.[\w.\[\]]+): )");
  static const std::regex array_index(R"(\[\d+\])");
  std::smatch found;
  if (!std::regex_search(complaint, found, field_path)) return complaint;
  const std::string path = std::regex_replace(found[1].str(), array_index, "");
  for (const TypedField& field : kTyped) {
    if (endsWith(path, field.path))
      return std::string(field.typed) + complaint.substr(found[1].str().size());
  }
  return complaint;
}

}  // namespace handgraft::client
