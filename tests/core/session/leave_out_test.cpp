// Patches that keep the hand off others, as a session opens.

#include "core/session/leave_out.h"

#include <algorithm>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/contact_file.h"
#include "core/optimize/diagnosis.h"
#include "core/session/best_way.h"
#include "core/session/patch_matching.h"
#include "core/session/session.h"

#include "tests/core/session/uneven_lemon.h"

namespace handgraft::session {
namespace {

using test::UnevenLemon;
using testing::HasSubstr;

std::size_t indexOf(const Session& session, const std::string& patch) {
  const auto& patches = session.patches();
  return static_cast<std::size_t>(std::find_if(patches.begin(), patches.end(),
                                               [&](const SessionPatch& item) {
                                                 return item.patch.name == patch;
                                               }) -
                                  patches.begin());
}

std::ptrdiff_t reachedBySolving(Session& session) {
  const Solution solution = session.solve(session.document().solving, SolveRun(), Progress());
  return std::ssize(solution.report.patches) -
         std::ssize(optimize::missedPatches(solution.problem, solution.report));
}

std::ptrdiff_t laidIn(const Session& session) {
  return std::count_if(session.patches().begin(), session.patches().end(),
                       [](const SessionPatch& item) {
                         return item.placement.has_value();
                       });
}

TEST(LeaveOut, AFingersPatchGoesWhereMoreOfTheOthersAreReachedAndComesBackByARoot) {
  const UnevenLemon lemon("index", 10.0);
  Session session = lemon.open("tendon16");
  const std::size_t index = indexOf(session, "index");
  ASSERT_LT(index, session.patches().size());
  EXPECT_FALSE(session.patches()[index].placement);
  EXPECT_THAT(session.patches()[index].dropped, HasSubstr("without 'index'"));
  EXPECT_THAT(session.document().notes, testing::Contains(HasSubstr("without 'index'")));
  const std::ptrdiff_t without = reachedBySolving(session);

  const hand::Hand hand = test::handOfLibrary("tendon16");
  const auto site = std::find_if(hand.sites.begin(), hand.sites.end(), [](const auto& one) {
    return one.name == "index";
  });
  ASSERT_NE(site, hand.sites.end());
  session.apply(PatchRootEdit{"index", Side::kHand,
                              transfer::placementAt(*hand.model, *hand.skin, *site).root_S});
  EXPECT_EQ(session.patches()[index].dropped, "");
  EXPECT_LT(reachedBySolving(session), without);
}

TEST(LeaveOut, NoneGoesWhereNothingIsGainedByIt) {
  const Session session = UnevenLemon("index", 1.0).open("human20");
  EXPECT_EQ(laidIn(session), std::ssize(session.patches()));
}

/// As heavy as it is: a grasp without a thumb is none.
TEST(LeaveOut, TheThumbsOnlyPatchStays) {
  for (const char* hand : {"tendon16", "allegro16", "barrett8"}) {
    const Session session = UnevenLemon("thumb", 30.0).open(hand);
    EXPECT_TRUE(session.patches()[indexOf(session, "thumb")].placement) << hand;
  }
}

/// Three are a grasp; of those none is left out, though without one both others are reached.
TEST(LeaveOut, ThreeStay) {
  const io::MeshFile file = io::readMesh(test::libraryPath("objects/scissors.obj"));
  const auto mesh = std::make_shared<const geometry::TriangleMesh>(file.mesh);
  const contact::ContactSet three =
      io::readContactSet(test::libraryPath("contacts/scissors_3.json"), file);
  ASSERT_EQ(three.patches.size(), 3u);
  for (const char* hand : {"allegro16", "barrett8"}) {
    const Session session(test::handOfLibrary(hand), mesh, three, Pose::Identity(), {});
    EXPECT_EQ(laidIn(session), 3) << hand;
  }
}

TEST(LeaveOut, NothingOfWhatSomebodyLaidHimself) {
  const UnevenLemon lemon("index", 10.0);
  const Session session = lemon.open("tendon16");
  Document again = session.document();
  const hand::Hand hand = test::handOfLibrary("tendon16");
  for (DocumentPatch& patch : again.patches) {
    for (const hand::ContactSite& site : hand.sites)
      if (site.name == patch.name && !patch.placement)
        patch.placement = transfer::placementAt(*hand.model, *hand.skin, site);
  }
  const Document before = again;
  ModelCache cache(modelsFor(again, hand, lemon.mesh,
                             std::make_shared<const contact::ContactSet>(lemon.contacts)));
  const Models models = cache.find(again.hand, again.object, Progress());
  WayTrials trials(models);
  leaveOutWhatKeepsOthersOff(std::vector<char>(again.patches.size(), 0), trials, again,
                             Progress());
  EXPECT_TRUE(again == before);
  leaveOutWhatKeepsOthersOff(std::vector<char>(again.patches.size(), 1), trials, again,
                             Progress());
  EXPECT_FALSE(again == before);
}

}  // namespace
}  // namespace handgraft::session
