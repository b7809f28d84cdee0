// What a build without CGAL can do and what it refuses.
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/hand/skin_cache.h"
#include "core/hand/skin_wrap.h"

#include "tests/support/shared_data.h"

namespace handgraft::hand {
namespace {

HandModel makeBall() {
  return {"ball", {{"ball", {{geometry::makeSphere(0.02, 3), "sphere"}}, {}}}, {}};
}

TEST(WithoutCgal, NoSkinIsWrappedAndTheReasonIsTold) {
  try {
    (void)buildSkin(makeBall(), {}, Progress());
    FAIL() << "a skin was made";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("HANDGRAFT_WITH_CGAL=OFF"));
  }
  EXPECT_THROW((void)remeshed(geometry::makeSphere(0.02, 3), 0.002), InvalidInput);
}

TEST(WithoutCgal, ASkinThatIsGivenIsTaken) {
  const HandModel model = makeBall();
  const std::string key = skinKey(model, {});
  const std::filesystem::path folder = test::scratchDirectory() / "given";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / (key + ".skin"), std::ios::binary)
      << serialise({geometry::makeSphere(0.0208, 4), {}}, key);
  SkinReport report;
  const Skin skin = SkinCache(folder).get(model, {}, Progress(), &report);
  EXPECT_TRUE(report.from_cache);
  const auto hit = skin.project({0.0208, 0.0, 0.0}, Eigen::Vector3d::UnitX());
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->link, 0);
  EXPECT_NEAR(hit->distance_m, 0.0008, 1e-4);
}

}  // namespace
}  // namespace handgraft::hand
