#include "core/io/session_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/io/json_keys.h"
#include "core/session/fields.h"

namespace handgraft::io {
namespace {

using nlohmann::ordered_json;
using session::visitFields;

constexpr const char* kFormat = "handgraft-session/1";
constexpr std::size_t kMostBytes = 32U << 20U;
constexpr std::size_t kMostEntries = 4096;  // of any list
constexpr std::size_t kLongestText = 4096;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <class T>
concept HasFields = requires(T& value) {
  visitFields(value, [](const char*, auto&) {});
};

// === How enumerators are spelled
constexpr std::array<std::pair<session::Side, const char*>, 2> kSides = {
    {{session::Side::kObject, "object"}, {session::Side::kHand, "hand"}}};
constexpr std::array<std::pair<optimize::NormalForm, const char*>, 2> kNormalForms = {
    {{optimize::NormalForm::kCosine, "cosine"}, {optimize::NormalForm::kSum, "sum"}}};

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
    const auto& solve = *std::get<std::shared_ptr<const session::CommittedSolve>>(entry);
    return {{"solve",
             {{"solving", json(solve.solving)},
              {"objective", json(solve.objective)},
              {"change", json(solve.change)}}}};
  }
};

/// A value inside the text and the way to it, for messages.
class Field {
 public:
  Field(const ordered_json& value, std::string path) : value_(value), path_(std::move(path)) {}

  template <class... Args>
  [[noreturn]] void reject(fmt::format_string<Args...> format, Args&&... args) const {
    rejectInput("session: {}: {}", path_.empty() ? "the whole" : quoted(path_),
                fmt::format(format, std::forward<Args>(args)...));
  }

  [[nodiscard]] const Field* itselfIfObject() const {
    if (!value_.is_object()) reject("is {}; it must be an object", value_.type_name());
    return this;
  }

  [[nodiscard]] bool has(const char* key) const {
    return itselfIfObject()->value_.contains(key);
  }

  [[nodiscard]] Field operator[](const char* key) const {
    if (!has(key)) reject("has no field '{}'", key);
    return {value_[key], path_.empty() ? key : path_ + "." + key};
  }

  /// All fields of an object, in the order of the text.
  template <class Visitor>
  void each(const Visitor& visit) const {
    requireSize(itselfIfObject()->value_.size());
    for (const auto& [key, value] : value_.items())
      visit(key, Field(value, path_ + "." + key));
  }

  void requireOnly(const std::vector<std::string>& permitted) const {
    for (const auto& [key, value] : itselfIfObject()->value_.items()) {
      if (std::find(permitted.begin(), permitted.end(), key) == permitted.end()) {
        reject("field {} is unknown; permitted are {}", quoted(key), fmt::join(permitted, " "));
      }
    }
  }

  [[nodiscard]] std::size_t size() const {
    if (!value_.is_array()) reject("is {}; it must be a list", value_.type_name());
    requireSize(value_.size());
    return value_.size();
  }

  [[nodiscard]] Field at(std::size_t index) const {
    return {value_[index], fmt::format("{}[{}]", path_, index)};
  }

  [[nodiscard]] std::string text() const {
    if (!value_.is_string()) reject("is {}; it must be a string", value_.type_name());
    const auto& text = value_.get_ref<const std::string&>();
    if (text.size() > kLongestText)
      reject("has {} bytes; permitted are {}", text.size(), kLongestText);
    return text;
  }

  void read(bool& value) const {
    if (!value_.is_boolean()) reject("is {}; it must be true or false", value_.type_name());
    value = value_.get<bool>();
  }

  void read(double& value) const {
    if (value_.is_string() && (value_ == "inf" || value_ == "-inf")) {
      value = value_ == "inf" ? kInfinity : -kInfinity;
      return;
    }
    if (!value_.is_number()) reject("is {}; it must be a number", value_.type_name());
    value = value_.get<double>();
  }

