#include <algorithm>

#include <Eigen/Geometry>

#include "client/editor/edit_builders.h"
#include "client/editor/match_values.h"
#include "client/link/hand_point.h"
#include "client/link/pose_file.h"
#include "core/base/error.h"
#include "idl/fields.h"

// The edits that move the hand or the object as a whole, choose models and searches, or go back
// and forth.
namespace handgraft::client::editor {

namespace {

std::uint32_t smallCount(const Value& value, const std::string& what) {
  if (value.count > 0xffffffffU)
    rejectInput("{} {}: it may be at most 2^32 - 1", what, value.text);
  return static_cast<std::uint32_t>(value.count);
}

// Roll about x, then pitch about y, then yaw about z, all of them the world's: URDF's way.
Eigen::Quaterniond rotationAt(const Match& match, std::size_t index) {
  const Eigen::Vector3d rpy = vectorAt(match, index);
  return Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX());
}

// === Points of the hand

HandPoint pointNamed(EditContext& context, const std::string& name) {
  return handPointNamed(context.hand(), name, [&]() -> const v1::HandDescription& {
    return context.handWithMeshes();
  });
}

v1::DragEdit dragEdit(const HandPoint& point, const Eigen::Vector3d& target_W) {
  v1::DragEdit edit;
  edit.link(point.link);
  edit.weight(1.0);
  edit.p_L_m() = {point.p_L.x(), point.p_L.y(), point.p_L.z()};
  edit.target_W_m() = {target_W.x(), target_W.y(), target_W.z()};
  return edit;
}

// === Poses

v1::EditBody placeEdit(const Eigen::Vector3d& p, const std::array<double, 4>& q_wxyz) {
  v1::Pose X_WO;
  X_WO.p_m() = {p.x(), p.y(), p.z()};
  X_WO.q_wxyz() = q_wxyz;
  return bodyOf<v1::Pose>(&v1::EditBody::X_WO, X_WO);
}

std::array<double, 4> wxyzOf(const Eigen::Quaterniond& q) {
  return {q.w(), q.x(), q.y(), q.z()};
}

v1::EditBody stepsEdit(v1::EditKind kind, const Match& match) {
  v1::StepsEdit steps;
  steps.count(match.values.empty() ? 1 : smallCount(match.values[0], "the count"));
  if (steps.count() == 0) {
    rejectInput("{} 0: the count must be at least 1", kind == v1::EDIT_UNDO ? "undo" : "redo");
  }
  v1::EditBody body;
  body.steps(steps);
  body._d(kind);
  return body;
}

v1::EditBody snapshotEdit(v1::EditKind kind, const std::string& name) {
  v1::SnapshotEdit edit;
  edit.name(name);
  v1::EditBody body;
  body.snapshot(edit);
  body._d(kind);
  return body;
}

v1::EditBody modelEdit(v1::EditKind kind, const std::string& name) {
  v1::ModelEdit edit;
  edit.name(name);
  v1::EditBody body;
  body.swapped_model(edit);
  body._d(kind);
  return body;
}

// === Pose

v1::EditBody drag(const Match& match, EditContext& context) {
  v1::DragEdit edit = dragEdit(pointNamed(context, word(match, 0)), vectorAt(match, 1));
  const auto weight = match.options.find("--weight");
  if (weight != match.options.end()) edit.weight(weight->second.number);
  return bodyOf(&v1::EditBody::drag, edit);
}

v1::EditBody release(const Match& match, EditContext& context) {
  v1::ReleaseEdit edit;
  edit.link(pointNamed(context, word(match, 0)).link);
  return bodyOf(&v1::EditBody::release, edit);
}

v1::EditBody releaseAll(const Match& /*match*/, EditContext& /*context*/) {
  return bodyOf(&v1::EditBody::release, v1::ReleaseEdit());
}

v1::EditBody palm(const Match& match, EditContext& context) {
  return bodyOf(&v1::EditBody::drag, dragEdit(palmPointOf(context.hand()), vectorAt(match, 0)));
}

v1::EditBody palmTurned(const Match& match, EditContext& context) {
  v1::DragEdit edit = dragEdit(palmPointOf(context.hand()), vectorAt(match, 0));
  const std::array<double, 4> q = wxyzOf(rotationAt(match, 3));
  edit.target_q_wxyz().assign(q.begin(), q.end());
  return bodyOf(&v1::EditBody::drag, edit);
}

v1::EditBody place(const Match& match, EditContext& context) {
  return placeEdit(vectorAt(match, 0), context.settings().X_WO().q_wxyz());
}

v1::EditBody placeTurned(const Match& match, EditContext& /*context*/) {
  return placeEdit(vectorAt(match, 0), wxyzOf(rotationAt(match, 3)));
}

v1::EditBody priorRest(const Match& /*match*/, EditContext& context) {
  const v1::HandDescription& hand = context.hand();
  v1::PriorEdit edit;
  for (std::size_t i = 0; i < std::min(hand.joints().size(), hand.rest_positions().size());
       ++i) {
    edit.joints().push_back(hand.joints()[i].name());
    edit.joint_positions().push_back(hand.rest_positions()[i]);
  }
  return bodyOf(&v1::EditBody::prior, edit);
}

v1::EditBody priorHere(const Match& /*match*/, EditContext& context) {
  const v1::PoseSolution* solution = context.solution();
  if (solution == nullptr) rejectInput("there is no solution yet; solve makes one");
  v1::PriorEdit edit;
  edit.X_WH().push_back(solution->X_WH());
  for (const v1::JointInfo& joint : context.hand().joints())
    edit.joints().push_back(joint.name());
  edit.joint_positions(solution->joint_positions());
  if (edit.joints().size() != edit.joint_positions().size()) {
    throw TransportError("the server's solution is not of this hand");
  }
  return bodyOf(&v1::EditBody::prior, edit);
}

v1::EditBody priorPose(const Match& match, EditContext& /*context*/) {
  const PoseFile pose = readPose(word(match, 0));
  v1::PriorEdit edit;
  edit.joints(pose.joints);
  edit.joint_positions(pose.joint_rad);
  if (pose.X_WH) edit.X_WH().push_back(*pose.X_WH);
  return bodyOf(&v1::EditBody::prior, edit);
}

v1::EditBody priorShares(const Match& match, EditContext& context) {
  v1::PriorShares shares = context.settings().prior_shares();
  shares.root_rotation(number(match, 0));
  shares.root_translation(number(match, 1));
  shares.joints(number(match, 2));
  return bodyOf(&v1::EditBody::prior_shares, shares);
}

v1::EditBody priorPosture(const Match& match, EditContext& context) {
  v1::PriorShares shares = context.settings().prior_shares();
  shares.posture(number(match, 0));
  return bodyOf(&v1::EditBody::prior_shares, shares);
}

// === Models and search

v1::EditBody hand(const Match& match, EditContext& /*context*/) {
  return modelEdit(v1::EDIT_HAND, word(match, 0));
}

v1::EditBody object(const Match& match, EditContext& /*context*/) {
  return modelEdit(v1::EDIT_OBJECT, word(match, 0));
}

v1::EditBody solver(const Match& match, EditContext& context) {
  Match named = match;
  named.options.emplace("--solver", match.values.at(0));
  return bodyOf(&v1::EditBody::solving, solvingWith(context.settings().solving(), named));
}

v1::EditBody solverOfPaper(const Match& match, EditContext& context) {
  Match named = match;
  named.options.emplace("--paper", Value());
  return bodyOf(&v1::EditBody::solving, solvingWith(context.settings().solving(), named));
}

v1::EditBody takeBack(const Match& match, EditContext& context) {
  const std::uint32_t number = smallCount(match.values.at(0), "take back");
  const std::size_t most = context.settings().timed().size();
  if (number == 0 || number > most) {
    rejectInput("take back {}: {}; show times lists them", number,
                most == 0 ? std::string("nothing was edited at a time")
                          : fmt::format("edits at times count from 1 to {}", most));
  }
  v1::RemoveTimedEdit edit;
  edit.index(number - 1);
  return bodyOf(&v1::EditBody::take_back, edit);
}

v1::EditBody choose(const Match& match, EditContext& context) {
  const std::uint32_t number = smallCount(match.values.at(0), "choose");
  const v1::PoseSolution* solution = context.solution();
  const std::size_t most = solution == nullptr ? 0 : solution->minima().size();
  if (number == 0 || (most > 0 && number > most)) {
    rejectInput("choose {}: minima count from 1{}; show minima lists them", number,
                most == 0 ? std::string() : fmt::format(" to {}", most));
  }
  v1::ChoiceEdit edit;
  edit.rank(number - 1);
  return bodyOf(&v1::EditBody::choice, edit);
}

// === History

v1::EditBody undo(const Match& match, EditContext& /*context*/) {
  return stepsEdit(v1::EDIT_UNDO, match);
}

v1::EditBody redo(const Match& match, EditContext& /*context*/) {
  return stepsEdit(v1::EDIT_REDO, match);
}

v1::EditBody snapshot(const Match& match, EditContext& /*context*/) {
  return snapshotEdit(v1::EDIT_SNAPSHOT, word(match, 0));
}

v1::EditBody restore(const Match& match, EditContext& /*context*/) {
  return snapshotEdit(v1::EDIT_RESTORE, word(match, 0));
}

}  // namespace

