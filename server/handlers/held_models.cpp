#include "server/handlers/held_models.h"

#include <set>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "idl/json.h"
#include "server/admission/rejection.h"
#include "server/handlers/enter_model.h"
#include "server/handlers/variant.h"
#include "server/reading/packed.h"
#include "server/store/state_store.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kMostHeld = 16u << 20;  // a file has its bound, too

Makings makingsOf(const Origin& origin, const Workshop& workshop) {
  if (origin.makings != nullptr) return *origin.makings;
  const KeptModel kept = workshop.state->model(origin.row);
  return {kept.form, kept.settings, workshop.state->bytesOf(origin.row), kept.base,
          kept.base_name};
}

Origin originOf(const std::string& kind, const std::string& name, const ModelStore& models) {
  if (kind == "hand") return models.hand(name)->origin;
  if (kind == "object") return models.object(name)->origin;
  return models.contacts(name)->origin;
}

bool isNamed(const std::string& kind, const std::string& name, const ModelStore& models) {
  try {
    static_cast<void>(originOf(kind, name, models));
    return true;
  } catch (const Rejection&) {
    return false;
  }
}

/// Puts models into a list, what they rest on first.
class Collecting {
 public:
  explicit Collecting(const Workshop& workshop) : workshop_(workshop) {}

  void add(const std::string& kind, const std::string& name) {
    if (!seen_.insert({kind, name}).second) return;
    const Origin origin = originOf(kind, name, workshop_.models);
    if (origin.makings == nullptr && origin.row == 0) return;  // built-in
    Makings makings = makingsOf(origin, workshop_);
    if (!makings.base_name.empty()) add(kind == "hand" ? "hand" : "object", makings.base_name);
    bytes_ += makings.settings.size() + makings.bytes.size();
    if (bytes_ > kMostHeld) return;  // who opens it hears what is lacking
    held_.push_back({kind, name, origin.content, std::move(makings.form),
                     std::move(makings.settings), std::move(makings.bytes),
                     std::move(makings.base_name)});
  }

  std::vector<io::HeldModel> take() { return std::move(held_); }

 private:
  const Workshop& workshop_;
  std::set<std::pair<std::string, std::string>> seen_;
  std::vector<io::HeldModel> held_;
  std::size_t bytes_ = 0;
};

template <class Read>
Read readOf(const io::HeldModel& held, const io::MeshFile* object = nullptr) {
  ReadModel model = unpackModel(held.bytes, object);
  if (!std::holds_alternative<Read>(model)) rejectInput("it holds a model of another kind");
  return std::get<Read>(std::move(model));
}

void enter(const io::HeldModel& held, Workshop& workshop) {
  Origin origin;
  origin.content = held.content;
  const auto put = [&](auto model, std::int64_t base_row = 0) {
    // Nobody's request is done by this: the session is what it asks for.
    enterModel(std::move(model), workshop, Mark(), "load_model", [&] {
      return Makings{held.form, held.settings, held.bytes, base_row, held.base};
    });
  };
  if (held.form == kVariantForm) {
    const auto parent = workshop.models.hand(held.base);
    const auto request = idl::fromJsonText<v1::VariantRequest>(held.settings);
    return put(variantHand(request, *parent), parent->origin.row);
  }
  if (held.form != kReadForm) rejectInput("its form {} is not known", quoted(held.form));
  const ReadRequest how = unpackRequest(held.settings);
  if (held.kind == "hand")
    return put(storedHand(held.name, origin, readOf<ReadHand>(held), how.hand));
  if (held.kind == "object")
    return put(storedObject(held.name, origin, readOf<io::MeshFile>(held), how.units));
  const auto object = workshop.models.object(held.base);
  put(storedContacts(held.name, origin, readOf<ReadContacts>(held, object->file.get()),
                     object->file, held.base),
      object->origin.row);
}

}  // namespace

bool isThere(const std::string& model, const ModelStore& models) {
  const std::size_t space = model.find(' ');
  return space != std::string::npos &&
         isNamed(model.substr(0, space), model.substr(space + 1), models);
}

std::vector<io::HeldModel> heldModels(session::Session& session, const Workshop& workshop) {
  Collecting held(workshop);
  for (const auto& [kind, name] : io::modelsNamedIn(session)) {
    if (isNamed(kind, name, workshop.models)) held.add(kind, name);
  }
  return held.take();
}

void takeUp(const std::vector<io::HeldModel>& models,
            Workshop& workshop,
            const Progress& progress) {
  for (const io::HeldModel& held : models) {
    progress.checkpoint();
    if (isNamed(held.kind, held.name, workshop.models)) continue;
    try {
      enter(held, workshop);
    } catch (const InvalidInput& error) {
      rejectInput("session: {} {} that it holds: {}", held.kind, quoted(held.name),
                  error.what());
    }
  }
}

}  // namespace handgraft::server
