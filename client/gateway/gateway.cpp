// The gateway, what sessions publish, and a server that goes and comes.
#include "client/gateway/gateway.h"

#include <array>
#include <random>
#include <utility>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "client/gateway/gateway_impl.h"
#include "core/base/error.h"
#include "idl/fields.h"

namespace handgraft::client::gateway {

namespace {

constexpr std::chrono::milliseconds kRestBeforeSaving(800);  // nobody waits for it
constexpr std::size_t kMostFramesTold = 600;  // of a motion, unasked; of more every second one

}  // namespace

// === What sessions publish

Listener Gateway::Impl::listenerFor(std::uint64_t session) {
  Listener listener;
  listener.on_solution = [this, session](const v1::PoseSolution& solution) {
    onSolution(session, solution);
  };
  listener.on_state = [this, session](const v1::SessionState& state) {
    onState(session, state);
  };
  listener.on_frames = [this, session](const v1::MotionFrames& frames) {
    onFrames(session, frames);
  };
  listener.on_clock = [this, session](const v1::MotionClock& clock) {
    onClock(session, clock);
  };
  listener.on_end = [this, session](const std::exception_ptr& why) {
    onEnd(session, why);
  };
  return listener;
}

void Gateway::Impl::onSolution(std::uint64_t session, const v1::PoseSolution& solution) {
  if (!solution.is_final()) return;  // poses on the way do not say where the links are
  const Shared text =
      textOf({{"event", "pose"}, {"session", session}, {"solution", idl::jsonOf(solution)}});
  const std::lock_guard lock(mutex);
  const auto found = followed.find(session);
  if (found == followed.end()) return;
  found->second.pose_text = text;
  found->second.heard = Clock::now();
  tellFollowers(session, "pose", text);
}

/// Of many frames every second, fourth, ... by its index: pages show no more of a long motion.
void Gateway::Impl::add(ToldFrames& told, const v1::MotionFrame& frame) {
  if (frame.index() % told.every != 0) return;
  if (told.frames.size() >= kMostFramesTold) {
    told.every *= 2;
    Json kept = Json::array();
    for (Json& one : told.frames)
      if (one["index"].get<std::uint32_t>() % told.every == 0) kept.push_back(std::move(one));
    told.frames = std::move(kept);
    return add(told, frame);
  }
  told.frames.push_back(idl::jsonOf(frame));
}

/// Each time all that came of a revision, so that a page that skips some of it misses nothing.
void Gateway::Impl::onFrames(std::uint64_t session, const v1::MotionFrames& frames) {
  const std::lock_guard lock(mutex);
  const auto found = followed.find(session);
  if (found == followed.end()) return;
  ToldFrames& told = found->second.told_frames;
  if (told.is_last) {
    told = {told.revision, frames.revision()};
  } else if (told.revision != frames.revision()) {
    told = {told.since, frames.revision()};  // that one was cut short
  }
  told.is_last = frames.is_last();
  for (const v1::MotionFrame& frame : frames.frames())
    add(told, frame);
  tellFollowers(session, "frames",
                textOf({{"event", "frames"},
                        {"session", session},
                        {"since", told.since ? Json(*told.since) : Json()},
                        {"revision", told.revision},
                        {"frame_count", frames.frame_count()},
                        {"is_last", told.is_last},
                        {"every", told.every},
                        {"frames", told.frames}}));
}

void Gateway::Impl::onClock(std::uint64_t session, const v1::MotionClock& clock) {
  // How old it is when it is read is told apart from the clocks of other machines.
  const double age_s =
      1e-9 * static_cast<double>(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                     std::chrono::system_clock::now().time_since_epoch())
                                     .count() -
                                 clock.stamp_ns());
  const Shared text = textOf({{"event", "clock"},
                              {"session", session},
                              {"age_s", std::max(0.0, age_s)},
                              {"clock", idl::jsonOf(clock)}});
  const std::lock_guard lock(mutex);
  if (followed.find(session) == followed.end()) return;
  tellFollowers(session, "clock", text);
}

