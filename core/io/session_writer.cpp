#include "core/io/session_writer.h"

#include <cmath>
#include <concepts>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/io/session_spelling.h"

namespace handgraft::io {
namespace {

using nlohmann::ordered_json;
using session::visitFields;

/// Writes whatever has fields.
struct Writer {
  static ordered_json json(bool value) { return value; }

  static ordered_json json(double value) {
    if (std::isinf(value)) return value > 0.0 ? "inf" : "-inf";
    return value;
  }

  template <std::integral T>
  static ordered_json json(T value) {
    return value;
  }

  static ordered_json json(const std::string& text) { return text; }

  static ordered_json json(session::Side side) {
    return kSides[static_cast<std::size_t>(side)].second;
  }

  static ordered_json json(optimize::NormalForm form) {
    return kNormalForms[static_cast<std::size_t>(form)].second;
  }

  static ordered_json json(optimize::Solver solver) {
    return std::string(optimize::nameOf(solver));
  }

  static ordered_json json(geometry::LogMapMethod method) {
    return std::string(geometry::nameOf(method));
  }

  static ordered_json json(const Pose& X) {
    ordered_json list = json(Eigen::Matrix3d(X.linear()));
    for (const double p : Eigen::Vector3d(X.translation()))
      list.push_back(json(p));
    return list;
  }

  /// Row by row.
  template <int Rows, int Columns>
  static ordered_json json(const Eigen::Matrix<double, Rows, Columns>& matrix) {
    ordered_json list = ordered_json::array();
    for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
      for (Eigen::Index column = 0; column < matrix.cols(); ++column)
        list.push_back(json(matrix(row, column)));
    }
    return list;
  }

  template <class T>
  static ordered_json json(const std::vector<T>& list) {
    ordered_json result = ordered_json::array();
    for (const T& entry : list)
      result.push_back(json(entry));
    return result;
  }

  template <class T>
  static ordered_json json(const std::pair<std::size_t, T>& entry) {
    return ordered_json::array({entry.first, json(entry.second)});
  }

  template <HasFields T>
  static ordered_json json(const T& value) {
    ordered_json result = ordered_json::object();
    visitFields(value, [&](const char* key, const auto& field) {
      put(result, key, field);
    });
    return result;
  }

  template <class T>
  static void put(ordered_json& object, const char* key, const T& field) {
    object[key] = json(field);
  }

  /// What is missing is left out.
  template <class T>
  static void put(ordered_json& object, const char* key, const std::optional<T>& field) {
    if (field) object[key] = json(*field);
  }

  /// Entries that did not change are many.
  template <class T>
  static void put(ordered_json& object,
                  const char* key,
                  const std::vector<std::pair<std::size_t, T>>& entries) {
    if (!entries.empty()) object[key] = json(entries);
  }

  static ordered_json json(const session::TimedChange& change) {
    ordered_json result = std::visit(
        [](const auto& one) {
          return json(one);
        },
        change);
    result["kind"] = std::string(session::kTimedKinds[change.index()]);
    return result;
  }

  /// Most sessions hold grasps, which have no times.
  static void put(ordered_json& object,
                  const char* key,
                  const std::vector<session::TimedEdit>& edits) {
    if (!edits.empty()) object[key] = json(edits);
  }

  static ordered_json json(const session::HistoryStep& step) {
    return {{"label", step.label}, {"change", json(step.change)}};
  }

  static ordered_json json(const session::History& history) {
    ordered_json result;
    result["present"] = json(history.present());
    for (const auto& [key, steps] :
         {std::pair{"undo", &history.undoSteps()}, std::pair{"redo", &history.redoSteps()}}) {
      result[key] = ordered_json::array();
      for (const auto& step : *steps)
        result[key].push_back(json(*step));
    }
    result["snapshots"] = ordered_json::object();
    for (const auto& [name, snapshot] : history.snapshots()) {
      result["snapshots"][name] = {{"revision", snapshot->revision},
                                   {"document", json(snapshot->document)}};
    }
    return result;
  }

  static ordered_json json(const session::Edit& edit) {
    ordered_json result = std::visit(
        [](const auto& one) {
          return json(one);
        },
        edit);
    result["kind"] = std::string(session::kEditKinds[edit.index()]);
    return result;
  }

  static ordered_json json(const session::LogEntry& entry) {
    if (const auto* edit = std::get_if<session::Edit>(&entry)) return {{"edit", json(*edit)}};
    if (std::holds_alternative<session::CancelledSolve>(entry)) return {{"cancelled", true}};
    if (const auto* followed = std::get_if<session::FollowedMotion>(&entry))
      return {{"motion", json(*followed)}};
    const auto& solve = *std::get<std::shared_ptr<const session::CommittedSolve>>(entry);
    ordered_json written = {{"solving", json(solve.solving)},
                            {"objective", json(solve.objective)},
                            {"change", json(solve.change)}};
    if (solve.is_step) written["is_step"] = *solve.is_step;
    return {{"solve", std::move(written)}};
  }
};

}  // namespace

ordered_json jsonOf(const session::History& history) {
  return Writer::json(history);
}

ordered_json jsonOf(const session::LogEntry& entry) {
  return Writer::json(entry);
}

}  // namespace handgraft::io
