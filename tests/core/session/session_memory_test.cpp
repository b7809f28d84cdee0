// What a session keeps for itself, beside the models that all share: by what the allocator says
// is in use, in a process of one thread.
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <malloc.h>

#include "core/base/error.h"
#include "core/base/sanitized.h"
#include "core/verdict/fit_check.h"

#include "tests/core/session/lemon_models.h"
#include "tests/core/session/random_edits.h"

namespace handgraft::session {
namespace {

constexpr double kMostKib = 1000.0;

double inUseKib() {
  const struct mallinfo2 info = mallinfo2();
  return 1e-3 * static_cast<double>(info.uordblks + info.hblkhd);
}

/// Edited, every edit solved, as a server does; returns what it takes, in kB.
double editedAtRandom(const SessionModels& models, unsigned seed, int count) {
  const double before_kib = inUseKib();
  Session session(models, Pose::Identity(), {});
  verdict::FitCheck check;
  SolveRun after_edit;
  after_edit.places_stay = true;
  SolverSettings quick;
  quick.starts = 2;
  quick.avoid_penetration = false;  // solids are shared by all, and what they cost is time
  session.commit(session.solve(quick, SolveRun(), Progress()));
  test::RandomEdits edits(seed);
  for (int applied = 0; applied < count;) {
    try {
      session.apply(edits.next(session));
      ++applied;
      if (session.needsSolve()) session.commit(session.solve(quick, after_edit, Progress()));
      if (session.solvedProblem()) check.of(session, *session.solvedProblem());
    } catch (const InvalidInput&) {
      // Refused, or all patches are off, or off the hand.
    }
  }
  return inUseKib() - before_kib;
}

void expectSmall(const SessionModels& models) {
  if (kIsSanitized)
    GTEST_SKIP() << "a sanitizer has an allocator of its own, which mallinfo2 does not know";
  // What all sessions on these models share is made by the first one.
  editedAtRandom(models, 1, 900);
  const double some_kib = editedAtRandom(models, 1, 300);
  const double many_kib = editedAtRandom(models, 1, 900);
  EXPECT_LT(some_kib, kMostKib);
  EXPECT_LT(many_kib, kMostKib) << "what is kept of the past is bounded";
  EXPECT_GT(some_kib, 50.0) << "nothing was measured";
  ::testing::Test::RecordProperty("kB_after_300_edits", std::to_string(some_kib));
  ::testing::Test::RecordProperty("kB_after_900_edits", std::to_string(many_kib));
}

TEST(SessionMemory, OfAHumanHandStaysBelowAMegabyte) {
  const std::filesystem::path folder = test::modelPath("hands/human20");
  expectSmall(test::lemonModels(test::handOf(folder / "human20.urdf", folder / "sites.yaml")));
}

TEST(SessionMemory, OfTheRealAllegroStaysBelowAMegabyte) {
  const std::string urdf = "hands/allegro_right/allegro_hand_right.urdf";
  HANDGRAFT_NEEDS_SHARED_DATA(urdf);
  expectSmall(test::lemonModels(test::handOf(test::sharedData(urdf), "")));
}

}  // namespace
}  // namespace handgraft::session
