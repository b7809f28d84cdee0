#pragma once

#include <string>

#include "core/base/progress.h"
#include "core/session/derived_state.h"
#include "core/session/document.h"
#include "core/session/edit.h"
#include "core/session/models.h"

namespace handgraft::session {

/// A document after an edit, and what there is to say about it.
struct Edited {
  Document document;
  std::string message;  ///< "2 mm short of its target", what a swap dropped; often empty
};

/// The document that `derived` follows, edited: a function of the document, the edit and the
/// models alone. `derived` is asked for what follows from the document (directions that nobody
/// gave, patches for a drag) and stays on it.
///
/// Errors: InvalidInput naming the patch, joint or value; BrokenContract for edits that move
/// through the history, and for a choice without its pose. Cancelled on wish.
Edited applied(const Edit& edit,
               DerivedState& derived,
               ModelCache& cache,
               const Progress& progress);

/// Everything a document promises about itself and its models, so that no file can make a
/// session that edits could not have made: sizes, ranges, places on their meshes, unit
/// tangents. Errors: InvalidInput naming what is wrong.
void validate(const Document& document, const Models& models);

}  // namespace handgraft::session
