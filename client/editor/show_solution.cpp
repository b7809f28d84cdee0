#include "client/editor/show_solution.h"

#include <fmt/format.h>

#include "client/present/minima_text.h"
#include "client/present/text_output.h"
#include "idl/fields.h"
#include "idl/grasp_file.h"

namespace handgraft::client::editor {

namespace {

using json::Json;
using text::plain;
using Rows = std::vector<std::vector<std::string>>;

bool counts(const v1::PatchFit& patch, const Off& off) {
  return patch.point_count() > 0 && off.count(patch.name()) == 0;
}

const v1::PatchFit* worstOf(const v1::PoseSolution& solution, const Off& off) {
  const v1::PatchFit* worst = nullptr;
  for (const v1::PatchFit& patch : solution.patches()) {
    if (!counts(patch, off)) continue;
    if (worst == nullptr || patch.mean_mm() > worst->mean_mm()) worst = &patch;
  }
  return worst;
}

// Over all points.
double meanOf(const v1::PoseSolution& solution, const Off& off) {
  double sum = 0.0;
  double count = 0.0;
  for (const v1::PatchFit& patch : solution.patches()) {
    if (!counts(patch, off)) continue;
    sum += patch.point_count() * patch.mean_mm();
    count += patch.point_count();
  }
  return count > 0.0 ? sum / count : 0.0;
}

}  // namespace

Off offIn(const v1::PoseSolution& solution) {
  Off off;
  for (const v1::PatchFit& patch : solution.patches()) {
    if (patch.diagnosis().verdict() == v1::VERDICT_NONE) off.insert(patch.name());
  }
  return off;
}

std::string poseLine(const v1::PoseSolution& solution, const Off& off) {
  std::string line =
      fmt::format("revision {}: objective {:.6g}, mean {:.2f} mm", solution.revision(),
                  solution.terms().objective(), meanOf(solution, off));
  if (const v1::PatchFit* worst = worstOf(solution, off)) {
    line += fmt::format(", worst {} {:.2f} mm", plain(worst->name()), worst->mean_mm());
  }
  if (solution.outcome() != v1::OUTCOME_CONVERGED) {
    line += fmt::format(", {}", nameOf(solution.outcome()));
  }
  return line;
}

std::string statusLine(const v1::PoseSolution& solution, const Off& off) {
  const std::string explanation = text::explanation(solution);
  return poseLine(solution, off) + (explanation.empty() ? "" : "; " + explanation);
}

Json status(const v1::PoseSolution& solution, const Off& off) {
  Json all = {{"revision", solution.revision()},
              {"outcome", nameOf(solution.outcome())},
              {"solver", solution.solver()},
              {"objective", solution.terms().objective()},
              {"mean_mm", meanOf(solution, off)},
              {"worst", nullptr},
              {"is_diagnosed", solution.is_diagnosed()},
              {"verdict", solution.verdict()}};
  if (const v1::PatchFit* worst = worstOf(solution, off)) {
    all["worst"] = {{"patch", worst->name()}, {"mean_mm", worst->mean_mm()}};
  }
  return all;
}

CommandOutput tellSolution(const v1::PoseSolution& solution,
                           const Off& off,
                           const std::optional<v1::Weights>& weights) {
  CommandOutput output;
  Rows rows = {{"patch", "mean mm", "max mm", "normal deg", "in 5 mm", "points", "verdict"}};
  for (const v1::PatchFit& patch : solution.patches()) {
    rows.push_back({plain(patch.name()), fmt::format("{:.2f}", patch.mean_mm()),
                    fmt::format("{:.2f}", patch.max_mm()),
                    fmt::format("{:.1f}", patch.normal_deg()),
                    fmt::format("{:.0f} %", 100.0 * patch.within_5mm()),
                    std::to_string(patch.point_count()),
                    solution.is_diagnosed() ? nameOf(patch.diagnosis().verdict()) : ""});
  }
  output.text = text::table(rows, "lrrrrrl") + "\n" + text::shortfalls(solution);
  output.text += fmt::format("{}, by {} after {} evaluations\n", text::terms(solution, weights),
                             plain(solution.solver()), solution.evaluations());
  for (const v1::PinnedPoint& place : solution.held()) {
    output.text += fmt::format("held: {}, {:.1f} mm off its place, weight {:.4g}\n",
                               plain(place.link()), 1e3 * place.miss_m(), place.weight());
  }
  if (!solution.joints_at_limit().empty()) {
    output.text += fmt::format("joints at limits: {}\n",
                               text::listed(text::limitNames(solution.joints_at_limit())));
  }
  output.text += statusLine(solution, off) + "\n";
  output.data = json::jsonOf(solution);
  if (weights)
    output.data["terms"]["penetration"] = idl::penetrationCharge(solution.terms(), *weights);
  output.data["solution"] = status(solution, off);
  return output;
}

CommandOutput tellMinima(const v1::PoseSolution& solution, const v1::HandDescription& hand) {
  CommandOutput output;
  output.text = text::minima(solution, hand);
  if (output.text.empty()) output.text = "the last solution brought no list of minima\n";
  output.data = {{"minima", json::jsonOf(solution)["minima"]},
                 {"chosen", solution.chosen_minimum() + 1}};
  return output;
}

}  // namespace handgraft::client::editor
