#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "idl/cyclone/participant.h"
#include "idl/cyclone/requester.h"
#include "idl/sessions.h"

#include "tests/system/service.h"

namespace handgraft::test {

/// A session opened over DDS, as an editor sees it: requests, edits and both streams.
class LiveSession {
 public:
  LiveSession(const Service& service,
              const std::string& hand,
              const std::string& object,
              const std::string& contacts);

  [[nodiscard]] unsigned long long id() const { return state_.session_id(); }

  [[nodiscard]] const v1::SessionState& opened() const { return state_; }

  v1::TransferReply transfer();
  v1::PoseSolution optimize(v1::Solver solver = v1::SOLVER_DEFAULT);
  /// A refusal comes back as a reply with its error, so that tests can look at it.
  v1::EditReply edit(const v1::EditBody& body, unsigned long long base_revision = 0);
  void close();

  /// The first sample of the stream, old or new, for which `wanted` holds; nothing after a
  /// minute.
  std::optional<v1::PoseSolution> solution(
      const std::function<bool(const v1::PoseSolution&)>& wanted);
  std::optional<v1::SessionState> state(
      const std::function<bool(const v1::SessionState&)>& wanted);

  /// Every solution taken so far, in the order of arrival.
  [[nodiscard]] const std::vector<v1::PoseSolution>& solutions() const { return solutions_; }

  /// Index of a joint in every joint_rad; fails the test if there is none.
  [[nodiscard]] std::size_t joint(const std::string& name) const;

 private:
  idl::cyclone::Participant participant_;
  idl::cyclone::Requester requester_;
  idl::cyclone::Reader<v1::PoseSolution> solution_reader_;
  idl::cyclone::Reader<v1::SessionState> state_reader_;
  v1::SessionState state_;
  std::vector<v1::PoseSolution> solutions_;
};

}  // namespace handgraft::test
