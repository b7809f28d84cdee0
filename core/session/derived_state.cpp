#include "core/session/derived_state.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/error.h"
#include "core/geometry/tangent.h"
#include "core/hand/finger_coordinates.h"
#include "core/optimize/near_samples.h"
#include "core/placement/hand_pose_guess.h"
#include "core/placement/open_directions.h"
#include "core/placement/open_roots.h"
#include "core/placement/place_slider.h"
#include "core/placement/posture_finding.h"
#include "core/placement/solids.h"
#include "core/session/patch_matching.h"
#include "core/session/pinned_points.h"
#include "core/session/place_matching.h"

namespace handgraft::session {
namespace {

using optimize::PointPair;
using optimize::PoseProblem;

constexpr int kPlacingStarts = 12;
constexpr double kSameRoot = 0.001;  // m
constexpr double kSameDirection = std::numbers::pi / 180.0;

transfer::Surfaces surfacesOf(const Models& models) {
  transfer::Surfaces surfaces;
  surfaces.object_O = std::make_shared<const geometry::LogMapper>(models.object_O);
  surfaces.skin = models.hand->skin;
  surfaces.planes_S = hand::planesOf(surfaces.skin);
  surfaces.drafts_S = transfer::draftChartsOf(surfaces.skin);
  surfaces.skin_S = models.hand->skin_maps;
  if (!surfaces.skin_S) {
    surfaces.skin_S = std::make_shared<const geometry::LogMapper>(
        std::shared_ptr<const geometry::TriangleMesh>(surfaces.skin, &surfaces.skin->mesh()));
  }
  return surfaces;
}

bool same(const geometry::SurfacePoint& a, const geometry::SurfacePoint& b) {
  return a.face == b.face && a.barycentric == b.barycentric;
}

bool same(const std::optional<transfer::PatchPlacement>& a,
          const std::optional<transfer::PatchPlacement>& b) {
  if (a.has_value() != b.has_value()) return false;
  return !a || (same(a->root_S, b->root_S) && a->direction_S == b->direction_S);
}

bool sameRoots(const SessionPatch& item, const DocumentPatch& patch) {
  return same(item.patch.root, patch.root_O) &&
         item.placement.has_value() == patch.placement.has_value() &&
         (!patch.placement || same(item.placement->root_S, patch.placement->root_S));
}

/// What the directions and the start that are found depend on.
std::string foundBy(Document document) {
  document.solving = {};
  document.is_solved = false;
  document.notes.clear();
  return bytesOf(document);
}

}  // namespace

std::vector<quality::ContactSide> contactSides(const std::vector<SessionPatch>& patches) {
  std::vector<quality::ContactSide> sides;
  for (const SessionPatch& item : patches) {
    if (!item.placement || item.patch.weight == 0.0) continue;
    for (const transfer::Correspondence& pair : item.transferred.correspondences)
      sides.push_back({pair.link, pair.p_O, pair.n_O});
  }
  return sides;
}

DerivedState::DerivedState(std::shared_ptr<ModelCache> cache)
    : cache_(std::move(cache)), near_(std::make_unique<optimize::NearLists>()) {}

DerivedState::~DerivedState() = default;
DerivedState::DerivedState(DerivedState&&) noexcept = default;
DerivedState& DerivedState::operator=(DerivedState&&) noexcept = default;

void DerivedState::follow(const Document& document, const Progress& progress) {
  const Models models = cache_->find(document.hand, document.object, progress);
  const bool same_models = models.hand == models_.hand && models.object_O == models_.object_O &&
                           models.contacts == models_.contacts &&
                           patches_.size() == document.patches.size();
  if (!same_models) {
    std::vector<SessionPatch> patches(document.patches.size());
    for (std::size_t i = 0; i < patches.size(); ++i)
      patches[i].patch = patchOf(models, document.patches[i]);
    const transfer::Surfaces surfaces = surfacesOf(models);
    if (models.hand != models_.hand) {
      coordinates_.reset();
      skin_faces_.reset();
      links_of_.clear();
    }
    placer_.reset();
    posture_.reset();
    spares_.clear();
    found_for_.clear();
    patches_ = std::move(patches);
    surfaces_ = surfaces;
    models_ = models;
  }
  spares_.resize(patches_.size());
  const bool keeps_found = !found_for_.empty() && found_for_ == foundBy(document);
  if (!keeps_found) {
    found_for_.clear();
    start_ = document.start;
    start_is_known_ = document.start_is_known;
  }
  const bool same_options =
      document.transfer.method == document_.transfer.method &&
      document.transfer.interior_rings == document_.transfer.interior_rings;
  // Charts are the larger part of a session's memory: of those that are no longer in use, only
  // the last change's are kept.
  std::vector<char> moves;
  for (std::size_t i = 0; i < patches_.size(); ++i)
    moves.push_back(sameRoots(patches_[i], document.patches[i]) ? 0 : 1);
  const bool any_moves = std::count(moves.begin(), moves.end(), 1) > 0;
  for (std::size_t i = 0; i < patches_.size(); ++i) {
    if (any_moves && moves[i] == 0) spares_[i] = {};
    if (!same_options) patches_[i].up_to_date = false;
    followPatch(i, document.patches[i], keeps_found);
  }
  document_ = document;
  if (expected_ != nullptr && expected_for_ != foundBy(document_)) expected_.reset();
}

void DerivedState::expect(std::shared_ptr<const Solution> solution) {
  expected_ = std::move(solution);
  expected_for_ = foundBy(document_);
  if (expected_ == nullptr) return;
  HANDGRAFT_REQUIRE(expected_->patches.size() == patches_.size());
  for (std::size_t i = 0; i < patches_.size(); ++i)
    if (!patches_[i].up_to_date) patches_[i].stages = expected_->patches[i].stages;
}

void DerivedState::followPatch(std::size_t index,
                               const DocumentPatch& patch,
                               bool keeps_found) {
  SessionPatch& item = patches_[index];
  if (item.patch.name != patch.name) item = {patchOf(models_, patch), {}, {}, {}, {}, {}};
  if (!sameRoots(item, patch)) {
    // An undo brings the roots back, and finds what was laid there.
    SessionPatch& spare = spares_[index];
    if (spare.patch.name == patch.name && sameRoots(spare, patch)) {
      std::swap(item, spare);
    } else if (item.up_to_date) {
      spare = item;
    }
  }
  const std::optional<Eigen::Vector3d> direction_O =
      keeps_found && patch.direction_is_open ? item.patch.direction_O : patch.direction_O;
  item.up_to_date = item.up_to_date && same(item.patch.root, patch.root_O) &&
                    same(item.placement, patch.placement) &&
                    item.patch.direction_O == direction_O;
  item.patch.root = patch.root_O;
  item.patch.direction_O = direction_O;
  item.patch.weight = patch.effectiveWeight();
  item.site = patch.site;
  item.placement = patch.placement;
  if (!item.placement) item.transferred = {};  // of one that was laid before
  item.dropped = patch.dropped;
  item.direction_is_open = patch.direction_is_open;
  item.root_is_open = patch.root_is_open;
  for (transfer::Correspondence& pair : item.transferred.correspondences)
    pair.weight = item.patch.weight;
}

void DerivedState::adopt(std::vector<SessionPatch> patches) {
  HANDGRAFT_REQUIRE(patches.size() == patches_.size());
  patches_ = std::move(patches);
  found_for_.clear();
}

// === Laying patches

void DerivedState::transfer(const Progress& progress) {
  findOpenDirections(progress);
  transferPatches(progress);
  progress.report("laying patches onto the skin", 1.0);
}

void DerivedState::transferPatches(const Progress& progress) {
  for (std::size_t i = 0; i < patches_.size(); ++i) {
    SessionPatch& item = patches_[i];
    if (!item.placement || item.up_to_date) continue;
    progress.checkpoint();
    progress.report("laying patches onto the skin",
                    static_cast<double>(i) / static_cast<double>(patches_.size()));
    item.transferred = item.stages.lay(surfaces_, item.patch, *item.placement,
                                       document_.transfer, uses_drafts_);
    for (transfer::Correspondence& pair : item.transferred.correspondences)
      pair.patch = static_cast<int>(i);
    item.up_to_date = true;
  }
}

std::vector<transfer::Suggestion> DerivedState::suggest(std::size_t patch,
                                                        const transfer::SuggestOptions& options,
                                                        const Progress& progress) {
  transfer(progress);
  const SessionPatch& item = patches_.at(patch);
  HANDGRAFT_REQUIRE(item.placement.has_value());
  return transfer::suggestPlacements(surfaces_, item.stages, item.patch, *item.placement,
                                     options, document_.transfer, progress);
}

// === What nobody gave

const placement::HandPoseGuesser& DerivedState::placer(const Progress& progress) {
  if (!placer_) {
    placer_ = std::make_unique<placement::HandPoseGuesser>(
        models_.hand->model, *models_.hand->skin,
        placement::solidOf(models_.object_O, progress));
  }
  return *placer_;
}

void DerivedState::findOpenDirections(const Progress& progress) {
  const bool any_missing =
      std::any_of(patches_.begin(), patches_.end(), [](const SessionPatch& item) {
        return item.placement && !item.patch.direction_O;
      });
  if (!any_missing) return;
  std::vector<placement::Anchor> anchors;
  for (const SessionPatch& item : patches_) {
    if (!item.placement || item.patch.weight == 0.0) continue;
    if (const auto anchor = placement::anchorAt(*models_.hand->skin, *item.placement)) {
      anchors.push_back(placement::withObjectSide(*anchor, item.patch, *models_.object_O,
                                                  !item.direction_is_open));
    }
  }
  if (!start_is_known_ && !anchors.empty()) {
    choosePlacement(placer(progress).place(anchors, document_.X_WO, kPlacingStarts, progress),
                    progress);
  } else {
    takeDirectionsFrom(start_);
  }
  found_for_ = foundBy(document_);
}

bool DerivedState::takeDirectionsFrom(const hand::HandPose& pose) {
  bool turned = false;
  for (SessionPatch& item : patches_) {
    if (!item.placement || !item.direction_is_open) continue;
    const auto anchor = placement::anchorAt(*models_.hand->skin, *item.placement);
    const Eigen::Vector3d direction_O =
        anchor ? placement::directionShownBy(*models_.hand->model, pose, *anchor,
                                             *models_.object_O, item.patch.root, document_.X_WO)
               : anyTangentAt(*models_.object_O, item.patch.root);
    const bool is_same = item.patch.direction_O &&
                         direction_O.dot(*item.patch.direction_O) > std::cos(kSameDirection);
    if (is_same) continue;
    item.patch.direction_O = direction_O;
    item.up_to_date = false;
    turned = true;
  }
  return turned;
}

const hand::FingerCoordinates& DerivedState::coordinates() {
  if (!coordinates_) coordinates_ = hand::coordinatesOf(*models_.hand);
  return *coordinates_;
}

const std::vector<char>& DerivedState::linksOf(const std::string& site) {
  if (const auto known = links_of_.find(site); known != links_of_.end()) return known->second;
  return links_of_.emplace(site, linksOfSite(*models_.hand, coordinates(), site)).first->second;
}

bool DerivedState::takeRootsByLength() {
  const geometry::TriangleMesh& skin_S = models_.hand->skin->mesh();
  bool moved = false;
  for (SessionPatch& item : patches_) {
    if (!item.placement || !item.root_is_open || !item.patch.place) continue;
    const auto onto = hand::placeNamed(item.site);
    if (!onto) continue;
    hand::HandLocation place = *item.patch.place;
    place.digit = onto->digit;
    const auto spot = coordinates().spotByLength(place);
    if (!spot) continue;
    const double way =
        (positionOf(skin_S, spot->root_S) - positionOf(skin_S, item.placement->root_S)).norm();
    if (way < kSameRoot) continue;
    item.placement = {spot->root_S, spot->direction_S};
    item.up_to_date = false;
    moved = true;
  }
  return moved;
}

bool DerivedState::takeRootsAround(const std::vector<int>& patches, double around_rad) {
  bool moved = false;
  for (const int k : patches) {
    SessionPatch& item = patches_[static_cast<std::size_t>(k)];
    if (!item.placement || !item.root_is_open || item.patch.place) continue;
    auto place = hand::placeNamed(item.site);
    if (!place || place->digit == hand::kPalmPart) continue;
    place->around_rad = around_rad;
    const auto spot = coordinates().spotAt(*place);
    if (!spot) continue;
    item.placement = {spot->root_S, spot->direction_S};
    item.up_to_date = false;
    moved = true;
  }
  return moved;
}

bool DerivedState::turnDirections(const std::vector<int>& patches, double turn_rad) {
  bool turned = false;
  for (const int k : patches) {
    SessionPatch& item = patches_[static_cast<std::size_t>(k)];
    if (!item.placement || !item.direction_is_open || !item.patch.direction_O) continue;
    const Eigen::Vector3d n_O = normalOf(*models_.object_O, item.patch.root);
    item.patch.direction_O = rotationFromVector(turn_rad * n_O) * *item.patch.direction_O;
    item.up_to_date = false;
    turned = true;
  }
  return turned;
}

bool DerivedState::takePlacesFrom(const hand::HandPose& pose) {
  if (skin_faces_ == nullptr) skin_faces_ = placement::facesOf(models_.hand->skin);
  const hand::LinkPoses X_SW = models_.hand->skin->fromWorld(*models_.hand->model, pose);
  const Pose& X_WO = document_.X_WO;
  bool any_moved = false;
  for (SessionPatch& item : patches_) {
    if (!item.placement || !item.root_is_open) continue;
    placement::ContactAt contact;
    contact.p_W = X_WO * positionOf(*models_.object_O, item.patch.root);
    contact.n_W = X_WO.linear() * normalOf(*models_.object_O, item.patch.root);
    // One that is open on the object is found there.
    if (item.patch.direction_O && !item.direction_is_open)
      contact.d_W = X_WO.linear() * *item.patch.direction_O;
    const auto slid = placement::slidPlace(*skin_faces_, coordinates(), X_SW,
                                           linksOf(item.site), contact, *item.placement);
    if (!slid) continue;
    item.placement = slid;
    item.up_to_date = false;
    any_moved = true;
  }
  if (any_moved) takeDirectionsFrom(pose);
  return any_moved;
}

// === The problem

bool DerivedState::holdsPosture(const SolverSettings& solving) const {
  return !solving.paper && !document_.start_is_known && document_.prior_shares.posture > 0.0;
}

void DerivedState::holdPosture(PoseProblem& problem) const {
  if (posture_ == nullptr)
    posture_ = std::make_unique<const placement::Posture>(
        placement::postureFor(*models_.hand, *models_.contacts));
  const double share = document_.prior_shares.posture * posture_->sureness;
  problem.prior.q = posture_->q;
  problem.prior_weights = Eigen::VectorXd::Ones(problem.dofCount());
  problem.prior_weights.tail(posture_->q.size()) *= share;
  if (!posture_->R_OH) return;
  problem.prior.X_WH.linear() = document_.X_WO.linear() * *posture_->R_OH;
  problem.prior_weights.head<3>() *= share;
}

PoseProblem DerivedState::problem(const SolverSettings& solving) const {
  PoseProblem problem = optimize::makeProblem(models_.hand->model);
  problem.weights = document_.weights;
  problem.normal_form = solving.normal_form;
  if (solving.avoids()) {
    problem.avoidance = placement::avoidanceOf(models_.hand->model, models_.hand->skin,
                                               models_.object_O, document_.X_WO, Progress());
  }
  problem.start = start_;
  problem.prior = document_.prior;
  if (holdsPosture(solving)) holdPosture(problem);
  problem.locked.assign(static_cast<std::size_t>(problem.dofCount()), false);
  for (std::size_t i = 0; i < document_.joints.size(); ++i) {
    const DocumentJoint& joint = document_.joints[i];
    const auto dof = static_cast<Eigen::Index>(i);
    problem.lower[dof] = joint.lower;
    problem.upper[dof] = joint.upper;
    // Searches begin elsewhere, opened or guessed; what is locked stays where the document has
    // it.
    const double value = joint.locked ? document_.start.q[dof] : start_.q[dof];
    problem.start.q[dof] = std::min(std::max(value, joint.lower), joint.upper);
    problem.locked[6 + i] = joint.locked;
    if (joint.soft_weight <= 0.0) continue;
    if (problem.prior_weights.size() != 0) problem.prior_weights[6 + dof] = 1.0;
    holdSoftly(static_cast<int>(i),
               std::min(std::max(joint.soft_value, joint.lower), joint.upper),
               joint.soft_weight, problem);
  }
  const optimize::PriorShares& shares = document_.prior_shares;
  if (shares.root_rotation != 1.0 || shares.root_translation != 1.0 || shares.joints != 1.0)
    scalePrior(shares, problem);
  for (const SessionPatch& item : patches_) {
    if (!item.placement) continue;
    HANDGRAFT_REQUIRE(item.up_to_date);
    for (const transfer::Correspondence& correspondence : item.transferred.correspondences) {
      PointPair pair;
      pair.link = correspondence.link;
      pair.p_L = correspondence.p_L;
      pair.n_L = correspondence.n_L;
      pair.p_W = document_.X_WO * correspondence.p_O;
      pair.n_W = document_.X_WO.linear() * correspondence.n_O;
      pair.weight = correspondence.weight;
      pair.patch = correspondence.patch;
      problem.pairs.push_back(pair);
    }
  }
  addHeldPlaces(document_.held, problem);
  return problem;
}

void DerivedState::requirePoints() const {
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

}  // namespace handgraft::session
