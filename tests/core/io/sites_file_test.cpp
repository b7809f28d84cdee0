#include "core/io/sites_file.h"

#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/shared_data.h"

namespace handgraft::io {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

const hand::HandModel& palm() {
  static const hand::HandModel palm_only("hand", {{"palm", {}, {}}}, {});
  return palm_only;
}

std::vector<hand::ContactSite> sitesIn(const std::string& text) {
  const std::filesystem::path path = test::scratchDirectory() / "sites.yaml";
  std::ofstream(path) << text;
  return readSites(path, palm());
}

std::string faultOf(const std::string& text) {
  try {
    (void)sitesIn(text);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "no fault";
}

const std::string sites_head = "format: handgraft-sites/1\nsites:\n";
const std::string one_site =
    "  - {name: thumb, link: palm, point_m: [1, 2, 3], normal: [0, 0, 2], direction: [1, 0, "
    "1]}\n";

TEST(SitesFile, ReadsSitesAndMakesDirectionsTangent) {
  const auto sites = sitesIn(sites_head + one_site);
  ASSERT_EQ(sites.size(), 1U);
  EXPECT_EQ(sites[0].name, "thumb");
  EXPECT_EQ(sites[0].p_L, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(sites[0].n_L.isApprox(Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(sites[0].direction_L.isApprox(Eigen::Vector3d::UnitX()));
}

TEST(SitesFile, NamesWhatIsWrong) {
  EXPECT_THAT(faultOf("{"), HasSubstr("sites.yaml"));
  EXPECT_THAT(faultOf("format: other\n"), HasSubstr("handgraft-sites/1"));
  EXPECT_THAT(faultOf("format: handgraft-sites/1\n"), HasSubstr("'sites'"));
  EXPECT_THAT(faultOf(sites_head + one_site + one_site), HasSubstr("twice"));
  EXPECT_THAT(
      faultOf(sites_head + "  - {name: thumb, link: palm, point_m: [1, .nan, 3], normal: [0, "
                           "0, 1], direction: [1, 0, 0]}\n"),
      AllOf(HasSubstr("'thumb'"), HasSubstr("'point_m'")));
  EXPECT_THAT(
      faultOf(sites_head + "  - {name: thumb, link: ghost, point_m: [1, 2, 3], normal: [0, 0, "
                           "1], direction: [1, 0, 0]}\n"),
      HasSubstr("'ghost'"));
  EXPECT_THAT(
      faultOf(sites_head + "  - {name: thumb, link: palm, point_m: [1, 2, 3], normal: [0, 0, "
                           "1], direction: [0, 0, 1]}\n"),
      HasSubstr("parallel"));
  EXPECT_THAT(faultOf(sites_head + "  - {name: thumb, colour: red}\n"), HasSubstr("'colour'"));
}

TEST(SitesFile, IsReadAsItWasWritten) {
  const hand::HandModel model("odd names", {{"no", {}, {}}}, {});
  hand::ContactSite odd;
  odd.name = "a \"quoted\": #name\n";
  odd.link = "no";
  odd.p_L << 0.123456789012, -1e-7, 3.0;
  odd.n_L = Eigen::Vector3d(1, 2, -3).normalized();
  odd.direction_L = odd.n_L.unitOrthogonal();
  hand::ContactSite thumb = odd;
  thumb.name = "thumb";
  const std::filesystem::path path = test::scratchDirectory() / "written.yaml";
  writeSites(path, {odd, thumb});
  const auto back = readSites(path, model);
  ASSERT_EQ(back.size(), 2U);
  EXPECT_EQ(back[0].name, odd.name);
  EXPECT_EQ(back[0].link, "no");
  EXPECT_EQ(back[1].name, "thumb");
  EXPECT_TRUE(back[0].p_L.isApprox(odd.p_L, 1e-8));
  EXPECT_TRUE(back[0].n_L.isApprox(odd.n_L, 1e-8));
  EXPECT_TRUE(back[0].direction_L.isApprox(odd.direction_L, 1e-8));
}

TEST(SitesFile, HoldsNoSiteOrSaysWhyItCannotBeWritten) {
  const std::filesystem::path path = test::scratchDirectory() / "none.yaml";
  writeSites(path, {});
  EXPECT_TRUE(readSites(path, palm()).empty());
  EXPECT_THROW(writeSites(test::scratchDirectory() / "missing" / "sites.yaml", {}),
               InvalidInput);
}

}  // namespace
}  // namespace handgraft::io
