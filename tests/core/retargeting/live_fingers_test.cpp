#include "core/retargeting/live_fingers.h"

#include <gtest/gtest.h>

namespace handgraft::retargeting {
namespace {

using session::Dealing;
using Digits = std::vector<std::string>;

hand::Anatomy handOf(const Digits& names) {
  hand::Anatomy anatomy;
  for (const std::string& name : names)
    anatomy.digits.emplace_back().name = name;
  return anatomy;
}

const Digits kFour{"thumb", "index", "middle", "ring"};
const Digits kAll{"thumb", "index", "middle", "ring", "little"};

TEST(LiveFingers, OfAHandThatHasThemAllAreThoseOfTheirNames) {
  const hand::Anatomy anatomy = handOf(kAll);
  const LiveFingers fingers(anatomy);
  EXPECT_EQ(fingers.waysFor({"thumb", "ring"}),
            (std::vector<Dealing>{{{"thumb", "thumb"}, {"ring", "ring"}}}));
  // Of a digit that nobody has a name for, too, some finger is one.
  EXPECT_EQ(fingers.waysFor({"f1"}).size(), 4u);
}

TEST(LiveFingers, AreChosenAmongAllWaysWhereTheHandLacksAny) {
  const hand::Anatomy anatomy = handOf(kFour);
  EXPECT_EQ(LiveFingers(anatomy).waysFor({"thumb", "ring"}).size(), 3u);
}

TEST(LiveFingers, AreTakenFromDigitsWhoseTouchesHaveFaded) {
  const hand::Anatomy anatomy = handOf(kFour);
  LiveFingers fingers(anatomy);
  const Digits first{"thumb", "index", "middle", "ring"};
  fingers.choose(fingers.waysFor(first).front(), first);
  EXPECT_TRUE(fingers.isChosenFor(first));

  // The index finger has just let go: its touch may come back.
  const Digits now{"thumb", "middle", "ring", "little"};
  fingers.take(now, kAll);
  EXPECT_EQ(fingers.fingerFor("little"), nullptr);
  EXPECT_TRUE(fingers.lacksOneFor(now));

  // Those that touch keep theirs, and none is left behind the ring's.
  fingers.take(now, now);
  EXPECT_EQ(fingers.fingerFor("little"), nullptr);

  // The ring finger has gone as well: the little one takes its.
  const Digits last{"thumb", "middle", "little"};
  fingers.take(last, last);
  ASSERT_NE(fingers.fingerFor("little"), nullptr);
  EXPECT_EQ(*fingers.fingerFor("little"), "ring");
  EXPECT_EQ(*fingers.fingerFor("middle"), "middle");
  EXPECT_EQ(fingers.fingerFor("ring"), nullptr);
  EXPECT_FALSE(fingers.isChosenFor(first)) << "other ways may be better now";
}

TEST(LiveFingers, OfHandsWithNamesOfTheirOwnKeepTheirOrder) {
  const hand::Anatomy anatomy = handOf({"f1", "f2", "f3"});
  LiveFingers fingers(anatomy);
  fingers.choose({{"f1", "f1"}, {"f3", "f3"}}, {"f1", "f3"});
  fingers.take({"f1", "f2", "f3"}, {"f1", "f2", "f3"});
  ASSERT_NE(fingers.fingerFor("f2"), nullptr);
  EXPECT_EQ(*fingers.fingerFor("f2"), "f2");
}

}  // namespace
}  // namespace handgraft::retargeting
