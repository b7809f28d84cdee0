#pragma once

#include <nlohmann/json_fwd.hpp>

#include "core/session/history.h"
#include "core/session/log.h"

/// The parts of `handgraft-session/1` (FORMATS of this folder), exact: every number reads back
/// to the same bits.
namespace handgraft::io {

nlohmann::ordered_json jsonOf(const session::History& history);
nlohmann::ordered_json jsonOf(const session::LogEntry& entry);

}  // namespace handgraft::io
