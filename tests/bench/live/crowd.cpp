// Many sessions at once.
#include <algorithm>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "tests/bench/live/commands.h"
#include "tests/bench/live/live_report.h"
#include "tests/bench/timing.h"

namespace handgraft::bench {

namespace {

/// What became of all edits of all sessions.
struct CrowdFates {
  std::vector<double> replies_ms;
  std::vector<double> medians_ms;  ///< a session
  std::vector<double> p99s_ms;     ///< likewise
  long solved = 0;
  long shared = 0;
  long unanswered = 0;
  long unsolved = 0;  ///< applied, and no final solution came
  std::map<std::string, long> refused;
};

CrowdFates fatesOf(EditClient& client, const std::vector<std::uint64_t>& sessions) {
  CrowdFates all;
  for (const std::uint64_t session : sessions) {
    std::vector<double> mine;
    for (const EditFate& fate : client.fates(session)) {
      if (!fate.answered) ++all.unanswered;
      if (fate.error != v1::ERROR_NONE) ++all.refused[fate.message];
      if (fate.answered) all.replies_ms.push_back(fate.reply_ms);
      if (fate.answered && fate.error == v1::ERROR_NONE && !fate.solved) ++all.unsolved;
      if (!fate.solved) continue;
      ++all.solved;
      all.shared += fate.shared ? 1 : 0;
      mine.push_back(fate.solution_ms);
    }
    all.medians_ms.push_back(quantile(mine, 0.5));
    all.p99s_ms.push_back(quantile(mine, 0.99));
  }
  return all;
}

}  // namespace

void crowd(const LiveOptions& options) {
  Room room(options);
  room.openSolved();  // the models are there
  const double before_kb = room.memoryKb();
  std::vector<std::uint64_t> sessions;
  std::vector<RandomEdits> random;
  for (int i = 0; i < options.sessions; ++i)
    sessions.push_back(room.open());
  const double open_kb = room.memoryKb();
  for (const std::uint64_t session : sessions) {
    room.solve(session);
    random.push_back(room.edits(session, options.seed + static_cast<unsigned>(session)));
  }
  const double solved_kb = room.memoryKb();
  const double processor_before = room.processorSeconds();
  const auto begin = Clock::now();
  const long count = static_cast<long>(options.sessions) * options.rate * options.seconds;
  const double step_s = 1.0 / (options.sessions * options.rate);
  for (long i = 0; i < count; ++i) {
    std::this_thread::sleep_until(
        begin + std::chrono::duration_cast<Clock::duration>(
                    std::chrono::duration<double>(static_cast<double>(i) * step_s)));
    const auto at = static_cast<std::size_t>(i % options.sessions);
    room.client().send(sessions[at], random[at].next());
  }
  const double took_s = std::chrono::duration<double>(Clock::now() - begin).count();
  std::this_thread::sleep_for(std::chrono::seconds(3));
  const double edited_kb = room.memoryKb();
  const double processor_s = room.processorSeconds() - processor_before;
  const CrowdFates fates = fatesOf(room.client(), sessions);
  for (const std::uint64_t session : sessions)
    room.client().ofSession(v1::OP_CLOSE_SESSION, session);
  const double closed_kb = room.memoryKb();

  LiveReport report("crowd");
  report.begin("edit to final, ms");
  report.times("answers to edits", fates.replies_ms);
  report.times("p50 of the sessions", fates.medians_ms);
  report.times("p99 of the sessions", fates.p99s_ms);
  report.figure("p99 of the slowest session, times the median's",
                *std::max_element(fates.p99s_ms.begin(), fates.p99s_ms.end()) /
                    quantile(fates.p99s_ms, 0.5));
  report.figure("sessions", options.sessions);
  report.figure("edits", static_cast<double>(count));
  report.figure("edits took", took_s, "s");
  report.figure("solved", static_cast<double>(fates.solved));
  report.figure("of these with a later one", static_cast<double>(fates.shared));
  report.figure("unanswered", static_cast<double>(fates.unanswered));
  report.figure("applied and never solved", static_cast<double>(fates.unsolved));
  report.counts("refused", fates.refused);
  report.figure("memory a session, open", (open_kb - before_kb) / options.sessions, "kB");
  report.figure("memory a session, solved", (solved_kb - before_kb) / options.sessions, "kB");
  report.figure("memory a session, edited", (edited_kb - before_kb) / options.sessions, "kB");
  report.figure("memory a session, closed", (closed_kb - before_kb) / options.sessions, "kB");
  report.figure("server's processor time an edit",
                1e3 * processor_s / static_cast<double>(count), "ms");
  report.print(options.json);
}

}  // namespace handgraft::bench
