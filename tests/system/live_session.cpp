#include "tests/system/live_session.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace handgraft::test {

namespace {

constexpr std::chrono::milliseconds kTick{50};
constexpr std::chrono::seconds kPatience{60};

}  // namespace

LiveSession::LiveSession(const Service& service,
                         const std::string& hand,
                         const std::string& object,
                         const std::string& contacts)
    : participant_(service.network()),
      requester_(participant_),
      solution_reader_(participant_, idl::kSolutionTopic),
      state_reader_(participant_, idl::kSessionTopic) {
  v1::OpenSessionRequest request;
  request.hand(hand);
  request.object(object);
  request.contacts(contacts);
  v1::RequestBody body;
  body.open_session(request);
  state_ = requester_.ask(body).session();
}

v1::TransferReply LiveSession::transfer() {
  v1::SessionKey key;
  key.session_id(id());
  v1::RequestBody body;
  body.session(key);
  body._d(v1::Operation::OP_TRANSFER);
  return requester_.ask(body).transfer();
}

v1::PoseSolution LiveSession::optimize(v1::Solver solver) {
  v1::OptimizeRequest request;
  request.session_id(id());
  v1::SolveOptions options;
  options.solver(solver);
  request.options().push_back(options);
  v1::RequestBody body;
  body.optimize(request);
  return requester_.ask(body).solution();
}

v1::EditReply LiveSession::edit(const v1::EditBody& body, unsigned long long base_revision) {
  try {
    return requester_.edit(id(), base_revision, body);
  } catch (const idl::cyclone::Refused& refused) {
    v1::EditReply reply;
    reply.error(refused.code());
    reply.message(refused.what());
    return reply;
  }
}

void LiveSession::close() {
  v1::SessionKey key;
  key.session_id(id());
  v1::RequestBody body;
  body.session(key);
  body._d(v1::Operation::OP_CLOSE_SESSION);
  requester_.ask(body);
}

std::optional<v1::PoseSolution> LiveSession::solution(
    const std::function<bool(const v1::PoseSolution&)>& wanted) {
  std::size_t looked_at = 0;
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (true) {
    for (; looked_at < solutions_.size(); ++looked_at) {
      if (wanted(solutions_[looked_at])) return solutions_[looked_at];
    }
    if (std::chrono::steady_clock::now() > end) return std::nullopt;
    solution_reader_.wait(kTick);
    solution_reader_.take([this](const v1::PoseSolution& sample) {
      if (sample.session_id() == id()) solutions_.push_back(sample);
    });
  }
}

std::optional<v1::SessionState> LiveSession::state(
    const std::function<bool(const v1::SessionState&)>& wanted) {
  std::optional<v1::SessionState> found;
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (!found && std::chrono::steady_clock::now() < end) {
    state_reader_.wait(kTick);
    state_reader_.take([&](const v1::SessionState& sample) {
      if (!found && sample.session_id() == id() && wanted(sample)) found = sample;
    });
  }
  return found;
}

std::size_t LiveSession::joint(const std::string& name) const {
  const auto& names = state_.joint_names();
  const auto found = std::find(names.begin(), names.end(), name);
  EXPECT_NE(found, names.end()) << "the session has no joint " << name;
  return static_cast<std::size_t>(found - names.begin());
}

}  // namespace handgraft::test