  template <std::integral T>
  void read(T& value) const {
    const bool fits = value_.is_number_unsigned()
                          ? value_.get<std::uint64_t>() <=
                                static_cast<std::uint64_t>(std::numeric_limits<T>::max())
                          : value_.is_number_integer() && std::is_signed_v<T> &&
                                value_.get<std::int64_t>() >=
                                    static_cast<std::int64_t>(std::numeric_limits<T>::min());
    if (!fits) reject("is {}; it must be a whole number in range", shownValue());
    value = value_.get<T>();
  }

  void read(std::string& value) const { value = text(); }

  void read(session::Side& side) const { readEnumerator(kSides, side); }

  void read(optimize::NormalForm& form) const { readEnumerator(kNormalForms, form); }

  void read(optimize::Solver& solver) const { solver = optimize::solverFrom(text()); }

  void read(geometry::LogMapMethod& method) const {
    method = geometry::logMapMethodFrom(text());
  }

  void read(Pose& X) const {
    std::vector<double> numbers;
    read(numbers);
    if (numbers.size() != 12) reject("has {} numbers; a pose has 12", numbers.size());
    X = Pose::Identity();
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        X.matrix()(row, column) = numbers[static_cast<std::size_t>(3 * row + column)];
      X.matrix()(row, 3) = numbers[static_cast<std::size_t>(9 + row)];
    }
  }

  template <int Rows, int Columns>
  void read(Eigen::Matrix<double, Rows, Columns>& matrix) const {
    std::vector<double> numbers;
    read(numbers);
    if constexpr (Rows == Eigen::Dynamic) {
      matrix.resize(static_cast<Eigen::Index>(numbers.size()));
    } else if (numbers.size() != static_cast<std::size_t>(matrix.size())) {
      reject("has {} numbers; it must have {}", numbers.size(), matrix.size());
    }
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const auto entry = static_cast<Eigen::Index>(i);
      matrix(entry / matrix.cols(), entry % matrix.cols()) = numbers[i];
    }
  }

  template <class T>
  void read(std::vector<T>& list) const {
    list.resize(size());
    for (std::size_t i = 0; i < list.size(); ++i)
      at(i).read(list[i]);
  }

  template <class T>
  void read(std::pair<std::size_t, T>& entry) const {
    if (size() != 2) reject("must be an index and a value");
    at(0).read(entry.first);
    at(1).read(entry.second);
  }

  template <HasFields T>
  void read(T& value) const {
    std::vector<std::string> keys = {"kind"};  // which an edit has besides
    visitFields(value, [&](const char* key, auto& field) {
      keys.emplace_back(key);
      readField(key, field);
    });
    requireOnly(keys);
  }

 private:
  template <class T>
  void readField(const char* key, T& field) const {
    (*this)[key].read(field);
  }

  template <class T>
  void readField(const char* key, std::optional<T>& field) const {
    field.reset();
    if (has(key)) (*this)[key].read(field.emplace());
  }

  template <class T>
  void readField(const char* key, std::vector<std::pair<std::size_t, T>>& entries) const {
    entries.clear();
    if (has(key)) (*this)[key].read(entries);
  }

  template <class Names, class T>
  void readEnumerator(const Names& names, T& value) const {
    const std::string name = text();
    for (const auto& [enumerator, spelled] : names) {
      if (name != spelled) continue;
      value = enumerator;
      return;
    }
    reject("is {}; permitted are '{}' and '{}'", quoted(name), names[0].second,
           names[1].second);
  }

  void requireSize(std::size_t size) const {
    if (size > kMostEntries) reject("has {} entries; permitted are {}", size, kMostEntries);
  }

  [[nodiscard]] std::string shownValue() const {
    return value_.is_structured() ? value_.type_name() : quoted(value_.dump());
  }

  const ordered_json& value_;
  std::string path_;
};

template <std::size_t Kind = 0>
session::Edit editOf(const Field& field, std::size_t kind) {
  if constexpr (Kind < std::variant_size_v<session::Edit>) {
    if (kind != Kind) return editOf<Kind + 1>(field, kind);
    std::variant_alternative_t<Kind, session::Edit> edit{};
    field.read(edit);
    return edit;
  } else {
    field.reject("is of no kind");
  }
}

