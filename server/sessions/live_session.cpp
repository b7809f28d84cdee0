#include "server/sessions/live_session.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/session/solids.h"
#include "server/messages/convert.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kMostWaiting = 256;
constexpr int kFlood = 16;  // edits that wait; two editors who hurry are none

bool isAtWork(v1::SessionPhase phase) {
  return phase == v1::PHASE_TRANSFERRING || phase == v1::PHASE_OPTIMIZING;
}

}  // namespace

std::string shortName(const v1::ClientId& client) {
  return fmt::format("{:02x}{:02x}{:02x}{:02x}", client[0], client[1], client[2], client[3]);
}

long long nowNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

LiveSession::LiveSession(std::uint64_t id,
                         session::Session session,
                         StrandPool& pool,
                         SessionAudience& audience)
    : id_(id), session_(std::move(session)), audience_(audience), strand_(pool, kMostWaiting) {
  state_.session_id(id_);
  touch();
  describeSession();
}

void LiveSession::hold(LiveMotion motion) {
  const std::lock_guard lock(mutex_);
  motion_ = std::move(motion);
  describeSession();
}

void LiveSession::describeSession() {
  const session::Document& document = session_.document();
  if (state_.hand() != document.hand || state_.joint_names().empty()) {
    state_.joint_names(session_.hand().model->dofNames());
  }
  state_.revision(session_.revision());
  state_.hand(document.hand);
  state_.object(document.object);
  state_.contacts(motion_ ? "" : document.contacts);
  state_.motion(motion_ ? motion_->name : "");
  state_.undo_count(static_cast<std::uint32_t>(session_.history().undoCount()));
  state_.redo_count(static_cast<std::uint32_t>(session_.history().redoCount()));
}

v1::SessionState LiveSession::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

void LiveSession::enter(v1::SessionPhase phase, const std::string& message, double progress) {
  const std::lock_guard lock(mutex_);
  if (state_.phase() == v1::PHASE_CLOSED) return;
  describeSession();
  setPhase(phase, message, progress);
  tell();
}

void LiveSession::settle(v1::SessionPhase phase) {
  const std::lock_guard lock(mutex_);
  if (state_.phase() == v1::PHASE_CLOSED) return;
  describeSession();
  resting_phase_ = phase;
  setPhase(restingPhase(), "");
  if (!expectsEdits()) tell();
}

void LiveSession::tellRest() {
  const std::lock_guard lock(mutex_);
  if (state_.phase() == v1::PHASE_CLOSED) return;
  if (isAtWork(state_.phase())) setPhase(restingPhase(), "");
  tell();
}

void LiveSession::tellCancelled() {
  const bool is_stopped = [this] {
    const std::lock_guard lock(flight_mutex_);
    return in_flight_ != nullptr && in_flight_->stopped_;
  }();
  if (is_stopped) unexplained = nullptr;
  const std::lock_guard lock(mutex_);
  if (state_.phase() == v1::PHASE_CLOSED) return;
  setPhase(restingPhase(), is_stopped ? "stopped" : "cancelled");
  if (is_stopped || !expectsEdits()) tell();
}

void LiveSession::enterSoon(v1::SessionPhase phase) {
  constexpr std::chrono::milliseconds kPeriod(2);
  const std::lock_guard lock(mutex_);
  if (state_.phase() == v1::PHASE_CLOSED) return;
  describeSession();
  setPhase(phase, "");
  // What is kept back is told by the next edit, or by the solve that follows the last one.
  if (expected_edits_ >= kFlood && std::chrono::steady_clock::now() - told_ < kPeriod) return;
  tell();
}

void LiveSession::setPhase(v1::SessionPhase phase,
                           const std::string& message,
                           double progress) {
  state_.phase(phase);
  state_.message(message.empty() ? warning_ : message);
  state_.progress(progress);
  if (!isAtWork(phase)) resting_phase_ = phase;
}

v1::SessionPhase LiveSession::restingPhase() const {
  return unexplained ? v1::PHASE_OPTIMIZING : resting_phase_;
}

void LiveSession::tell() {
  if (told_state_ == state_) return;
  told_state_ = state_;
  told_ = std::chrono::steady_clock::now();
  audience_.onState(state_);
}

void LiveSession::advance(std::string_view stage, double fraction) {
  constexpr std::chrono::milliseconds kPeriod(100);
  const std::lock_guard lock(mutex_);
  if (state_.phase() == v1::PHASE_CLOSED) return;
  state_.message(std::string(stage));
  state_.progress(std::clamp(fraction, 0.0, 1.0));
  if (std::chrono::steady_clock::now() - told_ < kPeriod) return;
  tell();
}

