#pragma once

#include <string>

#include "core/base/progress.h"
#include "core/session/apply_edit.h"

namespace handgraft::session {

/// The document on another hand.
///
/// Kept: the object's side of every patch, weights, what is switched off. Of joints of the same
/// name: locks, soft values and edited limits, as far as they lie within the new hand's limits;
/// the pose, if the new hand has no joint that the old one lacks, moved into the limits. Of
/// places on the hand: those on a skin with the same triangles (a variant of the hand), else
/// patches are matched to the new hand's sites. What is dropped is noted.
/// Errors: InvalidInput if the hand cannot be found or no patch has a site on it.
Edited withHand(const Document& document,
                const std::string& name,
                ModelCache& cache,
                const Progress& progress);

/// The document on another object: patches that the contact set has there (ModelCache::
/// contactsOn), with roots and directions that were edited carried along where they have a
/// place there. Everything of the hand stays.
/// Errors: InvalidInput if the object cannot be found or the contact set does not fit it.
Edited withObject(const Document& document,
                  const std::string& name,
                  ModelCache& cache,
                  const Progress& progress);

}  // namespace handgraft::session
