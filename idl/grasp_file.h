#pragma once

#include <optional>
#include <string>
#include <vector>

#include "idl/json.h"
#include "idl/sessions.h"

/// `handgraft-grasp/1`: one grasp as a document, which is read wherever a pose is. The one
/// writer.
namespace handgraft::idl {

/// What a solution does not say by itself.
struct GraspNames {
  std::string hand;
  std::string object;
  std::string contacts;
  std::vector<std::string> joints;       ///< in the order of `joint_positions`
  std::vector<std::string> links;        ///< in the order of `X_WL`; empty: without
  std::optional<v1::Weights> weights{};  ///< of the terms; empty: not known
};

/// What the objective charges for penetration: all of it that the weighted terms are not, but
/// for what sums round away.
double penetrationCharge(const v1::Terms& terms, const v1::Weights& weights);

/// An object of the values by their names.
Json byName(const std::vector<std::string>& names, const Json& values);

/// `format`, `hand`, `object`, `contacts`; `joints` (positions by name) and `links_X_WL` (poses
/// by name) instead of `joint_positions` and `X_WL`; then every other key of PoseSolution as
/// idl/json.h writes it. Of minima, `joints` likewise; of patches, their reports' fields, too,
/// and after them those that were dropped. With `weights` they are told, and of all terms, of
/// minima too, `penetration`: its charge.
Json graspFile(const GraspNames& names,
               const v1::PoseSolution& solution,
               const std::vector<v1::PatchReport>& reports);

/// The same as text.
std::string graspText(const GraspNames& names,
                      const v1::PoseSolution& solution,
                      const std::vector<v1::PatchReport>& reports);

}  // namespace handgraft::idl
