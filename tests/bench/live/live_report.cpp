#include "tests/bench/live/live_report.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include <fmt/format.h>

#include "tests/bench/timing.h"

namespace handgraft::bench {

void LiveReport::begin(const std::string& block) {
  block_ = block;
  text_ += fmt::format("\n{:<28} {:>7} {:>9} {:>9} {:>9} {:>9}\n", block, "count", "p50", "p90",
                       "p99", "max");
}

void LiveReport::times(const std::string& what, const std::vector<double>& ms) {
  if (ms.empty()) return;
  const double p50 = quantile(ms, 0.5);
  const double p90 = quantile(ms, 0.9);
  const double p99 = quantile(ms, 0.99);
  const double most = *std::max_element(ms.begin(), ms.end());
  text_ += fmt::format("{:<28} {:>7} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f}\n", what, ms.size(),
                       p50, p90, p99, most);
  json_[block_][what] = {
      {"count", ms.size()}, {"p50", p50}, {"p90", p90}, {"p99", p99}, {"max", most}};
}

void LiveReport::figure(const std::string& what, double value, const std::string& unit) {
  const std::string shown = value == static_cast<double>(static_cast<long>(value))
                                ? fmt::format("{:.0f}", value)
                                : fmt::format("{:.2f}", value);
  text_ += fmt::format("{}: {}{}{}\n", what, shown, unit.empty() ? "" : " ", unit);
  json_[unit.empty() ? what : fmt::format("{}, {}", what, unit)] = value;
}

void LiveReport::counts(const std::string& what, const std::map<std::string, long>& of) {
  for (const auto& [each, count] : of) {
    text_ += fmt::format("{:>7} {}: {}\n", count, what, each);
    json_[what][each] = count;
  }
}

void LiveReport::print(bool as_json) const {
  // How busy the machine was: times on a busy one tell little.
  std::ifstream file("/proc/loadavg");
  double load = 0.0;
  file >> load;
  if (as_json) {
    nlohmann::ordered_json line;
    line["bench"] = name_;
    line["load"] = load;
    line.update(json_);
    fmt::print("{}\n", line.dump());
  } else {
    fmt::print("== {}, load {:.1f} at its end\n{}", name_, load, text_);
  }
}

}  // namespace handgraft::bench