v1::SolveOptions solvingWith(v1::SolveOptions solving, const Match& match) {
  const auto given = [&](const char* option) -> const Value* {
    const auto found = match.options.find(option);
    return found == match.options.end() ? nullptr : &found->second;
  };
  if (const Value* name = given("--solver")) {
    solving.solver(v1::enumeratorFrom<v1::Solver>(name->text, "solver"));
  }
  const Value* starts = given("--starts");
  if (starts != nullptr) solving.starts(smallCount(*starts, "--starts"));
  if (const Value* seed = given("--seed")) solving.seed(smallCount(*seed, "--seed"));
  if (const Value* most = given("--max-evaluations")) {
    solving.max_evaluations(smallCount(*most, "--max-evaluations"));
  }
  if (given("--paper") != nullptr) {
    if (given("--solver") != nullptr || starts != nullptr) {
      rejectInput(
          "--paper: it names its own solver and start, so --solver and --starts do not "
          "go with it");
    }
    solving.paper(true);
    solving.solver(v1::SOLVER_DEFAULT);
    solving.starts(0);
  } else if (given("--solver") != nullptr || starts != nullptr) {
    solving.paper(false);
  }
  if (const Value* form = given("--normal-form")) {
    solving.normal_form(form->text == "sum" ? v1::NORMAL_SUM : v1::NORMAL_COSINE);
  }
  const bool avoid = given("--avoid-penetration") != nullptr;
  const bool touch_only = given("--touch-only") != nullptr;
  if (avoid && touch_only) rejectInput("--avoid-penetration: it does not go with --touch-only");
  if (avoid) solving.penetration(v1::PENETRATION_AVOIDED);
  if (touch_only) solving.penetration(v1::PENETRATION_REPORTED);
  return solving;
}

