#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <thread>

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/played_motion.h"
#include "client/link/client.h"
#include "client/link/motion_player.h"
#include "client/link/session_id.h"
#include "client/present/interactive_client.h"
#include "client/present/interruption.h"
#include "client/present/json_output.h"
#include "core/base/error.h"
#include "idl/topics.h"

namespace handgraft::client {

namespace {

using PlayTime = PlayClock::Time;

constexpr std::chrono::seconds kListenersPatience(2);

/// Whole lines of standard input, without ever waiting for one.
class StandardInput {
 public:
  /// The next line that is there; false if there is none yet, or none any more.
  bool line(std::string& line) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    while (text_.find('\n') == std::string::npos && !has_ended_ && ::poll(&input, 1, 0) > 0) {
      std::array<char, 256> some{};
      const ssize_t count = ::read(STDIN_FILENO, some.data(), some.size());
      if (count <= 0) has_ended_ = true;
      if (count > 0) text_.append(some.data(), static_cast<std::size_t>(count));
    }
    const std::size_t end = text_.find('\n');
    if (end == std::string::npos) return false;
    line = text_.substr(0, end);
    text_.erase(0, end + 1);
    return true;
  }

 private:
  std::string text_;
  bool has_ended_ = false;
};

double numberIn(std::istringstream& words, const std::string& verb) {
  double number = 0.0;
  std::string more;
  if (!(words >> number) || words >> more)
    rejectInput("{}: a number is wanted, and nothing else", verb);
  return number;
}

/// False if it is to end.
bool obey(const std::string& line, PlayClock& clock, PlayTime now) {
  std::istringstream words(line);
  std::string verb;
  words >> verb;
  if (verb.empty()) return true;
  if (verb == "quit") return false;
  if (verb == "play") {
    clock.play(now);
  } else if (verb == "pause") {
    clock.pause(now);
  } else if (verb == "seek") {
    clock.seek(numberIn(words, verb), now);
  } else if (verb == "speed") {
    clock.setSpeed(numberIn(words, verb), now);
  } else if (verb == "loop") {
    std::string how;
    words >> how;
    if (how != "on" && how != "off") rejectInput("loop {}: on or off", handgraft::quoted(how));
    clock.setLooping(how == "on", now);
  } else {
    rejectInput("{}: there are play, pause, seek S, speed X, loop on|off, quit",
                handgraft::quoted(verb));
  }
  return true;
}

void tell(const PlayClock& clock, PlayTime now, bool as_json) {
  if (as_json) return;
  fmt::print("{} at {:.2f} of {:.2f} s, speed {:g}{}\n",
             clock.isPlaying(now) ? "playing" : "paused", clock.at(now), clock.duration(),
             clock.speed(), clock.isLooping() ? ", looping" : "");
  std::fflush(stdout);
}

/// A motion that ends elsewhere than it begins makes a hand jump where it begins again.
void warnOfSeam(const PlayedMotion& way,
                const std::vector<std::string>& joint_names,
                PlayTime now) {
  constexpr double kSeam = 0.05;  // rad or m
  const std::vector<double> first = way.at(0.0, now);
  const std::vector<double> last = way.at(way.duration(), now);
  std::size_t worst = 0;
  for (std::size_t i = 0; i < first.size(); ++i)
    if (std::abs(last[i] - first[i]) > std::abs(last[worst] - first[worst])) worst = i;
  if (first.empty() || std::abs(last[worst] - first[worst]) < kSeam) return;
  fmt::print(stderr,
             "it ends elsewhere than it begins: a hand goes there as fast as it may, {} from "
             "{:.2f} to {:.2f}\n",
             joint_names[worst], last[worst], first[worst]);
}

void waitForListeners(const SampleWriter& writer, const Interruption& interruption) {
  const PlayTime give_up = std::chrono::steady_clock::now() + kListenersPatience;
  while (writer.listeners() == 0 && std::chrono::steady_clock::now() < give_up &&
         !interruption.requested())
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  if (writer.listeners() > 0) return;
  fmt::print(stderr, "nobody listens on {} yet: is there a handgraft-bridge?\n",
             writer.topic());
}

}  // namespace

int run(const MotionPlayOptions& options,
        const CommonOptions& common,
        Interruption& interruption) {
  Client server(interactiveClient(common.network, Absence::kFail, interruption));
  const std::uint64_t session_id = sessionMeant(server, options.session_id);
  const v1::SessionState session = server.describeSession(session_id).get();
  PlayedMotion way(server, session);
  SampleWriter writer(*server.participant(),
                      options.topic.empty() ? idl::sampleTopicName(session_id) : options.topic,
                      session.joint_names());
  waitForListeners(writer, interruption);

  PlayTime now = std::chrono::steady_clock::now();
  const PlayTime begin = now;
  const auto period = std::chrono::duration_cast<PlayTime::duration>(
      std::chrono::duration<double>(1.0 / options.rate_hz));
  const auto lead_in = std::chrono::duration_cast<PlayTime::duration>(
      std::chrono::duration<double>(options.lead_in_s));
  PlayClock clock(way.duration());
  clock.setSpeed(options.speed, now);
  clock.setLooping(options.loops, now);
  clock.seek(options.from_s, now);
  if (options.loops) warnOfSeam(way, session.joint_names(), now);
  if (!options.paused) clock.play(begin + lead_in);
  tell(clock, now, common.json);

  StandardInput input;
  std::uint64_t samples = 0;
  bool goes_on = true;
  bool was_playing = true;
  while (goes_on && !interruption.requested()) {
    now = std::chrono::steady_clock::now();
    if (const std::string edited = way.takeEdits(now); !edited.empty())
      fmt::print(stderr, "{}\n", edited);
    const bool leads_in = now - begin < lead_in;  // the hand goes to where the motion begins
    for (std::string line; goes_on && input.line(line);) {
      try {
        goes_on = obey(line, clock, now);
        tell(clock, now, common.json);
      } catch (const InvalidInput& error) {
        fmt::print(stderr, "{}\n", error.what());  // what plays goes on
      }
    }
    const bool plays = clock.isPlaying(now);
    if (leads_in || plays || was_playing) {
      writer.write(way.at(clock.at(now), now), std::chrono::system_clock::now());
      ++samples;
    }
    const bool has_ended = !leads_in && !plays && clock.at(now) >= clock.duration();
    if (has_ended && !options.stays) break;
    was_playing = leads_in || plays;
    if (!server.alive()) {
      throw NoServer(fmt::format("handgraft-server on {} stopped answering",
                                 handgraft::describe(common.network)));
    }
    // By absolute deadlines: late ones are not made up for.
    const auto passed = (std::chrono::steady_clock::now() - begin) / period;
    std::this_thread::sleep_until(begin + (passed + 1) * period);
  }
  const double spent_s = std::chrono::duration<double>(now - begin).count();
  if (common.json) {
    fmt::print("{}\n", json::written({{"session_id", session_id},
                                      {"topic", writer.topic()},
                                      {"duration_s", way.duration()},
                                      {"rate_hz", options.rate_hz},
                                      {"samples", samples},
                                      {"listeners", writer.listeners()},
                                      {"spent_s", spent_s},
                                      {"time_s", clock.at(now)}},
                                     2));
  } else {
    fmt::print("{} samples in {:.2f} s on {}, up to {:.2f} of {:.2f} s\n", samples, spent_s,
               writer.topic(), clock.at(now), way.duration());
  }
  return 0;
}

}  // namespace handgraft::client
