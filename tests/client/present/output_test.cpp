#include <cmath>
#include <iterator>
#include <limits>
#include <sstream>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/link/grasp_result.h"
#include "client/present/json_output.h"
#include "client/present/minima_text.h"
#include "client/present/motion_output.h"
#include "client/present/text_output.h"
#include "core/base/error.h"

#include "tests/client/present/example_grasp.h"

namespace handgraft::client {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

/// What a program reads.
json printed(const client::json::Json& document) {
  return json::parse(client::json::written(document));
}

TEST(GraspJson, SaysWhatTheReadmePromises) {
  const json document = printed(client::json::grasp(exampleGrasp()));
  EXPECT_EQ(document["format"], "handgraft-grasp/1");
  EXPECT_EQ(document["hand"], "claw");
  EXPECT_EQ(document["object"], "plate");
  EXPECT_EQ(document["contacts"], "plate_2");
  EXPECT_TRUE(document["session_id"].is_null());
  EXPECT_EQ(document["X_WH"]["p_m"][0], 0.1);
  EXPECT_EQ(document["X_WO"]["q_wxyz"].size(), 4U);
  EXPECT_EQ(document["joints"]["bend"], 0.5);
  EXPECT_EQ(document["links_X_WL"]["tip"]["p_m"][0], 0.3);
  EXPECT_EQ(document["terms"]["objective"], 0.25);
  EXPECT_EQ(document["joints_at_limit"][0]["joint"], "bend");
  EXPECT_EQ(document["joints_at_limit"][0]["side"], "upper");
  EXPECT_EQ(document["times"][0]["duration_ms"], 12.0);
  ASSERT_EQ(document["patches"].size(), 2U);
  const json& thumb = document["patches"][0];
  EXPECT_EQ(thumb["placed"], true);
  EXPECT_EQ(thumb["mean_mm"], 1.25);
  EXPECT_EQ(thumb["lost"][0]["index"], 3);
  EXPECT_EQ(thumb["lost"][0]["ring"], 0);
  EXPECT_EQ(thumb["fidelity"]["distance_mean"], 0.031);
  EXPECT_EQ(thumb["method_O"], "exact");
  EXPECT_EQ(thumb["hand_W_m"].size(), 9U);
  EXPECT_EQ(thumb["hand_W_m"][3], 0.01);
  EXPECT_EQ(document["patches"][1]["placed"], false);
  EXPECT_EQ(document["patches"][1]["reason"], "the hand has no finger 'ring'");
}

// Two places, the second 3 mm off, a quarter turn about x and 0.1 rad of its joint.
v1::PoseSolution ranked() {
  v1::MinimumInfo best;
  best.solver("lm");
  best.hits(40);
  best.terms().objective(1.5);
  best.X_WH() = poseAt(0.1);
  best.joint_positions() = {0.5};
  v1::MinimumInfo second = best;
  second.solver("mma");
  second.hits(2);
  second.start(7);
  second.terms().objective(2.0);
  second.X_WH() = poseAt(0.103);
  second.X_WH().q_wxyz({std::sqrt(0.5), std::sqrt(0.5), 0.0, 0.0});
  second.joint_positions() = {0.4};
  v1::PoseSolution solution;
  solution.minima() = {best, second};
  solution.chosen_minimum(1);
  return solution;
}

TEST(RankedMinima, SayHowFarEachIsFromTheBestAndWhichOneIsTaken) {
  const std::string shown = text::minima(ranked(), exampleGrasp().hand);
  EXPECT_THAT(shown, ContainsRegex("1 +lm +1.5 +40 +0 +0.0 +0.0 +0.0\n"));
  EXPECT_THAT(shown, ContainsRegex("2 +mma +2 +2 +7 +3.0 +90.0 +5.7 +taken\n"));
  EXPECT_EQ(text::minima(v1::PoseSolution(), exampleGrasp().hand), "");
}

TEST(RankedMinima, AreInTheDocumentWithTheirPoses) {
  GraspResult result = exampleGrasp();
  result.solution.minima() = ranked().minima();
  result.solution.chosen_minimum(1);
  const json minima = printed(client::json::grasp(result))["minima"];
  ASSERT_EQ(minima.size(), 2U);
  EXPECT_EQ(minima[0]["taken"], false);
  EXPECT_EQ(minima[1]["rank"], 2);
  EXPECT_EQ(minima[1]["taken"], true);
  EXPECT_EQ(minima[1]["hits"], 2);
  EXPECT_EQ(minima[1]["joints"]["bend"], 0.4);
  EXPECT_NEAR(minima[1]["moved_mm"], 3.0, 1e-9);
  EXPECT_NEAR(minima[1]["turned_deg"], 90.0, 1e-9);
}

TEST(GraspText, HintsAtTheOtherSideWhereNobodyKnowsWhoTouchedAndLittleIsReached) {
  GraspResult result = exampleGrasp();
  result.hand.digits().resize(5);
  result.hand.chirality(v1::CHIRALITY_RIGHT);
  result.solution.patches().resize(1);
  result.solution.patches()[0].diagnosis().verdict(v1::VERDICT_OUT_OF_REACH);
  const auto hint = HasSubstr("--mirror, with the hand's URDF, tries the other side");
  EXPECT_THAT(text::grasp(result), hint);
  result.touched = v1::CHIRALITY_RIGHT;
  EXPECT_THAT(text::grasp(result), Not(hint)) << "a right hand's, on a right one";
  result.hand.chirality(v1::CHIRALITY_UNKNOWN);
  EXPECT_THAT(text::grasp(result), hint);
  result.solution.patches()[0].diagnosis().verdict(v1::VERDICT_REACHED);
  EXPECT_THAT(text::grasp(result), Not(hint));
  result.solution.patches()[0].diagnosis().verdict(v1::VERDICT_OUT_OF_REACH);
  result.hand.digits().resize(3);
  EXPECT_THAT(text::grasp(result), Not(hint)) << "a claw takes what either touched";
}

TEST(GraspJson, NamesTheSessionThatIsKept) {
  GraspResult result = exampleGrasp();
  result.kept = true;
  EXPECT_EQ(printed(client::json::grasp(result))["session_id"], 9);
}

TEST(GraspJson, StaysJsonWhateverTheServerSends) {
  GraspResult result = exampleGrasp();
  result.session.hand("\xff\"\n");
  result.solution.terms().objective(std::numeric_limits<double>::quiet_NaN());
  const json document = printed(client::json::grasp(result));
  EXPECT_EQ(document["terms"]["objective"], "nan");
}

TEST(TextOutput, WrapsLongTextsAndLosesNothing) {
  EXPECT_EQ(client::text::wrapped("thumb: near"), "thumb: near\n");
  std::string text = "thumb:";
  for (int i = 0; i < 100; ++i)
    text += " word" + std::to_string(i);
  text += "\x1b" + std::string(150, 'x');
  const std::string out = client::text::wrapped(text);
  std::istringstream lines(out);
  std::istringstream words(out);
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    EXPECT_EQ(line.rfind("    ", 0), count == 0 ? std::string::npos : 0U) << line;
    EXPECT_LE(line.size(), line.find('x') == std::string::npos ? 100U : 154U);
  }
  EXPECT_EQ(std::distance(std::istream_iterator<std::string>(words), {}), 102);
  EXPECT_EQ(out.find('\x1b'), std::string::npos);
}

