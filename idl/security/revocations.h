#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "idl/security/guids.h"
#include "idl/security/identity.h"

namespace handgraft::idl::security {

/// The revocation list beside an identity, which DDS itself reads when a program starts: this
/// looks at it while the program runs. Not thread-safe.
class Revocations {
 public:
  explicit Revocations(const Identity& own) : own_(own) {}

  struct News {
    std::set<GuidBegin> revoked;  ///< of all that are on the list
    bool is_own = false;          ///< this program's identity is
    /// Why the list was not taken: unreadable, or not the authority's. Then the one before
    /// stands, and nothing else is told.
    std::string trouble;
  };

  /// What the file says where it changed since the last time, the first one included.
  std::optional<News> look();

 private:
  using Version = std::pair<std::int64_t, std::int64_t>;  // when it was written, its number

  const Identity own_;
  std::optional<Version> seen_;
};

}  // namespace handgraft::idl::security
