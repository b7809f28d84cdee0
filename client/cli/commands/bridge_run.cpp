#include "client/cli/commands/bridge_run.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>

#include "client/present/render/plot.h"
#include "core/base/error.h"
#include "core/base/quoting.h"
#include "idl/fields.h"

namespace handgraft::client {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kKinds[] = {"measured", "command", "target", "residual"};
constexpr std::size_t kKindCount = 4;

std::vector<double> rowOf(const std::vector<double>& told, std::size_t joints) {
  return told.size() == joints ? told : std::vector<double>(joints, kNaN);
}

std::vector<std::string> fieldsOf(const std::string& line, std::size_t number) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (is_quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += line[++i];
    } else if (c == '"') {
      is_quoted = !is_quoted;
    } else if (c == ',' && !is_quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  if (is_quoted) rejectInput("line {}: a quotation mark is not closed", number);
  return fields;
}

double numberOf(const std::string& field, std::size_t line) {
  if (field.empty()) return kNaN;
  double value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size() || !std::isfinite(value))
    rejectInput("line {}: {} is no number", line, quoted(field));
  return value;
}

std::vector<std::string> linesOf(const std::string& csv) {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  while (begin < csv.size()) {
    const std::size_t end = std::min(csv.find('\n', begin), csv.size());
    lines.push_back(csv.substr(begin, end - begin));
    if (!lines.back().empty() && lines.back().back() == '\r') lines.back().pop_back();
    begin = end + 1;
  }
  return lines;
}

const char* unitOf(bool slides) {
  return slides ? "m" : "rad";
}

/// Of the heading, into `run`.
void readJoints(const std::string& heading, BridgeRun& run) {
  const std::vector<std::string> fields = fieldsOf(heading, 1);
  const bool is_ours = fields.size() > 2 && fields[0] == "time_s" && fields[1] == "state" &&
                       (fields.size() - 2) % kKindCount == 0;
  if (!is_ours) rejectInput("line 1: it is not the heading of a bridge's run");
  for (std::size_t i = 2; i < fields.size(); ++i) {
    const bool is_next = (i - 2) % kKindCount == 0;
    const std::string kind = std::string(" ") + kKinds[(i - 2) % kKindCount] + "_";
    const bool slides = fields[i].ends_with(kind + unitOf(true));
    const std::string ending = kind + unitOf(slides);
    const bool ends = fields[i].size() > ending.size() && fields[i].ends_with(ending);
    const std::string joint = ends ? fields[i].substr(0, fields[i].size() - ending.size()) : "";
    if (!ends || (!is_next && (joint != run.joints.back() || slides != run.slides.back())))
      rejectInput("line 1: column {} is {}, not a joint's{}", i + 1, quoted(fields[i]), ending);
    if (!is_next) continue;
    run.joints.push_back(joint);
    run.slides.push_back(slides);
  }
}

std::vector<double> columnOf(const std::vector<std::vector<double>>& rows, std::size_t joint) {
  std::vector<double> column;
  column.reserve(rows.size());
  for (const std::vector<double>& row : rows)
    column.push_back(row[joint]);
  return column;
}

double spanOf(const std::vector<double>& values) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  return high > low ? high - low : 0;
}

// The largest |command - measured| of all joints of that kind; NaN without power.
std::vector<double> trackingOf(const BridgeRun& run, bool slides) {
  std::vector<double> tracking;
  for (std::size_t k = 0; k < run.size(); ++k) {
    double worst = kNaN;
    for (std::size_t i = 0; i < run.joints.size(); ++i) {
      if (run.slides[i] != slides) continue;
      const double off = std::abs(run.command[k][i] - run.measured[k][i]);
      if (std::isfinite(off)) worst = std::isfinite(worst) ? std::max(worst, off) : off;
    }
    tracking.push_back(worst);
  }
  return tracking;
}

}  // namespace

bool BridgeRun::add(const v1::JointState& sample) {
  if (sample.names().empty()) return false;
  if (size() == 0) {
    joints = sample.names();
    for (const std::string& joint : joints) {
      const std::vector<std::string>& sliding = sample.sliding();
      slides.push_back(std::find(sliding.begin(), sliding.end(), joint) != sliding.end());
    }
    first_ns_ = sample.stamp_ns();
  } else if (joints != sample.names() || sample.stamp_ns() <= last_ns_) {
    return false;
  }
  last_ns_ = sample.stamp_ns();
  time_s.push_back(static_cast<double>(last_ns_ - first_ns_) * 1e-9);
  state.emplace_back(v1::nameOf(sample.state()));
  measured.push_back(rowOf(sample.position(), joints.size()));
  command.push_back(rowOf(sample.command(), joints.size()));
  target.push_back(rowOf(sample.target(), joints.size()));
  residual.push_back(rowOf(sample.residual(), joints.size()));
  return true;
}