// === Stopping

void LiveSession::stopSolving(const v1::ClientId& stopper) {
  touch();
  const std::lock_guard lock(flight_mutex_);
  ++stops_;
  stopper_ = stopper;
  if (in_flight_ == nullptr) return;
  in_flight_->stopped_ = true;
  in_flight_->progress_.cancel();
}

void LiveSession::endSolveLongerThan(std::chrono::duration<double> longest) {
  const std::lock_guard lock(flight_mutex_);
  if (in_flight_ == nullptr || in_flight_->stopped_) return;
  if (std::chrono::steady_clock::now() - in_flight_->begin_ <= longest) return;
  ++stops_;
  stopper_.reset();
  in_flight_->stopped_ = true;
  in_flight_->progress_.cancel();
}

std::string LiveSession::whoStopped() const {
  const std::lock_guard lock(flight_mutex_);
  return stopper_ ? "stopped by client " + shortName(*stopper_) : "stopped: its time is over";
}

// === Edits on their way

void LiveSession::expectEdit() {
  ++expected_edits_;
  touch();
  const std::lock_guard lock(flight_mutex_);
  if (in_flight_ != nullptr) in_flight_->giveWay();
}

void LiveSession::meetEdit() {
  --expected_edits_;
}

LiveSession::SolveInFlight::SolveInFlight(LiveSession& live,
                                          Progress& progress,
                                          std::chrono::milliseconds least)
    : live_(live),
      progress_(progress),
      begin_(std::chrono::steady_clock::now()),
      least_(least) {
  const std::lock_guard lock(live_.flight_mutex_);
  live_.in_flight_ = this;
  if (live_.stops_ == live_.asked_at_stops) return;
  stopped_ = true;
  progress_.cancel();
}

LiveSession::SolveInFlight::~SolveInFlight() {
  const std::lock_guard lock(live_.flight_mutex_);
  live_.in_flight_ = nullptr;
}

void LiveSession::SolveInFlight::giveWay() {
  if (!live_.expectsEdits() || cut_short_) return;
  if (std::chrono::steady_clock::now() - begin_ < least_) return;
  cut_short_ = true;
  progress_.cancel();
}

void LiveSession::prepareSolids(const std::shared_ptr<LiveSession>& self, StrandPool& pool) {
  const session::Hand& hand = session_.hand();
  const std::shared_ptr<const geometry::TriangleMesh>& object_O = session_.sharedObject();
  if (begun_hand_.lock() == hand.model && begun_object_.lock() == object_O) return;
  begun_hand_ = hand.model;
  begun_object_ = object_O;
  const bool is_taken = pool.post([self, hand, object_O] {
    try {
      // The object first: a session that comes to wait begins with the hand.
      static_cast<void>(session::solidOf(object_O, self->solves()));
      session::makeSolids(hand, object_O, self->solves());
    } catch (const std::exception&) {  // who needs them tries again, and tells
    }
  });
  if (!is_taken) begun_hand_.reset();
}

void LiveSession::noteEdit(AppliedEdit edit) {
  constexpr std::size_t kMostNoted = 64;
  {
    const std::lock_guard lock(mutex_);
    state_.last_edit(edit.label);
    state_.last_client(edit.client);
  }
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
  using Clock = std::chrono::steady_clock;
  return Clock::now() - Clock::time_point(Clock::duration(last_used_));
}

void LiveSession::warn(const std::string& warning) {
  const std::lock_guard lock(mutex_);
  if (state_.phase() == v1::PHASE_CLOSED || warning == warning_) return;
  if (state_.message() == warning_) state_.message(warning);
  warning_ = warning;
  tell();
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

v1::PoseSolution LiveSession::publish(v1::PoseSolution solution) {
  solution.session_id(id_);
  solution.revision(session_.revision());
  solution.sequence_number(++sequence_number_);
  solution.stamp_ns(nowNs());
  audience_.onSolution(solution);
  if (solution.is_final() && !solution.is_diagnosed()) {
    const Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(
        solution.joint_positions().data(),
        static_cast<Eigen::Index>(solution.joint_positions().size()));
    audience_.onJointCommand(id_, jointCommand(*session_.hand().model, q, solution.stamp_ns()));
  }
  return solution;
}

}  // namespace handgraft::server
