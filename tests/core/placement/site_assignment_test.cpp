#include "core/placement/site_assignment.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "core/placement/solids.h"

#include "tests/core/session/ball_grasp.h"

namespace handgraft::placement {
namespace {

using test::BallGrasp;

struct Case {
  BallGrasp grasp;
  HandPoseGuesser placer{grasp.small.model, *grasp.small.skin, solidOf(grasp.ball, Progress())};
  std::vector<Anchor> patches;
  std::vector<Anchor> sites;

  Case() {
    for (std::size_t i = 0; i < 3; ++i) {
      Anchor patch;
      patch.p_O = positionOf(*grasp.ball, grasp.contacts.patches[i].root);
      patch.n_O = normalOf(*grasp.ball, grasp.contacts.patches[i].root);
      patches.push_back(patch);
      sites.push_back(*anchorAt(
          *grasp.small.skin,
          transfer::placementAt(*grasp.small.model, *grasp.small.skin, grasp.small.sites[i])));
    }
  }

  [[nodiscard]] std::vector<int> assign(const std::vector<std::vector<bool>>& permitted) const {
    return assignSites(placer, grasp.small.model, {}, patches, sites, permitted,
                       Pose::Identity(), 1, Progress())
        .front();
  }
};

TEST(AssignSites, OpposesTheThumb) {
  Case c;
  std::rotate(c.patches.begin(), c.patches.begin() + 1,
              c.patches.end());  // the thumb's is last
  const auto answer = c.assign({3, std::vector<bool>(3, true)});
  EXPECT_EQ(answer[2], 0);
}

TEST(AssignSites, KeepsToWhatIsPermitted) {
  const Case c;
  const auto answer = c.assign({{false, true, true}, {true, false, false}, {true, true, true}});
  EXPECT_NE(answer[0], 0);
  EXPECT_EQ(answer[1], 0);
  EXPECT_NE(answer[2], 0);
}

TEST(AssignSites, LeavesOutWhatFindsNoPlace) {
  const Case c;
  EXPECT_EQ(c.assign({3, std::vector<bool>(3, false)}), (std::vector<int>{-1, -1, -1}));
  const auto answer =
      c.assign({{true, false, false}, {true, false, false}, {true, false, false}});
  EXPECT_EQ(std::count(answer.begin(), answer.end(), -1), 2);
}

TEST(AssignSites, TakesTheFirstPatchesWhenThereAreTooMany) {
  Case c;
  c.sites.resize(2);
  const auto answer = c.assign({3, std::vector<bool>(2, true)});
  EXPECT_EQ(std::count(answer.begin(), answer.end(), -1), 1);
}

}  // namespace
}  // namespace handgraft::placement
