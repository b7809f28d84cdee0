#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/contact/contact_set.h"
#include "core/io/mesh_file.h"
#include "idl/models.h"
#include "server/reading/read_model.h"
#include "server/store/lazy_hand.h"
#include "server/store/model_recipe.h"

namespace handgraft::server {

/// Where a model came from.
struct Origin {
  bool built_in = false;
  /// ContentHash of what it was made from; empty for built-in ones.
  std::string content = {};
  /// Of the state store that keeps it; 0: none does.
  std::int64_t row = 0;
  /// Where no store keeps it; null for built-in ones.
  std::shared_ptr<const ModelRecipe> recipe = {};
};

struct StoredHand {
  std::string name;
  Origin origin;
  std::string urdf;
  std::vector<std::string> notes;
  std::shared_ptr<LazyHand> hand;
  bool mirrored = false;  ///< then `urdf` describes the other hand
  std::vector<hand::NamedPose> poses{};
  /// Joints of the file that place the whole hand, cut off (hand/floating_base.h); or null.
  std::shared_ptr<const hand::HandModel> floating_base{};
};

struct StoredObject {
  std::string name;
  Origin origin;
  std::shared_ptr<const io::MeshFile> file;
  std::string units{};  ///< it was read in, as the request named them
};

struct StoredContacts {
  std::string name;
  Origin origin;
  /// The object as it was when the set was read; `set.object` is its name.
  std::shared_ptr<const io::MeshFile> object;
  contact::ContactSet set;
  /// What the patches were found in, and at which threshold; null for sets.
  std::shared_ptr<const contact::ContactMap> map{};
  double threshold = 0.0;
};

struct StoredMotion {
  std::string name;
  Origin origin;
  /// The object as it was when the motion was read.
  std::shared_ptr<const io::MeshFile> object;
  std::string object_name;
  std::shared_ptr<const manipulation::Motion> motion;
};

// === Of what was read (reading/read_model.h)
StoredHand storedHand(std::string name, Origin origin, ReadHand read, const HandReading& how);
StoredObject storedObject(std::string name,
                          Origin origin,
                          io::MeshFile read,
                          std::string units);
StoredContacts storedContacts(std::string name,
                              Origin origin,
                              ReadContacts read,
                              std::shared_ptr<const io::MeshFile> object,
                              std::string object_name);

StoredMotion storedMotion(std::string name,
                          Origin origin,
                          ReadMotion read,
                          std::shared_ptr<const io::MeshFile> object,
                          std::string object_name);

/// Models by name. Errors: Rejection (ERROR_NOT_FOUND) that lists the names there are.
/// Threads: all methods from any thread.
class NamedModels {
 public:
  virtual ~NamedModels() = default;
  [[nodiscard]] virtual std::shared_ptr<const StoredHand> hand(
      const std::string& name) const = 0;
  [[nodiscard]] virtual std::shared_ptr<const StoredObject> object(
      const std::string& name) const = 0;
  [[nodiscard]] virtual std::shared_ptr<const StoredContacts> contacts(
      const std::string& name) const = 0;
  [[nodiscard]] virtual std::shared_ptr<const StoredMotion> motion(
      const std::string& name) const = 0;
};

/// Where models lie that were kept, by row. Threads: all methods from any thread. Errors:
/// StorageError; those of what a model rests on.
class ModelKeeper {
 public:
  virtual ~ModelKeeper() = default;
  virtual std::shared_ptr<const StoredHand> hand(std::int64_t row) = 0;
  virtual std::shared_ptr<const StoredObject> object(std::int64_t row) = 0;
  virtual std::shared_ptr<const StoredContacts> contacts(std::int64_t row) = 0;
  virtual std::shared_ptr<const StoredMotion> motion(std::int64_t row) = 0;
};

/// The hands, objects, contact sets and motions that sessions can use, by name.
///
/// What is taken out lives on in the sessions that use it. Threads: all methods from any
/// thread.
class ModelStore final : public NamedModels {
 public:
  /// Adds a model. The same files under the same name again change nothing.
  /// Errors: InvalidInput for a bad name (see `validateName`); Rejection (ERROR_CONFLICT) if
  /// the name stands for other content, (ERROR_OVERLOADED) if there are too many.
  void add(StoredHand hand);
  void add(StoredObject object);
  void add(StoredContacts contacts);
  void add(StoredMotion motion);

  /// Whether a model of that content has to be made: false if the name stands for it already.
  /// Errors: as `add`.
  [[nodiscard]] bool lacks(v1::ModelKind kind,
                           const std::string& name,
                           const std::string& content) const;

  /// Adds one that `keeper` reads when it is first asked for.
  void addKept(const v1::ModelSummary& summary,
               const Origin& origin,
               std::shared_ptr<ModelKeeper> keeper);

  /// As above, but takes the place of what has the name.
  void replace(StoredHand hand);
  void replace(StoredObject object);
  void replace(StoredContacts contacts);

  [[nodiscard]] std::shared_ptr<const StoredHand> hand(const std::string& name) const override;
  [[nodiscard]] std::shared_ptr<const StoredObject> object(
      const std::string& name) const override;
  [[nodiscard]] std::shared_ptr<const StoredContacts> contacts(
      const std::string& name) const override;
  [[nodiscard]] std::shared_ptr<const StoredMotion> motion(
      const std::string& name) const override;

  /// Errors: Rejection: ERROR_NOT_FOUND, or ERROR_CONFLICT for a built-in model.
  void remove(v1::ModelKind kind, const std::string& name);
  void requireRemovable(v1::ModelKind kind, const std::string& name) const;

  /// All, by kind and name.
  [[nodiscard]] std::vector<v1::ModelSummary> list() const;
  [[nodiscard]] std::size_t size() const;

 private:
  /// A model, or where it lies until somebody asks for it.
  template <class Model>
  struct Place {
    std::shared_ptr<const Model> model;
    Origin origin;
    v1::ModelSummary summary;  ///< while there is no model
    std::shared_ptr<ModelKeeper> keeper;
  };

  template <class Model>
  using ModelMap = std::map<std::string, Place<Model>>;

  template <class Model>
  void put(ModelMap<Model>& models, Model model, bool replace);
  template <class Model, class Read>
  std::shared_ptr<const Model> get(ModelMap<Model>& models,
                                   v1::ModelKind kind,
                                   const std::string& name,
                                   const Read& read) const;
  /// `action(models)` of that kind. Errors: InvalidInput if there is no such kind.
  template <class Action>
  auto onModels(v1::ModelKind kind, const Action& action) const;

  mutable std::mutex mutex_;
  // What is kept is put into its place by those who ask.
  mutable ModelMap<StoredHand> hands_;
  mutable ModelMap<StoredObject> objects_;
  mutable ModelMap<StoredContacts> contacts_;
  mutable ModelMap<StoredMotion> motions_;
};

/// Names are 1-64 letters, digits, `_`, `-` and `.`, and do not begin with a dot: they appear
/// in topics, files and messages. InvalidInput otherwise.
void validateName(const std::string& name);

/// InvalidInput unless contacts, or a motion, were read for a mesh like the object's. An object
/// that was taken out and loaded again is the same one.
void requireSameMesh(const StoredContacts& contacts, const StoredObject& object);
void requireSameMesh(const StoredMotion& motion, const StoredObject& object);

v1::ModelSummary summaryOf(const StoredHand& hand);
v1::ModelSummary summaryOf(const StoredObject& object);
v1::ModelSummary summaryOf(const StoredContacts& contacts);
v1::ModelSummary summaryOf(const StoredMotion& motion);

}  // namespace handgraft::server
