#include "core/session/models.h"

#include <utility>

#include "core/base/content_hash.h"
#include "core/base/error.h"
#include "core/contact/reproject.h"

namespace handgraft::session {
namespace {

void addPose(ContentHash& hash, const Pose& X) {
  hash.addNumbers(X.data(), 16);
}

void addPlace(ContentHash& hash, const geometry::SurfacePoint& point) {
  hash.addNumbers(&point.face, 1);
  hash.addNumbers(point.barycentric.data(), 3);
}

void addMesh(ContentHash& hash, const geometry::TriangleMesh& mesh) {
  hash.addNumbers(mesh.vertices().data(), static_cast<std::size_t>(mesh.vertices().size()));
  hash.addNumbers(mesh.faces().data(), static_cast<std::size_t>(mesh.faces().size()));
}

/// All of a hand that poses and patches depend on.
std::string hashOf(const hand::Hand& hand) {
  ContentHash hash;
  const hand::HandModel& model = *hand.model;
  for (const hand::Link& link : model.links())
    hash.addText(link.name);
  for (const hand::HandModel::Node& node : model.nodes()) {
    hash.addText(node.joint_name);
    const int numbers[] = {node.link, node.parent_link, static_cast<int>(node.type), node.dof};
    hash.addNumbers(numbers, 4);
    hash.addNumbers(&node.multiplier, 1);
    hash.addNumbers(&node.offset, 1);
    addPose(hash, node.X_PJ);
    hash.addNumbers(node.axis_J.data(), 3);
  }
  for (const Eigen::VectorXd* q : {&model.lower(), &model.upper(), &model.restPose()})
    hash.addNumbers(q->data(), static_cast<std::size_t>(q->size()));
  addMesh(hash, hand.skin->mesh());
  for (const hand::ContactSite& site : hand.sites) {
    hash.addText(site.name);
    hash.addText(site.link);
    for (const Eigen::Vector3d* v : {&site.p_L, &site.n_L, &site.direction_L})
      hash.addNumbers(v->data(), 3);
  }
  hash.addNumbers(&hand.sites_are_found, 1);
  return hash.finish();
}

std::string hashOf(const geometry::TriangleMesh& mesh) {
  ContentHash hash;
  addMesh(hash, mesh);
  return hash.finish();
}

std::string hashOf(const contact::ContactSet& set) {
  ContentHash hash;
  for (const contact::Patch& patch : set.patches) {
    hash.addText(patch.name);
    addPlace(hash, patch.root);
    for (const geometry::SurfacePoint& place : patch.interpolation_boundary)
      addPlace(hash, place);
    if (patch.direction_O) hash.addNumbers(patch.direction_O->data(), 3);
    hash.addNumbers(&patch.weight, 1);
    if (!patch.place) continue;
    const hand::HandLocation& place = *patch.place;
    hash.addText(place.digit);
    hash.addText(place.segment);
    hash.addNumbers(&place.segment_count, 1);
    for (const double* number :
         {&place.along, &place.around_rad, &place.across, &place.from_tip})
      hash.addNumbers(number, 1);
  }
  return hash.finish();
}

bool sameMesh(const geometry::TriangleMesh& a, const geometry::TriangleMesh& b) {
  return &a == &b || (a.vertexCount() == b.vertexCount() && a.faceCount() == b.faceCount() &&
                      a.faces() == b.faces() && a.vertices() == b.vertices());
}

}  // namespace

SessionModels modelsOf(hand::Hand hand,
                       std::shared_ptr<const geometry::TriangleMesh> object_O,
                       const contact::ContactSet& contacts) {
  HANDGRAFT_REQUIRE(hand.model != nullptr);
  SessionModels models;
  models.hand_name = hand.model->name();
  models.hand = std::move(hand);
  models.object_name = contacts.object;
  models.object_O = std::move(object_O);
  models.contacts_name = contacts.name;
  models.contacts = std::make_shared<const contact::ContactSet>(contacts);
  return models;
}

ModelCache::ModelCache(SessionModels models) : first_(std::move(models)) {
  HANDGRAFT_REQUIRE(first_.hand.model != nullptr && first_.hand.skin != nullptr);
  HANDGRAFT_REQUIRE(first_.object_O != nullptr && first_.contacts != nullptr);
  hands_[first_.hand_name] = first_.hand;
  objects_[first_.object_name] = first_.object_O;
  carried_[first_.object_name] = first_.contacts;
}

const hand::Hand& ModelCache::hand(const std::string& name, const Progress& progress) {
  const auto known = hands_.find(name);
  if (known != hands_.end()) return known->second;
  if (first_.source == nullptr) {
    rejectInput("there is no hand {}; this session has {} alone", quoted(name),
                quoted(first_.hand_name));
  }
  if (hands_.size() >= kMostModels)
    rejectInput("hand {}: a session may know {} hands", quoted(name), kMostModels);
  hand::Hand hand = first_.source->hand(name, progress);
  HANDGRAFT_REQUIRE(hand.model != nullptr && hand.skin != nullptr);
  validate(*hand.model, hand.sites);
  return hands_.emplace(name, std::move(hand)).first->second;
}

std::shared_ptr<const geometry::TriangleMesh> ModelCache::object(const std::string& name,
                                                                 const Progress& progress) {
  const auto known = objects_.find(name);
  if (known != objects_.end()) return known->second;
  if (first_.source == nullptr) {
    rejectInput("there is no object {}; this session has {} alone", quoted(name),
                quoted(first_.object_name));
  }
  if (objects_.size() >= kMostModels)
    rejectInput("object {}: a session may know {} objects", quoted(name), kMostModels);
  auto object = first_.source->object(name, progress);
  HANDGRAFT_REQUIRE(object != nullptr);
  return objects_.emplace(name, std::move(object)).first->second;
}

std::shared_ptr<const contact::ContactSet> ModelCache::contactsOn(const std::string& object,
                                                                  const Progress& progress) {
  const auto known = carried_.find(object);
  if (known != carried_.end()) return known->second;
  const auto mesh_O = this->object(object, progress);
  auto set = first_.contacts;
  if (!sameMesh(*mesh_O, *first_.object_O)) {
    set = std::make_shared<const contact::ContactSet>(
        contact::reproject(*first_.contacts, *first_.object_O, *mesh_O));
  }
  carried_[object] = set;
  return set;
}

Models ModelCache::find(const std::string& hand,
                        const std::string& object,
                        const Progress& progress) {
  Models models;
  models.hand = &this->hand(hand, progress);
  models.object_O = this->object(object, progress);
  models.contacts = contactsOn(object, progress);
  if (models.contacts == first_.contacts) models.frames = first_.frames;
  models.threads = first_.threads;
  return models;
}

std::string ModelCache::handHash(const std::string& name) {
  std::string& hash = hashes_["hand " + name];
  if (hash.empty()) hash = hashOf(hand(name, Progress()));
  return hash;
}

std::string ModelCache::objectHash(const std::string& name) {
  std::string& hash = hashes_["object " + name];
  if (hash.empty()) hash = hashOf(*object(name, Progress()));
  return hash;
}

std::string ModelCache::contactsHash() {
  std::string& hash = hashes_["contacts"];
  if (hash.empty()) hash = hashOf(*first_.contacts);
  return hash;
}

}  // namespace handgraft::session
