#include "client/present/motion_output.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "client/present/joint_unit.h"
#include "client/present/text_output.h"

namespace handgraft::client {

namespace {

using Rows = std::vector<std::vector<std::string>>;

/// "0.00-1.25, 1.90", or "never"; what is more than three is counted.
std::string spansText(const std::vector<MotionSpan>& spans) {
  constexpr std::size_t kMostShown = 3;
  if (spans.empty()) return "never";
  std::string text;
  for (std::size_t i = 0; i < std::min(spans.size(), kMostShown); ++i) {
    const std::string begin = fmt::format("{:.2f}", spans[i].begin_s);
    const std::string end = fmt::format("{:.2f}", spans[i].end_s);
    text += fmt::format("{}{}{}", i == 0 ? "" : ", ", begin, begin == end ? "" : "-" + end);
  }
  if (spans.size() > kMostShown) text += fmt::format(", {} more", spans.size() - kMostShown);
  return text;
}

/// The joint that is fastest, and when.
std::string fastestText(const MotionResult& result) {
  double largest = -1.0;
  std::size_t joint = 0;
  double time_s = 0.0;
  for (std::size_t k = 1; k < result.frames.size(); ++k) {
    const std::vector<double>& now = result.frames[k].joint_positions();
    const std::vector<double>& before = result.frames[k - 1].joint_positions();
    for (std::size_t i = 0; i < now.size(); ++i) {
      const double step = std::abs(now[i] - before[i]);
      if (step <= largest) continue;
      largest = step;
      joint = i;
      time_s = result.frames[k].time_s();
    }
  }
  if (largest <= 0.0) return "";
  return fmt::format(" ({} at {:.2f} s)", text::plain(result.hand.joints()[joint].name()),
                     time_s);
}

/// The joints that stand at limits, most often first.
std::string limitsText(const MotionResult& result) {
  constexpr std::size_t kMostShown = 6;
  std::map<std::string, int> counts;
  for (const v1::MotionFrame& frame : result.frames)
    for (const v1::JointLimit& limit : frame.joints_at_limit())
      ++counts[fmt::format("{} {}", text::plain(limit.joint()),
                           limit.side() == v1::LIMIT_UPPER ? "upper" : "lower")];
  if (counts.empty()) return "joints at limits: none\n";
  std::vector<std::pair<std::string, int>> order(counts.begin(), counts.end());
  std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    return a.second > b.second;
  });
  std::string line = "joints at limits:";
  for (std::size_t i = 0; i < std::min(order.size(), kMostShown); ++i) {
    line += fmt::format("{} {} ({:.0f} %)", i == 0 ? "" : ",", order[i].first,
                        100.0 * order[i].second / static_cast<double>(result.frames.size()));
  }
  if (order.size() > kMostShown) line += fmt::format(" and {} more", order.size() - kMostShown);
  return line + " of the frames\n";
}

/// When a patch is there, by the motion itself: it may be so in several places at once.
std::vector<MotionSpan> spansOf(const v1::MotionDescription& motion, const std::string& patch) {
  std::vector<MotionSpan> there;
  for (const v1::PresenceInfo& presence : motion.presence())
    if (presence.patch() == patch) there.push_back({presence.begin_s(), presence.end_s()});
  std::sort(there.begin(), there.end(), [](const MotionSpan& a, const MotionSpan& b) {
    return a.begin_s < b.begin_s;
  });
  std::vector<MotionSpan> spans;
  for (const MotionSpan& span : there) {
    if (!spans.empty() && span.begin_s <= spans.back().end_s)
      spans.back().end_s = std::max(spans.back().end_s, span.end_s);
    else
      spans.push_back(span);
  }
  return spans;
}

