#include "server/store/model_store.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include <fmt/format.h>

#include "core/base/error.h"
#include "core/retargeting/motion_solving.h"
#include "idl/fields.h"
#include "server/base/rejection.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kMostModels = 1000;  // of one kind

v1::ModelKind kindOf(const StoredHand&) {
  return v1::MODEL_HAND;
}

v1::ModelKind kindOf(const StoredObject&) {
  return v1::MODEL_OBJECT;
}

v1::ModelKind kindOf(const StoredContacts&) {
  return v1::MODEL_CONTACTS;
}

v1::ModelKind kindOf(const StoredMotion&) {
  return v1::MODEL_MOTION;
}

v1::ModelSummary summary(v1::ModelKind kind,
                         const std::string& name,
                         const Origin& origin,
                         std::string text) {
  v1::ModelSummary one;
  one.kind(kind);
  one.name(name);
  one.built_in(origin.built_in);
  one.text(std::move(text));
  return one;
}

bool isSame(const geometry::TriangleMesh& a, const geometry::TriangleMesh& b) {
  return &a == &b || (a.vertexCount() == b.vertexCount() && a.faceCount() == b.faceCount() &&
                      a.faces() == b.faces() && a.vertices() == b.vertices());
}

template <class ModelMap>
auto find(ModelMap& models, v1::ModelKind kind, const std::string& name) {
  const auto found = models.find(name);
  if (found != models.end()) return found;
  std::string names;
  for (const auto& [other, model] : models) {
    names += (names.empty() ? "" : ", ") + other;
    if (names.size() > 400) {
      names += ", ...";
      break;
    }
  }
  reject(v1::ERROR_NOT_FOUND, "{} {} is not known; there are: {}", nameOf(kind),
         handgraft::quoted(name), names.empty() ? "none" : names);
}

/// False if it is there already. Errors: Rejection (ERROR_CONFLICT), (ERROR_OVERLOADED).
template <class ModelMap>
bool finds(ModelMap& models,
           v1::ModelKind kind,
           const std::string& name,
           const std::string& content) {
  const auto found = models.find(name);
  if (found != models.end()) {
    const Origin& there = found->second.origin;
    if (!there.built_in && there.content == content) return false;
    reject(v1::ERROR_CONFLICT, "{} {} exists already, with {}; choose another name{}",
           nameOf(kind), handgraft::quoted(name),
           there.built_in ? "the server's own content" : "other content",
           there.built_in ? "" : " or unload it");
  }
  if (models.size() >= kMostModels) {
    reject(v1::ERROR_OVERLOADED, "there are {} models of this kind; unload some",
           models.size());
  }
  return true;
}

}  // namespace

template <class Action>
auto ModelStore::onModels(v1::ModelKind kind, const Action& action) const {
  switch (kind) {
    case v1::MODEL_HAND:
      return action(hands_);
    case v1::MODEL_OBJECT:
      return action(objects_);
    case v1::MODEL_CONTACTS:
      return action(contacts_);
    case v1::MODEL_MOTION:
      return action(motions_);
  }
  rejectInput("model kind {} does not exist", static_cast<unsigned>(kind));
}

template <class Model>
void ModelStore::put(ModelMap<Model>& models, Model model, bool replace) {
  validateName(model.name);
  const std::lock_guard lock(mutex_);
  if (!replace && !finds(models, kindOf(model), model.name, model.origin.content)) return;
  const std::string name = model.name;
  const Origin origin = model.origin;
  models[name] = {std::make_shared<const Model>(std::move(model)), origin, {}, nullptr};
}

bool ModelStore::lacks(v1::ModelKind kind,
                       const std::string& name,
                       const std::string& content) const {
  validateName(name);
  const std::lock_guard lock(mutex_);
  return onModels(kind, [&](auto& models) {
    return finds(models, kind, name, content);
  });
}

void ModelStore::addKept(const v1::ModelSummary& summary,
                         const Origin& origin,
                         std::shared_ptr<ModelKeeper> keeper) {
  validateName(summary.name());
  const std::lock_guard lock(mutex_);
  onModels(summary.kind(), [&](auto& models) {
    // A name that the program's own library has taken since stands for that.
    if (models.count(summary.name()) != 0) return;
    models[summary.name()] = {nullptr, origin, summary, std::move(keeper)};
  });
}

