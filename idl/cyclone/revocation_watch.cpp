#include "idl/cyclone/revocation_watch.h"

#include <chrono>
#include <cstdio>

#include <fmt/format.h>

#include "idl/cyclone/datagram_gate.h"

namespace handgraft::idl::cyclone {

RevocationWatch::RevocationWatch(int domain, const security::Identity& own)
    : domain_(domain), revocations_(own) {
  look();  // before anybody is met
  thread_ = std::thread([this] {
    run();
  });
}

RevocationWatch::~RevocationWatch() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  ends_.notify_all();
  thread_.join();
}

void RevocationWatch::look() {
  const auto news = revocations_.look();
  if (!news) return;
  if (!news->trouble.empty()) {
    fmt::print(stderr, "handgraft: who was revoked is not known: {}\n", news->trouble);
    return;
  }
  if (news->is_own) {
    fmt::print(
        stderr,
        "handgraft: this program's own identity was revoked: those who know of it do not "
        "meet it any more\n");
  }
  refuse(domain_, news->revoked);
}

void RevocationWatch::run() {
  constexpr std::chrono::seconds kPeriod(1);
  std::unique_lock lock(mutex_);
  while (!ends_.wait_for(lock, kPeriod, [this] {
    return is_ending_;
  })) {
    lock.unlock();
    look();
    lock.lock();
  }
}

}  // namespace handgraft::idl::cyclone
