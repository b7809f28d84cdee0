#include "core/retargeting/live_searches.h"

#include <vector>

#include <gtest/gtest.h>

namespace handgraft::retargeting {
namespace {

/// At 100 Hz, of a hand that is lost from the beginning and never found: when it is searched.
std::vector<double> searchesOf(double seconds, bool is_lost, bool is_unserved) {
  LiveSearches searches;
  std::vector<double> times;
  for (int k = 1; k <= 100 * seconds; ++k) {
    searches.see(0.01, is_lost, is_unserved);
    if (!searches.isDue(0.01 * k)) continue;
    times.push_back(0.01 * k);
    searches.foundNothing(0.01 * k);
  }
  return times;
}

TEST(LiveSearches, WaitTwiceAsLongEachTimeWhereNothingIsFound) {
  for (const bool is_lost : {true, false}) {
    const std::vector<double> times = searchesOf(20.0, is_lost, !is_lost);
    ASSERT_EQ(times.size(), 8u);
    EXPECT_NEAR(times[0], 0.25, 0.0101);
    const double waits[] = {0.5, 1.0, 2.0, 4.0, 4.0, 4.0, 4.0};
    for (std::size_t i = 0; i + 1 < times.size(); ++i)
      EXPECT_NEAR(times[i + 1] - times[i], waits[i], 0.0101) << i;
  }
  EXPECT_TRUE(searchesOf(20.0, false, false).empty());
}

TEST(LiveSearches, OfAHandThatIsLostForAMomentAreNotDue) {
  LiveSearches searches;
  for (int k = 1; k <= 200; ++k) {
    searches.see(0.01, k % 24 != 0, false);
    EXPECT_FALSE(searches.isDue(0.01 * k)) << k;
  }
}

TEST(LiveSearches, AreDueSoonAgainWhereSomethingElseTouches) {
  LiveSearches searches;
  searches.see(1.0, true, false);
  for (double time_s = 0.0; time_s < 10.0; time_s += 5.0)
    searches.foundNothing(time_s);
  searches.touchesChanged();
  searches.foundNothing(20.0);
  searches.see(0.01, true, false);
  EXPECT_FALSE(searches.isDue(20.4));
  EXPECT_TRUE(searches.isDue(20.6));
}

TEST(LiveSearches, WaitUntilAHandIsWhereItWasFound) {
  LiveSearches searches;
  searches.see(1.0, true, false);
  searches.found(3.0);
  EXPECT_FALSE(searches.isDue(3.4));
  EXPECT_TRUE(searches.isDue(3.6));
  searches.beginAnew(3.6);
  EXPECT_FALSE(searches.isDue(3.7)) << "behind a pause nobody is lost yet";
}

}  // namespace
}  // namespace handgraft::retargeting