/// When a patch is there, as a bar of so many letters over the whole time.
std::string barText(const v1::MotionDescription& motion, const std::string& patch) {
  constexpr std::size_t kLetters = 50;
  std::string bar(kLetters, '.');
  const double frames = motion.frame_count();
  for (const v1::PresenceInfo& presence : motion.presence()) {
    if (presence.patch() != patch) continue;
    const auto begin = static_cast<std::size_t>(presence.begin() / frames * kLetters);
    const auto end = static_cast<std::size_t>(std::ceil(presence.end() / frames * kLetters));
    for (std::size_t i = begin; i < std::min(std::max(end, begin + 1), kLetters); ++i)
      bar[i] = '#';
  }
  return bar;
}

json::Json spansJson(const std::vector<MotionSpan>& spans) {
  json::Json list = json::Json::array();
  for (const MotionSpan& span : spans)
    list.push_back({span.begin_s, span.end_s});
  return list;
}

json::Json finiteOrNull(double value) {
  return std::isfinite(value) ? json::Json(value) : json::Json(nullptr);
}

std::string cellText(double value) {
  return std::isfinite(value) ? fmt::format("{:.6g}", value) : "";
}

std::string patchTable(const MotionResult& result) {
  Rows rows = {
      {"patch", "mean mm", "worst mm", "normal deg", "reached", "there s", "reached s"}};
  for (const PatchOverTime& patch : patchesOf(result)) {
    if (patch.frames == 0) {  // left out of the hand's frames, or not in the motion either
      rows.push_back({text::plain(patch.name), "-", "-", "-", "-",
                      spansText(spansOf(result.motion, patch.name)), spansText({})});
      continue;
    }
    rows.push_back({text::plain(patch.name), fmt::format("{:.2f}", patch.mean_mm),
                    fmt::format("{:.2f}", patch.worst_mm),
                    fmt::format("{:.1f}", patch.normal_deg),
                    fmt::format("{:.0f} %", 100.0 * patch.frames_reached / patch.frames),
                    spansText(patch.there), spansText(patch.reached)});
  }
  return text::table(rows, "lrrrrl");
}

std::string reachedOverTime(const MotionResult& result) {
  int touching = 0;
  int reaching = 0;
  for (const FrameMeasure& measure : measuresOf(result)) {
    touching += measure.patches > 0 ? 1 : 0;
    reaching += measure.patches > 0 && measure.reached == measure.patches ? 1 : 0;
  }
  std::string left_out;
  for (const PatchOverTime& patch : patchesOf(result)) {
    if (patch.frames > 0 || spansOf(result.motion, patch.name).empty()) continue;
    left_out += (left_out.empty() ? "" : ", ") + text::plain(patch.name);
  }
  return fmt::format("{} frame{} touch{}, in {} every patch is reached{}", touching,
                     touching == 1 ? "" : "s", touching == 1 ? "es" : "", reaching,
                     left_out.empty() ? "" : ", " + left_out + " left out");
}

/// When a frame's `depth_of` is largest.
template <class DepthOf>
std::string deepestText(const MotionResult& result, const DepthOf& depth_of) {
  const auto deepest =
      std::max_element(result.frames.begin(), result.frames.end(),
                       [&](const v1::MotionFrame& a, const v1::MotionFrame& b) {
                         return depth_of(a) < depth_of(b);
                       });
  return depth_of(*deepest) > 0.0
             ? fmt::format("{:.2f} mm at {:.2f} s", 1e3 * depth_of(*deepest), deepest->time_s())
             : "never";
}

std::string insideText(const MotionResult& result) {
  return fmt::format("inside the object: {}\ninside itself: {}\n",
                     deepestText(result,
                                 [](const v1::MotionFrame& frame) {
                                   return frame.max_depth_m();
                                 }),
                     deepestText(result, [](const v1::MotionFrame& frame) {
                       return frame.self_depth_m();
                     }));
}

/// The last frame that is not behind `time_s`.
const v1::MotionFrame& frameAt(const MotionResult& result, double time_s) {
  const auto behind = std::upper_bound(result.frames.begin(), result.frames.end(), time_s,
                                       [](double time, const v1::MotionFrame& frame) {
                                         return time < frame.time_s();
                                       });
  return behind == result.frames.begin() ? *behind : *(behind - 1);
}

}  // namespace

