#include "core/hand/contact_site.h"

#include <cmath>
#include <set>

#include <Eigen/Geometry>

#include "core/base/error.h"

namespace handgraft::hand {

namespace {

/// Room for vectors that a file gives with a few digits.
constexpr double kUnitTolerance = 1e-3;

void checkUnit(const ContactSite& site, const Eigen::Vector3d& v, const char* what) {
  const double length = v.stableNorm();
  if (!(std::abs(length - 1.0) <= kUnitTolerance))
    rejectInput("site {}: its {} ({} {} {}) must be a unit vector", quoted(site.name), what,
                v.x(), v.y(), v.z());
}

/// Farthest that a site may lie from the box around its link: sites are slid onto the skin, and
/// coordinates in millimetres are a common slip.
constexpr double kFarthestOff = 0.02;  // m

/// From a place to the box around the surface of its link; 0 where the link has none.
double distanceToBox(const Link& link, const Eigen::Vector3d& p_L) {
  Eigen::AlignedBox3d box;
  for (const Shape& shape : link.surface())
    for (const auto& p : shape.mesh_L.vertices().colwise())
      box.extend(Eigen::Vector3d(p));
  return box.isEmpty() ? 0.0 : box.exteriorDistance(p_L);
}

}  // namespace

void validate(const HandModel& model, const std::vector<ContactSite>& sites) {
  std::set<std::string> names;
  for (const ContactSite& site : sites) {
    if (site.name.empty()) rejectInput("a site of hand {} has no name", quoted(model.name()));
    if (!names.insert(site.name).second)
      rejectInput("site {} is there twice: names must differ", quoted(site.name));
    if (!model.maybeLinkIndex(site.link))
      rejectInput("site {}: hand {} has no link {}", quoted(site.name), quoted(model.name()),
                  quoted(site.link));
    if (!site.p_L.allFinite())
      rejectInput("site {}: its point is not finite", quoted(site.name));
    const double off = distanceToBox(model.links()[model.linkIndex(site.link)], site.p_L);
    if (!(off <= kFarthestOff))
      rejectInput("site {}: its point ({} {} {}) lies {} m off link {}; permitted are {} m",
                  quoted(site.name), site.p_L.x(), site.p_L.y(), site.p_L.z(), off,
                  quoted(site.link), kFarthestOff);
    checkUnit(site, site.n_L, "normal");
    checkUnit(site, site.direction_L, "direction");
    if (!(std::abs(site.n_L.dot(site.direction_L)) <= kUnitTolerance))
      rejectInput("site {}: its direction must be at right angles to its normal",
                  quoted(site.name));
  }
}

}  // namespace handgraft::hand
