#include "client/link/session.h"

#include <algorithm>

#include "core/base/error.h"

namespace handgraft::client {

namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr milliseconds kPatience(20);
constexpr milliseconds kLateJoin(2000);
constexpr milliseconds kNothingFollows(2000);  // after the session has come to rest

}  // namespace

/// How long a session has rested at a revision without a break.
class Session::Rest {
 public:
  Rest(const Session& session, std::uint64_t revision)
      : session_(session), revision_(revision) {}

  [[nodiscard]] bool isLong() {
    const Clock::time_point now = Clock::now();
    if (!session_.restsAt(revision_)) since_ = now;
    return now - since_ > kNothingFollows;
  }

 private:
  const Session& session_;
  const std::uint64_t revision_;
  Clock::time_point since_ = Clock::now();
};

Session::Session(Client& client, const v1::SessionState& state)
    : client_(client),
      stream_(client, state.session_id()),
      state_(state),
      server_id_(state.server_id() != 0 ? state.server_id() : client.status().server_id()) {}

bool Session::hasEnded() const {
  return client_.status().server_id() != server_id_;
}

void Session::requireStanding() const {
  if (state_.phase() == v1::PHASE_CLOSED) {
    throw Refused(v1::ERROR_NOT_FOUND, fmt::format("session {} has been closed", id()));
  }
  if (hasEnded()) {
    throw Refused(
        v1::ERROR_NOT_FOUND,
        fmt::format("session {} has ended with its server; load opens a saved one", id()));
  }
}

void Session::requireOpen() const {
  requireStanding();
  if (!client_.alive()) {
    throw NoServer(fmt::format("handgraft-server on {} stopped answering",
                               handgraft::describe(client_.network())));
  }
}

// === Asking

Pending<v1::EditReply> Session::edit(const v1::EditBody& body,
                                     std::uint64_t base_revision,
                                     const std::optional<v1::EditTime>& when) {
  return client_.edit(id(), base_revision, body, when);
}

Pending<v1::PoseSolution> Session::solve(const std::optional<v1::SolveOptions>& options) {
  v1::OptimizeRequest request;
  request.session_id(id());
  if (options) request.options().push_back(*options);
  return client_.optimize(request);
}

// === Following

void Session::take(const OnSolution& on_solution, const OnState& on_state) {
  const bool ended = hasEnded();
  stream_.take(
      [&](const v1::PoseSolution& solution) {
        if (ended) return;
        if (solution.is_final()) solution_ = solution;
        if (on_solution) on_solution(solution);
      },
      [&](const v1::SessionState& state) {
        // Who comes late is told older states first.
        if (ended || state.revision() < state_.revision()) return;
        state_ = state;
        if (on_state) on_state(state);
      });
}

const v1::PoseSolution* Session::joinedSolution() {
  take();
  // Late readers are brought the last pose once they are found.
  while (!solution_ && state_.phase() != v1::PHASE_OPEN && state_.phase() != v1::PHASE_CLOSED &&
         !hasEnded() && Clock::now() - joined_ < kLateJoin) {
    client_.checkpoint();
    stream_.wait(kPatience);
    take();
  }
  return solution();
}

const v1::PoseSolution* Session::awaitFinal(std::uint64_t revision,
                                            const OnSolution& on_solution) {
  Rest rest(*this, revision);
  while (true) {
    take(on_solution);
    if (solution_ && solution_->revision() >= revision) return &*solution_;
    requireOpen();
    if (state_.revision() >= revision && state_.phase() == v1::PHASE_FAILED) {
      throw SolveFailed(state_.message());
    }
    if (rest.isLong()) return nullptr;
    client_.checkpoint();
    stream_.wait(kPatience);
  }
}

const v1::PoseSolution& Session::awaitDiagnosed(std::uint64_t revision, Timeout longest) {
  const Clock::time_point begin = Clock::now();
  Rest rest(*this, revision);
  while (true) {
    take();
    HANDGRAFT_REQUIRE(solution_.has_value());
    if (solution_->is_diagnosed() || solution_->revision() > revision) return *solution_;
    requireOpen();
    if (rest.isLong() || Clock::now() - begin >= longest) return *solution_;
    client_.checkpoint();
    stream_.wait(std::min(kPatience, longest));
  }
}

bool Session::restsAt(std::uint64_t revision) const {
  return state_.revision() >= revision &&
         (state_.phase() == v1::PHASE_READY || state_.phase() == v1::PHASE_OPEN ||
          state_.phase() == v1::PHASE_FAILED);
}

const v1::PoseSolution& Session::adopt(const v1::PoseSolution& solution) {
  if (!solution_ || solution_->sequence_number() <= solution.sequence_number()) {
    solution_ = solution;
  }
  return *solution_;
}

void Session::adopt(const v1::SessionState& state) {
  if (state.revision() >= state_.revision()) state_ = state;
}

}  // namespace handgraft::client
