#include <algorithm>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "core/base/base64.h"
#include "core/base/error.h"
#include "core/io/session_field.h"
#include "core/io/session_file.h"

namespace handgraft::io {
namespace {

using nlohmann::ordered_json;
using Field = SessionField;

constexpr std::size_t kMostBytes = 32U << 20U;

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
    field["kind"].reject("is {}; permitted are {}", handgraft::quoted(kind),
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
    steps.pushBack(std::move(step));
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
  field.requireOnly({"edit", "solve", "cancelled", "motion"});
  if (field.has("edit")) return editOf(field["edit"]);
  if (field.has("cancelled")) return session::CancelledSolve();
  if (field.has("motion")) {
    session::FollowedMotion followed;
    field["motion"].read(followed);
    return followed;
  }
  const Field solve = field["solve"];
  solve.requireOnly({"solving", "objective", "change", "is_step"});
  auto committed = std::make_shared<session::CommittedSolve>();
  solve["solving"].read(committed->solving);
  solve["objective"].read(committed->objective);
  solve["change"].read(committed->change);
  if (solve.has("is_step")) {
    bool is_step = false;
    solve["is_step"].read(is_step);
    committed->is_step = is_step;
  }
  return std::shared_ptr<const session::CommittedSolve>(std::move(committed));
}

std::vector<EmbeddedModel> heldIn(const Field& field) {
  if (field.size() > 2 * session::kMostModels + 1)
    field.reject("has {} models; permitted are {}", field.size(), 2 * session::kMostModels + 1);
  const auto bytes_of = [](const Field& text) {
    const std::string coded = text.text(kMostBytes);
    try {
      return bytesOfBase64(coded);
    } catch (const InvalidInput& error) {
      text.reject("{}", error.what());
    }
  };
  std::vector<EmbeddedModel> held;
  for (std::size_t i = 0; i < field.size(); ++i) {
    const Field entry = field.at(i);
    entry.requireOnly({"kind", "name", "content", "form", "settings", "bytes", "base"});
    EmbeddedModel model;
    entry["kind"].read(model.kind);
    if (model.kind != "hand" && model.kind != "object" && model.kind != "contacts" &&
        model.kind != "motion") {
      entry["kind"].reject("is {}; permitted are hand object contacts motion",
                           handgraft::quoted(model.kind));
    }
    entry["name"].read(model.name);
    entry["content"].read(model.content);
    entry["form"].read(model.form);
    entry["base"].read(model.base);
    model.settings = bytes_of(entry["settings"]);
    model.bytes = bytes_of(entry["bytes"]);
    held.push_back(std::move(model));
  }
  return held;
}

}  // namespace

SessionFile readSessionText(const std::string& text) {
  if (text.size() > kMostBytes)
    rejectInput("session: {} bytes; permitted are {}", text.size(), kMostBytes);
  ordered_json document;
  try {
    document = ordered_json::parse(text);
  } catch (const ordered_json::parse_error& failure) {
    const std::size_t end = std::min(failure.byte, text.size());
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<long>(end), '\n');
    rejectInput("session: not JSON: it breaks off or goes wrong in line {}, at byte {}", line,
                end);
  } catch (const ordered_json::exception&) {
    rejectInput("session: not JSON: a number in it is too large");
  }
  const Field file(document, "");
  const std::string format = file["format"].text();
  if (format != kSessionFormat)
    file["format"].reject("is {}; it must be '{}'", handgraft::quoted(format), kSessionFormat);
  file.requireOnly({"format", "models", "revision", "history", "first", "log"});

  SessionFile result;
  const Field models = file["models"];
  models.requireOnly({"hand", "object", "contacts", "motion", "hashes", "held"});
  models["hand"].read(result.hand);
  models["object"].read(result.object);
  models["contacts"].read(result.contacts);
  if (models.has("motion")) {
    result.motion.name = result.contacts;
    models["motion"].read(result.motion.content);
  }
  models["hashes"].each([&](const std::string& model, const Field& hash) {
    hash.read(result.hashes[model]);
  });
  if (result.hashes.size() > 2 * session::kMostModels + 1) {
    models["hashes"].reject("has {} models; permitted are {}", result.hashes.size(),
                            2 * session::kMostModels + 1);
  }
  for (const std::string& model :
       {"hand " + result.hand, "object " + result.object, "contacts " + result.contacts}) {
    if (result.hashes.count(model) == 0)
      models["hashes"].reject("lacks {}", handgraft::quoted(model));
  }
  if (models.has("held")) result.held = heldIn(models["held"]);
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

session::LogEntry readEntryText(const std::string& text) {
  try {
    const ordered_json document = ordered_json::parse(text);
    return entryOf(Field(document, "entry"));
  } catch (const ordered_json::exception& error) {
    rejectInput("session entry: not JSON: {}", error.what());
  }
}

}  // namespace handgraft::io
