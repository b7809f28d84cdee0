#include "tests/bench/chain_pair.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/hand/skin_cache.h"
#include "core/io/contact_file.h"
#include "core/io/mesh_file.h"
#include "core/io/urdf_file.h"
#include "core/placement/hand_pose_guess.h"
#include "core/placement/solids.h"
#include "core/verdict/verdicts.h"

#include "tests/bench/recorded_joints.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

ScannedGrasp readGrasp(const std::string& name,
                       const std::filesystem::path& object,
                       const std::filesystem::path& contacts,
                       bool with_joints) {
  const io::MeshFile file = io::readMesh(object);
  contact::SegmentationOptions options;
  if (with_joints) options.joints_O = recordedJoints(contacts);
  return {name, std::make_shared<const geometry::TriangleMesh>(file.mesh),
          io::readContacts(contacts, file, options)};
}

hand::Hand readHand(const std::filesystem::path& urdf, const std::filesystem::path& cache) {
  hand::Hand hand;
  hand.model = std::make_shared<const hand::HandModel>(io::readUrdf(urdf).model);
  hand.skin = std::make_shared<const hand::Skin>(
      hand::SkinCache(cache).get(*hand.model, hand::SkinOptions(), Progress()));
  hand.sites = findContactSites(*hand.model, *hand.skin);
  hand.sites_are_found = true;
  if (hand.sites.empty()) rejectInput("{}: no contact site was found", quoted(urdf.string()));
  return hand;
}

int ChainOutcome::points() const {
  int sum = 0;
  for (const PatchOutcome& patch : patches)
    sum += patch.points;
  return sum;
}

int ChainOutcome::lost() const {
  int sum = 0;
  for (const PatchOutcome& patch : patches)
    sum += patch.lost;
  return sum;
}

const PatchOutcome* ChainOutcome::worst() const {
  const PatchOutcome* worst = nullptr;
  for (const PatchOutcome& patch : patches)
    if (patch.points > 0 && (worst == nullptr || patch.mean_mm > worst->mean_mm))
      worst = &patch;
  return worst;
}

ChainOutcome graspWith(const hand::Hand& hand,
                       const ScannedGrasp& grasp,
                       bool avoid_penetration) {
  ChainOutcome outcome;
  outcome.hand = hand.model->name();
  outcome.grasp = grasp.name;
  try {
    const double begin = threadMilliseconds();
    session::Session session(hand, grasp.object_O, grasp.contacts, Pose::Identity(), {});
    session.transferPatches(Progress());
    const double laid = threadMilliseconds();
    outcome.ms_transfer = laid - begin;
    // The solids are made once for each hand and object.
    const auto measure = [&](const hand::HandPose& pose) {
      return verdict::penetrationOf(session, pose, Progress());
    };
    outcome.penetration = measure({Pose::Identity(), hand.model->restPose()});
    session::SolverSettings solving;
    solving.avoid_penetration = avoid_penetration;
    const double ready = threadMilliseconds();
    session::Solution solution = session.solve(solving, {}, Progress());
    outcome.ms_solve = threadMilliseconds() - ready;
    const optimize::SolveReport report = solution.report;
    session.commit(std::move(solution));
    const double solved = threadMilliseconds();
    outcome.penetration = measure(report.pose);
    outcome.ms_penetration = threadMilliseconds() - solved;

    for (const session::SessionPatch& item : session.patches()) {
      PatchOutcome patch;
      patch.name = item.patch.name;
      patch.site = item.site;
      patch.dropped = item.dropped;
      patch.points = static_cast<int>(item.transferred.correspondences.size());
      patch.lost = static_cast<int>(item.transferred.lost.size());
      outcome.patches.push_back(patch);
    }
    for (const optimize::PatchFit& fit : report.patches) {
      PatchOutcome& patch = outcome.patches.at(static_cast<std::size_t>(fit.patch));
      patch.mean_mm = fit.mean_mm;
      patch.normal_deg = fit.normal_mean_deg;
      outcome.mean_mm += fit.mean_mm * fit.point_count;
      outcome.normal_deg += fit.normal_mean_deg * fit.point_count;
    }
    outcome.mean_mm /= std::max(1, outcome.points());
    outcome.normal_deg /= std::max(1, outcome.points());
    const placement::HandPoseGuesser placer(hand.model, *hand.skin,
                                            placement::solidOf(grasp.object_O, Progress()));
    outcome.depth_mm =
        1e3 * std::sqrt(placer.meanSquareDepth(report.pose, session.objectPose()));
    outcome.objective = report.terms.objective;
    outcome.outcome = optimize::nameOf(report.outcome);
    outcome.joints_at_limits = static_cast<int>(report.active_limits.size());
    outcome.notes = session.notes();
  } catch (const InvalidInput& error) {
    outcome.refused = error.what();
  }
  return outcome;
}

}  // namespace handgraft::bench
