// Which finger and segment patches lie on, on the built-in library's real skins.
#include "core/session/place_matching.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/progress.h"
#include "core/hand/finger_coordinates.h"
#include "core/io/contact_file.h"
#include "core/optimize/diagnosis.h"
#include "core/session/dealing.h"
#include "core/session/session.h"
#include "core/transfer/patch_placement.h"

#include "tests/core/session/library_models.h"

namespace handgraft::session {
namespace {

using test::handOfLibrary;
using test::libraryPath;

/// A lemon so large that a claw's palm reaches it, too.
constexpr double kLarge = 1.3;

/// The library's lemon, so much larger.
io::MeshFile lemonOf(double times) {
  io::MeshFile file = io::readMesh(libraryPath("objects/lemon.obj"));
  file.mesh = geometry::TriangleMesh(times * file.mesh.vertices(), file.mesh.faces());
  return file;
}

/// A lemon in a whole hand, as a map with labels tells it.
struct LabelledLemon {
  io::MeshFile file;
  std::shared_ptr<const geometry::TriangleMesh> mesh =
      std::make_shared<const geometry::TriangleMesh>(file.mesh);
  contact::ContactSet contacts = io::readContactSet(libraryPath("contacts/lemon_6.json"), file);

  explicit LabelledLemon(double times = kLarge) : file(lemonOf(times)) {
    for (contact::Patch& patch : contacts.patches)
      if (patch.name != "palm") patch.name += "_distal";
  }
};

/// How many of the set's patches a hand reaches.
std::ptrdiff_t reachedOf(const hand::Hand& hand,
                         const LabelledLemon& lemon,
                         const contact::ContactSet& contacts) {
  Session session(hand, lemon.mesh, contacts, Pose::Identity(), {});
  const Solution solution = session.solve(SolverSettings(), {}, Progress());
  return std::ssize(solution.report.patches) -
         std::ssize(optimize::missedPatches(solution.problem, solution.report));
}

TEST(LinksOfSite, AreThoseOfItsSegmentAndTheOnesBesideIt) {
  const hand::Hand hand = handOfLibrary("human20");
  const auto coordinates = hand::coordinatesOf(hand);
  const auto segments_of = [&](const std::string& site) {
    std::vector<std::string> segments;
    const std::vector<char> links = linksOfSite(hand, *coordinates, site);
    for (std::size_t link = 0; link < links.size(); ++link) {
      if (links[link] == 0) continue;
      const auto& part = coordinates->parts()[link];
      const std::string name = part.digit + "_" + part.segment;
      if (std::find(segments.begin(), segments.end(), name) == segments.end())
        segments.push_back(name);
    }
    std::sort(segments.begin(), segments.end());
    return segments;
  };
  using Segments = std::vector<std::string>;
  EXPECT_EQ(segments_of("index_distal"), (Segments{"index_distal", "index_middle"}));
  EXPECT_EQ(segments_of("index"), (Segments{"index_distal", "index_middle"}));
  EXPECT_EQ(segments_of("index_middle"),
            (Segments{"index_distal", "index_middle", "index_proximal"}));
  EXPECT_EQ(segments_of("thumb_proximal"), (Segments{"thumb_middle", "thumb_proximal"}));
}

/// Of every way to leave two fingers out, none reaches more patches than the one that was
/// taken.
TEST(DealingFingers, TakesTheWayThatReachesMost) {
  const hand::Hand hand = handOfLibrary("barrett8");
  const LabelledLemon lemon;
  const std::vector<contact::Patch>& all = lemon.contacts.patches;  // palm, thumb, fingers
  std::ptrdiff_t most = 0;
  std::ptrdiff_t fewest = std::ssize(all);
  for (std::size_t index = 2; index < all.size(); ++index) {
    for (std::size_t middle = index + 1; middle < all.size(); ++middle) {
      contact::ContactSet four = lemon.contacts;
      four.patches = {all[0], all[1], all[index], all[middle]};
      four.patches[2].name = "index_distal";
      four.patches[3].name = "middle_distal";
      const std::ptrdiff_t reached = reachedOf(hand, lemon, four);
      most = std::max(most, reached);
      fewest = std::min(fewest, reached);
    }
  }
  ASSERT_LT(fewest, most) << "no way is better than another";
  EXPECT_EQ(reachedOf(hand, lemon, lemon.contacts), most);
}

/// As large as it is, the palm's patch keeps a claw's fingers away.
TEST(PalmsPatch, IsLeftOutWhereTheHandReachesMoreWithoutItAndComesBackByARoot) {
  const hand::Hand hand = handOfLibrary("barrett8");
  const LabelledLemon lemon(1.0);
  Session session(hand, lemon.mesh, lemon.contacts, Pose::Identity(), {});
  const auto palm = [&]() -> const SessionPatch& {
    return session.patches().front();
  };
  ASSERT_EQ(palm().patch.name, "palm");
  EXPECT_FALSE(palm().placement);
  EXPECT_THAT(palm().dropped, testing::HasSubstr("without 'palm'"));
  const Solution solution = session.solve(SolverSettings(), {}, Progress());
  EXPECT_EQ(solution.report.patches.size(), 3u);
  EXPECT_TRUE(optimize::missedPatches(solution.problem, solution.report).empty());

  const auto site = std::find_if(hand.sites.begin(), hand.sites.end(), [](const auto& one) {
    return one.name == "palm";
  });
  ASSERT_NE(site, hand.sites.end());
  session.apply(PatchRootEdit{"palm", Side::kHand,
                              transfer::placementAt(*hand.model, *hand.skin, *site).root_S});
  EXPECT_TRUE(palm().placement);
  EXPECT_EQ(palm().dropped, "");
}

/// Fingers without human names: what no finger takes is not laid on one piece by piece.
TEST(DealingFingers, KeepsAFingersPatchesTogetherWhereFingersHaveNamesOfTheirOwn) {
  hand::Hand hand = handOfLibrary("barrett8");
  for (hand::ContactSite& site : hand.sites)
    if (site.name != "thumb" && site.name != "palm")
      site.name = site.name == "index" ? "f1" : "f2";
  const LabelledLemon lemon;
  const Session session(hand, lemon.mesh, lemon.contacts, Pose::Identity(), {});
  std::size_t laid = 0;
  for (const SessionPatch& patch : session.patches()) {
    if (!patch.placement) {
      EXPECT_NE(patch.dropped.find("goes without"), std::string::npos) << patch.dropped;
      continue;
    }
    ++laid;
  }
  EXPECT_EQ(laid, 4u) << "palm, thumb and a finger's each";
}

/// A thumb and two fingers may stand the other way round: which of these is called what decides
/// nothing.
TEST(DealingFingers, TurnsAClawRoundWhereThatReachesMore) {
  hand::Hand hand = handOfLibrary("barrett8");
  const LabelledLemon lemon;
  const std::ptrdiff_t as_named = reachedOf(hand, lemon, lemon.contacts);
  for (hand::ContactSite& site : hand.sites)
    if (site.name == "index" || site.name == "middle")
      site.name = site.name == "index" ? "middle" : "index";
  EXPECT_EQ(reachedOf(hand, lemon, lemon.contacts), as_named);

  // All that touched are there, too.
  contact::ContactSet three = lemon.contacts;
  std::erase_if(three.patches, [](const contact::Patch& patch) {
    return patch.name == "ring_distal" || patch.name == "little_distal";
  });
  const std::ptrdiff_t exchanged = reachedOf(hand, lemon, three);
  EXPECT_EQ(reachedOf(handOfLibrary("barrett8"), lemon, three), exchanged);
}

/// A hand of a thumb, an index and a middle finger.
hand::Anatomy threeDigits() {
  hand::Anatomy anatomy;
  for (const char* name : {"thumb", "index", "middle"})
    anatomy.digits.emplace_back().name = name;
  return anatomy;
}

TEST(DealingFingers, HasAllWaysThatKeepTheirOrder) {
  using Ways = std::vector<Dealing>;
  EXPECT_EQ(waysToDeal(threeDigits(), {"thumb", "ring"}),
            (Ways{{{"thumb", "thumb"}, {"ring", "index"}},
                  {{"thumb", "thumb"}, {"ring", "middle"}}}));
  // Two fingers may stand the other way round.
  EXPECT_EQ(waysToDeal(threeDigits(), {"ring", "little"}),
            (Ways{{{"ring", "index"}, {"little", "middle"}},
                  {{"ring", "middle"}, {"little", "index"}}}));
  EXPECT_EQ(waysToDeal(threeDigits(), {}), Ways{{}});
  EXPECT_EQ(waysToDeal(threeDigits(), {"index", "middle", "ring"}).size(), 6u);
}

TEST(DealingFingers, OneMoreTakesAFingerThatIsFree) {
  const hand::Anatomy hand = threeDigits();
  EXPECT_EQ(extendedBy(hand, "middle", {{"index", "index"}}),
            (Dealing{{"index", "index"}, {"middle", "middle"}}));
  EXPECT_EQ(extendedBy(hand, "middle", {}), (Dealing{{"middle", "middle"}})) << "its own";
  EXPECT_EQ(extendedBy(hand, "ring", {{"index", "index"}}),
            (Dealing{{"index", "index"}, {"ring", "middle"}}));
  EXPECT_EQ(extendedBy(hand, "ring", {{"index", "index"}, {"middle", "middle"}}), std::nullopt);
  EXPECT_EQ(extendedBy(hand, "thumb", {{"ring", "middle"}}),
            (Dealing{{"thumb", "thumb"}, {"ring", "middle"}}));

  const std::vector<std::string> all{"thumb", "index", "middle", "ring", "little"};
  EXPECT_EQ(neighboursServed(hand, all, {{"middle", "index"}}), 2)
      << "index (turned round), ring";
  EXPECT_EQ(neighboursServed(hand, {"thumb", "index", "middle"}, {{"middle", "index"}}), 1)
      << "this demonstrator has no ring finger";
  EXPECT_EQ(neighboursServed(hand, all, {{"index", "index"}, {"middle", "middle"}}), 0);
}

/// What does not touch while most does is not to be reached beside it.
TEST(DealingFingers, OfAMotionGoByWhatIsThereInItsFrames) {
  const hand::Hand hand = handOfLibrary("barrett8");
  const LabelledLemon lemon;
  const auto dropped_of = [&](const SessionModels& models) {
    const Session session(models, Pose::Identity(), {});
    std::vector<std::string> dropped;
    for (const SessionPatch& patch : session.patches())
      if (!patch.placement) dropped.push_back(patch.patch.name);
    return dropped;
  };
  SessionModels models = modelsOf(hand, lemon.mesh, lemon.contacts);
  const std::vector<std::string> of_all = dropped_of(models);
  ASSERT_EQ(of_all.size(), 2u);
  FrameContacts frame{models.contacts, {}};
  for (const contact::Patch& patch : lemon.contacts.patches) {
    frame.is_there.push_back(patch.name == of_all[0] || patch.name == "palm" ||
                             patch.name == "thumb_distal");
  }
  models.frames = {frame};
  EXPECT_THAT(dropped_of(models), testing::Not(testing::Contains(of_all[0])));
}

TEST(DealingFingers, KeepsTheirOrderAndTheThumbAndTellsIt) {
  const hand::Hand hand = handOfLibrary("barrett8");
  const LabelledLemon lemon;
  const Session session(hand, lemon.mesh, lemon.contacts, Pose::Identity(), {});
  std::vector<std::string> sites;
  std::size_t dropped = 0;
  for (const SessionPatch& patch : session.patches()) {
    if (patch.placement) {
      sites.push_back(patch.site);
    } else {
      ++dropped;
      EXPECT_NE(patch.dropped.find("hand has fewer fingers"), std::string::npos)
          << patch.dropped;
    }
  }
  EXPECT_EQ(sites, (std::vector<std::string>{"palm", "thumb_distal", "index_distal",
                                             "middle_distal"}));
  EXPECT_EQ(dropped, 2u);
  const auto is_told = [&](const std::string& part) {
    return std::any_of(session.notes().begin(), session.notes().end(),
                       [&](const std::string& note) {
                         return note.find(part) != std::string::npos;
                       });
  };
  EXPECT_TRUE(is_told("it has no ring, little"));
  EXPECT_FALSE(is_told("thumb's contacts go"));
}

TEST(PlaceMatching, WhatAHandWithoutSitesHasNoPlaceForIsNoted) {
  LabelledLemon lemon;
  int number = 0;
  for (contact::Patch& patch : lemon.contacts.patches) {
    if (patch.name == "palm") continue;
    patch.name = fmt::format("c{}", ++number);
    patch.place.reset();
  }
  hand::Hand hand = handOfLibrary("human20");
  hand.sites.clear();
  const Session session(hand, lemon.mesh, lemon.contacts, Pose::Identity(), {});
  EXPECT_THAT(
      session.document().notes,
      testing::Contains(testing::HasSubstr("without contact sites: 1 of 6 patches are laid")));
}

}  // namespace
}  // namespace handgraft::session
