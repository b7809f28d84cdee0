#include "core/session/patch_matching.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/side_note.h"
#include "core/contact/touching_side.h"
#include "core/geometry/tangent.h"
#include "core/placement/hand_pose_guess.h"
#include "core/placement/site_assignment.h"
#include "core/placement/solids.h"
#include "core/session/best_way.h"
#include "core/session/leave_out.h"
#include "core/session/patch_names.h"
#include "core/session/place_matching.h"

namespace handgraft::session {
namespace {

void lay(const hand::Hand& hand, const hand::ContactSite& site, DocumentPatch& patch) {
  patch.site = site.name;
  patch.placement = soundPlacementAt(hand, site);
  patch.root_is_open = hand.sites_are_found;
  patch.dropped.clear();
}

/// Lays patches on the sites of their names, but for those that have a place.
void matchByName(const hand::Hand& hand, const PlacesOfPatches& places, Document& document) {
  for (std::size_t i = 0; i < document.patches.size(); ++i) {
    DocumentPatch& patch = document.patches[i];
    if (patch.placement || !patch.dropped.empty()) continue;
    if (i < places.size() && places[i]) continue;
    for (const hand::ContactSite& site : hand.sites) {
      if (site.name == patch.name) lay(hand, site, patch);
    }
  }
}

placement::Anchor objectSideOf(placement::Anchor anchor,
                               const DocumentPatch& patch,
                               const Models& models) {
  contact::Patch place;
  place.root = patch.root_O;
  place.direction_O = patch.direction_O;
  return placement::withObjectSide(std::move(anchor), place, *models.object_O,
                                   !patch.direction_is_open);
}

/// Assignments of patches without a name that are solved to be compared, with a palm in them
/// and without.
constexpr std::size_t kWays = 6;

/// False if nothing changes by it.
bool forbidPalm(const std::vector<const hand::ContactSite*>& sites,
                std::vector<std::vector<bool>>& permitted) {
  bool any = false;
  for (std::size_t s = 0; s < sites.size(); ++s) {
    if (sites[s]->name != hand::kPalmPart) continue;
    for (std::vector<bool>& of_patch : permitted) {
      any = any || of_patch[s];
      of_patch[s] = false;
    }
  }
  return any;
}

/// What is left to match by geometry: patches and sites, where they are, and what is laid.
struct Unmatched {
  std::vector<std::size_t> patches;
  std::vector<placement::Anchor> patch_anchors;
  std::vector<placement::Anchor> fixed;
  std::vector<const hand::ContactSite*> sites;
  std::vector<placement::Anchor> site_anchors;
};

/// Notes those whose finger has been dealt with.
Unmatched unmatchedOf(const Models& models, Document& document) {
  const hand::Hand& hand = *models.hand;
  Unmatched left;
  for (std::size_t i = 0; i < document.patches.size(); ++i) {
    const DocumentPatch& patch = document.patches[i];
    if (!patch.placement && !patch.dropped.empty()) {
      // Part of it on another finger would be worse than none.
      document.notes.push_back(patch.dropped);
    } else if (!patch.placement) {
      left.patches.push_back(i);
      left.patch_anchors.push_back(objectSideOf({}, patch, models));
    } else if (auto anchor = placement::anchorAt(*hand.skin, *patch.placement)) {
      left.fixed.push_back(objectSideOf(*anchor, patch, models));
    }
  }
  for (const hand::ContactSite& site : hand.sites) {
    const bool is_taken =
        std::any_of(document.patches.begin(), document.patches.end(), [&](const auto& patch) {
          return patch.placement && patch.site == site.name;
        });
    const auto anchor = placement::anchorAt(*hand.skin, soundPlacementAt(hand, site));
    if (is_taken || !anchor) continue;
    left.sites.push_back(&site);
    left.site_anchors.push_back(*anchor);
  }
  return left;
}

/// Which of the sites each patch that is left goes to, -1: to none; the ways worth trying.
std::vector<std::vector<int>> answersFor(const Models& models,
                                         const Unmatched& left,
                                         const Document& document,
                                         const Progress& progress) {
  bool any = false;
  std::vector<std::vector<bool>> permitted;
  for (const std::size_t i : left.patches) {
    permitted.emplace_back();
    for (const hand::ContactSite* site : left.sites) {
      // Where at least one of the two has no finger's name.
      const bool may =
          isAnonymousPatch(document.patches[i].name) || isAnonymousSite(site->name);
      permitted.back().push_back(may);
      any = any || may;
    }
  }
  if (!any) return {std::vector<int>(left.patches.size(), -1)};
  const hand::Hand& hand = *models.hand;
  const placement::HandPoseGuesser placer(hand.model, *hand.skin,
                                          placement::solidOf(models.object_O, progress));
  const auto assigned = [&] {
    return placement::assignSites(placer, hand.model, left.fixed, left.patch_anchors,
                                  left.site_anchors, permitted, document.X_WO, kWays, progress);
  };
  std::vector<std::vector<int>> answers = assigned();
  // Hands touch with fingers first: a palm that is as good by roots and normals may be out of
  // what they leave of the object's reach.
  if (forbidPalm(left.sites, permitted)) {
    for (std::vector<int>& answer : assigned())
      if (std::find(answers.begin(), answers.end(), answer) == answers.end())
        answers.push_back(std::move(answer));
  }
  return answers;
}

/// The document with the patches on the sites of an answer; what goes without says why.
Document withAnswer(const std::vector<int>& answer,
                    bool is_only_one,
                    const hand::Hand& hand,
                    const Unmatched& left,
                    Document document) {
  const auto laid_count = std::count_if(answer.begin(), answer.end(), [](int site) {
    return site >= 0;
  });
  const bool is_site_left = laid_count < std::ssize(left.sites);
  for (std::size_t i = 0; i < left.patches.size(); ++i) {
    DocumentPatch& patch = document.patches[left.patches[i]];
    if (answer[i] >= 0) {
      lay(hand, *left.sites[static_cast<std::size_t>(answer[i])], patch);
      document.notes.push_back(fmt::format(
          "{} laid on site '{}': {}", quoted(patch.name), patch.site,
          is_only_one ? "no other way is open" : "of the ways tried this fits best"));
    } else if (isAnonymousPatch(patch.name)) {
      patch.dropped = fmt::format(
          "no site is left for {}{}; the hand's sites are {}", quoted(patch.name),
          is_site_left ? " that reaches it beside the others" : "", namesOf(hand.sites));
    } else {
      patch.dropped = fmt::format("hand has no {}; its sites are {}", quoted(patch.name),
                                  namesOf(hand.sites));
    }
  }
  return document;
}

void matchByGeometry(const Models& models,
                     WayTrials& trials,
                     Document& document,
                     const Progress& progress) {
  const Unmatched left = unmatchedOf(models, document);
  const auto answers = answersFor(models, left, document, progress);
  std::vector<Document> ways;
  ways.reserve(answers.size());
  for (const std::vector<int>& answer : answers)
    ways.push_back(withAnswer(answer, answers.size() == 1, *models.hand, left, document));
  document = std::move(ways[trials.best(ways, true, progress)]);
}

}  // namespace

Sides sidesOf(const Models& models) {
  return {contact::touchingSide(*models.contacts, *models.object_O),
          sideOf(hand::coordinatesOf(*models.hand)->anatomy())};
}

std::shared_ptr<const Solution> matchPatches(const Models& models,
                                             Document& document,
                                             const Progress& progress) {
  std::vector<char> may_go;
  for (DocumentPatch& patch : document.patches) {
    if (!patch.placement) patch.dropped.clear();
    may_go.push_back(patch.placement ? 0 : 1);
  }
  const auto coordinates = hand::coordinatesOf(*models.hand);
  if (const Sides sides = sidesOf(models); sides.differ())
    document.notes.push_back(otherSideNote(nameOf(sides.touched), nameOf(sides.own)));
  const PlacesOfPatches places = placesIn(models, *coordinates, document);
  // Which finger takes whose patches depends on what else is to be reached.
  matchByName(*models.hand, places, document);
  WayTrials trials(models);
  matchByPlace(models, *coordinates, places, trials, document, progress);
  matchByName(*models.hand, {}, document);
  matchByGeometry(models, trials, document, progress);
  const auto is_placed = [](const DocumentPatch& patch) {
    return patch.placement.has_value();
  };
  if (std::none_of(document.patches.begin(), document.patches.end(), is_placed)) {
    std::vector<std::string> names;
    for (const DocumentPatch& patch : document.patches)
      names.push_back(patch.name);
    rejectInput(
        "contact set {}: none of its patches ({}) has a site on the hand; its sites are {}",
        quoted(document.contacts), fmt::join(names, ", "), namesOf(models.hand->sites));
  }
  // In a motion it may be what other frames are held by.
  if (models.frames.empty()) leaveOutWhatKeepsOthersOff(may_go, trials, document, progress);
  const auto laid = std::ranges::count_if(document.patches, is_placed);
  if (models.hand->sites.empty() && laid < std::ssize(document.patches)) {
    document.notes.push_back(
        fmt::format("the hand was given without contact sites: {} of {} patches are laid; "
                    "hand::findContactSites and io::readSites make them",
                    laid, document.patches.size()));
  }
  return trials.solutionOf(document);
}

SessionModels modelsFor(const Document& document,
                        const hand::Hand& hand,
                        std::shared_ptr<const geometry::TriangleMesh> object_O,
                        std::shared_ptr<const contact::ContactSet> contacts) {
  SessionModels models;
  models.hand_name = document.hand;
  models.hand = hand;
  models.object_name = document.object;
  models.object_O = std::move(object_O);
  models.contacts_name = document.contacts;
  models.contacts = std::move(contacts);
  return models;
}

Document atFrame(Document document, const FrameContacts& frame) {
  HANDGRAFT_REQUIRE(frame.is_there.size() == document.patches.size());
  for (std::size_t i = 0; i < document.patches.size(); ++i) {
    DocumentPatch& patch = document.patches[i];
    patch.enabled = patch.enabled && frame.is_there[i];
    if (!patch.enabled) continue;
    const contact::Patch& then = frame.contacts->patches.at(i);
    patch.root_O = then.root;
    if (then.direction_O) patch.direction_O = then.direction_O;
  }
  return document;
}

std::vector<DocumentJoint> jointsOf(const hand::HandModel& model) {
  std::vector<DocumentJoint> joints(static_cast<std::size_t>(model.dofCount()));
  for (std::size_t i = 0; i < joints.size(); ++i) {
    joints[i].lower = model.lower()[static_cast<Eigen::Index>(i)];
    joints[i].upper = model.upper()[static_cast<Eigen::Index>(i)];
  }
  return joints;
}

contact::Patch patchOf(const Models& models, const DocumentPatch& patch) {
  for (const contact::Patch& outline : models.contacts->patches) {
    if (outline.name != patch.name) continue;
    contact::Patch result = outline;
    result.root = patch.root_O;
    result.direction_O = patch.direction_O;
    result.weight = patch.effectiveWeight();
    return result;
  }
  rejectInput("contact set {} has no patch {}", quoted(models.contacts->name),
              quoted(patch.name));
}

FirstDocument firstDocument(ModelCache& cache,
                            const Pose& X_WO,
                            const optimize::Weights& weights,
                            const transfer::TransferOptions& transfer,
                            const Progress& progress) {
  const SessionModels& first = cache.first();
  const Models models = cache.find(first.hand_name, first.object_name, progress);
  validate(*models.hand->model, models.hand->sites);
  validateSet(*models.contacts, *models.object_O, models.hand->sites);
  validate(transfer);

  FirstDocument result;
  Document& document = result.document;
  document.hand = first.hand_name;
  document.object = first.object_name;
  document.contacts = first.contacts_name;
  document.X_WO = X_WO;
  document.weights = weights;
  document.transfer = transfer;
  document.notes = models.contacts->notes;
  document.joints = jointsOf(*models.hand->model);
  document.start.q = models.hand->model->restPose();
  document.prior = document.start;
  for (const contact::Patch& outline : models.contacts->patches) {
    DocumentPatch patch;
    patch.name = outline.name;
    patch.weight = outline.weight;
    patch.root_O = outline.root;
    patch.direction_O = outline.direction_O;
    patch.direction_is_open = !outline.direction_O.has_value();
    document.patches.push_back(std::move(patch));
  }
  result.solution = matchPatches(models, document, progress);
  return result;
}

}  // namespace handgraft::session
