#include "server/store/model_source.h"

#include <utility>

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
  const auto stored_contacts = models.contacts(contacts);
  requireSameMesh(*stored_contacts, *stored_object);
  session::SessionModels made;
  made.hand_name = hand;
  made.hand = stored_hand->hand->get(progress);
  made.object_name = object;
  made.object_O = meshOf(stored_object);
  made.contacts_name = contacts;
  made.contacts = {stored_contacts, &stored_contacts->set};
  made.source = std::move(source);
  return made;
}

session::SessionModels motionModels(const std::string& hand,
                                    const std::string& object,
                                    const std::string& motion,
                                    const NamedModels& models,
                                    std::shared_ptr<session::ModelSource> source,
                                    const Progress& progress) {
  const auto stored_hand = models.hand(hand);
  const auto stored_object = models.object(object);
  const auto stored_motion = models.motion(motion);
  requireSameMesh(*stored_motion, *stored_object);
  session::SessionModels made;
  made.hand_name = hand;
  made.hand = stored_hand->hand->get(progress);
  made.object_name = object;
  made.object_O = meshOf(stored_object);
  made.contacts_name = motion;
  made.contacts = std::make_shared<const contact::ContactSet>(
      retargeting::graspOf(*stored_motion->motion, stored_object->file->mesh));
  made.source = std::move(source);
  return made;
}

}  // namespace handgraft::server
