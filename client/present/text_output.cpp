#include "client/present/text_output.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "client/link/client.h"
#include "client/link/model_files.h"
#include "client/present/joint_unit.h"
#include "client/present/transfer_text.h"
#include "core/base/error.h"
#include "core/base/utf8.h"
#include "idl/fields.h"
#include "idl/grasp_file.h"

namespace handgraft::client::text {

namespace {

using Rows = std::vector<std::vector<std::string>>;

std::string milliseconds(double value) {
  if (value >= 1000.0) return fmt::format("{:.2f} s", 1e-3 * value);
  return value < 10.0 ? fmt::format("{:.1f} ms", value) : fmt::format("{:.0f} ms", value);
}

}  // namespace

std::string plain(const std::string& text) {
  const std::string line = quoted(text);
  return line.substr(1, line.size() - 2);
}

std::string wrapped(const std::string& text) {
  constexpr std::size_t kWidth = 100;
  const std::string indent(4, ' ');
  std::string out;
  std::string line;
  std::string word;
  const auto end_word = [&] {
    if (word.empty()) return;
    if (line.find_first_not_of(' ') != std::string::npos) {
      if (columnsOf(line) + 1 + columnsOf(word) <= kWidth) {
        line += ' ';
      } else {
        out += line + "\n";
        line = indent;
      }
    }
    line += onOneLine(std::exchange(word, ""));
  };
  for (std::string_view rest = text; !rest.empty();) {
    const Character next = takeCharacter(rest);
    if (next.code == ' ' || isControl(next.code)) {
      end_word();
    } else {
      word += next.bytes;
    }
  }
  end_word();
  return out + line + "\n";
}

namespace {

/// Which angle the verdicts judge, where the table's could be taken for it.
std::string normalsLegend(const v1::PoseSolution& solution) {
  const bool puzzles = std::any_of(
      solution.patches().begin(), solution.patches().end(), [](const v1::PatchFit& patch) {
        const v1::Verdict verdict = patch.diagnosis().verdict();
        return verdict == v1::VERDICT_NORMALS_IN_CONFLICT ||
               (verdict == v1::VERDICT_REACHED && patch.normal_deg() > v1::REACHED_FACING_DEG);
      });
  if (!puzzles) return "";
  return fmt::format(
      "normal deg is the mean over a patch's points; judged is the angle between the mean "
      "normals of both sides, at most {:.0f} deg\n",
      v1::REACHED_FACING_DEG);
}

}  // namespace

std::string shortfalls(const v1::PoseSolution& solution) {
  std::string lines;
  for (const v1::PatchFit& patch : solution.patches()) {
    const v1::PatchDiagnosis& diagnosis = patch.diagnosis();
    if (diagnosis.verdict() == v1::VERDICT_REACHED || diagnosis.text().empty()) continue;
    lines += wrapped(fmt::format("{}: {}", patch.name(), diagnosis.text()));
  }
  return lines + normalsLegend(solution);
}

std::vector<std::string> limitNames(const std::vector<v1::JointLimit>& limits) {
  std::vector<std::string> names;
  names.reserve(limits.size());
  for (const v1::JointLimit& limit : limits)
    names.push_back(limit.joint() + " " + nameOf(limit.side()));
  return names;
}

std::string listed(const std::vector<std::string>& items) {
  std::string line;
  for (const std::string& item : items)
    line += (line.empty() ? "" : ", ") + plain(item);
  return line;
}

std::string notes(const std::vector<std::string>& notes) {
  std::string lines;
  for (const std::string& note : notes)
    lines += fmt::format("note: {}\n", onOneLine(note));  // all of it: advice comes last
  return lines;
}

namespace {

/// What penetration is charged for in a pose that is not seen to enter the object.
std::string chargedFor(const v1::PoseSolution& solution) {
  if (solution.penetration().empty() || solution.penetration()[0].max_depth_m() > 0.0)
    return "";
  return solution.penetration()[0].self_depth_m() > 0.0
             ? " for links in each other, and for margins"
             : " for margins: a hand that touches is kept a little off";
}

}  // namespace

std::string terms(const v1::PoseSolution& solution, const std::optional<v1::Weights>& weights) {
  const v1::Terms& terms = solution.terms();
  if (!weights) {
    return fmt::format("distance {:.4g} m2, normal {:.4g}, prior {:.4g}", terms.distance_m2(),
                       terms.normal(), terms.prior());
  }
  std::string line =
      fmt::format("distance {:g} x {:.4g} m2, normal {:g} x {:.4g}, prior {:g} x {:.4g}",
                  weights->distance(), terms.distance_m2(), weights->normal(), terms.normal(),
                  weights->prior(), terms.prior());
  if (const double charge = idl::penetrationCharge(terms, *weights); charge > 0.0)
    line += fmt::format(", penetration {:.4g}{}", charge, chargedFor(solution));
  return line;
}

std::string table(const Rows& rows, const std::string& alignment) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()), 0);
    for (std::size_t k = 0; k < row.size(); ++k)
      widths[k] = std::max(widths[k], columnsOf(row[k]));
  }
  std::string out;
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t k = 0; k < row.size(); ++k) {
      if (k > 0) line += "  ";
      const bool right =
          !alignment.empty() && alignment[std::min(k, alignment.size() - 1)] == 'r';
      const std::string padding(widths[k] - columnsOf(row[k]), ' ');
      line += right ? padding + row[k] : row[k] + padding;
    }
    line.erase(line.find_last_not_of(' ') + 1);
    out += line + "\n";
  }
  return out;
}