void Gateway::Impl::onState(std::uint64_t session, const v1::SessionState& state) {
  const std::lock_guard lock(mutex);
  const auto found = followed.find(session);
  if (found == followed.end()) return;
  Followed& one = found->second;
  const auto editor = one.editors.find(state.revision());
  one.state = state;
  one.closed = state.phase() == v1::PHASE_CLOSED;
  one.heard = Clock::now();
  one.state_text = textOf({{"event", "state"},
                           {"session", session},
                           {"state", idl::jsonOf(state)},
                           {"is_ours", state.last_client() == client.id()},
                           {"page", editor == one.editors.end() ? 0 : editor->second}});
  tellFollowers(session, "state", one.state_text);
}

void Gateway::Impl::onEnd(std::uint64_t session, const std::exception_ptr& why) {
  const std::lock_guard lock(mutex);
  const auto found = followed.find(session);
  if (found == followed.end()) return;
  if (why == nullptr) {
    found->second.closed = true;
  } else {
    found->second.ended = true;
  }
}

// === The server goes and comes

bool Gateway::Impl::findServer() {
  if (client.alive()) {
    const std::lock_guard lock(mutex);
    if (!std::exchange(server_is_heard, true))
      tellAll({{"event", "server"}, {"is_heard", true}});
    return true;
  }
  {
    const std::lock_guard lock(mutex);
    if (std::exchange(server_is_heard, false))
      tellAll({{"event", "server"}, {"is_heard", false}});
  }
  try {
    client.rejoin();
  } catch (const std::exception&) {
    return false;  // the next time, perhaps
  }
  return client.alive() && findServer();
}

/// The session again, on the server that is there now.
void Gateway::Impl::resume(std::uint64_t session) {
  whenDone(client.describeSession(session), [this, session](Outcome<v1::SessionState> outcome) {
    const std::lock_guard lock(mutex);
    const auto found = followed.find(session);
    if (found == followed.end()) return;
    if (!client.alive()) {
      found->second.ended = true;  // tried again when one is heard
      return;
    }
    if (const auto* state = std::get_if<v1::SessionState>(&outcome)) {
      const v1::SessionState& was = found->second.state;
      const bool is_same = state->hand() == was.hand() && state->object() == was.object() &&
                           state->contacts() == was.contacts() &&
                           state->revision() >= was.revision();
      if (is_same) return moveTo(session, *state, true);
    }
    if (client.status().server_id() == found->second.server_id) {
      return lose(session, "the session has been closed");
    }
    restore(session);
  });
}

void Gateway::Impl::lose(std::uint64_t session, const std::string& why) {
  followed[session].closed = true;
  tellAll({{"event", "lost"}, {"session", session}, {"message", why}});
}

void Gateway::Impl::restore(std::uint64_t session) {
  const auto found = followed.find(session);
  if (found->second.saved.empty()) return lose(session, "the session ended with its server");
  whenDone(client.loadSession(found->second.saved),
           [this, session](Outcome<v1::SessionState> outcome) {
             const std::lock_guard lock(mutex);
             if (!followed.contains(session)) return;
             if (const auto* error = std::get_if<std::exception_ptr>(&outcome)) {
               const Json reason = errorJson(*error);
               if (reason["code"] != "no_server") return lose(session, reason["message"]);
               followed[session].ended = true;  // tried again when one is heard
               return;
             }
             const auto& state = std::get<v1::SessionState>(outcome);
             v1::OptimizeRequest request;
             request.session_id(state.session_id());
             client.optimize(request);  // its pose comes by the stream
             moveTo(session, state, false);
           });
}

/// Its pages follow that one from now on.
void Gateway::Impl::moveTo(std::uint64_t session, const v1::SessionState& state, bool is_same) {
  auto node = followed.extract(session);
  Followed& one = node.mapped();
  past.push_back(std::move(one.following));
  const std::uint64_t now = state.session_id();
  one.ended = false;
  one.state = state;
  one.saved_revision = 0;
  one.editors.clear();
  if (!is_same) one.pose_text = one.state_text = nullptr;
  one.told_frames = {};
  one.server_id = client.status().server_id();
  one.following = std::make_unique<Following>(client, now, listenerFor(now));
  node.key() = now;
  if (const auto other = followed.find(now); other != followed.end()) {
    past.push_back(std::move(other->second.following));
    followed.erase(other);
  }
  followed.insert(std::move(node));
  for (auto& [page, its] : pages) {
    if (its.sessions.erase(session) == 0) continue;
    its.sessions.insert(now);
    web->send(page, textOf({{"event", "moved"}, {"from", session}, {"to", now}}));
  }
}

