#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "idl/sessions.h"

/// What `transfer --json` and `suggest --json` print; as json_output.h.
namespace handgraft::client::json {

std::string transfer(const v1::TransferReply& reply, int indent = 2);

/// A suggestion that was applied, and what came of it.
struct Applied {
  std::size_t number = 0;  ///< from 1
  std::uint64_t revision = 0;
  v1::PatchReport report;
};

std::string suggestions(const v1::SuggestReply& reply,
                        const std::optional<Applied>& applied,
                        int indent = 2);

}  // namespace handgraft::client::json
