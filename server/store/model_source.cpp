#include "server/store/model_source.h"

#include <utility>

#include "core/retargeting/motion_grasps.h"
#include "core/retargeting/motion_solving.h"

namespace handgraft::server {

namespace {

class StoreSource final : public session::ModelSource {
 public:
  explicit StoreSource(std::shared_ptr<const NamedModels> models)
      : models_(std::move(models)) {}

  hand::Hand hand(const std::string& name, const Progress& progress) override {
    return models_->hand(name)->hand->get(progress);
  }

  std::shared_ptr<const geometry::TriangleMesh> object(const std::string& name,
                                                       const Progress& /*progress*/) override {
    return meshOf(models_->object(name));
  }

 private:
  std::shared_ptr<const NamedModels> models_;
};

session::SessionModels modelsOn(const std::string& hand,
                                const std::shared_ptr<const StoredHand>& stored_hand,
                                const std::string& object,
                                const std::shared_ptr<const StoredObject>& stored_object,
                                const std::string& contacts,
                                std::shared_ptr<const contact::ContactSet> set,
                                std::shared_ptr<session::ModelSource> source,
                                const Progress& progress) {
  session::SessionModels made;
  made.hand_name = hand;
  made.hand = stored_hand->hand->get(progress);
  made.object_name = object;
  made.object_O = meshOf(stored_object);
  made.contacts_name = contacts;
  made.contacts = std::move(set);
  made.source = std::move(source);
  return made;
}

}  // namespace

std::shared_ptr<session::ModelSource> sourceOf(std::shared_ptr<const NamedModels> models) {
  return std::make_shared<StoreSource>(std::move(models));
}

std::shared_ptr<session::ModelSource> sourceOf(const ModelStore& models) {
  // Owned by nobody here.
  return sourceOf(
      std::shared_ptr<const NamedModels>(std::shared_ptr<const NamedModels>(), &models));
}

std::shared_ptr<const geometry::TriangleMesh> meshOf(
    const std::shared_ptr<const StoredObject>& object) {
  return {object->file, &object->file->mesh};
}

session::SessionModels sessionModels(const std::string& hand,
                                     const std::string& object,
                                     const std::string& contacts,
                                     const NamedModels& models,
                                     std::shared_ptr<session::ModelSource> source,
                                     const Progress& progress) {
  const auto stored_hand = models.hand(hand);
  const auto stored_object = models.object(object);
  const auto stored = models.contacts(contacts);
  requireSameMesh(*stored, *stored_object);
  return modelsOn(hand, stored_hand, object, stored_object, contacts, {stored, &stored->set},
                  std::move(source), progress);
}

session::SessionModels motionModels(const std::string& hand,
                                    const std::string& object,
                                    const std::string& motion,
                                    const NamedModels& models,
                                    std::shared_ptr<session::ModelSource> source,
                                    const Progress& progress) {
  const auto stored_hand = models.hand(hand);
  const auto stored_object = models.object(object);
  const auto stored = models.motion(motion);
  requireSameMesh(*stored, *stored_object);
  auto grasp = std::make_shared<const contact::ContactSet>(
      retargeting::graspOf(*stored->motion, stored_object->file->mesh));
  session::SessionModels made = modelsOn(hand, stored_hand, object, stored_object, motion,
                                         grasp, std::move(source), progress);
  made.frames = retargeting::frameContactsOf(*stored->motion, *grasp, *made.object_O);
  return made;
}

}  // namespace handgraft::server
