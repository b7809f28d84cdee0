#include "core/hand/contact_site.h"

#include <limits>

#include <gtest/gtest.h>

#include "core/base/error.h"

namespace handgraft::hand {
namespace {

ContactSite makeSite() {
  ContactSite site;
  site.name = "thumb";
  site.link = "palm";
  site.n_L = Eigen::Vector3d::UnitX();
  site.direction_L = Eigen::Vector3d::UnitZ();
  return site;
}

const HandModel& palm() {
  static const HandModel kModel("hand", {{"palm", {}, {}}}, {});
  return kModel;
}

TEST(ContactSite, IsValidWithUnitVectorsAtRightAngles) {
  EXPECT_NO_THROW(validate(palm(), {makeSite()}));
}

TEST(ContactSite, RefusesWhatNoHandHas) {
  const auto expectFault = [](auto change) {
    ContactSite site = makeSite();
    change(site);
    EXPECT_THROW(validate(palm(), {site}), InvalidInput);
  };
  expectFault([](ContactSite& s) {
    s.name.clear();
  });
  expectFault([](ContactSite& s) {
    s.link = "ghost";
  });
  expectFault([](ContactSite& s) {
    s.n_L *= 2.0;
  });
  expectFault([](ContactSite& s) {
    s.direction_L = s.n_L;
  });
  expectFault([](ContactSite& s) {
    s.p_L.x() = std::numeric_limits<double>::infinity();
  });
  EXPECT_THROW(validate(palm(), {makeSite(), makeSite()}), InvalidInput);
}

}  // namespace
}  // namespace handgraft::hand
