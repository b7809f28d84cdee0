#include "server/base/session_access.h"

#include <algorithm>

#include "core/base/error.h"
#include "server/base/rejection.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kMostIdentities = 64;

bool isOwnerOrOperator(const SessionAccess& access, const idl::security::Named& who) {
  if (who.name.empty()) return false;
  return who.role == idl::security::Role::kOperator || who.name == access.owner;
}

std::string ownerInWords(const SessionAccess& access) {
  return access.owner.empty() ? "nobody's" : access.owner + "'s";
}

}  // namespace

SessionAccess accessOfNew(const Who& opener) {
  if (!opener) return {};
  return {opener->name, v1::ACCESS_OWNER, {}};
}

bool mayModify(const SessionAccess& access, const Who& who) {
  if (!who || access.access == v1::ACCESS_ALL) return true;
  if (isOwnerOrOperator(access, *who)) return true;
  return access.access == v1::ACCESS_LISTED && !who->name.empty() &&
         std::find(access.identities.begin(), access.identities.end(), who->name) !=
             access.identities.end();
}

void requireMaySteer(const SessionAccess& access, const Who& who, std::uint64_t session) {
  if (mayModify(access, who)) return;
  reject(v1::ERROR_NOT_PERMITTED,
         "session {} is {} and not shared with {}: its owner or an operator can, by "
         "`handgraft session share {} {}`",
         session, ownerInWords(access), who->name.empty() ? "you" : who->name, session,
         who->name.empty() ? "NAME" : who->name);
}

SessionAccess shared(const SessionAccess& access,
                     const v1::ShareRequest& request,
                     const Who& who) {
  if (!who) {
    reject(v1::ERROR_UNSUPPORTED,
           "session {} is everybody's: in a domain without identities nobody knows who asks; "
           "`handgraft keys` makes some",
           request.session_id());
  }
  if (!isOwnerOrOperator(access, *who)) {
    reject(v1::ERROR_NOT_PERMITTED,
           "session {} is {}: who else may edit it is for its owner or an operator to say",
           request.session_id(), ownerInWords(access));
  }
  if (request.identities().size() > kMostIdentities) {
    rejectInput("identities: {} are too many, at most {}", request.identities().size(),
                kMostIdentities);
  }
  if (request.identities().empty() == (request.access() == v1::ACCESS_LISTED)) {
    rejectInput("identities: {}", request.identities().empty()
                                      ? "whom the session is shared with is not said"
                                      : "are of a session that is shared with these alone");
  }
  for (const std::string& name : request.identities())
    idl::security::requireIdentityName(name);
  if (!request.owner().empty()) idl::security::requireIdentityName(request.owner());
  return {request.owner().empty() ? access.owner : request.owner(), request.access(),
          request.identities()};
}

}  // namespace handgraft::server
