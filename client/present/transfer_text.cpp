#include "client/present/transfer_text.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "client/present/text_output.h"
#include "idl/fields.h"

namespace handgraft::client::text {

namespace {

using Rows = std::vector<std::vector<std::string>>;

constexpr double kDegrees = 180.0 / std::numbers::pi;

std::string percent(double share) {
  return fmt::format("{:.1f} %", 100.0 * share);
}

std::string degrees(double angle_rad) {
  return fmt::format("{:.1f}", angle_rad * kDegrees);
}

std::string millimetres(double length_m) {
  return fmt::format("{:.2f}", 1e3 * length_m);
}

const std::vector<std::string> fidelity_head = {"length", "max",       "angle deg", "max",
                                                "area",   "offset mm", "max"};

/// The columns of fidelity_head; empty ones where nothing was reached, so that there is no
/// shape to compare.
void addFidelity(std::vector<std::string>& row, const v1::Fidelity& f, bool is_reached) {
  if (!is_reached) {
    row.insert(row.end(), fidelity_head.size(), "-");
    return;
  }
  row.insert(
      row.end(),
      {percent(f.distance_mean()), percent(f.distance_max()), degrees(f.angle_mean_rad()),
       degrees(f.angle_max_rad()), fmt::format("{:.3f}", f.area_ratio()),
       millimetres(f.projection_mean_m()), millimetres(f.projection_max_m())});
}

std::string methods(const v1::PatchReport& report) {
  return report.method_O() == report.method_S()
             ? nameOf(report.method_S())
             : fmt::format("{}/{}", nameOf(report.method_O()), nameOf(report.method_S()));
}

/// "edge of the surface 3, cut locus 1", in the order in which the reasons first come up.
std::string reasonsOf(const std::vector<v1::LostPoint>& lost) {
  std::vector<std::pair<std::string, int>> counts;
  for (const v1::LostPoint& point : lost) {
    const auto known = std::find_if(counts.begin(), counts.end(), [&](const auto& count) {
      return count.first == point.reason();
    });
    if (known == counts.end()) {
      counts.emplace_back(point.reason(), 1);
    } else {
      ++known->second;
    }
  }
  std::string line;
  for (const auto& [reason, count] : counts)
    line += fmt::format("{}{} {}", line.empty() ? "" : ", ", plain(reason), count);
  return line;
}

std::string reasonsOf(const std::vector<v1::LostCount>& lost) {
  std::string line;
  for (const v1::LostCount& count : lost) {
    line +=
        fmt::format("{}{} {}", line.empty() ? "" : ", ", plain(count.reason()), count.count());
  }
  return line;
}

std::string transferTable(const std::vector<v1::PatchReport>& patches) {
  Rows rows = {{"patch", "points", "lost"}};
  rows[0].insert(rows[0].end(), fidelity_head.begin(), fidelity_head.end());
  rows[0].emplace_back("log maps");
  for (const v1::PatchReport& report : patches) {
    if (!report.placed()) continue;
    std::vector<std::string> row = {plain(report.name()), std::to_string(report.point_count()),
                                    std::to_string(report.lost().size())};
    addFidelity(row, report.fidelity(), report.point_count() > 0);
    row.push_back(methods(report));
    rows.push_back(std::move(row));
  }
  return table(rows, "lr");
}

}  // namespace

std::string losses(const std::vector<v1::PatchReport>& patches, std::uint64_t session_id) {
  std::string out;
  std::string worst;
  std::size_t most = 0;
  for (const v1::PatchReport& report : patches) {
    const std::size_t lost = report.lost().size();
    if (!report.placed() || lost == 0) continue;
    out += fmt::format("{} lost {} of {} points: {}\n", plain(report.name()), lost,
                       report.point_count() + lost, reasonsOf(report.lost()));
    // Another root on the hand brings back only what was lost on the hand.
    const std::size_t on_skin = static_cast<std::size_t>(std::count_if(
        report.lost().begin(), report.lost().end(), [](const v1::LostPoint& point) {
          return point.reason().rfind("not ", 0) != 0;
        }));
    if (on_skin > most) {
      most = on_skin;
      worst = plain(report.name());
    }
  }
  if (worst.empty()) return out;
  if (session_id != 0) {
    return out +
           fmt::format("hint: handgraft suggest {} {} looks for a root that loses fewer\n",
                       session_id, worst);
  }
  return out + fmt::format(
                   "hint: grasp again with --keep on a running server; then handgraft suggest "
                   "SESSION {} looks for a root that loses fewer\n",
                   worst);
}

std::vector<std::string> furtherNotes(const v1::TransferReply& reply) {
  std::vector<std::string> further;
  for (const std::string& note : reply.notes()) {
    const bool is_told = std::any_of(reply.patches().begin(), reply.patches().end(),
                                     [&](const v1::PatchReport& report) {
                                       return !report.placed() && report.reason() == note;
                                     });
    if (!is_told) further.push_back(note);
  }
  return further;
}

std::string transfer(const v1::TransferReply& reply) {
  std::string out = fmt::format(
      "session {} revision {}: log maps {}, {} interior rings\n\n", reply.session_id(),
      reply.revision(), nameOf(reply.options().method()), reply.options().interior_rings());
  out += transferTable(reply.patches()) + "\n";
  for (const v1::PatchReport& report : reply.patches()) {
    if (!report.placed()) {
      out += fmt::format("dropped {}: {}\n", plain(report.name()), plain(report.reason()));
    }
    if (report.folded() > 0) {
      out += fmt::format(
          "{}: {} places lie under several sheets of a surface; the nearest was taken\n",
          plain(report.name()), report.folded());
    }
  }
  out += losses(reply.patches(), reply.session_id());
  out += notes(furtherNotes(reply));
  return out + fmt::format("time: {:.1f} ms\n", reply.transfer_ms());
}

std::string suggestions(const v1::SuggestReply& reply) {
  std::string out = fmt::format("session {} revision {}: patch {}\n\n", reply.session_id(),
                                reply.revision(), plain(reply.patch()));
  Rows rows = {{"", "moved mm", "turned deg", "points", "lost"}};
  rows[0].insert(rows[0].end(), fidelity_head.begin(), fidelity_head.end());
  const v1::PatchReport& present = reply.present();
  rows.push_back({"present", "", "", std::to_string(present.point_count()),
                  std::to_string(present.lost().size())});
  addFidelity(rows.back(), present.fidelity(), present.point_count() > 0);
  int number = 0;
  for (const v1::PlacementSuggestion& one : reply.suggestions()) {
    rows.push_back({std::to_string(++number), millimetres(one.moved_m()),
                    degrees(one.turned_rad()), std::to_string(one.point_count()),
                    std::to_string(one.lost_count())});
    addFidelity(rows.back(), one.fidelity(), one.point_count() > 0);
  }
  out += table(rows, "lr") + "\n";
  if (!present.lost().empty()) {
    out += fmt::format("present loses: {}\n", reasonsOf(present.lost()));
  }
  number = 0;
  for (const v1::PlacementSuggestion& one : reply.suggestions()) {
    ++number;
    if (one.lost_count() > 0)
      out += fmt::format("{} loses: {}\n", number, reasonsOf(one.lost()));
  }
  if (reply.suggestions().empty()) {
    return out + (present.lost().empty() ? "no point is lost: nothing to better\n"
                                         : "no place within reach loses fewer\n");
  }
  return out;
}

std::string applied(std::size_t number,
                    const v1::PlacementSuggestion& suggestion,
                    const v1::PatchReport& report,
                    std::uint64_t revision) {
  std::string out =
      fmt::format("applied {}: {} moved by {} mm, turned by {} deg; revision {}\n\n", number,
                  plain(report.name()), millimetres(suggestion.moved_m()),
                  degrees(suggestion.turned_rad()), revision);
  out += transferTable({report});
  if (!report.lost().empty()) {
    out += fmt::format("\n{} loses: {}\n", plain(report.name()), reasonsOf(report.lost()));
  }
  return out;
}

}  // namespace handgraft::client::text
