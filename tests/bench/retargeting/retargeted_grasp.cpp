#include "tests/bench/retargeting/retargeted_grasp.h"

#include <memory>
#include <utility>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/hand/hand_parts.h"
#include "core/io/urdf_file.h"
#include "core/placement/solids.h"
#include "core/session/derived_state.h"
#include "core/session/patch_matching.h"
#include "core/session/session.h"
#include "core/verdict/verdicts.h"

#include "tests/bench/chain_pair.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

/// Mean distance between the joints at two poses, m.
double jointsApart(const hand::HandModel& model,
                   const hand::HandPose& a,
                   const hand::HandPose& b) {
  const hand::LinkPoses X_WA = hand::forwardKinematics(model, a);
  const hand::LinkPoses X_WB = hand::forwardKinematics(model, b);
  double sum = 0.0;
  int joints = 0;
  for (const hand::HandModel::Node& node : model.nodes()) {
    if (node.type == hand::JointType::kFixed) continue;
    const auto link = static_cast<std::size_t>(node.link);
    sum += (X_WA[link].translation() - X_WB[link].translation()).norm();
    ++joints;
  }
  return joints == 0 ? 0.0 : sum / joints;
}

template <class Solve>
std::optional<Retargeted> baseline(const Solve& solve,
                                   const optimize::PoseProblem& problem,
                                   const MeasuredHand& hand,
                                   const Demonstration& demonstration) {
  Retargeted result;
  const double begin = threadMilliseconds();
  try {
    result.pose = solve();
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
  result.ms = threadMilliseconds() - begin;
  result.measure = measureGrasp(problem, *hand.exact, hand.parts,
                                *demonstration.object->solid_O, result.pose);
  return result;
}

/// Of the search alone: what opening has tried, the session gives without one.
double msOfSearch(const MeasuredHand& hand,
                  const Demonstration& demonstration,
                  const session::Document& document) {
  session::DerivedState fresh(std::make_shared<session::ModelCache>(
      session::modelsFor(document, hand.hand, demonstration.object->mesh_O,
                         std::make_shared<const contact::ContactSet>(demonstration.contacts))));
  fresh.follow(document, Progress());
  fresh.transfer(Progress());
  const double begin = threadMilliseconds();
  (void)fresh.solve(document.solving, {}, Progress());
  return threadMilliseconds() - begin;
}

void graft(const MeasuredHand& hand,
           const Demonstration& demonstration,
           RetargetedGrasp& row,
           optimize::PoseProblem& problem) {
  const auto& object_O = demonstration.object->mesh_O;
  placement::makeSolids(hand.hand, object_O, Progress());  // once for a hand and an object
  const double begin = threadMilliseconds();
  session::Session session(hand.hand, object_O, demonstration.contacts, Pose::Identity(), {});
  session.transferPatches(Progress());
  const double laid = threadMilliseconds();
  const session::Solution solution = session.solve(session::SolverSettings(), {}, Progress());
  row.ms_pose = threadMilliseconds() - begin;
  row.ms_transfer = laid - begin;
  row.ours.ms = msOfSearch(hand, demonstration, session.document());
  row.ours.pose = solution.report.pose;
  row.joints_at_limits = static_cast<int>(solution.report.active_limits.size());
  for (const session::SessionPatch& patch : solution.patches) {
    row.patches.push_back({patch.patch.name, patch.site, patch.dropped});
    row.asked += patch.dropped.empty() ? 1 : 0;
  }
  const quality::Penetration told = verdict::penetrationOf(session, row.ours.pose, Progress());
  row.told_depth_m = told.max_depth_m;
  row.told_self_m = told.self_depth_m;
  problem = solution.problem;
}

}  // namespace

MeasuredHand readMeasuredHand(const std::filesystem::path& urdf,
                              const std::filesystem::path& cache) {
  MeasuredHand hand;
  hand.name = urdf.stem().string();
  hand.hand = readHand(urdf, cache);
  if (auto carrier = io::readUrdf(urdf).floating_base)
    hand.carrier = std::make_shared<const hand::HandModel>(std::move(*carrier));
  hand.exact = std::make_shared<const ExactHand>(hand.hand.model, cache);
  hand.parts = hand::HandParts(*hand.hand.model, hand.hand.sites).names();
  hand.fingertips = fingertipsOf(hand.hand);
  return hand;
}

RetargetedGrasp retarget(const MeasuredHand& hand,
                         const MeasuredHand& demonstrator,
                         const Demonstration& demonstration,
                         bool with_baselines) {
  RetargetedGrasp row;
  row.hand = hand.name;
  row.object = demonstration.object->name;
  row.grasp = demonstration.name;
  row.digits_touching = demonstration.digits_touching;
  optimize::PoseProblem problem;
  try {
    graft(hand, demonstration, row, problem);
  } catch (const InvalidInput& error) {
    row.refused = error.what();
    return row;
  }
  row.ours.measure = measureGrasp(problem, *hand.exact, hand.parts,
                                  *demonstration.object->solid_O, row.ours.pose);
  if (hand.hand.model == demonstrator.hand.model)
    row.joints_mm = 1e3 * jointsApart(*hand.hand.model, row.ours.pose, demonstration.pose);
  if (!with_baselines) return row;
  const FingertipPose human =
      posed(*demonstrator.hand.model, demonstrator.fingertips, demonstration.pose);
  row.fingertips = baseline(
      [&] {
        return fingertipKinematics(hand.hand, hand.fingertips, human);
      },
      problem, hand, demonstration);
  row.dex_pilot = baseline(
      [&] {
        return dexPilot(hand.hand, hand.fingertips, human);
      },
      problem, hand, demonstration);
  return row;
}

}  // namespace handgraft::bench
