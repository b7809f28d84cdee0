#include "server/live_session.h"

#include <algorithm>
#include <utility>

#include "server/convert.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kMostWaiting = 256;

}  // namespace

long long nowNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

LiveSession::LiveSession(std::uint64_t id,
                         SessionNames names,
                         session::Session session,
                         WorkerPool& pool,
                         SessionAudience& audience)
    : id_(id), session_(std::move(session)), audience_(audience), strand_(pool, kMostWaiting) {
  state_.session_id(id_);
  state_.hand(std::move(names.hand));
  state_.object(std::move(names.object));
  state_.contacts(std::move(names.contacts));
  state_.joint_names(session_.hand().model->dofNames());
}

v1::SessionState LiveSession::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

void LiveSession::enter(v1::SessionPhase phase, const std::string& message, double progress) {
  // Held while telling, so that states go out in the order in which they came to be.
  const std::lock_guard lock(mutex_);
  if (state_.phase() == v1::PHASE_CLOSED) return;
  state_.revision(session_.revision());
  state_.phase(phase);
  state_.message(message);
  state_.progress(progress);
  told_ = std::chrono::steady_clock::now();
  audience_.onState(state_);
}

void LiveSession::advance(std::string_view stage, double fraction) {
  constexpr std::chrono::milliseconds kPeriod(100);
  const std::lock_guard lock(mutex_);
  if (state_.phase() == v1::PHASE_CLOSED) return;
  state_.message(std::string(stage));
  state_.progress(std::clamp(fraction, 0.0, 1.0));
  const auto now = std::chrono::steady_clock::now();
  if (now - told_ < kPeriod) return;
  told_ = now;
  audience_.onState(state_);
}

v1::PoseSolution LiveSession::publish(v1::PoseSolution solution) {
  solution.session_id(id_);
  solution.revision(session_.revision());
  solution.sequence_number(++sequence_number_);
  solution.stamp_ns(nowNs());
  audience_.onSolution(solution);
  if (solution.is_final()) {
    const Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(
        solution.joint_rad().data(), static_cast<Eigen::Index>(solution.joint_rad().size()));
    audience_.onJointCommand(id_, jointCommand(*session_.hand().model, q, solution.stamp_ns()));
  }
  return solution;
}

}  // namespace handgraft::server
