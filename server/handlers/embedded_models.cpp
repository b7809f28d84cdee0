#include "server/handlers/embedded_models.h"

#include <set>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "idl/json.h"
#include "server/base/rejection.h"
#include "server/handlers/enter_model.h"
#include "server/handlers/persisted_models.h"
#include "server/handlers/variant.h"
#include "server/reading/packed.h"
#include "server/store/state_store.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kMostHeld = 16u << 20;  // a file has its bound, too

Origin originOf(const std::string& kind, const std::string& name, const NamedModels& models) {
  if (kind == "hand") return models.hand(name)->origin;
  if (kind == "object") return models.object(name)->origin;
  if (kind == "motion") return models.motion(name)->origin;
  return models.contacts(name)->origin;
}

bool isNamed(const std::string& kind, const std::string& name, const NamedModels& models) {
  try {
    static_cast<void>(originOf(kind, name, models));
    return true;
  } catch (const Rejection&) {
    return false;
  }
}

/// A session's own models, whoever has taken their names meanwhile. Where nothing is kept they
/// go by their names: the file's hashes tell whether another one has it.
std::shared_ptr<const NamedModels> modelsOf(const LiveSession& live,
                                            const HandlerContext& context) {
  if (live.journal != nullptr)
    return context.persisted_models->named(context.state->session(live.id()).models);
  return {std::shared_ptr<const NamedModels>(), &context.models};
}

/// Puts models into a list, what they rest on first.
class Collecting {
 public:
  Collecting(const NamedModels& models, const StateStore* state)
      : models_(models), state_(state) {}

  void add(const std::string& kind, const std::string& name) {
    add(kind, name, originOf(kind, name, models_));
  }

  std::vector<io::EmbeddedModel> take() { return std::move(held_); }

 private:
  void add(const std::string& kind, const std::string& name, const Origin& origin) {
    if (origin.recipe == nullptr && origin.row == 0) return;  // built-in
    if (!seen_.insert({kind, name}).second) return;
    ModelRecipe recipe = recipeOf(origin);
    if (!recipe.base_name.empty()) addBase(kind == "hand" ? "hand" : "object", recipe);
    bytes_ += recipe.settings.size() + recipe.bytes.size();
    if (bytes_ > kMostHeld) return;  // who opens it hears what is lacking
    held_.push_back({kind, name, origin.content, std::move(recipe.form),
                     std::move(recipe.settings), std::move(recipe.bytes),
                     std::move(recipe.base_name)});
  }

  void addBase(const std::string& kind, const ModelRecipe& recipe) {
    if (recipe.base_row == 0) return add(kind, recipe.base_name);
    Origin origin;
    origin.row = recipe.base_row;
    origin.content = state_->model(recipe.base_row).content;
    add(kind, recipe.base_name, origin);
  }

  [[nodiscard]] ModelRecipe recipeOf(const Origin& origin) const {
    if (origin.recipe != nullptr) return *origin.recipe;
    PersistedModel kept = state_->model(origin.row);
    return {std::move(kept.form), std::move(kept.settings), state_->bytesOf(origin.row),
            kept.base, std::move(kept.base_name)};
  }

  const NamedModels& models_;
  const StateStore* state_;
  std::set<std::pair<std::string, std::string>> seen_;
  std::vector<io::EmbeddedModel> held_;
  std::size_t bytes_ = 0;
};

template <class Read>
Read readOf(const io::EmbeddedModel& held, int form, const io::MeshFile* object = nullptr) {
  ReadModel model = unpackModel(held.bytes, object, form);
  if (!std::holds_alternative<Read>(model)) rejectInput("it holds a model of another kind");
  return std::get<Read>(std::move(model));
}

void enter(const io::EmbeddedModel& held, HandlerContext& context) {
  Origin origin;
  origin.content = held.content;
  const auto put = [&](auto model, std::int64_t base_row = 0) {
    // Nobody's request is done by this: the session is what it asks for.
    enterModel(std::move(model), context, RequestKey(), "load_model", [&] {
      return ModelRecipe{held.form, held.settings, held.bytes, base_row, held.base};
    });
  };
  if (held.form == kVariantForm) {
    const auto parent = context.models.hand(held.base);
    const auto request = idl::fromJsonText<v1::VariantRequest>(held.settings);
    return put(variantHand(request, *parent), parent->origin.row);
  }
  const std::optional<int> form = packedFormOf(held.form);
  if (!form) rejectInput("its form {} is not known", quoted(held.form));
  const ReadRequest how = unpackRequest(held.settings);
  if (held.kind == "hand")
    return put(storedHand(held.name, origin, readOf<ReadHand>(held, *form), how.hand));
  if (held.kind == "object")
    return put(storedObject(held.name, origin, readOf<io::MeshFile>(held, *form), how.units));
  const auto object = context.models.object(held.base);
  if (held.kind == "motion") {
    return put(
        storedMotion(held.name, origin, readOf<ReadMotion>(held, *form, object->file.get()),
                     object->file, held.base),
        object->origin.row);
  }
  put(storedContacts(held.name, origin, readOf<ReadContacts>(held, *form, object->file.get()),
                     object->file, held.base),
      object->origin.row);
}

}  // namespace

bool isThere(const std::string& model, const ModelStore& models) {
  const std::size_t space = model.find(' ');
  return space != std::string::npos &&
         isNamed(model.substr(0, space), model.substr(space + 1), models);
}

std::vector<io::EmbeddedModel> embeddedModels(LiveSession& live,
                                              const HandlerContext& context) {
  const auto models = modelsOf(live, context);
  Collecting held(*models, context.state);
  for (auto [kind, name] : io::modelsNamedIn(live.session())) {
    if (kind == "contacts" && live.motion() != nullptr) kind = "motion";
    if (isNamed(kind, name, *models)) held.add(kind, name);
  }
  return held.take();
}

Origin originOfMotion(LiveSession& live, const HandlerContext& context) {
  HANDGRAFT_REQUIRE(live.motion() != nullptr);
  return modelsOf(live, context)->motion(live.motion()->name)->origin;
}

void takeUp(const std::vector<io::EmbeddedModel>& models,
            HandlerContext& context,
            const Progress& progress) {
  for (const io::EmbeddedModel& held : models) {
    progress.checkpoint();
    if (isNamed(held.kind, held.name, context.models)) continue;
    try {
      enter(held, context);
    } catch (const InvalidInput& error) {
      rejectInput("session: {} {} that it holds: {}", held.kind, quoted(held.name),
                  error.what());
    }
  }
}

}  // namespace handgraft::server
