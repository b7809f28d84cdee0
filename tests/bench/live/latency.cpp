// One edit after another, each waited for.
#include <map>
#include <string>
#include <vector>

#include "tests/bench/live/commands.h"
#include "tests/bench/live/live_report.h"

namespace handgraft::bench {

void latency(const LiveOptions& options) {
  Room room(options);
  const std::uint64_t session = room.openSolved();
  RandomEdits random = room.edits(session, options.seed);
  std::map<std::string, std::vector<double>> by_kind;
  std::map<std::string, std::vector<double>> shares;
  std::map<std::string, long> refused;
  const double processor_before = room.processorSeconds();
  int lost = 0;
  for (int i = 0; i < options.edits; ++i) {
    const v1::EditBody body = random.next();
    const std::uint64_t edit = room.client().send(session, body);
    const EditFate fate = room.client().await(session, edit, std::chrono::seconds(5));
    if (fate.error != v1::ERROR_NONE) {
      ++refused[fate.message];
      continue;
    }
    if (!fate.solved) {
      ++lost;
      continue;
    }
    by_kind[random.kind()].push_back(fate.solution_ms);
    by_kind["all"].push_back(fate.solution_ms);
    double known = fate.back_ms;
    shares["answer to the edit"].push_back(fate.reply_ms);
    shares["solution's way back"].push_back(fate.back_ms);
    for (const auto& [stage, ms] : fate.stages_ms) {
      if (stage == "skin") continue;
      shares[stage].push_back(ms);
      known += ms;
    }
    shares["edit's way, queue, rest"].push_back(fate.solution_ms - known);
  }
  LiveReport report("latency");
  report.begin("edit to final, ms");
  for (const auto& [kind, values] : by_kind)
    report.times(kind, values);
  report.begin("shares, ms");
  for (const auto& [share, values] : shares)
    report.times(share, values);
  report.figure("server's processor time an edit",
                1e3 * (room.processorSeconds() - processor_before) / options.edits, "ms");
  report.figure("lost", lost);
  report.counts("refused", refused);
  report.print(options.json);
}

}  // namespace handgraft::bench