session::Edit editOf(const Field& field) {
  const std::string kind = field["kind"].text();
  const auto found = std::find(session::kEditKinds.begin(), session::kEditKinds.end(), kind);
  if (found == session::kEditKinds.end()) {
    field["kind"].reject("is {}; permitted are {}", quoted(kind),
                         fmt::join(session::kEditKinds, " "));
  }
  return editOf(field, static_cast<std::size_t>(found - session::kEditKinds.begin()));
}

session::History::Steps stepsOf(const Field& field) {
  session::History::Steps steps;
  for (std::size_t i = 0; i < field.size(); ++i) {
    auto step = std::make_shared<session::HistoryStep>();
    const Field entry = field.at(i);
    entry.requireOnly({"label", "change"});
    entry["label"].read(step->label);
    entry["change"].read(step->change);
    steps.push_back(std::move(step));
  }
  return steps;
}

session::History historyOf(const Field& field) {
  field.requireOnly({"present", "undo", "redo", "snapshots"});
  session::Document present;
  field["present"].read(present);
  session::History::Snapshots snapshots;
  field["snapshots"].each([&](const std::string& name, const Field& entry) {
    auto snapshot = std::make_shared<session::Snapshot>();
    entry.requireOnly({"revision", "document"});
    entry["revision"].read(snapshot->revision);
    entry["document"].read(snapshot->document);
    snapshots[name] = std::move(snapshot);
  });
  return session::History::restored(std::move(present), stepsOf(field["undo"]),
                                    stepsOf(field["redo"]), std::move(snapshots));
}

session::LogEntry entryOf(const Field& field) {
  field.requireOnly({"edit", "solve", "cancelled"});
  if (field.has("edit")) return editOf(field["edit"]);
  if (field.has("cancelled")) return session::CancelledSolve();
  const Field solve = field["solve"];
  solve.requireOnly({"solving", "objective", "change"});
  auto committed = std::make_shared<session::CommittedSolve>();
  solve["solving"].read(committed->solving);
  solve["objective"].read(committed->objective);
  solve["change"].read(committed->change);
  return std::shared_ptr<const session::CommittedSolve>(std::move(committed));
}

std::string hashOf(session::ModelShelf& shelf, const std::string& model) {
  const std::size_t space = model.find(' ');
  const std::string kind = model.substr(0, space);
  const std::string name = space == std::string::npos ? "" : model.substr(space + 1);
  if (kind == "hand") return shelf.handHash(name);
  if (kind == "object") return shelf.objectHash(name);
  if (kind == "contacts" && name == shelf.first().contacts_name) return shelf.contactsHash();
  rejectInput("session: {} is no model of a session", quoted(model));
}

void addModels(const session::History& history, std::set<std::string>& models) {
  const auto add = [&](const session::Document& document) {
    models.insert("hand " + document.hand);
    models.insert("object " + document.object);
  };
  add(history.present());
  for (const auto* steps : {&history.undoSteps(), &history.redoSteps()}) {
    for (const auto& step : *steps) {
      if (step->change.hand) models.insert("hand " + *step->change.hand);
      if (step->change.object) models.insert("object " + *step->change.object);
    }
  }
  for (const auto& [name, snapshot] : history.snapshots())
    add(snapshot->document);
}

/// All models that opening and replaying it asks for.
std::set<std::string> modelsIn(const session::SavedSession& saved,
                               const session::ModelShelf& shelf) {
  std::set<std::string> models = {"contacts " + shelf.first().contacts_name,
                                  "hand " + shelf.first().hand_name,
                                  "object " + shelf.first().object_name};
  addModels(saved.history, models);
  addModels(saved.first.history, models);
  for (const session::LogEntry& entry : saved.log) {
    const auto* edit = std::get_if<session::Edit>(&entry);
    if (edit == nullptr) continue;
    if (const auto* hand = std::get_if<session::HandEdit>(edit))
      models.insert("hand " + hand->name);
    if (const auto* object = std::get_if<session::ObjectEdit>(edit))
      models.insert("object " + object->name);
  }
  return models;
}

}  // namespace

