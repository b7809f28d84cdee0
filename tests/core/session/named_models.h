#pragma once

#include <map>
#include <memory>
#include <string>

#include "core/base/error.h"
#include "core/session/models.h"

namespace handgraft::test {

/// Models by name, for sessions that swap them.
class NamedModels : public session::ModelSource {
 public:
  hand::Hand hand(const std::string& name, const Progress& /*progress*/) override {
    if (hands.count(name) == 0) rejectInput("there is no hand {}", quoted(name));
    return hands[name];
  }

  std::shared_ptr<const geometry::TriangleMesh> object(const std::string& name,
                                                       const Progress& /*progress*/) override {
    if (objects.count(name) == 0) rejectInput("there is no object {}", quoted(name));
    return objects[name];
  }

  std::map<std::string, hand::Hand> hands;
  std::map<std::string, std::shared_ptr<const geometry::TriangleMesh>> objects;
};

/// A session's models, with others to swap to: the same hand with other limits ("bent"), one
/// whose sites were found ("found"), the object on another mesh ("shaved"), and one that is far
/// too small for the contacts ("speck").
inline session::SessionModels withOthers(
    const hand::Hand& hand,
    const std::shared_ptr<const geometry::TriangleMesh>& object_O,
    const contact::ContactSet& contacts) {
  auto others = std::make_shared<NamedModels>();
  hand::Hand bent = hand;
  bent.model = std::make_shared<const hand::HandModel>(
      hand.model->withRestPose(0.8 * hand.model->restPose() +
                               0.2 * (0.5 * (hand.model->lower() + hand.model->upper()))));
  hand::Hand found = hand;
  found.sites_are_found = true;
  others->hands = {{"bent", bent}, {"found", found}};
  // Cut a little smaller, so that triangles are others' and patches still find their places.
  others->objects["shaved"] = std::make_shared<const geometry::TriangleMesh>(
      geometry::transformed(*object_O, Eigen::Affine3d(Eigen::Scaling(0.98))));
  others->objects["speck"] = std::make_shared<const geometry::TriangleMesh>(
      geometry::transformed(*object_O, Eigen::Affine3d(Eigen::Scaling(0.01))));
  session::SessionModels models;
  models.hand_name = "hand";
  models.hand = hand;
  models.object_name = "object";
  models.object_O = object_O;
  models.contacts_name = "contacts";
  models.contacts = std::make_shared<const contact::ContactSet>(contacts);
  models.source = others;
  return models;
}

}  // namespace handgraft::test