TEST(TextOutput, TellsNotesInFull) {
  const std::string note = std::string(300, 'x') + " say --units mm";
  EXPECT_EQ(client::text::notes({note, "b\x1b"}), "note: " + note + "\nnote: b?\n");
}

TEST(WatchText, TellsPosesFromTheirDiagnosis) {
  v1::PoseSolution solution = exampleGrasp().solution;
  solution.is_final(false);
  solution.verdict("");
  solution.penetration().clear();
  EXPECT_THAT(client::text::solutionLine(solution), HasSubstr(": on the way "));
  solution.is_final(true);
  solution.is_diagnosed(false);
  const std::string pose = client::text::solutionLine(solution);
  EXPECT_THAT(pose, HasSubstr(": pose "));
  solution.is_diagnosed(true);
  solution.verdict("1 of 2 patches reached");
  solution.penetration().emplace_back();
  solution.penetration()[0].max_depth_m(0.0042);
  EXPECT_THAT(client::text::solutionLine(solution),
              testing::AllOf(HasSubstr(": solution "),
                             testing::EndsWith("; 1 of 2 patches reached, 4.2 mm deep")));
}

TEST(WatchText, DepthStandsBehindWhatIsReached) {
  v1::PoseSolution solution = exampleGrasp().solution;
  solution.is_final(true);
  solution.verdict("1 of 2 patches reached; 'solve' searches anew");
  solution.penetration().resize(1);
  solution.penetration()[0].max_depth_m(0.0006);
  EXPECT_THAT(client::text::solutionLine(solution),
              testing::EndsWith("1 of 2 patches reached, 0.6 mm deep; 'solve' searches anew"));
}

