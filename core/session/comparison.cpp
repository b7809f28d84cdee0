#include "core/session/comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "core/base/pose.h"
#include "core/session/pinned_points.h"

namespace handgraft::session {
namespace {

constexpr double kDegrees = 180.0 / 3.14159265358979323846;
constexpr const char* kMissing = "none";

/// Collects rows; what is alike is left out.
class Table {
 public:
  void text(const std::string& what, const std::string& a, const std::string& b) {
    if (a != b) rows.push_back({what, a, b, std::numeric_limits<double>::quiet_NaN()});
  }

  void number(const std::string& what, double a, double b, const char* unit) {
    if (a == b) return;
    rows.push_back({what, withUnit(a, unit), withUnit(b, unit), b - a});
  }

  void flag(const std::string& what, bool a, bool b) {
    text(what, a ? "yes" : "no", b ? "yes" : "no");
  }

  /// How far apart, and by how much turned; told in the second column.
  void pose(const std::string& what, const Pose& a, const Pose& b) {
    const double moved = (b.translation() - a.translation()).norm();
    const double turned = vectorFromRotation(a.linear().transpose() * b.linear()).norm();
    if (moved != 0.0)
      rows.push_back({what + " place", "0 mm", withUnit(moved * 1e3, "mm"), moved * 1e3});
    if (turned != 0.0) {
      rows.push_back(
          {what + " turn", "0 deg", withUnit(turned * kDegrees, "deg"), turned * kDegrees});
    }
  }

  std::vector<Difference> rows;

