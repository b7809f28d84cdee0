#pragma once

#include <memory>
#include <optional>

#include "core/base/progress.h"
#include "core/hand/digits.h"
#include "core/optimize/pose_problem.h"
#include "core/session/document.h"
#include "core/session/models.h"

namespace handgraft::session {

struct Solution;

/// What a session begins with.
struct FirstDocument {
  Document document;  ///< every patch on its site, the hand at rest
  /// What solving it by its own settings comes to, where that had to be tried; else null.
  std::shared_ptr<const Solution> solution;
};

/// That of the cache's first models.
///
/// Errors: InvalidInput as Session's constructor. Cost: some milliseconds; of patches without
/// fingers' names as assignSites; where the hand cannot have all of them, as
/// leaveOutWhatKeepsOthersOff.
FirstDocument firstDocument(ModelCache& cache,
                            const Pose& X_WO,
                            const optimize::Weights& weights,
                            const transfer::TransferOptions& transfer,
                            const Progress& progress);

/// The side of the hand that touched, and of this one.
struct Sides {
  hand::Chirality touched = hand::Chirality::kUnknown;
  hand::Chirality own = hand::Chirality::kUnknown;

  [[nodiscard]] bool differ() const {
    constexpr auto kUnknown = hand::Chirality::kUnknown;
    return touched != kUnknown && own != kUnknown && touched != own;
  }

  /// This hand has a side, and nobody said which one touched.
  [[nodiscard]] bool isHalfKnown() const {
    return touched == hand::Chirality::kUnknown && own != hand::Chirality::kUnknown;
  }
};

Sides sidesOf(const Models& models);

/// Lays the patches that have no place onto the hand's sites: by name, then by geometry where a
/// patch or a site has no finger's name. What keeps the hand off others goes again
/// (leave_out.h). Adds notes, and says why a patch is dropped. What solving the document by its
/// own settings comes to, where that had to be tried; else null.
/// Errors: InvalidInput if no patch of the document has a place then.
std::shared_ptr<const Solution> matchPatches(const Models& models,
                                             Document& document,
                                             const Progress& progress);

/// What a document's names stand for, to solve it apart from its session.
SessionModels modelsFor(const Document& document,
                        const hand::Hand& hand,
                        std::shared_ptr<const geometry::TriangleMesh> object_O,
                        std::shared_ptr<const contact::ContactSet> contacts);

/// The document at a time of a motion: patches that are not there then are off.
Document atFrame(Document document, const FrameContacts& frame);

/// The joints of a hand as its model has them.
std::vector<DocumentJoint> jointsOf(const hand::HandModel& model);

/// A patch of the contact set as the document has it: root, direction and effective weight.
contact::Patch patchOf(const Models& models, const DocumentPatch& patch);

}  // namespace handgraft::session