std::string doctor(const DoctorReport& report) {
  Rows rows = {{"handgraft", report.version},
               {"protocol", std::to_string(v1::PROTOCOL_VERSION)},
               {"interface", fmt::format("{} ({})", report.interface, report.address)},
               {"domain", std::to_string(report.domain)}};
  if (report.server) {
    const v1::ServerStatus& status = *report.server;
    rows.push_back(
        {"server",
         fmt::format("{}{} on {}, process {}, up {:.0f} s, found in {}",
                     status.name().empty() ? "" : plain(status.name()) + ", ",
                     plain(status.version()), plain(status.host()), status.process_id(),
                     status.uptime_s(), milliseconds(report.found_ms))});
    if (status.secured()) rows.push_back({"secured", "yes: it checks identities"});
    rows.push_back({"load", fmt::format("{} sessions, {} requests running, {} answered",
                                        status.session_count(), status.requests_running(),
                                        status.requests_answered())});
    if (report.round_trip_ms > 0.0)
      rows.push_back({"round trip", fmt::format("{:.2f} ms", report.round_trip_ms)});
    for (const v1::ModelKind kind : {v1::MODEL_HAND, v1::MODEL_OBJECT, v1::MODEL_CONTACTS}) {
      std::vector<std::string> names;
      for (const v1::ModelSummary& model : report.models.models()) {
        if (model.kind() == kind && model.built_in()) names.push_back(model.name());
      }
      rows.push_back(
          {kind == v1::MODEL_CONTACTS ? "contacts" : fmt::format("{}s", nameOf(kind)),
           names.empty() ? "none built in" : listed(names)});
    }
  } else {
    rows.push_back({"server", "none answers"});
  }
  std::string out = table(rows, "l");
  if (!report.advice.empty()) out += "\n" + report.advice + "\n";
  return out;
}

std::string models(const v1::ModelList& list) {
  Rows rows = {{"kind", "name", "", ""}};
  for (const v1::ModelSummary& model : list.models()) {
    rows.push_back({nameOf(model.kind()), plain(model.name()),
                    model.built_in() ? "built-in" : "uploaded", plain(model.text())});
  }
  return table(rows, "l");
}

namespace {

std::string editors(const v1::SessionState& state) {
  switch (state.access()) {
    case v1::ACCESS_ALL:
      return "everyone";
    case v1::ACCESS_LISTED:
      return "owner and others";
    case v1::ACCESS_OWNER:
      return "owner";
  }
  return "";
}

}  // namespace

