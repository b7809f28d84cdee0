// Ways to lay patches: what one trial knows of another, and what opening has found already.

#include "core/session/best_way.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/session/derived_state.h"
#include "core/session/session.h"

#include "tests/core/session/uneven_lemon.h"

namespace handgraft::session {
namespace {

/// Whose index finger keeps the others off, on the hand below: patches are tried as it opens.
struct HardLemon : test::UnevenLemon {
  std::string hand = "tendon16";

  HardLemon() : UnevenLemon("index", 10.0) {}

  [[nodiscard]] SessionModels models() const { return UnevenLemon::models(hand); }
};

void expectSame(const Solution& a, const Solution& b) {
  EXPECT_EQ(a.report.pose.q, b.report.pose.q);
  EXPECT_EQ(a.report.pose.X_WH.matrix(), b.report.pose.X_WH.matrix());
  EXPECT_EQ(a.report.terms.objective, b.report.terms.objective);
  EXPECT_EQ(a.report.evaluations, b.report.evaluations);
  EXPECT_EQ(a.report.minima.size(), b.report.minima.size());
  EXPECT_TRUE(a.document == b.document);
  ASSERT_EQ(a.patches.size(), b.patches.size());
  for (std::size_t i = 0; i < a.patches.size(); ++i) {
    EXPECT_EQ(a.patches[i].transferred.correspondences.size(),
              b.patches[i].transferred.correspondences.size())
        << a.patches[i].patch.name;
  }
}

/// A session that does not know what its opening came to.
Session asSaved(const HardLemon& lemon, const Session& session) {
  return {lemon.models(), session.saved()};
}

TEST(WayTrials, WhatOpeningFoundIsWhatASolveFinds) {
  const HardLemon lemon;
  Session session(lemon.models(), Pose::Identity(), {});
  Session again = asSaved(lemon, session);
  const SolverSettings solving = session.document().solving;
  const Solution known = session.solve(solving, {}, Progress());
  expectSame(known, again.solve(solving, {}, Progress()));
  session.commit(session.solve(solving, {}, Progress()));
  again.commit(again.solve(solving, {}, Progress()));
  EXPECT_TRUE(session.document() == again.document());
}

/// Its charts serve the edits that follow as those of a solve do.
TEST(WayTrials, EditsGoOnFromWhatOpeningFoundAsFromASolve) {
  const HardLemon lemon;
  Session session(lemon.models(), Pose::Identity(), {});
  Session again = asSaved(lemon, session);
  const SolverSettings solving = session.document().solving;
  for (Session* one : {&session, &again}) {
    one->commit(one->solve(solving, {}, Progress()));
    one->apply(PatchWeightEdit{"thumb", 3.0});
  }
  SolveRun after_edit;
  after_edit.places_stay = true;
  expectSame(session.solve(solving, after_edit, Progress()),
             again.solve(solving, after_edit, Progress()));
}

/// Neither another seed nor another document gets the answer of the first.
TEST(WayTrials, WhatOpeningFoundAnswersNothingElse) {
  const HardLemon lemon;
  Session session(lemon.models(), Pose::Identity(), {});
  Session again = asSaved(lemon, session);
  SolverSettings other = session.document().solving;
  other.starts = 5;
  expectSame(session.solve(other, {}, Progress()), again.solve(other, {}, Progress()));
  for (Session* one : {&session, &again})
    one->apply(PatchWeightEdit{"thumb", 3.0});
  const SolverSettings solving = session.document().solving;
  expectSame(session.solve(solving, {}, Progress()), again.solve(solving, {}, Progress()));
  for (Session* one : {&session, &again})
    one->apply(UndoEdit{1});
  expectSame(session.solve(solving, {}, Progress()), again.solve(solving, {}, Progress()));
}

/// What a full search laid is no draft: a short one after it is what it would have been.
TEST(WayTrials, NoneDependsOnWhatWasTriedBefore) {
  const HardLemon lemon;
  const Session session(lemon.models(), Pose::Identity(), {});
  const auto cache = std::make_shared<ModelCache>(lemon.models());
  SolverSettings few = session.document().solving;
  few.starts = 4;
  const auto short_search = [&](bool after_full) {
    DerivedState derived(cache);
    derived.follow(session.document(), Progress());
    if (after_full) derived.solve(session.document().solving, {}, Progress());
    return derived.solveRoughly(few, Progress());
  };
  expectSame(short_search(false), short_search(true));
}

/// Which fingers take whose patches, what is left out, and the answer that is known.
TEST(WayTrials, AreTheSameOnAnyNumberOfThreads) {
  HardLemon lemon;
  for (const char* hand : {"tendon16", "barrett8"}) {
    lemon.hand = hand;
    Session alone(lemon.models(), Pose::Identity(), {});
    SessionModels models = lemon.models();
    models.threads = 4;
    Session together(models, Pose::Identity(), {});
    EXPECT_TRUE(alone.document() == together.document()) << hand;
    const SolverSettings solving = alone.document().solving;
    expectSame(alone.solve(solving, {}, Progress()), together.solve(solving, {}, Progress()));
  }
}

TEST(WayTrials, AreGivenUpOnWish) {
  const HardLemon lemon;
  SessionModels models = lemon.models();
  models.threads = 2;
  Progress given_up;
  given_up.cancel();
  EXPECT_THROW(Session(models, Pose::Identity(), {}, {}, given_up), Cancelled);
}

TEST(WayTrials, KeepWhatAFullSearchFound) {
  const HardLemon lemon;
  const Session session(lemon.models(), Pose::Identity(), {});
  const Document& document = session.document();
  ModelCache cache(lemon.models());
  const Models models = cache.find(document.hand, document.object, Progress());
  WayTrials trials(models);
  EXPECT_EQ(trials.solutionOf(document), nullptr);
  const std::ptrdiff_t missed = trials.missedBySearch(document, Progress());
  const auto solution = trials.solutionOf(document);
  ASSERT_NE(solution, nullptr);
  EXPECT_EQ(missed, failedPatches(solution->problem, solution->report));
  // One that lays fewer and reaches no more is not better, and the first stays known.
  Document fewer = document;
  fewer.patches.front().placement.reset();
  EXPECT_EQ(trials.bestSolved({document, fewer}, Progress()), 0U);
  EXPECT_EQ(trials.solutionOf(document), solution);
  EXPECT_EQ(trials.solutionOf(fewer), nullptr);
}

}  // namespace
}  // namespace handgraft::session
