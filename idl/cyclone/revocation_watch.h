#pragma once

#include <condition_variable>
#include <mutex>
#include <thread>

#include "idl/security/revocations.h"

namespace handgraft::idl::cyclone {

/// Looks once a second at the revocation list beside an identity: of what those on it say
/// nothing reaches this process' Cyclone DDS any more, which drops them after a lease. What
/// cannot be read, or concerns this identity, is said on standard error.
class RevocationWatch {
 public:
  /// Of a domain that this process has joined (Domain), until this is destroyed.
  RevocationWatch(int domain, const security::Identity& own);
  ~RevocationWatch();
  RevocationWatch(const RevocationWatch&) = delete;
  RevocationWatch& operator=(const RevocationWatch&) = delete;

 private:
  void look();
  void run();

  const int domain_;
  security::Revocations revocations_;
  std::mutex mutex_;
  std::condition_variable ends_;
  bool is_ending_ = false;
  std::thread thread_;
};

}  // namespace handgraft::idl::cyclone