std::string sessions(const v1::SessionList& list) {
  if (list.sessions().empty()) return "no sessions\n";
  const bool are_owned =
      std::any_of(list.sessions().begin(), list.sessions().end(), [](const auto& state) {
        return !state.owner().empty();
      });
  const bool hold_motions =
      std::any_of(list.sessions().begin(), list.sessions().end(), [](const auto& state) {
        return !state.motion().empty();
      });
  Rows rows = {{"session", "phase", "revision", "hand", "object",
                hold_motions ? "contacts or motion" : "contacts"}};
  if (are_owned) rows.front().insert(rows.front().end(), {"owner", "edited by"});
  for (const v1::SessionState& state : list.sessions()) {
    rows.push_back(
        {std::to_string(state.session_id()), nameOf(state.phase()),
         std::to_string(state.revision()), plain(state.hand()), plain(state.object()),
         state.motion().empty() ? plain(state.contacts()) : "motion " + plain(state.motion())});
    if (are_owned)
      rows.back().insert(rows.back().end(), {plain(state.owner()), editors(state)});
  }
  return table(rows, "l");
}

namespace {

// What keeps patches away, and what joint limits would bring.
std::string verdicts(const v1::PoseSolution& solution, const v1::HandDescription& hand) {
  std::string lines;
  if (!solution.verdict().empty()) lines = wrapped(solution.verdict());
  lines += shortfalls(solution);
  for (const v1::LimitSensitivity& sensitivity : solution.sensitivities()) {
    constexpr double kWorthTellingMm = 0.005;
    const auto joint =
        std::find_if(hand.joints().begin(), hand.joints().end(), [&](const v1::JointInfo& one) {
          return one.name() == sensitivity.limit().joint();
        });
    const JointUnit unit =
        unitOf(joint == hand.joints().end() ? v1::JOINT_REVOLUTE : joint->kind());
    lines += fmt::format("sensitivity: {} {} by {:.1f} {}: objective {:.3g} less",
                         plain(sensitivity.limit().joint()), nameOf(sensitivity.limit().side()),
                         unit.scale * sensitivity.given(), unit.name, sensitivity.gain());
    if (std::abs(sensitivity.gain_mm()) >= kWorthTellingMm) {
      lines += fmt::format(", {:.2f} mm {}", std::abs(sensitivity.gain_mm()),
                           sensitivity.gain_mm() > 0.0 ? "nearer" : "farther");
    }
    lines += "\n";
  }
  return lines;
}

}  // namespace

namespace {

/// What was waited for, by parts that add up to all of it. The server makes the skin while it
/// opens the session.
std::string waitedText(const GraspResult& result) {
  std::string parts;
  double told_ms = 0.0;
  const auto add = [&](const std::string& part, double part_ms) {
    parts += fmt::format("{} {}, ", part, milliseconds(part_ms));
    told_ms += part_ms;
  };
  const std::vector<v1::StageTime>& stages = result.solution.times();
  const auto skin = std::find_if(stages.begin(), stages.end(), [](const auto& stage) {
    return stage.stage() == "skin";
  });
  add("server", result.server_ms);
  add("models", result.models_ms - (skin == stages.end() ? 0.0 : skin->duration_ms()));
  for (const v1::StageTime& stage : stages)
    add(plain(stage.stage()), stage.duration_ms());
  if (result.files_ms >= 0.05) add("files", result.files_ms);
  const double all_ms = result.server_ms + result.total_ms + result.files_ms;
  return fmt::format("time: {}other {}; all in all {}\n", parts,
                     milliseconds(std::max(0.0, all_ms - told_ms)), milliseconds(all_ms));
}

/// The segment of the hand that a patch was laid on; empty if it is not known.
std::string segmentOf(const v1::PatchReport* report) {
  if (report == nullptr || report->place().empty()) return "";
  const v1::HandLocation& place = report->place().front();
  return plain(place.digit()) + (place.segment().empty() ? "" : "_" + plain(place.segment()));
}

/// A last column of the segments that patches lie on, where any lies on another than its name
/// says: `index_middle_2` lies on the middle one of an index finger.
void addSegments(const GraspResult& result, Rows& rows) {
  std::vector<std::string> segments{"on"};
  bool tells = false;
  for (const v1::PatchFit& patch : result.solution.patches()) {
    const std::string& segment =
        segments.emplace_back(segmentOf(reportOf(result, patch.name())));
    tells = tells || (!segment.empty() && !plain(patch.name()).starts_with(segment));
  }
  if (!tells) return;
  for (std::size_t i = 0; i < rows.size(); ++i)
    rows[i].push_back(segments[i]);
}

}  // namespace

