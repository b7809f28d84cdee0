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
  static const HandModel palm_only("hand", {{"palm", {}, {}}}, {});
  return palm_only;
}

TEST(ContactSite, IsValidWithUnitVectorsAtRightAngles) {
  EXPECT_NO_THROW(validate(palm(), {makeSite()}));
}

TEST(ContactSite, RefusesWhatNoHandHas) {
  const auto expect_fault = [](auto change) {
    ContactSite site = makeSite();
    change(site);
    EXPECT_THROW(validate(palm(), {site}), InvalidInput);
  };
  expect_fault([](ContactSite& s) {
    s.name.clear();
  });
  expect_fault([](ContactSite& s) {
    s.link = "ghost";
  });
  expect_fault([](ContactSite& s) {
    s.n_L *= 2.0;
  });
  expect_fault([](ContactSite& s) {
    s.direction_L = s.n_L;
  });
  expect_fault([](ContactSite& s) {
    s.p_L.x() = std::numeric_limits<double>::infinity();
  });
  EXPECT_THROW(validate(palm(), {makeSite(), makeSite()}), InvalidInput);
}

// A box of 100 x 20 x 20 mm about the origin: 20 mm off it is the farthest.
TEST(ContactSite, LiesNearItsLink) {
  const Shape box{geometry::makeBox({0.1, 0.02, 0.02}), "box"};
  const HandModel hand("hand", {{"palm", {box}, {}}}, {});
  ContactSite site = makeSite();
  site.p_L = {0.05, 0.0, 0.0299};
  EXPECT_NO_THROW(validate(hand, {site}));
  site.p_L = {0.05, 0.0, 0.0301};
  EXPECT_THROW(validate(hand, {site}), InvalidInput);
  site.p_L = {50.0, 0.0, 0.0};  // millimetres
  EXPECT_THROW(validate(hand, {site}), InvalidInput);
}

}  // namespace
}  // namespace handgraft::hand