/// Sessions are saved while nobody edits them, so that a server that dies takes little along.
void Gateway::Impl::saveWhatRests() {
  const std::lock_guard lock(mutex);
  for (auto& [session, one] : followed) {
    const bool is_saved = !one.saved.empty() && one.saved_revision == one.state.revision();
    if (is_saved || one.saving || one.ended || one.closed ||
        one.state.phase() != v1::PHASE_READY || Clock::now() - one.heard < kRestBeforeSaving)
      continue;
    one.saving = true;
    whenDone(client.saveSession(session),
             [this, session = session,
              revision = one.state.revision()](Outcome<std::string> outcome) {
               const std::lock_guard inner(mutex);
               const auto found = followed.find(session);
               if (found == followed.end()) return;
               found->second.saving = false;
               if (auto* text = std::get_if<std::string>(&outcome)) {
                 found->second.saved = std::move(*text);
                 found->second.saved_revision = revision;
               } else {
                 found->second.heard = Clock::now();  // not again at once
               }
             });
  }
}

/// Where the hands are that follow a session, as they say themselves.
void Gateway::Impl::tellMeasured() {
  {
    const std::lock_guard lock(mutex);
    if (followed.empty()) return measured.rest();
  }
  measured.take([this](const v1::JointState& state) {
    Json names = Json::array();
    Json positions = Json::array();
    for (std::size_t i = 0; i < std::min(state.names().size(), state.position().size()); ++i) {
      if (!std::isfinite(state.position()[i])) continue;  // not measured
      names.push_back(state.names()[i]);
      positions.push_back(state.position()[i]);
    }
    const Shared text = textOf({{"event", "measured"},
                                {"session", state.session_id()},
                                {"bridge", state.bridge_id()},
                                {"names", names},
                                {"positions", positions}});
    const std::lock_guard lock(mutex);
    tellFollowers(state.session_id(), "measured", text);
  });
}

// === The gateway

Gateway::Gateway(Client& client, const WebOptions& options, WebFiles files)
    : impl_(std::make_shared<Impl>(client)) {
  const std::lock_guard lock(impl_->mutex);  // nobody is served before there is a web server
  impl_->web = std::make_unique<WebServer>(options, std::move(files), *impl_);
}

Gateway::~Gateway() {
  std::map<std::uint64_t, Impl::Followed> followed;
  std::vector<std::unique_ptr<Following>> past;
  // Their threads end without the lock, which they may be waiting for.
  const std::lock_guard lock(impl_->mutex);
  impl_->ending = true;
  followed.swap(impl_->followed);
  past.swap(impl_->past);
  impl_->work.clear();
}

std::uint16_t Gateway::port() const {
  return impl_->web->port();
}

void Gateway::tend() {
  std::vector<std::unique_ptr<Following>> past;
  {
    const std::lock_guard lock(impl_->mutex);
    past.swap(impl_->past);
  }
  past.clear();
  std::vector<std::function<void()>> work;
  {
    const std::lock_guard lock(impl_->mutex);
    work.swap(impl_->work);
  }
  for (const auto& step : work)
    step();
  try {
    impl_->tellMeasured();
  } catch (const TransportError&) {
    impl_->measured.rest();  // looked for again
  }
  if (!impl_->findServer()) return;
  std::vector<std::uint64_t> ended;
  {
    const std::lock_guard lock(impl_->mutex);
    for (auto& [session, one] : impl_->followed) {
      if (!one.closed && std::exchange(one.ended, false)) ended.push_back(session);
    }
  }
  for (const std::uint64_t session : ended)
    impl_->resume(session);
  impl_->saveWhatRests();
}

std::string addressOf(const WebOptions& options, std::uint16_t port) {
  std::string host = options.address;
  if (host == "0.0.0.0" || host == "::") {
    std::array<char, 256> name{};  // of this machine, by which others reach it
    if (gethostname(name.data(), name.size() - 1) == 0) host = name.data();
  }
  const bool is_v6 = host.find(':') != std::string::npos;
  return fmt::format("http://{}{}{}:{}/", is_v6 ? "[" : "", host, is_v6 ? "]" : "", port);
}

std::string randomToken() {
  std::random_device device;
  std::string token;
  for (int i = 0; i < 4; ++i)
    token += fmt::format("{:08x}", device());
  return token;
}

}  // namespace handgraft::client::gateway
