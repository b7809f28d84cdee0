#pragma once

#include "core/session/edit.h"
#include "idl/edits.h"

/// Edits as they come from the wire: enumerators, bounds of sequences and every number are
/// checked here, names and what they mean by the session.
namespace handgraft::server {

/// Errors: InvalidInput naming the field and its value; numbers that are not finite are none,
/// but a joint's limits may be infinite.
session::Edit editFrom(const v1::EditBody& body);

}  // namespace handgraft::server
