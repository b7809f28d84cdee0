#include "server/sessions/live_session.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/placement/solids.h"
#include "server/messages/convert.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kMostWaiting = 256;
constexpr int kFlood = 16;  // edits that wait; two editors who hurry are none

bool isAtWork(v1::SessionPhase phase) {
  return phase == v1::PHASE_TRANSFERRING || phase == v1::PHASE_OPTIMIZING;
}

}  // namespace

long long nowNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

LiveSession::LiveSession(std::uint64_t id,
                         session::Session session,
                         StrandPool& pool,
                         SessionAudience& audience,
                         SolveCycle::Now now)
    : id_(id),
      now_(now),
      session_(std::move(session)),
      audience_(audience),
      strand_(pool, kMostWaiting),
      cycle_(now),
      published_(
          [&audience](const v1::SessionState& state) {
            audience.onState(state);
          },
          std::move(now)) {
  touch();
  const auto begin = [this](v1::SessionState& state) {
    state.session_id(id_);
    describeSession(state);
  };
  published_.change(begin, PublishedState::kSilently);
}

void LiveSession::belongTo(std::uint64_t server_id) {
  const auto belong = [server_id](v1::SessionState& state) {
    state.server_id(server_id);
  };
  published_.change(belong, PublishedState::kSilently);
}

void LiveSession::hold(LiveMotion motion) {
  motion_ = std::move(motion);
  const auto describe = [this](v1::SessionState& state) {
    describeSession(state);
  };
  published_.change(describe, PublishedState::kSilently);
}

// === Whose it is

SessionAccess LiveSession::access() const {
  const std::lock_guard lock(access_mutex_);
  return access_;
}

void LiveSession::grant(SessionAccess access, PublishPolicy telling) {
  const auto tell = [&access](v1::SessionState& state) {
    state.owner(access.owner);
    state.access(access.access);
  };
  {  // who hears of it may edit
    const std::lock_guard lock(access_mutex_);
    access_ = access;
  }
  published_.change(tell, telling);
}

// === Its state

void LiveSession::describeSession(v1::SessionState& state) const {
  const session::Document& document = session_.document();
  if (state.hand() != document.hand || state.joint_names().empty()) {
    state.joint_names(session_.hand().model->dofNames());
  }
  state.revision(session_.revision());
  state.hand(document.hand);
  state.object(document.object);
  state.contacts(motion_ ? "" : document.contacts);
  state.motion(motion_ ? motion_->name : "");
  state.undo_count(static_cast<std::uint32_t>(session_.history().undoCount()));
  state.redo_count(static_cast<std::uint32_t>(session_.history().redoCount()));
}

void LiveSession::setPhase(v1::SessionState& state,
                           v1::SessionPhase phase,
                           const std::string& message,
                           double progress) {
  state.phase(phase);
  state.message(message.empty() ? warning(state) : message);
  state.progress(progress);
  if (!isAtWork(phase)) resting_phase_ = phase;
}

v1::SessionPhase LiveSession::restingPhase() const {
  return cycle_.undiagnosed() ? v1::PHASE_OPTIMIZING : resting_phase_;
}

PublishPolicy LiveSession::unlessEditsWait() const {
  return cycle_.editsQueued() > 0 ? PublishedState::kSilently : PublishedState::kAtOnce;
}

void LiveSession::enter(v1::SessionPhase phase, const std::string& message, double progress) {
  published_.change([&](v1::SessionState& state) {
    describeSession(state);
    setPhase(state, phase, message, progress);
  });
}

void LiveSession::enterSoon(v1::SessionPhase phase) {
  constexpr PublishPolicy kSoon{std::chrono::milliseconds(2)};
  const auto change = [&](v1::SessionState& state) {
    describeSession(state);
    setPhase(state, phase, "");
  };
  // What is kept back is told by the next edit, or by the solve that follows the last one.
  const bool is_flood = cycle_.editsQueued() >= kFlood;
  published_.change(change, is_flood ? kSoon : PublishedState::kAtOnce);
}

void LiveSession::settle(v1::SessionPhase phase) {
  const auto change = [&](v1::SessionState& state) {
    describeSession(state);
    resting_phase_ = phase;
    setPhase(state, restingPhase(), "");
  };
  published_.change(change, unlessEditsWait());
}

void LiveSession::tellRest() {
  published_.change([&](v1::SessionState& state) {
    if (isAtWork(state.phase())) setPhase(state, restingPhase(), "");
  });
}

void LiveSession::tellEnd(SolveEnd end) {
  const bool is_stopped = end == SolveEnd::kStopped;
  if (is_stopped) cycle_.forgetUndiagnosed();
  const auto change = [&](v1::SessionState& state) {
    setPhase(state, restingPhase(), is_stopped ? "stopped" : "cancelled");
  };
  published_.change(change, is_stopped ? PublishedState::kAtOnce : unlessEditsWait());
}

void LiveSession::advance(std::string_view stage, double fraction) {
  constexpr PublishPolicy kNowAndThen{std::chrono::milliseconds(100)};
  const auto change = [&](v1::SessionState& state) {
    state.message(std::string(stage));
    state.progress(std::clamp(fraction, 0.0, 1.0));
  };
  published_.change(change, kNowAndThen);
}