namespace text {

std::string motion(const v1::MotionDescription& motion) {
  const double frames = motion.frame_count();
  std::string out = fmt::format("motion {} on {}: {} frame{} in {:.2f} s", plain(motion.name()),
                                plain(motion.object()), motion.frame_count(),
                                motion.frame_count() == 1 ? "" : "s", motion.duration_s());
  if (motion.duration_s() > 0.0)
    out += fmt::format(", {:.4g} a second", (frames - 1.0) / motion.duration_s());
  if (motion.demonstrator() != v1::CHIRALITY_UNKNOWN)
    out += fmt::format("\ntouched by a {} hand", nameOf(motion.demonstrator()));
  out += "\n\n";
  Rows rows = {{"patch", "there s", fmt::format("0 to {:.2f} s", motion.duration_s())}};
  for (const std::string& patch : motion.patches())
    rows.push_back({plain(patch), spansText(spansOf(motion, patch)), barText(motion, patch)});
  return out + table(rows, "l") + notes(motion.notes());
}

std::string motion(const MotionResult& result) {
  const v1::MotionSummary& summary = result.summary;
  std::string out = fmt::format(
      "{} follows {} on {}: {} frames in {:.2f} s, {}\n\n", plain(result.session.hand()),
      plain(result.motion.name()), plain(result.session.object()), summary.frame_count(),
      summary.duration_s(), summary.options().causal() ? "causal" : "offline");
  out += patchTable(result);
  out += fmt::format("\nall in all {:.2f} mm and {:.1f} deg off in the mean; {}\n",
                     summary.mean_mm(), summary.normal_deg(), reachedOverTime(result));
  out += insideText(result);
  const JointUnit unit = unitOfLargest(result.hand);
  out += fmt::format(
      "joints: largest step {:.3g}{}, velocity {:.3g}, acceleration {:.3g}, RMS jerk {:.3g} "
      "({}; s)\n",
      unit.scale * summary.max_step(), fastestText(result), unit.scale * summary.max_velocity(),
      unit.scale * summary.max_acceleration(), unit.scale * summary.rms_jerk(), unit.name);
  out += limitsText(result);
  out += notes(summary.notes());
  out += fmt::format("time: solve {:.0f} ms, {:.2f} ms a frame; ", summary.solve_ms(),
                     summary.solve_ms() / std::max(1U, summary.frame_count()));
  if (result.files_ms > 0.0)
    out += fmt::format("files and pictures {:.0f} ms; ", result.files_ms);
  out += fmt::format("all in all {:.0f} ms\n", result.total_ms + result.files_ms);
  return out;
}

std::string motionFit(const MotionResult& result) {
  return patchTable(result) + "\n" + reachedOverTime(result) + "\n" + insideText(result) +
         limitsText(result);
}

std::string motionFrame(const MotionResult& result, double time_s) {
  const v1::MotionFrame& frame = frameAt(result, time_s);
  Rows rows = {{"patch", "mean mm", "normal deg", "there", "reached"}};
  for (const v1::FramePatch& patch : frame.patches()) {
    constexpr double kFaded = 0.005;
    if (patch.presence() < kFaded) continue;
    rows.push_back(
        {plain(result.motion.patches()[patch.patch()]), fmt::format("{:.2f}", patch.mean_mm()),
         fmt::format("{:.1f}", patch.normal_deg()),
         fmt::format("{:.0f} %", 100.0 * patch.presence()), patch.reached() ? "yes" : "no"});
  }
  return fmt::format("frame {} at {:.3f} s{}\n", frame.index(), frame.time_s(),
                     frame.patches().empty() ? ": no contact" : "") +
         (frame.patches().empty() ? "" : table(rows, "lrrrl")) +
         fmt::format(
             "inside the object: {:.2f} mm\ninside itself: {:.2f} mm\njoints at limits: {}\n",
             1e3 * frame.max_depth_m(), 1e3 * frame.self_depth_m(),
             frame.joints_at_limit().empty() ? "none"
                                             : listed(limitNames(frame.joints_at_limit())));
}

}  // namespace text

