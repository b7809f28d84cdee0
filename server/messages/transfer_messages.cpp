#include "server/messages/transfer_messages.h"

#include <algorithm>
#include <string>
#include <utility>

#include <Eigen/Geometry>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/error.h"
#include "core/geometry/main_extent.h"
#include "idl/fields.h"
#include "server/messages/convert.h"

namespace handgraft::server {

namespace {

constexpr double kWidestGrasp = 0.4;  // m; twice what a large hand spans

v1::LostPoint toMessage(const transfer::LostPoint& lost) {
  v1::LostPoint message;
  message.index(static_cast<std::uint32_t>(lost.index));
  message.ring(static_cast<std::uint32_t>(lost.ring));
  message.reason(lost.reason);
  return message;
}

/// How many were lost for each reason, in the order in which the reasons first come up.
std::vector<v1::LostCount> countedByReason(const std::vector<transfer::LostPoint>& lost) {
  std::vector<v1::LostCount> counts;
  for (const transfer::LostPoint& point : lost) {
    auto known = std::find_if(counts.begin(), counts.end(), [&](const v1::LostCount& count) {
      return count.reason() == point.reason;
    });
    if (known == counts.end()) {
      known = counts.emplace(counts.end());
      known->reason(point.reason);
    }
    known->count(known->count() + 1);
  }
  return counts;
}

v1::LogMapMethod methodMessage(geometry::LogMapMethod method) {
  return v1::enumeratorFrom<v1::LogMapMethod>(geometry::nameOf(method), "log map method");
}

}  // namespace

transfer::TransferOptions transferOptionsFrom(const std::vector<v1::TransferOptions>& options) {
  transfer::TransferOptions result;
  if (options.empty()) return result;
  if (options.size() > 1) {
    rejectInput("transfer: {} entries; at most 1 is allowed", options.size());
  }
  const v1::TransferOptions& message = options.front();
  if (message.method() != v1::LOG_MAP_DEFAULT)
    result.method = geometry::logMapMethodFrom(nameOf(message.method()));
  if (message.interior_rings() > transfer::kMostInteriorRings) {
    rejectInput("interior_rings: {} is outside 0-{}", message.interior_rings(),
                transfer::kMostInteriorRings);
  }
  result.interior_rings = static_cast<int>(message.interior_rings());
  return result;
}

transfer::SuggestOptions suggestOptionsFrom(const v1::SuggestRequest& request) {
  constexpr unsigned kMostSuggestions = 100;
  if (request.count() > kMostSuggestions) {
    rejectInput("count of suggestions: {} is outside 0-{}", request.count(), kMostSuggestions);
  }
  transfer::SuggestOptions options;
  if (request.count() > 0) options.count = static_cast<int>(request.count());
  if (request.reach_m() != 0.0) options.reach_m = request.reach_m();
  validate(options);
  return options;
}

v1::TransferOptions toMessage(const transfer::TransferOptions& options) {
  v1::TransferOptions message;
  message.method(methodMessage(options.method));
  message.interior_rings(static_cast<std::uint32_t>(options.interior_rings));
  return message;
}

v1::Fidelity toMessage(const transfer::Fidelity& fidelity) {
  v1::Fidelity message;
  message.distance_mean(fidelity.distance_mean);
  message.distance_max(fidelity.distance_max);
  message.angle_mean_rad(fidelity.angle_mean_rad);
  message.angle_max_rad(fidelity.angle_max_rad);
  message.area_ratio(fidelity.area_ratio);
  message.projection_mean_m(fidelity.projection_mean_m);
  message.projection_max_m(fidelity.projection_max_m);
  return message;
}

v1::PatchReport patchReport(const session::SessionPatch& patch,
                            const hand::FingerCoordinates& on) {
  v1::PatchReport report;
  report.name(patch.patch.name);
  report.placed(patch.placement.has_value());
  report.reason(patch.dropped);
  if (!patch.placement) return report;
  const transfer::PatchTransfer& transferred = patch.transferred;
  report.root_S(toMessage(patch.placement->root_S));
  report.direction_S(toMessage(patch.placement->direction_S));
  if (const auto place = on.placeOf(patch.placement->root_S))
    report.place().push_back(toMessage(*place));
  report.point_count(static_cast<std::uint32_t>(transferred.correspondences.size()));
  report.boundary_count(static_cast<std::uint32_t>(transferred.boundary_count));
  for (const transfer::LostPoint& lost : transferred.lost)
    report.lost().push_back(toMessage(lost));
  report.fidelity(toMessage(transferred.fidelity));
  report.folded(static_cast<std::uint32_t>(transferred.folded));
  report.method_O(methodMessage(transferred.method_O));
  report.method_S(methodMessage(transferred.method_S));
  return report;
}

std::vector<v1::PatchReport> patchReports(const session::Session& session) {
  const auto coordinates = hand::coordinatesOf(session.hand());
  std::vector<v1::PatchReport> reports;
  for (const session::SessionPatch& patch : session.patches())
    reports.push_back(patchReport(patch, *coordinates));
  return reports;
}

std::vector<std::string> distortionNotes(const std::vector<session::SessionPatch>& patches) {
  std::vector<std::string> distorted;
  for (const session::SessionPatch& patch : patches) {
    if (!patch.placement || patch.transferred.correspondences.empty()) continue;
    const std::string distortion = transfer::distortionOf(patch.transferred.fidelity);
    if (!distortion.empty()) distorted.push_back(patch.patch.name + ": " + distortion);
  }
  if (distorted.empty()) return {};
  return {fmt::format(
      "distorted on the hand, since a surface has holes or folds under the contact, or the "
      "finger is too thin for it: {}",
      fmt::join(distorted, "; "))};
}

std::vector<std::string> sizeNotes(const std::vector<session::SessionPatch>& patches,
                                   const geometry::TriangleMesh& object_O,
                                   const geometry::TriangleMesh& skin_S) {
  Eigen::AlignedBox3d roots_O;
  for (const session::SessionPatch& patch : patches)
    roots_O.extend(geometry::positionOf(object_O, patch.patch.root));
  if (patches.size() < 2 || roots_O.diagonal().norm() < kWidestGrasp) return {};
  const double hand = geometry::mainExtent(skin_S);
  if (roots_O.diagonal().norm() < 2.0 * hand) return {};
  return {
      fmt::format("the contacts lie {:.2f} m apart and the hand is {:.2f} m across: is the "
                  "object in metres (--units mm, cm)?",
                  roots_O.diagonal().norm(), hand)};
}

v1::PlacementSuggestion toMessage(const transfer::Suggestion& suggestion,
                                  const geometry::TriangleMesh& skin_S) {
  const transfer::PatchTransfer& transferred = suggestion.transfer;
  v1::PlacementSuggestion message;
  message.root_S(toMessage(suggestion.placement.root_S));
  message.p_S_m(toMessage(geometry::positionOf(skin_S, suggestion.placement.root_S)));
  message.direction_S(toMessage(suggestion.placement.direction_S));
  message.moved_m(suggestion.moved_m);
  message.turned_rad(suggestion.turned_rad);
  message.point_count(static_cast<std::uint32_t>(transferred.correspondences.size()));
  message.lost_count(static_cast<std::uint32_t>(transferred.lost.size()));
  message.lost(countedByReason(transferred.lost));
  message.fidelity(toMessage(transferred.fidelity));
  return message;
}

}  // namespace handgraft::server
