#include "core/hand/kept_solid.h"

#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/hand/kept_files.h"

#include "tests/core/hand/palm_of_parts.h"
#include "tests/support/own_folder.h"

namespace handgraft::hand {
namespace {

namespace fs = std::filesystem;

constexpr double kBall = 0.01;  // m

/// A skin of its own of that hand, so that it can be told where things are kept.
Skin skinOf(const test::BallHand& hand) {
  return {*hand.model,          hand.skin->mesh(),       hand.skin->qReference(),
          hand.skin->epsilon(), SurfaceSource::kVisuals, hand.skin->faceLinks()};
}

SolidFindings findingsOf(const test::BallHand& hand) {
  SolidFindings findings;
  const HandSolid solid(*hand.model, *hand.skin, Progress(), {}, &findings);
  return findings;
}

void expectSame(const SampleSet& a, const SampleSet& b) {
  ASSERT_EQ(a.samples.size(), b.samples.size());
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    EXPECT_EQ(a.samples[i].p_L, b.samples[i].p_L);
    EXPECT_EQ(a.samples[i].area_m2, b.samples[i].area_m2);
  }
}

void expectSame(const HandSolid& a, const HandSolid& b) {
  EXPECT_EQ(a.collisionPairs(), b.collisionPairs());
  ASSERT_EQ(a.links().size(), b.links().size());
  for (std::size_t i = 0; i < a.links().size(); ++i) {
    const LinkSolid& one = a.links()[i];
    const LinkSolid& other = b.links()[i];
    EXPECT_EQ(one.link, other.link);
    EXPECT_EQ(one.skin_offset, other.skin_offset);
    EXPECT_EQ(one.grid_L->values(), other.grid_L->values());
    EXPECT_EQ(one.for_links_L->values(), other.for_links_L->values());
    EXPECT_EQ(one.cells_L.size(), other.cells_L.size());
    const Eigen::Vector3d p_L(0.3 * kBall, 0.1 * kBall, 0);
    EXPECT_EQ(one.grid_L->exact().at(p_L).distance, other.grid_L->exact().at(p_L).distance);
    expectSame(one.coarse, other.coarse);
    expectSame(one.fine, other.fine);
  }
}

class KeptSolid : public test::OwnFolder {};

TEST_F(KeptSolid, IsTheSameToTheBit) {
  const test::BallHand hand = test::palmOfParts(kBall);
  const HandSolid made(*hand.model, *hand.skin, Progress());
  Skin skin = skinOf(hand);
  skin.keepIn(std::make_shared<const KeptFiles>(folder));
  expectSame(*keptSolid(*hand.model, skin, Progress()), made);
  ASSERT_EQ(files().size(), 1u);
  const auto written = fs::last_write_time(files().front());
  expectSame(*keptSolid(*hand.model, skin, Progress()), made);
  EXPECT_EQ(fs::last_write_time(files().front()), written) << "found, not made anew";
}

TEST_F(KeptSolid, IsReadWhereItIsKept) {
  const test::BallHand hand = test::palmOfParts(kBall);
  Skin skin = skinOf(hand);
  const auto place = std::make_shared<const KeptFiles>(folder);
  skin.keepIn(place);
  // Values that no making gives: the solid that has them was read.
  SolidFindings findings = findingsOf(hand);
  for (float& value : findings.links.at(0).for_links)
    value += 1.0F;
  const std::string key = solidKey(*hand.model, skin);
  place->keep(key + ".solid", serialise(findings, key));
  EXPECT_EQ(keptSolid(*hand.model, skin, Progress())->links().at(0).for_links_L->values(),
            findings.links[0].for_links);
}

TEST_F(KeptSolid, IsMadeWhereNothingIsKept) {
  const test::BallHand hand = test::palmOfParts(kBall);
  Skin skin = skinOf(hand);
  expectSame(*keptSolid(*hand.model, skin, Progress()),
             *keptSolid(*hand.model, skin, Progress()));
  skin.keepIn(std::make_shared<const KeptFiles>(std::nullopt, folder));
  static_cast<void>(keptSolid(*hand.model, skin, Progress()));
  EXPECT_TRUE(files().empty()) << "what came with the program is only read";
}

TEST_F(KeptSolid, IsMadeAnewWhereItsFileIsDamaged) {
  const test::BallHand hand = test::palmOfParts(kBall);
  Skin skin = skinOf(hand);
  skin.keepIn(std::make_shared<const KeptFiles>(folder));
  const auto made = keptSolid(*hand.model, skin, Progress());
  ASSERT_EQ(files().size(), 1u);
  const std::uintmax_t size = fs::file_size(files().front());
  fs::resize_file(files().front(), size / 2);
  expectSame(*keptSolid(*hand.model, skin, Progress()), *made);
  EXPECT_EQ(fs::file_size(files().front()), size) << "and kept again";
}

TEST_F(KeptSolid, IsNotKeptIfItsMakingWasStopped) {
  const test::BallHand hand = test::palmOfParts(kBall);
  Skin skin = skinOf(hand);
  skin.keepIn(std::make_shared<const KeptFiles>(folder));
  Progress progress;
  progress.cancel();
  EXPECT_THROW(static_cast<void>(keptSolid(*hand.model, skin, progress)), Cancelled);
  EXPECT_TRUE(files().empty());
}

TEST(SolidKey, ChangesWithWhatMakesTheSolid) {
  const test::BallHand hand = test::palmOfParts(kBall);
  const std::string key = solidKey(*hand.model, *hand.skin);
  EXPECT_EQ(solidKey(*hand.model, skinOf(hand)), key);
  const test::BallHand larger = test::palmOfParts(1.001 * kBall);
  EXPECT_NE(solidKey(*larger.model, *larger.skin), key);
  std::vector<int> links = hand.skin->faceLinks();
  links.back() = 0;
  const Skin other_links(*hand.model, hand.skin->mesh(), hand.skin->qReference(),
                         hand.skin->epsilon(), SurfaceSource::kVisuals, links);
  EXPECT_NE(solidKey(*hand.model, other_links), key);
  std::vector<Joint> joints = hand.model->joints();
  joints.back().type = JointType::kFixed;
  const HandModel stiff("palm", hand.model->links(), joints);
  const Skin its(stiff, hand.skin->mesh(), stiff.restPose(), hand.skin->epsilon());
  EXPECT_NE(solidKey(stiff, its), key) << "the palm carries one digit less";
}

TEST(SolidFindings, ComeBackAsTheyWere) {
  const std::string key(64, 'a');
  const SolidFindings findings = findingsOf(test::palmOfParts(kBall));
  ASSERT_EQ(findings.links.size(), 4u);
  EXPECT_FALSE(findings.links[0].outer_faces.empty()) << "of a palm with walls within";
  const auto back = deserialiseFindings(serialise(findings, key), key);
  ASSERT_TRUE(back);
  ASSERT_EQ(back->links.size(), findings.links.size());
  for (std::size_t i = 0; i < findings.links.size(); ++i) {
    EXPECT_EQ(back->links[i].for_links, findings.links[i].for_links);
    EXPECT_EQ(back->links[i].for_objects, findings.links[i].for_objects);
    EXPECT_EQ(back->links[i].outer_faces, findings.links[i].outer_faces);
  }
}

/// A checksum that fits does not make bad numbers good.
TEST(SolidFindings, AreNothingIfWronglyMade) {
  const std::string key(64, 'a');
  SolidFindings findings;
  findings.links.resize(1);
  findings.links[0].outer_faces = {{0, 0, 0}, {1, 0, 0}};
  EXPECT_FALSE(deserialiseFindings(serialise(findings, key), key)) << "a face of two corners";
  findings.links[0].outer_faces.emplace_back(0, std::numeric_limits<double>::quiet_NaN(), 0);
  EXPECT_FALSE(deserialiseFindings(serialise(findings, key), key)) << "a corner nowhere";
  findings.links[0].outer_faces.back() = {0, 1, 0};
  EXPECT_TRUE(deserialiseFindings(serialise(findings, key), key));
  std::string content(8, '\0');
  content[6] = '\x7f';
  EXPECT_FALSE(deserialiseFindings(sealed("handgraft-solid/1\n", key, content), key))
      << "more links than bytes";
}

TEST(SolidFindings, ThatDoNotFitAreFoundAnew) {
  const test::BallHand hand = test::palmOfParts(kBall);
  const HandSolid made(*hand.model, *hand.skin, Progress());
  SolidFindings findings = findingsOf(hand);
  findings.links[0].for_links.pop_back();
  findings.links[1].for_links.front() = std::numeric_limits<float>::infinity();
  findings.links.pop_back();
  expectSame(HandSolid(*hand.model, *hand.skin, Progress(), {}, &findings), made);
  expectSame(HandSolid(*hand.model, *hand.skin, Progress(), {}, &findings), made);
}

}  // namespace
}  // namespace handgraft::hand