void LiveSession::prepareSolids(const std::shared_ptr<LiveSession>& self, StrandPool& pool) {
  const hand::Hand& hand = session_.hand();
  const std::shared_ptr<const geometry::TriangleMesh>& object_O = session_.sharedObject();
  if (begun_hand_.lock() == hand.model && begun_object_.lock() == object_O) return;
  begun_hand_ = hand.model;
  begun_object_ = object_O;
  const bool is_taken = pool.post([self, hand, object_O] {
    try {
      // The object first: a session that comes to wait begins with the hand.
      static_cast<void>(placement::solidOf(object_O, self->solves()));
      placement::makeSolids(hand, object_O, self->solves());
    } catch (const std::exception&) {  // who needs them tries again, and tells
    }
  });
  if (!is_taken) begun_hand_.reset();
}

void LiveSession::noteEdit(AppliedEdit edit) {
  constexpr std::size_t kMostNoted = 64;
  const auto change = [&](v1::SessionState& state) {
    state.last_edit(edit.label);
    state.last_client(edit.client);
  };
  published_.change(change, PublishedState::kSilently);
  edits_.push_back(std::move(edit));
  if (edits_.size() > kMostNoted) edits_.pop_front();
}

std::string LiveSession::editsSince(std::uint64_t revision, const v1::ClientId& mine) const {
  constexpr std::size_t kMostTold = 3;
  std::vector<const AppliedEdit*> since;
  for (const AppliedEdit& edit : edits_) {
    if (edit.revision > revision) since.push_back(&edit);
  }
  std::string text;
  const std::size_t first = since.size() > kMostTold ? since.size() - kMostTold : 0;
  for (std::size_t i = first; i < since.size(); ++i) {
    const std::string whose =
        since[i]->client == mine ? "you" : "client " + shortName(since[i]->client);
    text += fmt::format("{}revision {}: {} by {}", text.empty() ? "" : "; ", since[i]->revision,
                        handgraft::quoted(since[i]->label), whose);
  }
  return text;
}

// === Idleness

std::chrono::steady_clock::duration LiveSession::idle() const {
  using Clock = SolveCycle::Clock;
  return now_() - Clock::time_point(Clock::duration(last_used_));
}

std::string LiveSession::warning(const v1::SessionState& state) const {
  const std::string& followed = state.following().text();
  return followed + (followed.empty() || closing_.empty() ? "" : "; ") + closing_;
}

void LiveSession::warn(const std::function<bool(v1::SessionState&)>& changes) {
  bool is_news = false;
  const auto change = [&](v1::SessionState& state) {
    const std::string before = warning(state);
    is_news = changes(state);
    if (state.message() == before) state.message(warning(state));
  };
  published_.change(change, PublishedState::kSilently);
  if (is_news) published_.change([](v1::SessionState&) {});
}

void LiveSession::warnOfClosing(const std::string& warning) {
  warn([&](v1::SessionState&) {
    return std::exchange(closing_, warning) != warning;
  });
}

void LiveSession::tellDemonstrator(const v1::FollowState& said) {
  warn([&](v1::SessionState& state) {
    const bool is_news = state.following() != said;
    state.following(said);
    return is_news;
  });
}

bool LiveSession::putFrame(v1::DemonstratorFrame frame) {
  const std::lock_guard lock(frame_mutex_);
  const bool is_first = !frame_.has_value();
  frame_ = std::move(frame);
  return is_first;
}

std::optional<v1::DemonstratorFrame> LiveSession::takeFrame() {
  const std::lock_guard lock(frame_mutex_);
  return std::exchange(frame_, std::nullopt);
}

void LiveSession::publish(v1::MotionFrames frames) {
  frames.session_id(id_);
  frames.sequence_number(++motion_->frames_sequence);
  audience_.onMotionFrames(frames);
}

void LiveSession::publishClock() {
  audience_.onClock(motion_->clock);
}

void LiveSession::recallFrom(std::int64_t left_ns) {
  left_ns_ = left_ns;
  left_revision_ = session_.revision();
}

v1::PoseSolution LiveSession::publish(v1::PoseSolution solution) {
  solution.session_id(id_);
  solution.revision(session_.revision());
  solution.sequence_number(++sequence_number_);
  const bool is_recalled = left_ns_ != 0 && left_revision_ == session_.revision();
  solution.stamp_ns(is_recalled ? left_ns_ : nowNs());
  audience_.onSolution(solution);
  if (solution.is_final() && !solution.is_diagnosed()) {
    const Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(
        solution.joint_positions().data(),
        static_cast<Eigen::Index>(solution.joint_positions().size()));
    audience_.onJointCommand(id_, jointCommand(*session_.hand().model, q, solution.stamp_ns()));
    diagnosed_.reset();
  }
  if (solution.is_final() && solution.is_diagnosed()) diagnosed_ = solution;
  return solution;
}

const v1::PoseSolution* LiveSession::diagnosed() const {
  const bool is_present = diagnosed_ && diagnosed_->revision() == session_.revision();
  return is_present ? &*diagnosed_ : nullptr;
}

}  // namespace handgraft::server