TEST(WatchJson, PutsEachEventOnOneLine) {
  const std::string solution = client::json::solutionEvent(exampleGrasp().solution, {"bend"});
  EXPECT_EQ(solution.find('\n'), std::string::npos);
  EXPECT_EQ(json::parse(solution)["event"], "solution");
  EXPECT_EQ(json::parse(solution)["joints"]["bend"], 0.5);
  v1::SessionState state;
  state.phase(v1::PHASE_CLOSED);
  EXPECT_EQ(json::parse(client::json::stateEvent(state))["phase"], "closed");
}

TEST(ModelsJson, SaysInfWhereAJointHasNoLimit) {
  v1::HandDescription hand;
  v1::JointInfo joint;
  joint.name("free");
  joint.lower(-std::numeric_limits<double>::infinity());
  joint.upper(1.5);
  hand.joints().push_back(joint);
  v1::ModelDescription description;
  description.hand(hand);
  const json document = printed(client::json::description(description));
  EXPECT_EQ(document["joints"][0]["lower"], "-inf");
  EXPECT_EQ(document["joints"][0]["upper"], 1.5);
}

TEST(DoctorJson, HasANullServerAndAdviceWhenNoneAnswers) {
  DoctorReport report;
  report.advice = "start one";
  const json document = printed(client::json::doctor(report));
  EXPECT_TRUE(document["server"].is_null());
  EXPECT_EQ(document["advice"], "start one");
}

TEST(GraspText, ShowsEachPatchWhatWasDroppedAndTheLimits) {
  const std::string text = text::grasp(exampleGrasp());
  EXPECT_THAT(text,
              HasSubstr("thumb     1.25    2.50         4.0     50 %    100 %       3     1"
                        "   3.1 %        5.7  0.950  at_limit\n"));
  EXPECT_THAT(text, HasSubstr("dropped ring: the hand has no finger 'ring'"));
  EXPECT_THAT(text, HasSubstr("joints at limits: bend upper"));
  EXPECT_THAT(text, HasSubstr("solve 12 ms"));
}

TEST(GraspText, TellsWhichAngleIsJudgedWhereTheTableMisleads) {
  GraspResult result = exampleGrasp();
  v1::PatchFit& patch = result.solution.patches()[0];
  patch.diagnosis().verdict(v1::VERDICT_REACHED);
  patch.normal_deg(58.0);
  EXPECT_THAT(text::grasp(result), testing::Not(HasSubstr("judged")));
  patch.normal_deg(62.0);
  EXPECT_THAT(text::grasp(result), HasSubstr("judged is the angle between the mean normals"));
}

TEST(GraspText, TellsAllThatTheObjectiveIsTheSumOf) {
  GraspResult result = exampleGrasp();
  v1::Terms& terms = result.solution.terms();
  terms.distance_m2(0.01);
  terms.normal(2.0);
  terms.prior(250.0);
  terms.objective(103.0);
  EXPECT_THAT(text::grasp(result),
              HasSubstr("objective 103 (distance 0.01 m2, normal 2, prior 250), "));
  result.weights.emplace();
  result.weights->distance(1e4);
  result.weights->normal(1.0);
  result.weights->prior(1e-3);
  EXPECT_THAT(text::grasp(result),
              HasSubstr("objective 103 (distance 10000 x 0.01 m2, normal 1 x 2, prior "
                        "0.001 x 250, penetration 0.75), "));
  // What is charged is explained where nothing is in the object.
  v1::Penetration& depth = result.solution.penetration().emplace_back();
  EXPECT_THAT(text::grasp(result), HasSubstr("penetration 0.75 for margins"));
  depth.self_depth_m(0.001);
  EXPECT_THAT(text::grasp(result), HasSubstr("penetration 0.75 for links in each other"));
  depth.max_depth_m(0.002);
  EXPECT_THAT(text::grasp(result), HasSubstr("penetration 0.75), "));
  terms.objective(102.25);
  EXPECT_THAT(text::grasp(result), HasSubstr("prior 0.001 x 250), "));
}