template <class Model, class Read>
std::shared_ptr<const Model> ModelStore::get(ModelMap<Model>& models,
                                             v1::ModelKind kind,
                                             const std::string& name,
                                             const Read& read) const {
  std::unique_lock lock(mutex_);
  const Place<Model> place = find(models, kind, name)->second;
  if (place.model != nullptr) return place.model;
  lock.unlock();
  auto model = read(*place.keeper, place.origin.row);
  lock.lock();
  // Unless it was taken out meanwhile.
  const auto found = models.find(name);
  if (found != models.end() && found->second.origin.row == place.origin.row)
    found->second.model = model;
  return model;
}

void ModelStore::add(StoredHand hand) {
  put(hands_, std::move(hand), false);
}

void ModelStore::add(StoredObject object) {
  put(objects_, std::move(object), false);
}

void ModelStore::add(StoredContacts contacts) {
  put(contacts_, std::move(contacts), false);
}

void ModelStore::add(StoredMotion motion) {
  put(motions_, std::move(motion), false);
}

void ModelStore::replace(StoredHand hand) {
  put(hands_, std::move(hand), true);
}

void ModelStore::replace(StoredObject object) {
  put(objects_, std::move(object), true);
}

void ModelStore::replace(StoredContacts contacts) {
  put(contacts_, std::move(contacts), true);
}

std::shared_ptr<const StoredHand> ModelStore::hand(const std::string& name) const {
  return get(hands_, v1::MODEL_HAND, name, [](ModelKeeper& keeper, std::int64_t row) {
    return keeper.hand(row);
  });
}

std::shared_ptr<const StoredObject> ModelStore::object(const std::string& name) const {
  return get(objects_, v1::MODEL_OBJECT, name, [](ModelKeeper& keeper, std::int64_t row) {
    return keeper.object(row);
  });
}

std::shared_ptr<const StoredContacts> ModelStore::contacts(const std::string& name) const {
  return get(contacts_, v1::MODEL_CONTACTS, name, [](ModelKeeper& keeper, std::int64_t row) {
    return keeper.contacts(row);
  });
}

std::shared_ptr<const StoredMotion> ModelStore::motion(const std::string& name) const {
  return get(motions_, v1::MODEL_MOTION, name, [](ModelKeeper& keeper, std::int64_t row) {
    return keeper.motion(row);
  });
}

void ModelStore::requireRemovable(v1::ModelKind kind, const std::string& name) const {
  const std::lock_guard lock(mutex_);
  onModels(kind, [&](auto& models) {
    if (!find(models, kind, name)->second.origin.built_in) return;
    reject(v1::ERROR_CONFLICT, "{} {} is the server's own and stays", nameOf(kind),
           handgraft::quoted(name));
  });
}

void ModelStore::remove(v1::ModelKind kind, const std::string& name) {
  requireRemovable(kind, name);
  const std::lock_guard lock(mutex_);
  onModels(kind, [&](auto& models) {
    models.erase(name);
  });
}

std::vector<v1::ModelSummary> ModelStore::list() const {
  const std::lock_guard lock(mutex_);
  std::vector<v1::ModelSummary> all;
  const auto add = [&](const auto& models) {
    for (const auto& [name, place] : models)
      all.push_back(place.model != nullptr ? summaryOf(*place.model) : place.summary);
  };
  add(hands_);
  add(objects_);
  add(contacts_);
  add(motions_);
  return all;
}

std::size_t ModelStore::size() const {
  const std::lock_guard lock(mutex_);
  return hands_.size() + objects_.size() + contacts_.size() + motions_.size();
}

StoredHand storedHand(std::string name, Origin origin, ReadHand read, const HandReading& how) {
  StoredHand hand;
  hand.name = std::move(name);
  hand.origin = std::move(origin);
  hand.urdf = std::move(read.urdf);
  hand.notes = std::move(read.notes);
  hand.hand =
      std::make_shared<LazyHand>(std::make_shared<const hand::HandModel>(std::move(read.model)),
                                 std::move(read.sites), how.skin);
  hand.mirrored = how.mirrored;
  hand.poses = std::move(read.poses);
  if (read.floating_base)
    hand.floating_base =
        std::make_shared<const hand::HandModel>(std::move(*read.floating_base));
  return hand;
}

StoredObject storedObject(std::string name,
                          Origin origin,
                          io::MeshFile read,
                          std::string units) {
  return {std::move(name), std::move(origin),
          std::make_shared<const io::MeshFile>(std::move(read)), std::move(units)};
}

