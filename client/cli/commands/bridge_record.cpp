#include <chrono>
#include <fstream>
#include <iterator>
#include <optional>

#include <fmt/format.h>

#include "client/cli/commands/bridge_link.h"
#include "client/cli/commands/bridge_run.h"
#include "client/cli/commands/commands.h"
#include "client/present/interruption.h"
#include "client/present/output_file.h"
#include "client/present/png_file.h"
#include "core/base/error.h"
#include "idl/topics.h"

namespace handgraft::client {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kPatience(5);  // for the first sample

void say(const BridgeRun& run, const CommonOptions& common, const std::string& path) {
  if (common.json) {
    fmt::print("{{\"samples\": {}, \"joints\": {}, \"seconds\": {:.6f}}}\n", run.size(),
               run.joints.size(), run.time_s.back());
  } else {
    fmt::print("{} samples of {} joints over {:.1f} s{}\n", run.size(), run.joints.size(),
               run.time_s.back(), path.empty() ? "" : " in " + path);
  }
}

}  // namespace

int run(const BridgeRecordOptions& options,
        const CommonOptions& common,
        Interruption& interruption) {
  requireSafe({{"--out", options.out}, {"--png", options.png}}, {});
  BridgeLink link(common.network, interruption);
  const std::uint32_t id = link.one(options.bridge_id).bridge_id();
  idl::cyclone::Reader<v1::JointState> states(link.participant(), idl::kJointStateTopic);
  BridgeRun run;
  const Clock::time_point start = Clock::now();
  std::optional<Clock::time_point> first;  // the run begins when something is told
  const auto is_over = [&] {
    const bool is_long =
        first && Clock::now() - *first > std::chrono::duration<double>(options.seconds);
    return interruption.requested() || (options.seconds > 0 && is_long);
  };
  while (!is_over()) {
    states.wait(std::chrono::milliseconds(20));
    states.take([&](const v1::JointState& sample) {
      if (sample.bridge_id() == id) run.add(sample);
    });
    if (!first && run.size() > 0) first = Clock::now();
    if (!first && Clock::now() - start > kPatience)
      throw TransportError(fmt::format("bridge {} measures no hand yet", id));
  }
  if (run.size() == 0) throw TransportError(fmt::format("bridge {} told nothing", id));
  writeFile(options.out, toCsv(run));
  if (!options.png.empty()) writePng(options.png, drawRun(run));
  say(run, common, options.out.string());
  return 0;
}

int run(const BridgePlotOptions& options,
        const CommonOptions& common,
        Interruption& /*interruption*/) {
  requireSafe({{"--out", options.out}}, {{"the run", options.run}});
  std::ifstream file(options.run, std::ios::binary);
  if (!file) rejectInput("{} cannot be read", quoted(options.run.string()));
  const std::string csv{std::istreambuf_iterator<char>(file), {}};
  BridgeRun recorded;
  try {
    recorded = bridgeRunOf(csv);
    if (recorded.size() == 0) rejectInput("line 2: there are no samples");
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", quoted(options.run.string()), error.what());
  }
  if (recorded.cut_line != 0) {
    fmt::print(stderr, "handgraft: {}: line {} is cut off, and left out\n",
               quoted(options.run.string()), recorded.cut_line);
  }
  writePng(options.out, drawRun(recorded));
  say(recorded, common, "");
  return 0;
}

}  // namespace handgraft::client
