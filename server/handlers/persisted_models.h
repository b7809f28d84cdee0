#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "server/store/model_recipe.h"
#include "server/store/model_store.h"
#include "server/store/state_store.h"

namespace handgraft::server {

/// The models of a state store, made again when they are first asked for.
class PersistedModels final : public ModelKeeper,
                              public std::enable_shared_from_this<PersistedModels> {
 public:
  /// `built_in` finds what others rest on; both must outlive it.
  PersistedModels(StateStore& store, const ModelStore& built_in)
      : store_(store), built_in_(built_in) {}

  /// Puts all that have a name into `models`.
  void listIn(ModelStore& models);

  /// Keeps one: its row. Errors: as StateStore::addModel.
  std::int64_t keep(const v1::ModelSummary& summary,
                    const Origin& origin,
                    const ModelRecipe& recipe,
                    const RequestKey& by,
                    const std::string& operation);

  // === ModelKeeper
  std::shared_ptr<const StoredHand> hand(std::int64_t row) override;
  std::shared_ptr<const StoredObject> object(std::int64_t row) override;
  std::shared_ptr<const StoredContacts> contacts(std::int64_t row) override;
  std::shared_ptr<const StoredMotion> motion(std::int64_t row) override;

  /// A session's models, by the names under which it knew them; else built-in ones.
  std::shared_ptr<const NamedModels> named(const std::vector<std::int64_t>& rows);

 private:
  class OfSession;

  /// The one in use, or what `make` makes of what is kept.
  template <class Model, class Make>
  std::shared_ptr<const Model> get(std::map<std::int64_t, std::weak_ptr<const Model>>& in_use,
                                   std::int64_t row,
                                   const Make& make);
  std::shared_ptr<const StoredObject> baseObject(const PersistedModel& kept);

  StateStore& store_;
  const ModelStore& built_in_;
  std::mutex mutex_;
  std::map<std::int64_t, std::weak_ptr<const StoredHand>> hands_;
  std::map<std::int64_t, std::weak_ptr<const StoredObject>> objects_;
  std::map<std::int64_t, std::weak_ptr<const StoredContacts>> contacts_;
  std::map<std::int64_t, std::weak_ptr<const StoredMotion>> motions_;
};

}  // namespace handgraft::server
