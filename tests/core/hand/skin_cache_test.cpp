#include "core/hand/skin_cache.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "core/base/content_hash.h"
#include "core/base/error.h"

#include "tests/support/environment_variable.h"
#include "tests/support/own_folder.h"
#include "tests/support/wrapping.h"

namespace handgraft::hand {
namespace {

namespace fs = std::filesystem;

HandModel makeBall(double radius_m) {
  return {"ball", {{"ball", {{geometry::makeSphere(radius_m, 3), "sphere"}}, {}}}, {}};
}

class SkinCacheTest : public test::OwnFolder {};

TEST(SkinKey, ChangesWithWhatMakesTheSkin) {
  const std::string key = skinKey(makeBall(0.02), {});
  EXPECT_EQ(skinKey(makeBall(0.02), {}), key);
  EXPECT_NE(skinKey(makeBall(0.020001), {}), key);
  SkinOptions options;
  options.edge_m = 0.003;
  EXPECT_NE(skinKey(makeBall(0.02), options), key);
  options = {};
  options.source = SurfaceSource::kCollisions;
  EXPECT_NE(skinKey(makeBall(0.02), options), key);
}

TEST(StoredSkin, ComesBackAsItWas) {
  const std::string key(64, 'a');
  const StoredSkin stored{geometry::makeSphere(0.02, 1), {"one", ""}, std::vector<int>(80, 7)};
  const auto back = deserialise(serialise(stored, key), key);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->mesh_S.vertices(), stored.mesh_S.vertices());
  EXPECT_EQ(back->mesh_S.faces(), stored.mesh_S.faces());
  EXPECT_EQ(back->notes, stored.notes);
  EXPECT_EQ(back->face_links, stored.face_links);
}

TEST(StoredSkin, IsNothingIfDamaged) {
  const std::string key(64, 'a');
  const std::string bytes = serialise({geometry::makeSphere(0.02, 1), {"note"}}, key);
  for (std::size_t i = 0; i < bytes.size(); i += 7) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 1);
    EXPECT_FALSE(deserialise(damaged, key)) << "byte " << i;
    EXPECT_FALSE(deserialise(bytes.substr(0, i), key)) << "cut at " << i;
  }
  EXPECT_FALSE(deserialise(bytes + "x", key));
  EXPECT_FALSE(deserialise(bytes, std::string(64, 'b')));
}

/// A checksum that fits does not make a bad mesh good.
TEST(StoredSkin, IsNothingIfWronglyMade) {
  const std::string key(64, 'a');
  Eigen::Matrix3Xi faces(3, 1);
  faces << 0, 1, 2;
  const geometry::TriangleMesh open(Eigen::Matrix3Xd(Eigen::Matrix3d::Identity()), faces);
  EXPECT_FALSE(deserialise(serialise({open, {}}, key), key));

  const StoredSkin of_fewer{geometry::makeSphere(0.02, 1), {}, std::vector<int>(79, 0)};
  EXPECT_FALSE(deserialise(serialise(of_fewer, key), key)) << "a face without a link";

  std::string body = serialise({geometry::makeSphere(0.02, 1), {}}, key);
  body.resize(body.size() - 64);
  const std::size_t counts = body.size() - 8 - 80 * 12 - 42 * 24 - 24;
  for (int byte = 0; byte < 8; ++byte)
    body[counts + static_cast<std::size_t>(byte)] = '\x7f';
  ContentHash hash;
  hash.add(body);
  EXPECT_FALSE(deserialise(body + hash.finish(), key));
}

TEST_F(SkinCacheTest, KeepsASkinAndGivesItBack) {
  HANDGRAFT_NEEDS_CGAL();
  const SkinCache cache(folder);
  SkinReport first;
  const Skin made = cache.get(makeBall(0.02), {}, Progress(), &first);
  EXPECT_FALSE(first.from_cache);
  ASSERT_EQ(files().size(), 1u);
  SkinReport second;
  const Skin found = cache.get(makeBall(0.02), {}, Progress(), &second);
  EXPECT_TRUE(second.from_cache);
  EXPECT_EQ(found.mesh().vertices(), made.mesh().vertices());
  EXPECT_EQ(found.mesh().faces(), made.mesh().faces());
  EXPECT_EQ(found.faceLinks(), made.faceLinks());
  EXPECT_EQ(second.notes, first.notes);
  EXPECT_FALSE(first.steps.empty());
  EXPECT_TRUE(second.steps.empty());
}

