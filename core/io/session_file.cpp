#include "core/io/session_file.h"

#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/base/base64.h"
#include "core/base/error.h"
#include "core/io/session_spelling.h"
#include "core/io/session_writer.h"

namespace handgraft::io {
namespace {

using nlohmann::ordered_json;

/// "hand NAME".
std::pair<std::string, std::string> kindAndName(const std::string& model) {
  const std::size_t space = model.find(' ');
  return {model.substr(0, space), space == std::string::npos ? "" : model.substr(space + 1)};
}

std::string hashOf(session::ModelCache& cache, const std::string& model) {
  const auto [kind, name] = kindAndName(model);
  if (kind == "hand") return cache.handHash(name);
  if (kind == "object") return cache.objectHash(name);
  if (kind == "contacts" && name == cache.first().contacts_name) return cache.contactsHash();
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
                               const session::ModelCache& cache) {
  std::set<std::string> models = {"contacts " + cache.first().contacts_name,
                                  "hand " + cache.first().hand_name,
                                  "object " + cache.first().object_name};
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

std::string sessionText(session::Session& session,
                        const std::vector<EmbeddedModel>& held,
                        const MotionOfSession& motion) {
  session::ModelCache& cache = session.cache();
  ordered_json file;
  file["format"] = kSessionFormat;
  file["models"] = {{"hand", cache.first().hand_name},
                    {"object", cache.first().object_name},
                    {"contacts", cache.first().contacts_name}};
  if (!motion.name.empty()) {
    HANDGRAFT_REQUIRE(motion.name == cache.first().contacts_name);
    file["models"]["motion"] = motion.content;
  }
  const session::SavedSession saved = session.saved();
  for (const std::string& model : modelsIn(saved, cache))
    file["models"]["hashes"][model] = hashOf(cache, model);
  for (const EmbeddedModel& model : held) {
    file["models"]["held"].push_back({{"kind", model.kind},
                                      {"name", model.name},
                                      {"content", model.content},
                                      {"form", model.form},
                                      {"settings", base64Of(model.settings)},
                                      {"bytes", base64Of(model.bytes)},
                                      {"base", model.base}});
  }
  file["revision"] = saved.revision;
  file["history"] = jsonOf(saved.history);
  file["first"] = {{"revision", saved.first.revision},
                   {"history", jsonOf(saved.first.history)}};
  file["log"] = ordered_json::array();
  for (const session::LogEntry& entry : saved.log)
    file["log"].push_back(jsonOf(entry));
  return file.dump(-1, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

std::set<std::pair<std::string, std::string>> modelsNamedIn(session::Session& session) {
  std::set<std::pair<std::string, std::string>> models;
  for (const std::string& model : modelsIn(session.saved(), session.cache()))
    models.insert(kindAndName(model));
  return models;
}

std::string entryText(const session::LogEntry& entry) {
  return jsonOf(entry).dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

void requireSameModels(const SessionFile& file,
                       session::SessionModels models,
                       const Progress& progress) {
  if (models.hand_name != file.hand || models.object_name != file.object ||
      models.contacts_name != file.contacts) {
    rejectInput("session: it was opened with hand {}, object {} and contacts {}",
                quoted(file.hand), quoted(file.object), quoted(file.contacts));
  }
  session::ModelCache cache(std::move(models));
  for (const auto& [model, hash] : file.hashes) {
    progress.checkpoint();
    if (hashOf(cache, model) != hash) {
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