namespace json {

Json motionFit(const MotionResult& result) {
  Json fit = {{"patches", Json::array()}};
  for (const PatchOverTime& patch : patchesOf(result)) {
    fit["patches"].push_back({{"name", patch.name},
                              {"frames", patch.frames},
                              {"frames_reached", patch.frames_reached},
                              {"mean_mm", patch.mean_mm},
                              {"worst_mm", patch.worst_mm},
                              {"normal_deg", patch.normal_deg},
                              {"there_s", spansJson(patch.there)},
                              {"reached_s", spansJson(patch.reached)}});
  }
  const std::vector<FrameMeasure> measures = measuresOf(result);
  fit["frames_touching"] =
      std::count_if(measures.begin(), measures.end(), [](const FrameMeasure& measure) {
        return measure.patches > 0;
      });
  return fit;
}

Json motionFrame(const MotionResult& result, double time_s) {
  Json frame = jsonOf(frameAt(result, time_s));
  for (const char* empty : {"bodies", "X_WL"})
    frame.erase(empty);
  for (Json& patch : frame["patches"]) {
    patch["name"] = result.motion.patches()[patch.at("patch").get<std::size_t>()];
    for (const char* empty : {"outline_O_m", "hand_W_m"})
      patch.erase(empty);
  }
  return frame;
}

Json motion(const MotionResult& result) {
  Json document = jsonOf(result.summary);
  if (!result.kept) document["session_id"] = nullptr;
  document["hand"] = result.session.hand();
  document["object"] = result.session.object();
  document["motion"] = result.motion.name();
  document["total_ms"] = result.total_ms;
  document["files_ms"] = result.files_ms;
  document["joint_names"] = Json::array();
  for (const v1::JointInfo& joint : result.hand.joints())
    document["joint_names"].push_back(joint.name());
  document.update(motionFit(result));
  const std::vector<FrameMeasure> measures = measuresOf(result);
  document["frames"] = Json::array();
  for (std::size_t k = 0; k < result.frames.size(); ++k) {
    Json frame = jsonOf(result.frames[k]);
    frame.erase("bodies");
    frame.erase("X_WL");
    for (Json& patch : frame["patches"]) {
      patch.erase("outline_O_m");
      patch.erase("hand_W_m");
    }
    frame["mean_mm"] = finiteOrNull(measures[k].mean_mm);
    frame["normal_deg"] = finiteOrNull(measures[k].normal_deg);
    frame["velocity"] = finiteOrNull(measures[k].velocity);
    frame["acceleration"] = finiteOrNull(measures[k].acceleration);
    frame["jerk"] = finiteOrNull(measures[k].jerk);
    document["frames"].push_back(std::move(frame));
  }
  return document;
}

}  // namespace json

std::string frameTable(const MotionResult& result) {
  std::string text =
      "time_s,mean_mm,normal_deg,patches,reached,depth_mm,self_depth_mm,velocity,acceleration,"
      "jerk,joints_at_limit\n";
  const std::vector<FrameMeasure> measures = measuresOf(result);
  for (std::size_t k = 0; k < result.frames.size(); ++k) {
    const v1::MotionFrame& frame = result.frames[k];
    const FrameMeasure& measure = measures[k];
    fmt::format_to(std::back_inserter(text), "{:.9g},{},{},{},{},{:.6g},{:.6g},{},{},{},{}\n",
                   frame.time_s(), cellText(measure.mean_mm), cellText(measure.normal_deg),
                   measure.patches, measure.reached, 1e3 * frame.max_depth_m(),
                   1e3 * frame.self_depth_m(), cellText(measure.velocity),
                   cellText(measure.acceleration), cellText(measure.jerk),
                   frame.joints_at_limit().size());
  }
  return text;
}

}  // namespace handgraft::client
