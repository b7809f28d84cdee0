// One session flooded, another one edited calmly.
#include <map>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "tests/bench/live/commands.h"
#include "tests/bench/live/live_report.h"

namespace handgraft::bench {

using std::chrono::milliseconds;
using std::chrono::seconds;

void pour(const LiveOptions& options) {
  EditClient client(Network{options.domain, "lo"});
  if (!client.requester().waitForServer(seconds(60))) throw std::runtime_error("no server");
  std::this_thread::sleep_for(seconds(1));  // for the edits' own discovery
  v1::EditBody body;
  v1::PatchWeightEdit edit;
  edit.patch(options.patch);
  const auto begin = Clock::now();
  long sent = 0;
  long timeouts = 0;
  while (Clock::now() - begin < seconds(options.seconds)) {
    const double due =
        options.rate * std::chrono::duration<double>(Clock::now() - begin).count();
    for (; static_cast<double>(sent) < due; ++sent) {
      edit.weight(1.0 + 1e-5 * static_cast<double>(sent % 50'000));  // each is another one
      body.patch_weight(edit);
      try {
        client.send(options.session, body);
      } catch (const idl::cyclone::WriteTimeout&) {
        ++timeouts;
      }
    }
    std::this_thread::sleep_for(milliseconds(1));
  }
  const double took_s = std::chrono::duration<double>(Clock::now() - begin).count();
  std::this_thread::sleep_for(seconds(2));
  std::map<std::string, long> fates;
  for (const EditFate& fate : client.fates(options.session)) {
    ++fates[!fate.answered                 ? "unanswered"
            : fate.error != v1::ERROR_NONE ? "refused: " + fate.message
            : fate.shared                  ? "applied, solved with a later one"
            : fate.solved                  ? "applied and solved"
                                           : "applied, no solution came"];
  }
  LiveReport report("pour");
  report.figure("sent", static_cast<double>(sent));
  report.figure("edits took", took_s, "s");
  report.figure("edits that the writer could not pass on", static_cast<double>(timeouts));
  report.counts("became", fates);
  report.print(options.json);
}

void flood(const LiveOptions& options) {
  constexpr int kRate = 10'000;
  Room room(options);
  const std::uint64_t calm = room.openSolved();
  const std::uint64_t flooded = room.openSolved();
  RandomEdits calm_edits = room.edits(calm, options.seed);
  long lost = 0;
  const auto calmly = [&](int count) {
    std::vector<double> times;
    for (int i = 0; i < count; ++i) {
      const auto edit = room.client().send(calm, calm_edits.next());
      const EditFate fate = room.client().await(calm, edit, seconds(5));
      if (fate.solved) times.push_back(fate.solution_ms);
      if (!fate.answered || (fate.error == v1::ERROR_NONE && !fate.solved)) ++lost;
      std::this_thread::sleep_for(milliseconds(100));
    }
    return times;
  };
  const std::vector<double> before = calmly(30);
  const double memory_before = room.memoryKb();
  std::vector<std::string> arguments{"pour",
                                     "--domain",
                                     std::to_string(room.network().domain),
                                     "--session",
                                     std::to_string(flooded),
                                     "--patch",
                                     room.placedPatch(flooded),
                                     "--rate",
                                     std::to_string(kRate),
                                     "--seconds",
                                     std::to_string(options.seconds)};
  if (options.json) arguments.emplace_back("--json");
  test::Process wild("/proc/self/exe", arguments);
  std::vector<double> during;
  while (wild.running()) {
    const auto more = calmly(5);
    during.insert(during.end(), more.begin(), more.end());
  }
  const double memory_after = room.memoryKb();
  const std::vector<double> after = calmly(20);
  fmt::print("{}{}", wild.out(), wild.err());

  LiveReport report("flood");
  report.begin("calm session, ms");
  report.times("before", before);
  report.times("during", during);
  report.times("after", after);
  report.figure("calm edits lost", static_cast<double>(lost));
  report.figure("server lives", room.server().running() ? 1 : 0);
  report.figure("server's memory before", memory_before, "kB");
  report.figure("server's memory after", memory_after, "kB");
  report.print(options.json);
}

}  // namespace handgraft::bench
