#include "client/link/hand_point.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "client/link/surface_pick.h"
#include "core/base/error.h"

namespace handgraft::client {

HandPoint handPointNamed(const v1::HandDescription& hand,
                         const std::string& name,
                         const std::function<const v1::HandDescription&()>& with_meshes) {
  if (const v1::SiteInfo* site = siteNamed(hand, name))
    return {site->link(), Eigen::Vector3d(site->p_L_m().data())};
  for (const v1::LinkInfo& link : hand.links())
    if (link.name() == name) return {name, Eigen::Vector3d::Zero()};
  constexpr std::string_view kTip = "_tip";
  const v1::SiteInfo* site = name.ends_with(kTip)
                                 ? siteNamed(hand, name.substr(0, name.size() - kTip.size()))
                                 : nullptr;
  if (site == nullptr) {
    std::vector<std::string> sites;
    for (const v1::SiteInfo& other : hand.sites())
      sites.push_back(other.name());
    rejectInput(
        "the hand has no point {}; there are its sites ({}), the same with _tip, and its links",
        quoted(name), fmt::join(sites, ", "));
  }
  const v1::HandDescription& shown = with_meshes();
  const v1::Mesh& surface_L = shown.links().at(linkIndex(shown, site->link())).surface_L();
  return {site->link(),
          furthestVertex(surface_L, -Eigen::Vector3d(site->direction_L().data()))};
}

HandPoint palmPointOf(const v1::HandDescription& hand) {
  if (const v1::SiteInfo* site = siteNamed(hand, "palm"))
    return {site->link(), Eigen::Vector3d(site->p_L_m().data())};
  if (hand.links().empty()) rejectInput("the hand has no links");
  return {hand.links().front().name(), Eigen::Vector3d::Zero()};
}

const v1::SiteInfo* siteNamed(const v1::HandDescription& hand, const std::string& name) {
  const auto found =
      std::find_if(hand.sites().begin(), hand.sites().end(), [&](const v1::SiteInfo& site) {
        return site.name() == name;
      });
  return found == hand.sites().end() ? nullptr : &*found;
}

std::size_t linkIndex(const v1::HandDescription& hand, const std::string& name) {
  for (std::size_t i = 0; i < hand.links().size(); ++i) {
    if (hand.links()[i].name() == name) return i;
  }
  rejectInput("the hand has no link {}", quoted(name));
}

}  // namespace handgraft::client