TEST(GraspText, CountsLostPointsByReasonAndNamesTheCommandThatHelps) {
  GraspResult result = exampleGrasp();
  EXPECT_THAT(text::grasp(result), HasSubstr("thumb lost 1 of 4 points: off the surface 1\n"));
  EXPECT_THAT(text::grasp(result), HasSubstr("with --keep"));
  result.kept = true;
  EXPECT_THAT(text::grasp(result), HasSubstr("hint: handgraft suggest 9 thumb looks for"));
  result.transfer.patches()[0].lost().clear();
  EXPECT_THAT(text::grasp(result), Not(HasSubstr("lost 1 of")));
  EXPECT_THAT(text::grasp(result), Not(HasSubstr("hint")));
}

TEST(SessionsText, SaysWhichMotionASessionHolds) {
  v1::SessionList list;
  list.sessions().resize(1);
  list.sessions()[0].contacts("lemon_6");
  EXPECT_THAT(client::text::sessions(list), HasSubstr("contacts\n"));
  EXPECT_THAT(client::text::sessions(list), HasSubstr("lemon_6\n"));
  list.sessions().resize(2);
  list.sessions()[1].motion("box_pull");
  EXPECT_THAT(client::text::sessions(list), HasSubstr("contacts or motion\n"));
  EXPECT_THAT(client::text::sessions(list), HasSubstr("motion box_pull\n"));
}

TEST(Table, AlignsItsColumns) {
  EXPECT_EQ(text::table({{"a", "long head"}, {"name", "1"}}, "lr"),
            "a     long head\nname          1\n");
  EXPECT_EQ(text::table({{"a", "b"}, {"name", "1"}}, "l"), "a     b\nname  1\n");
  EXPECT_EQ(text::table({}, "lr"), "");
}

