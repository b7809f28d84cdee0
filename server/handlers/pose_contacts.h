#pragma once

#include "core/base/progress.h"
#include "core/contact/pose_contacts.h"
#include "idl/models.h"
#include "server/handlers/handler_context.h"

namespace handgraft::server {

/// Makes a contact set, with its map, of where a posed hand meets an object; the summary of it.
///
/// Values beyond a joint's limits are taken and noted: recorded poses of people exceed them.
/// The hand's skin is made if need be, since its sites tell directions.
/// Errors: InvalidInput for joints that are unknown, follow others, are named twice or not
/// finite, for X_WH beside joints of the floating base, a reach outside 0.1-100 mm, and a hand
/// that touches nothing (how far it is); Rejection as for loaded models; Cancelled.
v1::ModelList contactsOfPose(const v1::PoseContactsRequest& request,
                             HandlerContext& context,
                             const RequestKey& by,
                             const Progress& progress);

/// The distance at which contact ends; 0: the default. Errors: InvalidInput outside 0.1-100 mm.
contact::PoseContactOptions reachFrom(double reach_m);

}  // namespace handgraft::server
