#pragma once

#include "idl/common.h"

namespace handgraft::idl {

/// A client's name for itself, which never comes twice. Threads: any.
v1::ClientId randomClient();

}  // namespace handgraft::idl