std::string titleOf(const v1::SessionState& session,
                    const v1::HandDescription& hand,
                    const std::string& does) {
  return fmt::format("{}{} {} {}", nameCalled(session.hand()),
                     hand.mirrored() ? " (mirrored)" : "", does, nameCalled(session.object()));
}

namespace {

struct ReachedCount {
  int asked = 0;
  int reached = 0;
};

ReachedCount countOfReached(const v1::PoseSolution& solution) {
  ReachedCount count;
  for (const v1::PatchFit& patch : solution.patches()) {
    count.asked += patch.diagnosis().verdict() != v1::VERDICT_NONE ? 1 : 0;
    count.reached += patch.diagnosis().verdict() == v1::VERDICT_REACHED ? 1 : 0;
  }
  return count;
}

/// Where nobody knows of two hands whether they are the same one, who is far from reaching
/// anything may have the other. A claw takes what either touched.
std::vector<std::string> mirrorHints(const GraspResult& result) {
  constexpr std::size_t kClawDigits = 3;
  const bool is_touched_known = result.touched != v1::CHIRALITY_UNKNOWN;
  const bool is_hand_known = result.hand.chirality() != v1::CHIRALITY_UNKNOWN;
  if ((is_touched_known && is_hand_known) || result.hand.digits().size() <= kClawDigits ||
      !isLessThanHalfReached(result.solution))
    return {};
  return {
      fmt::format("less than half of the patches is reached, and {}: --mirror, with the "
                  "hand's URDF, tries the other side",
                  is_touched_known ? "whether this is a right or a left hand is not known"
                                   : "whether a right or a left hand touched is not known")};
}

}  // namespace

bool isLessThanHalfReached(const v1::PoseSolution& solution) {
  const auto [asked, reached] = countOfReached(solution);
  return 2 * reached < asked;
}

std::string reachedText(const v1::PoseSolution& solution) {
  const auto [asked, reached] = countOfReached(solution);
  return fmt::format("{} of {} patch{} reached", reached, asked, asked == 1 ? "" : "es");
}

std::string grasp(const GraspResult& result) {
  const v1::PoseSolution& solution = result.solution;
  std::string out =
      fmt::format("{} by {}\n\n", plain(titleOf(result.session, result.hand, "grasps")),
                  plain(nameCalled(result.session.contacts())));
  Rows rows = {{"patch", "mean mm", "max mm", "normal deg", "in 2 mm", "in 5 mm", "points",
                "lost", "length", "angle deg", "area", "verdict"}};
  for (const v1::PatchFit& patch : solution.patches()) {
    const v1::PatchReport* report = reportOf(result, patch.name());
    rows.push_back({plain(patch.name()), fmt::format("{:.2f}", patch.mean_mm()),
                    fmt::format("{:.2f}", patch.max_mm()),
                    fmt::format("{:.1f}", patch.normal_deg()),
                    fmt::format("{:.0f} %", 100.0 * patch.within_2mm()),
                    fmt::format("{:.0f} %", 100.0 * patch.within_5mm()),
                    std::to_string(patch.point_count())});
    const v1::Fidelity f = report == nullptr ? v1::Fidelity() : report->fidelity();
    rows.back().insert(
        rows.back().end(),
        {report == nullptr ? "" : std::to_string(report->lost().size()),
         fmt::format("{:.1f} %", 100.0 * f.distance_mean()),
         fmt::format("{:.1f}", f.angle_mean_rad() * 180.0 / std::numbers::pi),
         fmt::format("{:.3f}", f.area_ratio()), nameOf(patch.diagnosis().verdict())});
  }
  addSegments(result, rows);
  out += table(rows, "lrrrrrrrrrrll") + "\n";
  for (const v1::PatchReport& report : result.transfer.patches()) {
    if (report.placed()) continue;
    out += fmt::format("dropped {}: {}\n", plain(report.name()), plain(report.reason()));
  }

  out += verdicts(solution, result.hand);
  out += losses(result.transfer.patches(), result.kept ? solution.session_id() : 0);
  out += notes(result.hand.notes());
  out += notes(result.object_notes);
  out += notes(furtherNotes(result.transfer));
  out += notes(mirrorHints(result));

  out +=
      fmt::format("objective {:.6g} ({}), {} by {} after {} evaluations\n",
                  solution.terms().objective(), terms(solution, result.weights),
                  nameOf(solution.outcome()), plain(solution.solver()), solution.evaluations());
  out += fmt::format("joints at limits: {}\n",
                     solution.joints_at_limit().empty()
                         ? "none"
                         : listed(limitNames(solution.joints_at_limit())));
  for (const v1::Penetration& inside : solution.penetration()) {
    if (inside.max_depth_m() > 0.0 && !inside.links().empty()) {
      out += fmt::format("inside the object: {:.1f} mm at {}, {:.1f} cm3\n",
                         1e3 * inside.max_depth_m(), plain(inside.links().front().link()),
                         1e6 * inside.volume_m3());
    }
    if (inside.self_depth_m() > 0.0 && inside.self_links().size() == 2) {
      out += fmt::format("inside itself: {:.1f} mm, {} and {}\n", 1e3 * inside.self_depth_m(),
                         plain(inside.self_links()[0]), plain(inside.self_links()[1]));
    }
  }
  return out + waitedText(result);
}

