#include "core/hand/contact_site.h"

#include <cmath>
#include <set>

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
    checkUnit(site, site.n_L, "normal");
    checkUnit(site, site.direction_L, "direction");
    if (!(std::abs(site.n_L.dot(site.direction_L)) <= kUnitTolerance))
      rejectInput("site {}: its direction must be at right angles to its normal",
                  quoted(site.name));
  }
}

}  // namespace handgraft::hand
