#include "client/link/following.h"

#include <utility>

#include "core/base/error.h"

namespace handgraft::client {

namespace {

constexpr std::chrono::milliseconds kLook(20);  // for a wish to stop, and a server that is gone

void tellMotion(SessionStream& stream, const Listener& listener) {
  for (const v1::MotionFrames& frames : stream.takeMotion())
    if (listener.on_frames) listener.on_frames(frames);
  const std::optional<v1::MotionClock> clock = stream.takeClock();
  if (clock && listener.on_clock) listener.on_clock(*clock);
}

}  // namespace

Following::Following(Client& client, std::uint64_t session_id, Listener listener)
    : client_(client),
      listener_(std::move(listener)),
      stream_(client, session_id),
      thread_([this] {
        run();
      }) {}

Following::~Following() {
  stopping_ = true;
  thread_.join();
}

void Following::run() {
  const std::uint64_t server_id = client_.status().server_id();
  bool closed = false;
  std::uint64_t revision = 0;
  while (!stopping_ && !closed) {
    if (client_.status().server_id() != server_id || !client_.alive()) {
      const auto lost = std::make_exception_ptr(NoServer(fmt::format(
          "handgraft-server on {} stopped answering", handgraft::describe(client_.network()))));
      if (listener_.on_end) listener_.on_end(lost);
      return;
    }
    stream_.take(listener_.on_solution, [&](const v1::SessionState& state) {
      // Who comes late is told older states first.
      if (state.revision() < revision) return;
      revision = state.revision();
      closed = closed || state.phase() == v1::PHASE_CLOSED;
      if (listener_.on_state) listener_.on_state(state);
    });
    tellMotion(stream_, listener_);
    if (!closed) stream_.wait(kLook);
  }
  if (closed && listener_.on_end) listener_.on_end(nullptr);
}

}  // namespace handgraft::client