StoredContacts storedContacts(std::string name,
                              Origin origin,
                              ReadContacts read,
                              std::shared_ptr<const io::MeshFile> object,
                              std::string object_name) {
  StoredContacts contacts;
  contacts.name = std::move(name);
  contacts.origin = std::move(origin);
  contacts.object = std::move(object);
  contacts.set = std::move(read.set);
  // An object sent under another name may be the same; its numbers of faces say nothing else.
  const std::string& meant = contacts.set.object;
  if (!meant.empty() && !object_name.starts_with(meant)) {
    contacts.set.notes.push_back(fmt::format(
        "the set says that it lies on object {}; its faces and vertices were taken of {}",
        handgraft::quoted(meant), handgraft::quoted(object_name)));
  }
  contacts.set.object = std::move(object_name);
  if (read.map)
    contacts.map = std::make_shared<const contact::ContactMap>(std::move(*read.map));
  contacts.threshold = read.threshold;
  return contacts;
}

StoredMotion storedMotion(std::string name,
                          Origin origin,
                          ReadMotion read,
                          std::shared_ptr<const io::MeshFile> object,
                          std::string object_name) {
  StoredMotion motion;
  motion.name = std::move(name);
  motion.origin = std::move(origin);
  motion.object = std::move(object);
  motion.object_name = std::move(object_name);
  read.motion.object = motion.object_name;
  read.motion.name = motion.name;
  motion.motion = std::make_shared<const manipulation::Motion>(std::move(read.motion));
  return motion;
}

void validateName(const std::string& name) {
  constexpr std::size_t kLongest = 64;
  const bool fits = !name.empty() && name.size() <= kLongest && name.front() != '.' &&
                    std::all_of(name.begin(), name.end(), [](char c) {
                      return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' ||
                             c == '-' || c == '.';
                    });
  if (!fits) {
    rejectInput(
        "name {}: must be 1-{} letters, digits, '_', '-' or '.', not beginning with a dot",
        handgraft::quoted(name), kLongest);
  }
}

void requireSameMesh(const StoredContacts& contacts, const StoredObject& object) {
  if (isSame(contacts.object->mesh, object.file->mesh)) return;
  rejectInput("contacts {} were read for object {}, which is another mesh than object {}",
              handgraft::quoted(contacts.name), handgraft::quoted(contacts.set.object),
              handgraft::quoted(object.name));
}

void requireSameMesh(const StoredMotion& motion, const StoredObject& object) {
  if (isSame(motion.object->mesh, object.file->mesh)) return;
  rejectInput("motion {} was read for object {}, which is another mesh than object {}",
              handgraft::quoted(motion.name), handgraft::quoted(motion.object_name),
              handgraft::quoted(object.name));
}

v1::ModelSummary summaryOf(const StoredHand& hand) {
  const hand::HandModel& model = hand.hand->model();
  std::string text = fmt::format("{} joints, {} links", model.dofCount(), model.linkCount());
  if (model.mimicCount() > 0) text += fmt::format(", {} mimic", model.mimicCount());
  if (const auto& sites = hand.hand->ownSites())
    text += fmt::format(", {} sites", sites->size());
  return summary(v1::MODEL_HAND, hand.name, hand.origin, text);
}

v1::ModelSummary summaryOf(const StoredObject& object) {
  const geometry::TriangleMesh& mesh = object.file->mesh;
  return summary(v1::MODEL_OBJECT, object.name, object.origin,
                 fmt::format("{} vertices, {} faces, {:.0f} mm across", mesh.vertexCount(),
                             mesh.faceCount(), 1e3 * mesh.diagonal()));
}

v1::ModelSummary summaryOf(const StoredContacts& contacts) {
  std::string names;
  for (const contact::Patch& patch : contacts.set.patches) {
    names += (names.empty() ? "" : " ") + patch.name;
  }
  return summary(v1::MODEL_CONTACTS, contacts.name, contacts.origin,
                 fmt::format("{} patches on {}: {}", contacts.set.patches.size(),
                             contacts.set.object, names));
}

v1::ModelSummary summaryOf(const StoredMotion& motion) {
  const manipulation::Motion& frames = *motion.motion;
  return summary(v1::MODEL_MOTION, motion.name, motion.origin,
                 fmt::format("{} frames in {:.2f} s, {} patches on {}", frames.frameCount(),
                             frames.duration(), retargeting::patchNames(frames).size(),
                             motion.object_name));
}

}  // namespace handgraft::server