// === What is typed for them, in the order of help

std::span<const Command> poseCommands() {
  // clang-format off
  static constexpr Command kRows[] = {
      {"drag POINT to LENGTH LENGTH LENGTH --weight NUMBER", "move a site, a site's _tip or a link's origin to a point of the world and hold it there, 20 times as firmly as all patches together unless weighed otherwise; 0: not held", Action::kEdit, drag},
      {"release POINT", "let go the link of what was dragged", Action::kEdit, release},
      {"release", "let go all that was dragged, the palm too", Action::kEdit, releaseAll},
      {"palm to LENGTH LENGTH LENGTH", "move the palm to a point of the world and hold it there", Action::kEdit, palm},
      {"palm to LENGTH LENGTH LENGTH rpy ANGLE ANGLE ANGLE", "and turn its link: roll, pitch and yaw about the world's axes", Action::kEdit, palmTurned},
      {"place object LENGTH LENGTH LENGTH", "put the object's origin there; it keeps its rotation", Action::kEdit, place},
      {"place object LENGTH LENGTH LENGTH rpy ANGLE ANGLE ANGLE", "and turn it: roll, pitch and yaw about the world's axes", Action::kEdit, placeTurned},
      {"prior rest", "the hand's rest pose becomes prior and start; the palm stays", Action::kEdit, priorRest},
      {"prior here", "the last solution does", Action::kEdit, priorHere},
      {"prior pose FILE", "a pose from a file does: of `grasp --out`, or written by hand", Action::kEdit, priorPose},
      {"prior shares NUMBER NUMBER NUMBER", "how firmly the prior holds the palm's rotation, its place and the joints; 1 1 1 is the paper's", Action::kEdit, priorShares},
      {"prior posture NUMBER", "how firmly a first solve holds the hand's posture; 0: not at all", Action::kEdit, priorPosture},
  };
  // clang-format on
  return kRows;
}

