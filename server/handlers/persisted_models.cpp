#include "server/handlers/persisted_models.h"

#include <fmt/format.h>

#include "core/base/error.h"
#include "idl/json.h"
#include "server/handlers/variant.h"
#include "server/reading/packed.h"

namespace handgraft::server {

namespace {

template <class Read>
Read readOf(const PersistedModel& kept, const std::string& bytes, const io::MeshFile* object) {
  const std::optional<int> form = packedFormOf(kept.form);
  if (!form) {
    throw StorageError(fmt::format("model {}: its form {} is not known",
                                   handgraft::quoted(kept.name), handgraft::quoted(kept.form)));
  }
  return std::get<Read>(unpackModel(bytes, object, *form));
}

}  // namespace

/// Those that a session named, while others may have taken their names.
class PersistedModels::OfSession final : public NamedModels {
 public:
  OfSession(std::shared_ptr<PersistedModels> kept, const std::vector<std::int64_t>& rows)
      : kept_(std::move(kept)) {
    for (const std::int64_t row : rows) {
      const PersistedModel model = kept_->store_.model(row);
      rows_[{static_cast<v1::ModelKind>(model.kind), model.name}] = row;
    }
  }

  [[nodiscard]] std::shared_ptr<const StoredHand> hand(const std::string& name) const override {
    const std::int64_t row = rowOf(v1::MODEL_HAND, name);
    return row != 0 ? kept_->hand(row) : kept_->built_in_.hand(name);
  }

  [[nodiscard]] std::shared_ptr<const StoredObject> object(
      const std::string& name) const override {
    const std::int64_t row = rowOf(v1::MODEL_OBJECT, name);
    return row != 0 ? kept_->object(row) : kept_->built_in_.object(name);
  }

  [[nodiscard]] std::shared_ptr<const StoredContacts> contacts(
      const std::string& name) const override {
    const std::int64_t row = rowOf(v1::MODEL_CONTACTS, name);
    return row != 0 ? kept_->contacts(row) : kept_->built_in_.contacts(name);
  }

  [[nodiscard]] std::shared_ptr<const StoredMotion> motion(
      const std::string& name) const override {
    const std::int64_t row = rowOf(v1::MODEL_MOTION, name);
    return row != 0 ? kept_->motion(row) : kept_->built_in_.motion(name);
  }

 private:
  [[nodiscard]] std::int64_t rowOf(v1::ModelKind kind, const std::string& name) const {
    const auto found = rows_.find({kind, name});
    return found == rows_.end() ? 0 : found->second;
  }

  std::shared_ptr<PersistedModels> kept_;
  std::map<std::pair<v1::ModelKind, std::string>, std::int64_t> rows_;
};

void PersistedModels::listIn(ModelStore& models) {
  for (const PersistedModel& kept : store_.models()) {
    Origin origin;
    origin.content = kept.content;
    origin.row = kept.row;
    models.addKept(idl::fromJsonText<v1::ModelSummary>(kept.summary), origin,
                   shared_from_this());
  }
}

std::int64_t PersistedModels::keep(const v1::ModelSummary& summary,
                                   const Origin& origin,
                                   const ModelRecipe& recipe,
                                   const RequestKey& by,
                                   const std::string& operation) {
  PersistedModel model;
  model.kind = static_cast<int>(summary.kind());
  model.name = summary.name();
  model.content = origin.content;
  model.summary = idl::jsonText(summary);
  model.form = recipe.form;
  model.settings = recipe.settings;
  model.base = recipe.base_row;
  model.base_name = recipe.base_name;
  return store_.addModel(model, recipe.bytes, by, operation);
}

template <class Model, class Make>
std::shared_ptr<const Model> PersistedModels::get(
    std::map<std::int64_t, std::weak_ptr<const Model>>& in_use,
    std::int64_t row,
    const Make& make) {
  {
    const std::lock_guard lock(mutex_);
    if (auto model = in_use[row].lock()) return model;
  }
  const PersistedModel kept = store_.model(row);
  Origin origin;
  origin.content = kept.content;
  origin.row = row;
  auto made = std::make_shared<const Model>(make(kept, origin));
  const std::lock_guard lock(mutex_);
  if (auto model = in_use[row].lock()) return model;  // somebody was faster
  in_use[row] = made;
  return made;
}

std::shared_ptr<const StoredObject> PersistedModels::baseObject(const PersistedModel& kept) {
  return kept.base != 0 ? object(kept.base) : built_in_.object(kept.base_name);
}

std::shared_ptr<const StoredHand> PersistedModels::hand(std::int64_t row) {
  return get(hands_, row, [&](const PersistedModel& kept, const Origin& origin) {
    if (kept.form == kVariantForm) {
      const auto request = idl::fromJsonText<v1::VariantRequest>(kept.settings);
      const auto parent = kept.base != 0 ? hand(kept.base) : built_in_.hand(kept.base_name);
      StoredHand variant = variantHand(request, *parent);
      variant.origin = origin;
      return variant;
    }
    return storedHand(kept.name, origin, readOf<ReadHand>(kept, store_.bytesOf(row), nullptr),
                      unpackRequest(kept.settings).hand);
  });
}

std::shared_ptr<const StoredObject> PersistedModels::object(std::int64_t row) {
  return get(objects_, row, [&](const PersistedModel& kept, const Origin& origin) {
    return storedObject(kept.name, origin,
                        readOf<io::MeshFile>(kept, store_.bytesOf(row), nullptr),
                        unpackRequest(kept.settings).units);
  });
}

std::shared_ptr<const StoredContacts> PersistedModels::contacts(std::int64_t row) {
  return get(contacts_, row, [&](const PersistedModel& kept, const Origin& origin) {
    const auto object = baseObject(kept);
    return storedContacts(kept.name, origin,
                          readOf<ReadContacts>(kept, store_.bytesOf(row), object->file.get()),
                          object->file, kept.base_name);
  });
}

std::shared_ptr<const StoredMotion> PersistedModels::motion(std::int64_t row) {
  return get(motions_, row, [&](const PersistedModel& kept, const Origin& origin) {
    const auto object = baseObject(kept);
    return storedMotion(kept.name, origin,
                        readOf<ReadMotion>(kept, store_.bytesOf(row), object->file.get()),
                        object->file, kept.base_name);
  });
}

std::shared_ptr<const NamedModels> PersistedModels::named(
    const std::vector<std::int64_t>& rows) {
  return std::make_shared<const OfSession>(shared_from_this(), rows);
}

}  // namespace handgraft::server
