#pragma once

#include <string>

namespace handgraft::client {

/// The server's complaint about a field of a message in the words that were typed: `--interior:
/// 20 is outside 0 to 16` for `body.open_session.transfer[0].interior_rings: 20 is ...`. As it
/// is where it does not begin with a field, or nobody types that one.
std::string asTyped(const std::string& complaint);

}  // namespace handgraft::client
