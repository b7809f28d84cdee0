// Transfers, solves, suggestions and exports as the service answers them.
#include <cmath>
#include <limits>
#include <set>
#include <string>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/messages/transfer_messages.h"

#include "tests/server/service_fixture.h"

namespace handgraft::server {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;

TEST_F(ServiceTest, SolvesAndPublishesOneFinalPose) {
  const std::uint64_t session = openSmallSession();
  const v1::Reply transfer = bus.ask(test::ofSession(v1::OP_TRANSFER, session));
  ASSERT_EQ(transfer.error(), v1::ERROR_NONE) << transfer.message();
  int placed = 0;
  for (const auto& patch : transfer.body().transfer().patches())
    placed += patch.placed();
  EXPECT_EQ(transfer.body().transfer().patches().size(), 6u);
  EXPECT_EQ(placed, 2);  // the clamp has a palm and an index; the rest is dropped and says why

  const v1::Reply reply = bus.ask(test::optimize(session));
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  const v1::PoseSolution& solution = reply.body().solution();
  EXPECT_TRUE(solution.is_final());
  EXPECT_EQ(solution.joint_positions().size(), 1u);
  EXPECT_EQ(solution.X_WL().size(), 2u);
  EXPECT_EQ(solution.patches().size(), 2u);
  for (const v1::PatchFit& fit : solution.patches()) {
    EXPECT_EQ(fit.hand_W_m().size(), 3 * fit.point_count());
    double sum = 0.0;
    for (std::size_t i = 0; i < fit.hand_W_m().size(); i += 3) {
      sum += std::hypot(fit.hand_W_m()[i] - fit.object_W_m()[i],
                        fit.hand_W_m()[i + 1] - fit.object_W_m()[i + 1],
                        fit.hand_W_m()[i + 2] - fit.object_W_m()[i + 2]);
    }
    EXPECT_NEAR(1e3 * sum / fit.point_count(), fit.mean_mm(), 1e-6) << fit.name();
  }
  ASSERT_EQ(bus.count(bus.commands), 1u);
  EXPECT_THAT(bus.commands[0].name(), testing::ElementsAre("hinge"));
  EXPECT_EQ(bus.commands[0].position()[0], solution.joint_positions()[0]);
  EXPECT_EQ(bus.states.back().phase(), v1::PHASE_READY);
}

TEST_F(ServiceTest, TellsWhatEachStageOfAFirstSolveTook) {
  const v1::Reply reply = bus.ask(test::optimize(openSmallSession()));
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  std::vector<std::string> stages;
  for (const v1::StageTime& time : reply.body().solution().times())
    stages.push_back(time.stage());
  EXPECT_THAT(stages, testing::ElementsAre("skin", "transfer", "sizes", "optimize", "solids",
                                           "report"));
}

TEST_F(ServiceTest, RanksWhereTheSearchesEnded) {
  const v1::Reply reply = bus.ask(test::optimize(openSmallSession(), v1::SOLVER_ALL));
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  const v1::PoseSolution& solution = reply.body().solution();
  ASSERT_GE(solution.minima().size(), 1u);
  ASSERT_LE(solution.minima().size(), 8u);
  EXPECT_EQ(solution.minima()[0].joint_positions(), solution.joint_positions());
  EXPECT_EQ(solution.minima()[0].X_WH().p_m(), solution.X_WH().p_m());
  EXPECT_EQ(solution.minima()[0].solver(), solution.solver());
  EXPECT_GE(solution.minima()[0].hits(), 1u);
  for (std::size_t i = 1; i < solution.minima().size(); ++i) {
    EXPECT_LE(solution.minima()[i - 1].terms().objective(),
              solution.minima()[i].terms().objective());
  }
}

TEST_F(ServiceTest, NamesWhatASolveDoesNotTake) {
  const std::uint64_t session = openSmallSession();
  const auto refusal_of = [&](const auto& change) {
    v1::RequestBody body = test::optimize(session);
    v1::SolveOptions options;
    change(options);
    body.optimize().options() = {options};
    const v1::Reply reply = bus.ask(body);
    EXPECT_EQ(reply.error(), v1::ERROR_INVALID_INPUT);
    return reply.message();
  };
  EXPECT_THAT(refusal_of([](auto& options) {
                options.starts(10'001);
              }),
              HasSubstr("starts: 10001 is outside 0 to 10000"));
  EXPECT_THAT(refusal_of([](auto& options) {
                options.max_evaluations(100'001);
              }),
              HasSubstr("max_evaluations: 100001 is outside 0 to 100000"));
  EXPECT_THAT(refusal_of([](auto& options) {
                options.paper(true);
                options.solver(v1::SOLVER_LM);
              }),
              HasSubstr("solver lm"));
  EXPECT_THAT(refusal_of([](auto& options) {
                options.paper(true);
                options.starts(64);
              }),
              HasSubstr("starts: 64"));
  EXPECT_THAT(refusal_of([](auto& options) {
                options.normal_form(static_cast<v1::NormalForm>(7));
              }),
              HasSubstr("normal_form: 7"));
  EXPECT_THAT(refusal_of([](auto& options) {
                options.penetration(static_cast<v1::PenetrationCare>(7));
              }),
              HasSubstr("penetration: 7"));
}

v1::RequestBody openSmallSessionWith(v1::LogMapMethod method, unsigned interior_rings) {
  v1::TransferOptions options;
  options.method(method);
  options.interior_rings(interior_rings);
  v1::RequestBody body = test::openSession("clamp", "fruit", "marks");
  body.open_session().transfer().push_back(options);
  return body;
}

TEST_F(ServiceTest, TransfersByTheMethodThatTheSessionAskedFor) {
  loadSmallGrasp();
  const v1::Reply opened = bus.ask(openSmallSessionWith(v1::LOG_MAP_EXACT, 0));
  ASSERT_EQ(opened.error(), v1::ERROR_NONE) << opened.message();
  const v1::Reply reply =
      bus.ask(test::ofSession(v1::OP_TRANSFER, opened.body().session().session_id()));
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  const v1::TransferReply& transfer = reply.body().transfer();
  EXPECT_EQ(transfer.options().method(), v1::LOG_MAP_EXACT);
  int placed = 0;
  for (const v1::PatchReport& patch : transfer.patches()) {
    if (!patch.placed()) continue;
    ++placed;
    EXPECT_EQ(patch.method_O(), v1::LOG_MAP_EXACT);
    EXPECT_EQ(patch.method_S(), v1::LOG_MAP_EXACT);
    EXPECT_EQ(patch.boundary_count(), patch.point_count());
  }
  EXPECT_EQ(placed, 2);
}

TEST(TransferNotes, NameThePatchesThatLostTheirShape) {
  std::vector<session::SessionPatch> patches(3);
  for (const int i : {0, 1, 2}) {
    patches[i].patch.name = fmt::format("patch_{}", i);
    patches[i].placement.emplace();
    patches[i].transferred.correspondences.resize(1);
    patches[i].transferred.fidelity.distance_mean = 0.1 * i;
  }
  EXPECT_THAT(distortionNotes(patches),
              ElementsAre(EndsWith(": patch_2: lengths 20 %, angles 0 deg, area x 1.00")));
  patches[2].placement.reset();
  EXPECT_TRUE(distortionNotes(patches).empty());
}

TEST(TransferNotes, AskForTheUnitsOfAnObjectThatIsTooLarge) {
  const auto notes_at = [](double side) {
    const geometry::TriangleMesh box = geometry::makeBox(Eigen::Vector3d::Constant(side));
    std::vector<session::SessionPatch> patches(2);
    patches[0].patch.root = geometry::surfacePointAtVertex(box, 0);
    patches[1].patch.root = geometry::surfacePointAtVertex(box, 7);
    return sizeNotes(patches, box, geometry::makeBox(Eigen::Vector3d::Constant(0.1)));
  };
  EXPECT_TRUE(notes_at(0.2).empty());
  EXPECT_THAT(notes_at(1.0), ElementsAre(HasSubstr("hand is 0.17 m across")));
}

TEST_F(ServiceTest, RefusesTransferOptionsOutOfRangeByName) {
  loadSmallGrasp();
  const v1::Reply method = bus.ask(openSmallSessionWith(static_cast<v1::LogMapMethod>(99), 0));
  EXPECT_EQ(method.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(method.message(), HasSubstr("exact"));
  const v1::Reply rings = bus.ask(openSmallSessionWith(v1::LOG_MAP_DEFAULT, 17));
  EXPECT_EQ(rings.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(rings.message(), HasSubstr("17 is outside 0 to 16"));
  v1::RequestBody twice = openSmallSessionWith(v1::LOG_MAP_DEFAULT, 0);
  twice.open_session().transfer().resize(2);
  EXPECT_EQ(bus.ask(twice).error(), v1::ERROR_INVALID_INPUT);
}

TEST_F(ServiceTest, SuggestsWithoutMovingAnything) {
  const std::uint64_t session = openSmallSession();
  const v1::Reply before = bus.ask(test::ofSession(v1::OP_TRANSFER, session));
  const v1::Reply reply = bus.ask(test::suggest(session, "palm"));
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  const v1::SuggestReply& suggest = reply.body().suggest();
  EXPECT_EQ(suggest.session_id(), session);
  EXPECT_EQ(suggest.revision(), 0u);
  EXPECT_EQ(suggest.patch(), "palm");
  const auto palm = [](const v1::Reply& transfer) {
    for (const v1::PatchReport& patch : transfer.body().transfer().patches()) {
      if (patch.name() == "palm") return patch;
    }
    return v1::PatchReport();
  };
  EXPECT_EQ(suggest.present(), palm(before));
  for (const v1::PlacementSuggestion& one : suggest.suggestions()) {
    EXPECT_LT(one.lost_count(), suggest.present().lost().size());
  }
  const v1::Reply after = bus.ask(test::ofSession(v1::OP_TRANSFER, session));
  EXPECT_EQ(palm(after), palm(before));
  EXPECT_EQ(after.body().transfer().revision(), 0u);
}

TEST_F(ServiceTest, RefusesToSuggestBeyondItsLimitsAndStaysAsItWas) {
  const std::uint64_t session = openSmallSession();
  const auto phase = [&] {
    return bus.ask(test::ofSession(v1::OP_DESCRIBE_SESSION, session)).body().session().phase();
  };
  const v1::SessionPhase before = phase();
  for (const double reach_m : {-0.01, 0.5, 1e-5, std::nan("")}) {
    const v1::Reply reply = bus.ask(test::suggest(session, "palm", reach_m));
    EXPECT_EQ(reply.error(), v1::ERROR_INVALID_INPUT) << reach_m;
    EXPECT_THAT(reply.message(), HasSubstr("0.1")) << reach_m;
  }
  EXPECT_THAT(bus.ask(test::suggest(session, "palm", 0.0, 101)).message(),
              HasSubstr("101 is outside"));
  EXPECT_THAT(bus.ask(test::suggest(session, "toe")).message(), HasSubstr("'toe'"));
  const v1::Reply dropped = bus.ask(test::suggest(session, "little"));
  EXPECT_EQ(dropped.error(), v1::ERROR_INVALID_INPUT);
  EXPECT_THAT(dropped.message(), HasSubstr("little"));
  EXPECT_EQ(bus.ask(test::suggest(999, "palm")).error(), v1::ERROR_NOT_FOUND);
  EXPECT_EQ(phase(), before);
}

TEST_F(ServiceTest, ExportsWhatItSolvedAsAProblem) {
  const std::uint64_t session = openSmallSession();
  bus.ask(test::optimize(session));
  const v1::Reply reply = bus.ask(test::exportProblem(session));
  ASSERT_EQ(reply.error(), v1::ERROR_NONE) << reply.message();
  const std::vector<std::uint8_t>& content = reply.body().exported_file().content();
  const std::string text(content.begin(), content.end());
  EXPECT_THAT(text, HasSubstr("handgraft-problem/1"));
  EXPECT_THAT(text, HasSubstr("clamp.urdf"));
}

}  // namespace
}  // namespace handgraft::server
