#include "client/cli/commands/played_motion.h"

#include <utility>

#include <fmt/format.h>

#include "client/present/motion_result.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace {

constexpr std::chrono::milliseconds kLook(250);

}  // namespace

PlayedMotion::PlayedMotion(Client& server, v1::SessionState session)
    : server_(server),
      session_(std::move(session)),
      way_(JointInterpolation(framesOf(server, session_.session_id()))),
      looking_([this] {
        look();
      }) {}

PlayedMotion::~PlayedMotion() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  ends_.notify_all();
  looking_.join();
}

void PlayedMotion::look() {
  // Frames of a session that was being solved as it was asked for may be those before.
  std::uint64_t known = session_.phase() == v1::PHASE_READY ? session_.revision() : ~0ULL;
  std::unique_lock lock(mutex_);
  while (!ends_.wait_for(lock, kLook, [this] {
    return is_ending_;
  })) {
    if (found_) continue;  // what was found before is not taken up yet
    lock.unlock();
    Found found = lookOnce(known);
    lock.lock();
    known = found.revision;
    const bool has_ended = found.trouble != nullptr;
    if (found.way || has_ended) found_ = std::move(found);
    if (has_ended) return;
  }
}

PlayedMotion::Found PlayedMotion::lookOnce(std::uint64_t known) {
  Found found{known, {}, {}};
  try {
    const v1::SessionState state = server_.describeSession(session_.session_id()).get();
    if (state.joint_names() != session_.joint_names()) {
      rejectInput("session {} is of hand {} now, it was {}: play it anew",
                  session_.session_id(), handgraft::quoted(state.hand()),
                  handgraft::quoted(session_.hand()));
    }
    if (state.revision() == known || state.phase() != v1::PHASE_READY) return found;
    found.way.emplace(framesOf(server_, session_.session_id()));
    found.revision = state.revision();
  } catch (const NoServer&) {
    // Whoever plays looks for that by itself, and has better words.
  } catch (...) {
    found.trouble = std::current_exception();
  }
  return found;
}

std::string PlayedMotion::takeEdits(Time now) {
  if (way_.isChanging(now)) return "";
  std::optional<Found> found;
  {
    const std::lock_guard lock(mutex_);
    found = std::exchange(found_, std::nullopt);
  }
  if (!found) return "";
  if (found->trouble) std::rethrow_exception(found->trouble);
  way_.goOverTo(std::move(*found->way), now);
  return fmt::format("revision {} is played from here on", found->revision);
}

}  // namespace handgraft::client
