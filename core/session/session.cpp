#include "core/session/session.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/tangent.h"
#include "core/hand/hand_parts.h"
#include "core/session/hand_placement.h"
#include "core/session/open_directions.h"
#include "core/session/open_roots.h"
#include "core/session/patch_names.h"

namespace handgraft::session {
namespace {

using optimize::PointPair;
using optimize::PoseProblem;
using optimize::SolveReport;

constexpr int kPlacingStarts = 12;
constexpr int kTriedPlacements = 4;  // of those, laid out and solved in full
constexpr int kTrialEvaluations = 300;
constexpr int kRefinements = 2;
constexpr int kSlides = 12;
constexpr int kWorseSlides = 3;  // in a row
constexpr double kSameRoot_m = 0.002;
constexpr double kSameDirection = std::numbers::pi / 180.0;

transfer::Surfaces surfacesOf(const Hand& hand,
                              const std::shared_ptr<const geometry::TriangleMesh>& object_O) {
  transfer::Surfaces surfaces;
  surfaces.object_O = std::make_shared<const geometry::LogMapper>(object_O);
  surfaces.skin = hand.skin;
  surfaces.skin_S = hand.skin_maps;
  if (!surfaces.skin_S) {
    surfaces.skin_S = std::make_shared<const geometry::LogMapper>(
        std::shared_ptr<const geometry::TriangleMesh>(hand.skin, &hand.skin->mesh()));
  }
  return surfaces;
}

}  // namespace

Session::Session(Hand hand,
                 std::shared_ptr<const geometry::TriangleMesh> object_O,
                 const contact::ContactSet& contacts,
                 const Pose& X_WO,
                 const optimize::Weights& weights,
                 const transfer::TransferOptions& transfer_options)
    : hand_(std::move(hand)),
      object_O_(std::move(object_O)),
      X_WO_(Pose::Identity()),
      transfer_options_(transfer_options),
      notes_(contacts.notes) {
  HANDGRAFT_REQUIRE(hand_.model != nullptr && hand_.skin != nullptr && object_O_ != nullptr);
  validate(*hand_.model, hand_.sites);
  validateSet(contacts, *object_O_, hand_.sites);
  validate(transfer_options_);
  surfaces_ = surfacesOf(hand_, object_O_);
  applyOne(ObjectPoseEdit{X_WO});
  applyOne(WeightsEdit{weights});

  const PoseProblem blank = optimize::makeProblem(hand_.model);
  lower_ = blank.lower;
  upper_ = blank.upper;
  start_ = blank.start;
  prior_ = blank.prior;
  locked_.assign(static_cast<std::size_t>(blank.dofCount()), false);

  for (const contact::Patch& patch : contacts.patches) {
    SessionPatch item;
    item.patch = patch;
    item.direction_is_open = !patch.direction_O.has_value();
    patches_.push_back(std::move(item));
  }
  matchByName();
  matchByGeometry();
  const auto isPlaced = [](const SessionPatch& item) {
    return item.placement.has_value();
  };
  if (std::none_of(patches_.begin(), patches_.end(), isPlaced)) {
    std::vector<std::string> names;
    for (const SessionPatch& item : patches_)
      names.push_back(item.patch.name);
    rejectInput(
        "contact set {}: none of its patches ({}) has a site on the hand; its sites are {}",
        quoted(contacts.name), fmt::join(names, ", "), namesOf(hand_.sites));
  }
}

Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

const HandPlacer& Session::placer() {
  if (!placer_) placer_ = std::make_unique<HandPlacer>(hand_.model, *hand_.skin, *object_O_);
  return *placer_;
}

void Session::findOpenDirections(const Progress& progress) {
  bool any_missing = false;
  std::vector<Anchor> anchors;
  for (const SessionPatch& item : patches_) {
    if (!item.placement) continue;
    any_missing = any_missing || !item.patch.direction_O;
    if (item.patch.weight == 0.0) continue;
    if (const auto anchor = anchorAt(*hand_.skin, *item.placement)) {
      anchors.push_back(
          withObjectSide(*anchor, item.patch, *object_O_, !item.direction_is_open));
    }
  }
  if (!any_missing) return;
  if (!start_is_known_ && !anchors.empty()) {
    choosePlacement(placer().place(anchors, X_WO_, kPlacingStarts, progress), progress);
  } else {
    takeDirectionsFrom(start_);
  }
}

void Session::choosePlacement(const std::vector<HandPlacement>& placements,
                              const Progress& progress) {
  optimize::SolveOptions options;
  options.starts = 1;
  options.max_evaluations = kTrialEvaluations;
  const std::vector<SessionPatch> before = patches_;
  const hand::HandPose rest = start_;
  std::vector<SessionPatch> best_patches = before;
  hand::HandPose best_start = rest;
  double best = std::numeric_limits<double>::infinity();
  try {
    for (std::size_t i = 0; i < std::min<std::size_t>(placements.size(), kTriedPlacements);
         ++i) {
      patches_ = before;
      start_ = placements[i].pose;
      takeDirectionsFrom(start_);
      layPatches(progress);
      const PoseProblem trial = problem();
      if (trial.pairs.empty()) break;
      const SolveReport report = solve(trial, options, progress);
      const double score =
          report.terms.objective + placer().depthCharge(report.pose, X_WO_, trial.pairs.size());
      if (score >= best) continue;
      best = score;
      best_patches = patches_;
      best_start = report.pose;
    }
  } catch (...) {
    patches_ = before;
    start_ = rest;
    throw;
  }
  if (std::isfinite(best)) {
    patches_ = std::move(best_patches);
    start_ = std::move(best_start);
  }
  takeDirectionsFrom(start_);
  start_is_known_ = true;
}

bool Session::takeDirectionsFrom(const hand::HandPose& pose) {
  bool turned = false;
  for (SessionPatch& item : patches_) {
    if (!item.placement || !item.direction_is_open) continue;
    const auto anchor = anchorAt(*hand_.skin, *item.placement);
    const Eigen::Vector3d direction_O =
        anchor
            ? directionShownBy(*hand_.model, pose, *anchor, *object_O_, item.patch.root, X_WO_)
            : anyTangentAt(*object_O_, item.patch.root);
    const bool is_same = item.patch.direction_O &&
                         direction_O.dot(*item.patch.direction_O) > std::cos(kSameDirection);
    if (is_same) continue;
    item.patch.direction_O = direction_O;
    item.up_to_date = false;
    turned = true;
  }
  return turned;
}

std::vector<char> Session::linksOfSite(const std::string& site) {
  if (parts_of_links_.empty())
    parts_of_links_ = hand::HandParts(*hand_.model, hand_.sites).names();
  std::vector<char> links(parts_of_links_.size(), 0);
  for (const hand::ContactSite& candidate : hand_.sites) {
    if (candidate.name != site) continue;
    const std::string& part = parts_of_links_[hand_.model->linkIndex(candidate.link)];
    for (std::size_t link = 0; link < links.size(); ++link)
      links[link] = parts_of_links_[link] == part ? 1 : 0;
  }
  return links;
}

bool Session::takeRootsFrom(const hand::HandPose& pose) {
  bool moved = false;
  for (SessionPatch& item : patches_) {
    if (!item.placement || !item.root_is_open) continue;
    const auto root_S = rootShownBy(*hand_.model, *hand_.skin, pose, linksOfSite(item.site),
                                    X_WO_ * positionOf(*object_O_, item.patch.root),
                                    X_WO_.linear() * normalOf(*object_O_, item.patch.root));
    if (!root_S) continue;
    const geometry::TriangleMesh& skin_S = hand_.skin->mesh();
    const double way =
        (positionOf(skin_S, *root_S) - positionOf(skin_S, item.placement->root_S)).norm();
    if (way < kSameRoot_m) continue;
    item.placement = movedTo(skin_S, *item.placement, *root_S);
    item.up_to_date = false;
    moved = true;
  }
  if (moved) takeDirectionsFrom(pose);
  return moved;
}

void Session::transferPatches(const Progress& progress) {
  findOpenDirections(progress);
  layPatches(progress);
  progress.report("laying patches onto the skin", 1.0);
}

void Session::layPatches(const Progress& progress) {
  for (std::size_t i = 0; i < patches_.size(); ++i) {
    SessionPatch& item = patches_[i];
    if (!item.placement || item.up_to_date) continue;
    progress.checkpoint();
    progress.report("laying patches onto the skin",
                    static_cast<double>(i) / static_cast<double>(patches_.size()));
    item.transferred =
        item.stages.lay(surfaces_, item.patch, *item.placement, transfer_options_);
    for (transfer::Correspondence& pair : item.transferred.correspondences) {
      pair.patch = static_cast<int>(i);
    }
    item.up_to_date = true;
  }
}

std::vector<transfer::Suggestion> Session::suggest(const std::string& patch,
                                                   const transfer::SuggestOptions& options,
                                                   const Progress& progress) {
  validate(options);
  if (const SessionPatch& item = patchNamed(patch); !item.placement) {
    rejectInput("patch {} is dropped: {}", quoted(patch), item.dropped);
  }
  transferPatches(progress);
  const SessionPatch& item = patchNamed(patch);
  return transfer::suggestPlacements(surfaces_, item.stages, item.patch, *item.placement,
                                     options, transfer_options_, progress);
}

PoseProblem Session::problem() const {
  PoseProblem problem = optimize::makeProblem(hand_.model);
  problem.weights = weights_;
  problem.lower = lower_;
  problem.upper = upper_;
  problem.start = start_;
  problem.start.q = start_.q.cwiseMax(lower_).cwiseMin(upper_);
  problem.prior = prior_;
  problem.locked = locked_;
  for (const SessionPatch& item : patches_) {
    if (!item.placement) continue;
    HANDGRAFT_REQUIRE(item.up_to_date);
    for (const transfer::Correspondence& correspondence : item.transferred.correspondences) {
      PointPair pair;
      pair.link = correspondence.link;
      pair.p_L = correspondence.p_L;
      pair.n_L = correspondence.n_L;
      pair.p_W = X_WO_ * correspondence.p_O;
      pair.n_W = X_WO_.linear() * correspondence.n_O;
      pair.weight = correspondence.weight;
      pair.patch = correspondence.patch;
      problem.pairs.push_back(pair);
    }
  }
  return problem;
}

void Session::requirePoints() const {
  std::string lost;
  for (const SessionPatch& item : patches_) {
    if (!item.placement) continue;
    if (item.transferred.correspondences.empty()) {
      lost += fmt::format(
          "; {}: {}", quoted(item.patch.name),
          item.transferred.lost.empty() ? "no point" : item.transferred.lost.front().reason);
    } else if (item.patch.weight > 0.0) {
      return;
    }
  }
  rejectInput("no patch with a weight above 0 has a point on the hand{}", lost);
}

SolveReport Session::optimize(const optimize::SolveOptions& options, const Progress& progress) {
  transferPatches(progress);
  requirePoints();
  SolveReport report = solve(problem(), options, progress);

  optimize::SolveOptions quiet = options;
  quiet.on_improvement = nullptr;
  for (int i = 0; i < kRefinements && refineDirections(report, quiet, progress); ++i) {
  }
  slideRoots(report, quiet, progress);
  solved_ = problem();
  start_ = report.pose;
  prior_ = report.pose;
  start_is_known_ = true;
  return report;
}

bool Session::refineDirections(SolveReport& report,
                               const optimize::SolveOptions& options,
                               const Progress& progress) {
  const std::vector<SessionPatch> patches = patches_;
  const hand::HandPose start = start_;
  const auto restore = [&] {
    patches_ = patches;
    start_ = start;
  };
  try {
    if (!takeDirectionsFrom(report.pose)) return false;
    transferPatches(progress);
    start_ = report.pose;
    SolveReport refined = solve(problem(), options, progress);
    const bool is_better = refined.terms.objective < report.terms.objective;
    if (is_better) {
      report = std::move(refined);
    } else {
      restore();
    }
    return is_better;
  } catch (...) {
    restore();
    throw;
  }
}

void Session::slideRoots(SolveReport& report,
                         const optimize::SolveOptions& options,
                         const Progress& progress) {
  std::vector<SessionPatch> best_patches = patches_;
  hand::HandPose best_start = start_;
  std::size_t best_pairs = problem().pairs.size();
  SolveReport present = report;
  try {
    // A step that moves all roots at once may first make things worse, so a few in a row may.
    for (int i = 0, worse = 0; i < kSlides && worse < kWorseSlides; ++i) {
      if (!takeRootsFrom(present.pose)) break;
      transferPatches(progress);
      start_ = present.pose;
      const PoseProblem slid = problem();
      if (slid.pairs.empty()) break;
      present = solve(slid, options, progress);
      // A point that is lost no longer counts: that alone makes nothing better.
      const bool is_better = slid.pairs.size() >= best_pairs &&
                             present.terms.objective / static_cast<double>(slid.pairs.size()) <
                                 report.terms.objective / static_cast<double>(best_pairs);
      ++worse;
      if (!is_better) continue;
      worse = 0;
      best_patches = patches_;
      best_start = start_;
      best_pairs = slid.pairs.size();
      report = present;
    }
  } catch (...) {
    patches_ = std::move(best_patches);
    start_ = std::move(best_start);
    throw;
  }
  patches_ = std::move(best_patches);
  start_ = std::move(best_start);
}

}  // namespace handgraft::session