TEST_F(SkinCacheTest, LooksFirstAtWhatCameWithTheProgram) {
  HANDGRAFT_NEEDS_CGAL();
  const fs::path shipped = folder / "shipped";
  const Skin made = SkinCache(shipped).get(makeBall(0.02), {}, Progress());
  const fs::path own = folder / "own";
  SkinReport report;
  const Skin found = SkinCache(own, shipped).get(makeBall(0.02), {}, Progress(), &report);
  EXPECT_TRUE(report.from_cache);
  EXPECT_EQ(found.mesh().vertices(), made.mesh().vertices());
  EXPECT_FALSE(fs::exists(own));
  (void)SkinCache(std::nullopt, shipped).get(makeBall(0.02), {}, Progress(), &report);
  EXPECT_TRUE(report.from_cache) << "also where nothing may be kept";
  (void)SkinCache(own, shipped).get(makeBall(0.03), {}, Progress(), &report);
  EXPECT_FALSE(report.from_cache);
  EXPECT_EQ(std::distance(fs::directory_iterator(shipped), fs::directory_iterator()), 1);
  EXPECT_EQ(std::distance(fs::directory_iterator(own), fs::directory_iterator()), 1);
}

TEST_F(SkinCacheTest, MakesAFileAnewThatNamesLinksOfAnotherHand) {
  HANDGRAFT_NEEDS_CGAL();
  const SkinCache cache(folder);
  const Skin made = cache.get(makeBall(0.02), {}, Progress());
  StoredSkin stored{made.mesh(), {}, made.faceLinks()};
  stored.face_links.front() = 1;  // the ball is link 0, and has no other
  const std::string key = skinKey(makeBall(0.02), {});
  std::ofstream(files().front(), std::ios::binary) << serialise(stored, key);
  SkinReport report;
  const Skin again = cache.get(makeBall(0.02), {}, Progress(), &report);
  EXPECT_FALSE(report.from_cache);
  EXPECT_EQ(again.faceLinks(), made.faceLinks());
}

TEST_F(SkinCacheTest, FindsTheLinksOfASkinThatIsGivenWithoutThem) {
  // In a build that wraps nothing, too.
  const HandModel ball = makeBall(0.02);
  const std::string key = skinKey(ball, {});
  fs::create_directories(folder);
  std::ofstream(folder / (key + ".skin"), std::ios::binary)
      << serialise({geometry::makeSphere(0.0208, 4), {}}, key);
  SkinReport report;
  const Skin skin = SkinCache(folder).get(ball, {}, Progress(), &report);
  EXPECT_TRUE(report.from_cache);
  EXPECT_EQ(skin.faceLinks(), std::vector<int>(skin.mesh().faceCount(), 0));
}

TEST_F(SkinCacheTest, MakesADamagedFileAnew) {
  HANDGRAFT_NEEDS_CGAL();
  const SkinCache cache(folder);
  (void)cache.get(makeBall(0.02), {}, Progress());
  ASSERT_EQ(files().size(), 1u);
  fs::resize_file(files().front(), fs::file_size(files().front()) / 2);
  SkinReport report;
  (void)cache.get(makeBall(0.02), {}, Progress(), &report);
  EXPECT_FALSE(report.from_cache);
  (void)cache.get(makeBall(0.02), {}, Progress(), &report);
  EXPECT_TRUE(report.from_cache);
}

TEST_F(SkinCacheTest, IsAtHomeWhereTheSystemKeepsCaches) {
  HANDGRAFT_NEEDS_CGAL();
  const test::EnvironmentVariable home("HOME", folder);
  {
    const test::EnvironmentVariable none("XDG_CACHE_HOME", std::nullopt);
    (void)SkinCache::fromEnvironment().get(makeBall(0.02), {}, Progress());
    EXPECT_TRUE(fs::exists(folder / ".cache" / "handgraft" / "skins"));
  }
  fs::remove_all(folder);
  const test::EnvironmentVariable elsewhere("XDG_CACHE_HOME", folder / "elsewhere");
  (void)SkinCache::fromEnvironment().get(makeBall(0.02), {}, Progress());
  EXPECT_TRUE(fs::exists(folder / "elsewhere" / "handgraft" / "skins"));
  EXPECT_FALSE(fs::exists(folder / ".cache"));
}

TEST_F(SkinCacheTest, WorksWhereNothingCanBeKept) {
  HANDGRAFT_NEEDS_CGAL();
  std::ofstream(folder) << "a file where the folder should be";
  EXPECT_TRUE(SkinCache(folder).get(makeBall(0.02), {}, Progress()).mesh().isClosed());
  EXPECT_TRUE(SkinCache().get(makeBall(0.02), {}, Progress()).mesh().isClosed());
}

TEST_F(SkinCacheTest, StopsOnWishAndKeepsNothing) {
  Progress progress;
  progress.cancel();
  EXPECT_THROW((void)SkinCache(folder).get(makeBall(0.02), {}, progress), Cancelled);
  EXPECT_TRUE(files().empty());
}

}  // namespace
}  // namespace handgraft::hand
