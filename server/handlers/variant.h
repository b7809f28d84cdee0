#pragma once

#include "core/base/progress.h"
#include "idl/studies.h"
#include "server/handlers/handler_context.h"

namespace handgraft::server {

/// Makes a hand like another one but for some changes, under a name of its own; the summary of
/// it. Its skin is made, from the other's, when first needed.
///
/// Errors: InvalidInput as hand::makeVariant; Rejection as for loaded models.
v1::ModelList makeVariant(const v1::VariantRequest& request,
                          HandlerContext& context,
                          const RequestKey& by);

/// The variant alone.
StoredHand variantHand(const v1::VariantRequest& request, const StoredHand& parent);

}  // namespace handgraft::server
