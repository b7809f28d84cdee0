#include "server/handlers/motion_clock.h"

#include <cmath>

#include "core/base/error.h"
#include "server/base/rejection.h"
#include "server/handlers/motions.h"
#include "server/messages/convert.h"

namespace handgraft::server {

namespace {

constexpr double kFastest = 100.0;  // times real time

/// Where a clock stands; beyond the end of a motion it goes round, or stays there.
double clockTime(const v1::MotionClock& clock, double duration_s, long long now) {
  if (!clock.playing()) return clock.time_s();
  const double time_s =
      clock.time_s() + clock.speed() * 1e-9 * static_cast<double>(now - clock.stamp_ns());
  if (time_s < duration_s) return time_s;
  return clock.looping() && duration_s > 0.0 ? std::fmod(time_s, duration_s) : duration_s;
}

}  // namespace

v1::MotionClock setClock(LiveSession& live,
                         const v1::ClockRequest& request,
                         const v1::ClientId& client) {
  LiveMotion& motion = motionOf(live);
  v1::MotionClock& clock = motion.clock;
  const double duration_s = motion.motion->duration();
  const long long now = nowNs();
  if (clock.stamp_ns() == 0) clock.speed(1.0);
  clock.time_s(clockTime(clock, duration_s, now));
  if (clock.time_s() >= duration_s && !clock.looping()) clock.playing(false);
  const double value = request.value();
  switch (request.action()) {
    case v1::CLOCK_PLAY:
      if (clock.time_s() >= duration_s) clock.time_s(0.0);
      clock.playing(true);
      break;
    case v1::CLOCK_PAUSE:
      clock.playing(false);
      break;
    case v1::CLOCK_SEEK:
      if (!(value >= 0.0 && value <= duration_s))
        rejectInput("clock: {} s; motion {} has 0 to {:.6g} s", value,
                    handgraft::quoted(motion.name), duration_s);
      clock.time_s(value);
      break;
    case v1::CLOCK_SPEED:
      if (!(value > 0.0 && value <= kFastest))
        rejectInput("clock: {} times real time; permitted are above 0 to {}", value, kFastest);
      clock.speed(value);
      break;
    case v1::CLOCK_LOOP:
      if (value != 0.0 && value != 1.0)
        rejectInput("clock: loop {}; permitted are 0 and 1", value);
      clock.looping(value == 1.0);
      break;
    default:
      rejectInput("clock: action {} does not exist", static_cast<unsigned>(request.action()));
  }
  clock.session_id(live.id());
  clock.duration_s(duration_s);
  clock.stamp_ns(now);
  clock.last_client(client);
  live.publishClock();
  return clock;
}

}  // namespace handgraft::server