TEST(GraspResult, IsRefusedWhenItDoesNotFitTheHand) {
  EXPECT_NO_THROW(requireConsistent(exampleGrasp()));
  GraspResult result = exampleGrasp();
  result.solution.joint_positions().push_back(0.0);
  EXPECT_THROW(requireConsistent(result), TransportError);
  result = exampleGrasp();
  result.solution.X_WL().pop_back();
  EXPECT_THROW(requireConsistent(result), TransportError);
  result = exampleGrasp();
  result.solution.joint_positions()[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(requireConsistent(result), TransportError);
  result = exampleGrasp();
  result.solution.patches()[0].hand_W_m().pop_back();
  EXPECT_THROW(requireConsistent(result), TransportError);
}

TEST(GraspText, TellsWhatReadingTheFilesHadToSay) {
  GraspResult result = exampleGrasp();
  result.hand.notes().emplace_back("no palm");
  result.object_notes = {"falls into 3 pieces"};
  EXPECT_THAT(text::grasp(result),
              AllOf(HasSubstr("note: no palm\n"), HasSubstr("note: falls into 3 pieces\n")));
  EXPECT_EQ(printed(client::json::grasp(result))["object_notes"],
            json::array({"falls into 3 pieces"}));
}

TEST(GraspText, TellsAnglesInDegreesAndSlidesInMillimetres) {
  GraspResult result = exampleGrasp();
  v1::JointInfo slide;
  slide.name("slide");
  slide.kind(v1::JOINT_PRISMATIC);
  result.hand.joints().push_back(slide);
  for (const auto& [joint, given] : {std::pair("bend", 0.1), std::pair("slide", 0.01)}) {
    v1::LimitSensitivity sensitivity;
    sensitivity.limit().joint(joint);
    sensitivity.limit().side(v1::LIMIT_UPPER);
    sensitivity.given(given);
    result.solution.sensitivities().push_back(sensitivity);
  }
  EXPECT_THAT(text::grasp(result), AllOf(HasSubstr("bend upper by 5.7 deg: objective"),
                                         HasSubstr("slide upper by 10.0 mm: objective")));
}

TEST(GraspText, TellsAllThatWasWaitedForByParts) {
  GraspResult result = exampleGrasp();
  v1::StageTime skin;
  skin.stage("skin");
  skin.duration_ms(300.0);
  v1::StageTime optimize;
  optimize.stage("optimize");
  optimize.duration_ms(12.0);
  result.solution.times() = {skin, optimize};
  result.server_ms = 1200.0;
  result.models_ms = 340.0;  // the skin's 300 with it
  result.total_ms = 360.0;
  result.files_ms = 25.0;
  EXPECT_THAT(text::grasp(result),
              HasSubstr("time: server 1.20 s, models 40 ms, skin 300 ms, optimize 12 ms, files "
                        "25 ms, other 8.0 ms; all in all 1.58 s\n"));
}

// === Names of the world

TEST(Table, ColumnsOfAllScriptsStandBelowOneAnother) {
  EXPECT_EQ(text::table({{"name", "mm"}, {"Größe", "1"}, {"杯子", "12"}}, "lr"),
            "name   mm\n"
            "Größe   1\n"
            "杯子   12\n");
}

TEST(Wrapped, CountsCharactersAndLosesNone) {
  std::string umlauts;
  for (int k = 0; k < 48; ++k)
    umlauts += "ö";
  EXPECT_EQ(text::wrapped(umlauts + " " + umlauts), umlauts + " " + umlauts + "\n");
  EXPECT_EQ(text::wrapped("Gr\xf6\n杯子\u009b"), "Gr? 杯子\n");
}

TEST(SolutionLine, NamesAreShownAsTheyAre) {
  v1::PoseSolution solution;
  solution.is_final(true);
  v1::PatchFit fit;
  fit.name("Größe");
  solution.patches().push_back(fit);
  solution.verdict("杯子 is reached");
  EXPECT_THAT(text::solutionLine(solution),
              AllOf(HasSubstr("Größe 0.0 mm"), HasSubstr("杯子 is reached")));
}

// === Motions

TEST(MotionText, SaysWhatIsNeverThereOrReached) {
  MotionResult result;
  result.motion.patches({"thumb", "index", "ring", "little"});
  result.motion.frame_count(3);
  result.motion.duration_s(2.0);
  for (const auto& [patch, begin, end] :
       {std::tuple("thumb", 1U, 2U), std::tuple("thumb", 0U, 1U), std::tuple("index", 1U, 1U),
        std::tuple("ring", 0U, 2U)}) {
    v1::PresenceInfo presence;
    presence.patch(patch);
    presence.begin(begin);
    presence.end(end + 1);
    presence.begin_s(begin);
    presence.end_s(end);
    result.motion.presence().push_back(presence);
  }
  EXPECT_THAT(text::motion(result.motion),
              AllOf(ContainsRegex("thumb +0.00-2.00 +#"), ContainsRegex("index +1.00 +[.]+#"),
                    ContainsRegex("little +never +[.]+\n")));

  // The hand has no place for the ring finger's.
  for (std::uint32_t k = 0; k < 3; ++k) {
    v1::MotionFrame frame;
    frame.index(k);
    frame.time_s(k);
    for (const std::uint32_t patch : {0U, 1U}) {
      v1::FramePatch fit;
      fit.patch(patch);
      fit.presence(1.0);
      fit.point_count(25);
      fit.reached(patch == 1U && k == 1U);
      if (patch == 0U || k == 1U) frame.patches().push_back(fit);
    }
    frame.self_depth_m(k == 1U ? 0.0007 : 0.0);
    result.frames.push_back(frame);
  }
  EXPECT_THAT(text::motion(result), AllOf(ContainsRegex("thumb .* 0 % +0.00-2.00 +never\n"),
                                          ContainsRegex("index .* 100 % +1.00 +1.00\n"),
                                          ContainsRegex("ring .* - +0.00-2.00 +never\n"),
                                          ContainsRegex("little .* - +never +never\n")));

  // What sessions show: the same without the summary, and one frame.
  EXPECT_THAT(text::motionFit(result),
              AllOf(ContainsRegex("index .* 100 % +1.00 +1.00\n"),
                    HasSubstr("3 frames touch, in 0 every patch is reached"),
                    HasSubstr("inside the object: never\ninside itself: 0.70 mm at 1.00 s\n"),
                    Not(HasSubstr("all in all"))));
  EXPECT_THAT(text::motionFrame(result, 1.4),
              AllOf(HasSubstr("frame 1 at 1.000 s\n"), ContainsRegex("thumb .* 100 % +no\n"),
                    ContainsRegex("index .* 100 % +yes\n"), Not(HasSubstr("ring")),
                    HasSubstr("inside itself: 0.70 mm\n")));
  const json fit = client::json::motionFit(result);
  EXPECT_EQ(fit.at("frames_touching"), 3);
  EXPECT_EQ(fit.at("patches").at(1).at("frames_reached"), 1);
  const json frame = client::json::motionFrame(result, 1.4);
  EXPECT_EQ(frame.at("index"), 1);
  EXPECT_EQ(frame.at("patches").at(1).at("name"), "index");
  EXPECT_EQ(frame.at("patches").at(1).at("reached"), true);
}

}  // namespace
}  // namespace handgraft::client
