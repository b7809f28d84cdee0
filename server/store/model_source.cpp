#include "server/store/model_source.h"

#include "core/session/motion_solving.h"

namespace handgraft::server {

namespace {

class StoreSource final : public session::ModelSource {
 public:
  explicit StoreSource(const ModelStore& models) : models_(models) {}

  session::Hand hand(const std::string& name, const Progress& progress) override {
    return models_.hand(name)->hand->get(progress);
  }

  std::shared_ptr<const geometry::TriangleMesh> object(const std::string& name,
                                                       const Progress& /*progress*/) override {
    return meshOf(models_.object(name));
  }

 private:
  const ModelStore& models_;
};

}  // namespace

std::shared_ptr<session::ModelSource> sourceOf(const ModelStore& models) {
  return std::make_shared<StoreSource>(models);
}

std::shared_ptr<const geometry::TriangleMesh> meshOf(
    const std::shared_ptr<const StoredObject>& object) {
  return {object->file, &object->file->mesh};
}

session::SessionModels sessionModels(const std::string& hand,
                                     const std::string& object,
                                     const std::string& contacts,
                                     const ModelStore& models,
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
  made.source = sourceOf(models);
  return made;
}

session::SessionModels motionModels(const std::string& hand,
                                    const std::string& object,
                                    const std::string& motion,
                                    const ModelStore& models,
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
      session::graspOf(*stored_motion->motion, stored_object->file->mesh));
  made.source = sourceOf(models);
  return made;
}

}  // namespace handgraft::server
