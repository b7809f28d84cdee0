#pragma once

#include <optional>
#include <string>
#include <vector>

#include "idl/security/identity.h"
#include "idl/sessions.h"

namespace handgraft::server {

/// Who asks, in a secured domain; nothing in an open one, where nobody knows.
using Who = std::optional<idl::security::Named>;

/// Whose a session is, and whom it lets edit. Who may read sessions may read all of them.
struct SessionAccess {
  std::string owner;  ///< an identity's name; empty: nobody's
  v1::Access access = v1::ACCESS_ALL;
  std::vector<std::string> identities;  ///< that ACCESS_LISTED lets in

  bool operator==(const SessionAccess&) const = default;
};

/// Of a session that is opened now: in a secured domain its opener's alone.
SessionAccess accessOfNew(const Who& opener);

/// In an open domain everybody may; operators may always.
bool mayModify(const SessionAccess& access, const Who& who);

/// Errors: Rejection (ERROR_NOT_PERMITTED), which says whose it is and what to do.
void requireMaySteer(const SessionAccess& access, const Who& who, std::uint64_t session);

/// What the owner, or an operator, makes of it by a request. Errors: Rejection
/// (ERROR_UNSUPPORTED in an open domain, ERROR_NOT_PERMITTED to others); InvalidInput.
SessionAccess shared(const SessionAccess& access,
                     const v1::ShareRequest& request,
                     const Who& who);

}  // namespace handgraft::server