std::string stateLine(const v1::SessionState& state) {
  std::string line = fmt::format("session {} revision {}: {}", state.session_id(),
                                 state.revision(), nameOf(state.phase()));
  if (state.phase() == v1::PHASE_TRANSFERRING || state.phase() == v1::PHASE_OPTIMIZING) {
    line += fmt::format(" {:.0f} %", 100.0 * state.progress());
  }
  if (!state.message().empty()) line += " (" + plain(state.message()) + ")";
  return line;
}

std::string explanation(const v1::PoseSolution& solution) {
  std::string line = onOneLine(solution.verdict());  // all of it, however long
  if (!solution.penetration().empty() && solution.penetration()[0].max_depth_m() > 0.0) {
    // Behind what is reached, before what else is to be said: of that depth is no part.
    line.insert(std::min(line.find("; "), line.size()),
                fmt::format("{}{:.1f} mm deep", line.empty() ? "" : ", ",
                            1e3 * solution.penetration()[0].max_depth_m()));
  }
  return line;
}

std::string solutionLine(const v1::PoseSolution& solution) {
  const char* what = !solution.is_final()      ? "on the way"
                     : solution.is_diagnosed() ? "solution"
                                               : "pose";
  std::string line = fmt::format("session {} revision {}: {} {} objective {:.6g}",
                                 solution.session_id(), solution.revision(), what,
                                 solution.sequence_number(), solution.terms().objective());
  if (!solution.is_final()) return line;
  line += fmt::format(", {}", nameOf(solution.outcome()));
  for (const v1::PatchFit& patch : solution.patches()) {
    line += fmt::format(", {} {:.1f} mm", plain(patch.name()), patch.mean_mm());
  }
  const std::string why = explanation(solution);
  return why.empty() ? line : line + "; " + why;
}

std::string motionLine(const v1::MotionFrames& frames) {
  return fmt::format("session {} revision {}: motion of {} frames solved", frames.session_id(),
                     frames.revision(), frames.frame_count());
}

std::string networkOptions(const Network& network) {
  const Network usual;
  std::string options;
  if (network.domain != usual.domain) options += fmt::format(" --domain {}", network.domain);
  if (network.interface != usual.interface) options += " --interface " + network.interface;
  for (const std::string& peer : network.peers)
    options += " --peers " + peer;
  if (!network.server.empty()) options += " --server " + network.server;
  if (!network.identity.empty()) options += " --identity " + network.identity;
  return options;
}

}  // namespace handgraft::client::text