std::string sessionText(session::Session& session) {
  session::ModelShelf& shelf = session.shelf();
  ordered_json file;
  file["format"] = kFormat;
  file["models"] = {{"hand", shelf.first().hand_name},
                    {"object", shelf.first().object_name},
                    {"contacts", shelf.first().contacts_name}};
  const session::SavedSession saved = session.saved();
  for (const std::string& model : modelsIn(saved, shelf))
    file["models"]["hashes"][model] = hashOf(shelf, model);
  file["revision"] = saved.revision;
  file["history"] = Writer::json(saved.history);
  file["first"] = {{"revision", saved.first.revision},
                   {"history", Writer::json(saved.first.history)}};
  file["log"] = ordered_json::array();
  for (const session::LogEntry& entry : saved.log)
    file["log"].push_back(Writer::json(entry));
  return file.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

SessionFile readSessionText(const std::string& text) {
  if (text.size() > kMostBytes)
    rejectInput("session: {} bytes; permitted are {}", text.size(), kMostBytes);
  ordered_json document;
  try {
    document = ordered_json::parse(text);
  } catch (const ordered_json::exception& failure) {
    rejectInput("session: not JSON: {}", quoted(failure.what()));
  }
  const Field file(document, "");
  const std::string format = file["format"].text();
  if (format != kFormat)
    file["format"].reject("is {}; it must be '{}'", quoted(format), kFormat);
  file.requireOnly({"format", "models", "revision", "history", "first", "log"});

  SessionFile result;
  const Field models = file["models"];
  models.requireOnly({"hand", "object", "contacts", "hashes"});
  models["hand"].read(result.hand);
  models["object"].read(result.object);
  models["contacts"].read(result.contacts);
  models["hashes"].each([&](const std::string& model, const Field& hash) {
    hash.read(result.hashes[model]);
  });
  if (result.hashes.size() > 2 * session::kMostModels + 1) {
    models["hashes"].reject("has {} models; permitted are {}", result.hashes.size(),
                            2 * session::kMostModels + 1);
  }
  for (const std::string& model :
       {"hand " + result.hand, "object " + result.object, "contacts " + result.contacts}) {
    if (result.hashes.count(model) == 0) models["hashes"].reject("lacks {}", quoted(model));
  }
  file["revision"].read(result.session.revision);
  result.session.history = historyOf(file["history"]);
  const Field first = file["first"];
  first.requireOnly({"revision", "history"});
  first["revision"].read(result.session.first.revision);
  result.session.first.history = historyOf(first["history"]);
  const Field log = file["log"];
  if (log.size() > session::kMostEntries)
    log.reject("has {} entries; permitted are {}", log.size(), session::kMostEntries);
  for (std::size_t i = 0; i < log.size(); ++i)
    result.session.log.push_back(entryOf(log.at(i)));
  return result;
}

void requireSameModels(const SessionFile& file,
                       session::SessionModels models,
                       const Progress& progress) {
  if (models.hand_name != file.hand || models.object_name != file.object ||
      models.contacts_name != file.contacts) {
    rejectInput("session: it was opened with hand {}, object {} and contacts {}",
                quoted(file.hand), quoted(file.object), quoted(file.contacts));
  }
  session::ModelShelf shelf(std::move(models));
  for (const auto& [model, hash] : file.hashes) {
    progress.checkpoint();
    if (hashOf(shelf, model) != hash) {
      rejectInput("session: {} is another one than the session was saved with", quoted(model));
    }
  }
}

session::Session openSession(const SessionFile& file,
                             session::SessionModels models,
                             const Progress& progress) {
  requireSameModels(file, models, progress);
  return {std::move(models), file.session};
}

}  // namespace handgraft::io