std::string toCsv(const BridgeRun& run) {
  std::string csv = "time_s,state";
  for (std::size_t i = 0; i < run.joints.size(); ++i) {
    for (const char* kind : kKinds)
      csv += "," + csvCell(fmt::format("{} {}_{}", run.joints[i], kind, unitOf(run.slides[i])));
  }
  csv += "\n";
  for (std::size_t k = 0; k < run.size(); ++k) {
    csv += fmt::format("{:.6f},{}", run.time_s[k], csvCell(run.state[k]));
    for (std::size_t i = 0; i < run.joints.size(); ++i) {
      for (const auto* rows : {&run.measured, &run.command, &run.target, &run.residual}) {
        const double value = (*rows)[k][i];
        csv += std::isfinite(value) ? fmt::format(",{:.6f}", value) : ",";
      }
    }
    csv += "\n";
  }
  return csv;
}

BridgeRun bridgeRunOf(const std::string& csv) {
  std::vector<std::string> lines = linesOf(csv);
  if (lines.empty()) rejectInput("line 1: it is empty");
  BridgeRun run;
  readJoints(lines.front(), run);
  if (lines.size() > 1 && csv.back() != '\n') {
    run.cut_line = lines.size();
    lines.pop_back();
  }
  for (std::size_t n = 1; n < lines.size(); ++n) {
    const std::vector<std::string> fields = fieldsOf(lines[n], n + 1);
    const std::size_t wanted = 2 + kKindCount * run.joints.size();
    if (fields.size() != wanted)
      rejectInput("line {}: {} columns, of {}", n + 1, fields.size(), wanted);
    run.time_s.push_back(numberOf(fields[0], n + 1));
    run.state.push_back(fields[1]);
    std::size_t kind = 0;
    for (auto* rows : {&run.measured, &run.command, &run.target, &run.residual}) {
      std::vector<double> row;
      for (std::size_t i = 0; i < run.joints.size(); ++i)
        row.push_back(numberOf(fields[2 + kKindCount * i + kind], n + 1));
      rows->push_back(std::move(row));
      ++kind;
    }
  }
  return run;
}

render::Image drawRun(const BridgeRun& run, std::size_t most) {
  if (run.size() == 0) rejectInput("a run without samples cannot be drawn");
  std::vector<std::size_t> order(run.joints.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::vector<double> spans;
  spans.reserve(order.size());
  // As far as it takes a fingertip that is that far from its joint.
  constexpr double kFinger_m = 0.1;
  for (const std::size_t i : order)
    spans.push_back(spanOf(columnOf(run.measured, i)) / (run.slides[i] ? kFinger_m : 1.0));
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return spans[a] > spans[b];
  });
  order.resize(std::min(order.size(), most));

  render::Plot plot;
  plot.title = "Commanded and measured";
  plot.subtitle =
      fmt::format("{} of {} joints, those that moved most", order.size(), run.joints.size());
  plot.x_label = "time (s)";
  const auto line = [&](const std::vector<double>& y, std::size_t color, double width,
                        const char* name) {
    render::PlotLine drawn;
    drawn.x = run.time_s;
    drawn.y = y;
    drawn.color = render::plotColor(color);
    drawn.width = width;
    drawn.name = name;
    return drawn;
  };
  for (const std::size_t i : order) {
    render::PlotPanel panel;
    panel.label = fmt::format("{} ({})", run.joints[i], unitOf(run.slides[i]));
    panel.lines = {line(columnOf(run.target, i), 2, 1.5, "target"),
                   line(columnOf(run.command, i), 1, 3.0, "commanded"),
                   line(columnOf(run.measured, i), 0, 1.5, "measured")};
    plot.panels.push_back(std::move(panel));
  }
  for (const bool slides : {false, true}) {
    if (std::find(run.slides.begin(), run.slides.end(), slides) == run.slides.end()) continue;
    render::PlotPanel tracking;
    tracking.label = fmt::format("largest off ({})", unitOf(slides));
    tracking.lines = {line(trackingOf(run, slides), 3, 2.0, "|commanded - measured|")};
    plot.panels.push_back(std::move(tracking));
  }
  return render::drawPlot(plot);
}

}  // namespace handgraft::client
