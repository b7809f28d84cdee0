#pragma once

#include <cstdint>
#include <string>

#include "idl/service.h"

/// Requests of sessions that hold a motion.
namespace handgraft::test {

inline constexpr const char* kPlan =
    R"({"format": "handgraft-motion-plan/1", "first": "first.json", "path": "path.csv",
        "rate_hz": 30})";
inline constexpr const char* kPath =
    "time_s,x,y,z,qw,qx,qy,qz\n0,0,0,0.3,1,0,0,0\n0.5,-0.05,0,0.3,0.98,0,0,0.199\n";

inline v1::RequestBody openMotion(const std::string& hand,
                                  const std::string& object,
                                  const std::string& motion) {
  v1::OpenSessionRequest open;
  open.hand(hand);
  open.object(object);
  open.motion(motion);
  v1::RequestBody body;
  body.open_session(open);
  return body;
}

inline v1::RequestBody solveMotion(std::uint64_t session, bool causal = false) {
  v1::SolveMotionRequest request;
  request.session_id(session);
  v1::MotionOptions options;
  options.causal(causal);
  request.options().push_back(options);
  v1::RequestBody body;
  body.solve_motion(request);
  return body;
}

}  // namespace handgraft::test
