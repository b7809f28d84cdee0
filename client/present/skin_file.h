#pragma once

#include <string>

#include "idl/models.h"

namespace handgraft::client {

/// The skin as a binary PLY: vertices in S (float, metres), faces with the property `link`, the
/// index of the link that each belongs to, -1 for none; a comment lists the links' names as
/// `links 0=palm 1=...`.
/// Errors: TransportError if the description contradicts itself.
std::string skinPly(const v1::HandDescription& hand);

}  // namespace handgraft::client