std::span<const Command> motionCommands() {
  // clang-format off
  static constexpr Command kRows[] = {
      {"at NUMBER", "edits from now on are of the motion's frame at that time (s)", Action::kTime},
      {"at NUMBER NUMBER", "and fade over so many seconds before and after it", Action::kTime},
      {"at all", "of all of the motion again", Action::kTime},
      {"take back COUNT", "an edit at a time of `show times`, which counts from 1, whatever was edited since", Action::kEdit, takeBack},
  };
  // clang-format on
  return kRows;
}

std::span<const Command> modelCommands() {
  // clang-format off
  static constexpr Command kRows[] = {
      {"hand HAND", "take another hand; what still fits is kept", Action::kEdit, hand},
      {"object OBJECT", "take another object, likewise", Action::kEdit, object},
      {"solver paper --normal-form FORM --avoid-penetration --touch-only", "search as the paper does from now on: one start, the prior, by mma", Action::kEdit, solverOfPaper},
      {"solver SOLVER --starts COUNT --seed COUNT --max-evaluations COUNT --normal-form FORM --avoid-penetration --touch-only", "search so from now on, also after edits; what is not named stays", Action::kEdit, solver},
      {"solve --solver SOLVER --starts COUNT --seed COUNT --max-evaluations COUNT --normal-form FORM --paper --avoid-penetration --touch-only", "search the pose, or the motion, so for this once; Ctrl-C cancels", Action::kSolve},
      {"choose COUNT", "another minimum of `show minima`, which counts from 1, becomes prior and start", Action::kEdit, choose},
  };
  // clang-format on
  return kRows;
}

std::span<const Command> historyCommands() {
  // clang-format off
  static constexpr Command kRows[] = {
      {"undo", "take back the last edit", Action::kEdit, undo},
      {"undo COUNT", "so many", Action::kEdit, undo},
      {"redo", "make what was undone again", Action::kEdit, redo},
      {"redo COUNT", "so many", Action::kEdit, redo},
      {"snapshot NAME", "remember the session as it is under a name", Action::kEdit, snapshot},
      {"restore SNAPSHOT", "make it as it was", Action::kEdit, restore},
      {"compare SNAPSHOT", "what differs between a snapshot and now", Action::kCompare},
      {"compare SNAPSHOT SNAPSHOT", "or between two", Action::kCompare},
  };
  // clang-format on
  return kRows;
}

}  // namespace handgraft::client::editor
