#include "client/link/session_id.h"

#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/base/random_id.h"

namespace handgraft::client {

std::uint64_t sessionMeant(Client& server, std::uint64_t typed) {
  constexpr std::uint64_t kFourDigits = 1000;
  if (typed < kFourDigits || typed >= kSmallestId) return typed;
  const std::string digits = std::to_string(typed);
  std::vector<std::uint64_t> meant;
  const v1::SessionList list = server.listSessions().get();
  for (const v1::SessionState& session : list.sessions()) {
    if (session.session_id() == typed) return typed;
    if (std::to_string(session.session_id()).rfind(digits, 0) == 0)
      meant.push_back(session.session_id());
  }
  if (meant.size() > 1)
    rejectInput("session {}: {} begin so; type more digits", typed, fmt::join(meant, ", "));
  return meant.empty() ? typed : meant.front();
}

}  // namespace handgraft::client