 private:
  static std::string withUnit(double value, const char* unit) {
    return *unit == 0 ? fmt::format("{:.6g}", value) : fmt::format("{:.6g} {}", value, unit);
  }
};

const DocumentPatch* patchNamed(const Document& document, const std::string& name) {
  for (const DocumentPatch& patch : document.patches) {
    if (patch.name == name) return &patch;
  }
  return nullptr;
}

const optimize::PatchFit* fitOf(const Document& document,
                                const optimize::SolveReport* report,
                                const std::string& name) {
  if (report == nullptr) return nullptr;
  for (const optimize::PatchFit& fit : report->patches) {
    if (document.patches[static_cast<std::size_t>(fit.patch)].name == name) return &fit;
  }
  return nullptr;
}

void compareFits(const Document& a,
                 const Document& b,
                 const optimize::SolveReport* fit_a,
                 const optimize::SolveReport* fit_b,
                 Table& table) {
  if (fit_a != nullptr && fit_b != nullptr)
    table.number("objective", fit_a->terms.objective, fit_b->terms.objective, "");
  for (const DocumentPatch& patch : a.patches) {
    const optimize::PatchFit* of_a = fitOf(a, fit_a, patch.name);
    const optimize::PatchFit* of_b = fitOf(b, fit_b, patch.name);
    if (of_a == nullptr || of_b == nullptr) continue;
    const std::string what = "patch " + patch.name;
    table.number(what + " mean", of_a->mean_mm, of_b->mean_mm, "mm");
    table.number(what + " max", of_a->max_mm, of_b->max_mm, "mm");
    table.number(what + " normal", of_a->normal_mean_deg, of_b->normal_mean_deg, "deg");
  }
}

void comparePatches(const Document& a, const Document& b, Table& table) {
  for (const DocumentPatch& of_a : a.patches) {
    const std::string what = "patch " + of_a.name;
    const DocumentPatch* of_b = patchNamed(b, of_a.name);
    if (of_b == nullptr) {
      table.text(what, "there", kMissing);
      continue;
    }
    table.flag(what + " enabled", of_a.enabled, of_b->enabled);
    table.number(what + " weight", of_a.weight, of_b->weight, "");
    table.flag(what + " placed", of_a.placement.has_value(), of_b->placement.has_value());
    table.text(what + " site", of_a.site, of_b->site);
    const auto place_of = [](const geometry::SurfacePoint& point) {
      return fmt::format("face {} ({:.3g}, {:.3g}, {:.3g})", point.face, point.barycentric[0],
                         point.barycentric[1], point.barycentric[2]);
    };
    table.text(what + " root on the object", place_of(of_a.root_O), place_of(of_b->root_O));
    if (of_a.placement && of_b->placement) {
      table.text(what + " root on the hand", place_of(of_a.placement->root_S),
                 place_of(of_b->placement->root_S));
      const double cosine = of_a.placement->direction_S.dot(of_b->placement->direction_S);
      const bool same_root =
          place_of(of_a.placement->root_S) == place_of(of_b->placement->root_S);
      if (same_root && of_a.placement->direction_S != of_b->placement->direction_S) {
        table.number(what + " turn on the hand", 0.0,
                     std::acos(std::clamp(cosine, -1.0, 1.0)) * kDegrees, "deg");
      }
    }
    const bool turned = of_a.direction_O && of_b->direction_O &&
                        place_of(of_a.root_O) == place_of(of_b->root_O) &&
                        *of_a.direction_O != *of_b->direction_O;
    if (turned) {
      const double cosine = of_a.direction_O->dot(*of_b->direction_O);
      table.number(what + " turn on the object", 0.0,
                   std::acos(std::clamp(cosine, -1.0, 1.0)) * kDegrees, "deg");
    }
  }
  for (const DocumentPatch& of_b : b.patches) {
    if (patchNamed(a, of_b.name) == nullptr)
      table.text("patch " + of_b.name, kMissing, "there");
  }
}

void compareJoints(const Document& a,
                   const Document& b,
                   const std::vector<std::string>& joints_a,
                   const std::vector<std::string>& joints_b,
                   Table& table) {
  for (std::size_t i = 0; i < joints_a.size(); ++i) {
    const std::string what = "joint " + joints_a[i];
    const auto found = std::find(joints_b.begin(), joints_b.end(), joints_a[i]);
    if (found == joints_b.end()) {
      table.text(what, "there", kMissing);
      continue;
    }
    const auto j = static_cast<std::size_t>(found - joints_b.begin());
    const DocumentJoint& of_a = a.joints[i];
    const DocumentJoint& of_b = b.joints[j];
    table.number(what, a.start.q[static_cast<Eigen::Index>(i)],
                 b.start.q[static_cast<Eigen::Index>(j)], "rad");
    table.number(what + " lower", of_a.lower, of_b.lower, "rad");
    table.number(what + " upper", of_a.upper, of_b.upper, "rad");
    table.flag(what + " locked", of_a.locked, of_b.locked);
    table.number(what + " soft weight", of_a.soft_weight, of_b.soft_weight, "");
    table.number(what + " soft value", of_a.soft_value, of_b.soft_value, "rad");
  }
  for (const std::string& name : joints_b) {
    if (std::find(joints_a.begin(), joints_a.end(), name) == joints_a.end())
      table.text("joint " + name, kMissing, "there");
  }
}

void compareHeld(const Document& a, const Document& b, Table& table) {
  const auto place_of = [](const Document& document, const std::string& link) -> std::string {
    for (const PinnedPoint& place : document.held) {
      if (place.link != link) continue;
      return fmt::format("at {:.4g} {:.4g} {:.4g}{}, weight {:.4g}", place.target_W.x(),
                         place.target_W.y(), place.target_W.z(),
                         place.target_R_WL ? ", turned" : "", place.weight);
    }
    return kMissing;
  };
  for (const std::string& link : heldLinks(a))
    table.text("held " + link, place_of(a, link), place_of(b, link));
  for (const std::string& link : heldLinks(b))
    if (place_of(a, link) == kMissing) table.text("held " + link, kMissing, place_of(b, link));
}

std::string solverOf(const SolverSettings& solving) {
  return solving.paper ? std::string("as in the paper")
                       : fmt::format("{}, {} starts, {} evaluations, seed {}",
                                     optimize::nameOf(solving.solver), solving.starts,
                                     solving.max_evaluations, solving.seed);
}

}  // namespace

std::vector<Difference> differencesBetween(const Document& a,
                                           const Document& b,
                                           const std::vector<std::string>& joints_a,
                                           const std::vector<std::string>& joints_b,
                                           const optimize::SolveReport* fit_a,
                                           const optimize::SolveReport* fit_b) {
  Table table;
  table.text("hand", a.hand, b.hand);
  table.text("object", a.object, b.object);
  table.text("contacts", a.contacts, b.contacts);
  compareFits(a, b, fit_a, fit_b, table);
  table.pose("object", a.X_WO, b.X_WO);
  table.pose("hand", a.start.X_WH, b.start.X_WH);
  compareJoints(a, b, joints_a, joints_b, table);
  comparePatches(a, b, table);
  compareHeld(a, b, table);
  table.number("weight of the distance", a.weights.distance, b.weights.distance, "1/m2");
  table.number("weight of the normals", a.weights.normal, b.weights.normal, "");
  table.number("weight of the prior", a.weights.prior, b.weights.prior, "");
  table.number("prior share of the root's rotation", a.prior_shares.root_rotation,
               b.prior_shares.root_rotation, "");
  table.number("prior share of the root's translation", a.prior_shares.root_translation,
               b.prior_shares.root_translation, "");
  table.number("prior share of the joints", a.prior_shares.joints, b.prior_shares.joints, "");
  table.number("prior share of the posture", a.prior_shares.posture, b.prior_shares.posture,
               "");
  table.text("solving", solverOf(a.solving), solverOf(b.solving));
  table.flag("normals as a sum", a.solving.normal_form == optimize::NormalForm::kSum,
             b.solving.normal_form == optimize::NormalForm::kSum);
  table.flag("penetration avoided", a.solving.avoid_penetration, b.solving.avoid_penetration);
  return table.rows;
}

}  // namespace handgraft::session
