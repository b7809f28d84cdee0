#include "server/handlers/pose_contacts.h"

#include <string>
#include <utility>
#include <vector>

#include "core/base/content_hash.h"
#include "core/base/error.h"
#include "core/demonstration/posed_hand_contacts.h"
#include "server/handlers/enter_model.h"
#include "server/handlers/named_joints.h"
#include "server/messages/convert.h"
#include "server/messages/load_messages.h"
#include "server/reading/packed.h"

namespace handgraft::server {

namespace {

/// The pose as far as the request and the hand say it.
struct AskedPose {
  hand::HandPose pose;
  std::vector<std::string> notes;
};

/// A pose of the hand's own may be called like the one that every hand has.
Eigen::VectorXd startOf(const v1::PoseContactsRequest& request, const StoredHand& hand) {
  constexpr const char* kRest = "rest";
  std::string names = handgraft::quoted(kRest);
  for (const hand::NamedPose& pose : hand.poses) {
    if (pose.name == request.start_pose()) return pose.q;
    if (pose.name != kRest) names += ", " + handgraft::quoted(pose.name);
  }
  if (request.start_pose().empty() || request.start_pose() == kRest)
    return hand.hand->model().restPose();
  rejectInput("hand {} has no pose {}; its poses are: {}", handgraft::quoted(hand.name),
              handgraft::quoted(request.start_pose()), names);
}

AskedPose askedPoseFrom(const v1::PoseContactsRequest& request, const StoredHand& hand) {
  const std::vector<double>& values = request.joint_positions();
  if (request.joints().size() != values.size()) {
    rejectInput("pose: {} joints but {} values", request.joints().size(), values.size());
  }
  const NamedJoints joints(hand, request.joints(), NamedJoints::Followers::kRefused);
  AskedPose asked;
  asked.pose = joints.poseAt(
      Eigen::VectorXd::Map(values.data(), static_cast<Eigen::Index>(values.size())),
      startOf(request, hand), server::poseFrom(request.X_WH(), "X_WH"),
      !request.X_WH().empty());
  asked.notes = beyondLimits(hand.hand->model(), {asked.pose});
  return asked;
}

contact::SegmentationOptions segmentationOf(const v1::PoseContactsRequest& request) {
  if (request.contacts().size() > 1) {
    rejectInput("contacts: {} entries; at most 1 is allowed", request.contacts().size());
  }
  return request.contacts().empty() ? contact::SegmentationOptions()
                                    : segmentationFrom(request.contacts().front());
}

/// Two requests of the same content have the same.
std::string contentOf(const v1::PoseContactsRequest& request,
                      const hand::HandPose& pose,
                      const Pose& X_WO,
                      const contact::PoseContactOptions& reach,
                      const contact::SegmentationOptions& segmentation,
                      const StoredHand& hand,
                      const StoredObject& object) {
  ContentHash hash;
  for (const std::string* text :
       {&request.hand(), &request.object(), &hand.origin.content, &object.origin.content})
    hash.addText(*text);
  hash.addNumbers(pose.q.data(), static_cast<std::size_t>(pose.q.size()));
  for (const Eigen::Matrix4d& X : {pose.X_WH.matrix(), X_WO.matrix()})
    hash.addNumbers(X.data(), 16);
  hash.addNumber(reach.reach_m);
  hash.addNumber(segmentation.threshold);
  hash.addNumber(static_cast<int>(segmentation.rule));
  hash.addNumber(segmentation.low_share);
  hash.addNumber(segmentation.outline_share);
  hash.addNumber(segmentation.smoothing_steps);
  hash.addNumber(segmentation.minimum_area_m2);
  hash.addNumber(segmentation.interpolation_count);
  return hash.finish();
}

}  // namespace

contact::PoseContactOptions reachFrom(double reach_m) {
  constexpr double kShortestReach = 1e-4;  // m
  constexpr double kLongestReach = 0.1;    // m
  contact::PoseContactOptions options;
  if (reach_m == 0.0) return options;
  if (!(reach_m >= kShortestReach && reach_m <= kLongestReach)) {
    rejectInput("reach is {} m; permitted are {} to {}", reach_m, kShortestReach,
                kLongestReach);
  }
  options.reach_m = reach_m;
  return options;
}

v1::ModelList contactsOfPose(const v1::PoseContactsRequest& request,
                             HandlerContext& context,
                             const RequestKey& by,
                             const Progress& progress) {
  validateName(request.name());
  const auto hand = context.models.hand(request.hand());
  const auto object = context.models.object(request.object());
  const Pose X_WO = poseFrom(request.X_WO(), "X_WO");
  const contact::PoseContactOptions reach = reachFrom(request.reach_m());
  const contact::SegmentationOptions segmentation = segmentationOf(request);
  AskedPose asked = askedPoseFrom(request, *hand);

  const hand::Hand ready = hand->hand->get(progress);
  demonstration::PosedContacts posed = tellingWhatIsBeyond(asked.notes, [&] {
    return demonstration::contactsOfPosedHand(ready, asked.pose, object->file->mesh, X_WO,
                                              reach, segmentation, progress);
  });

  StoredContacts contacts;
  contacts.name = request.name();
  contacts.origin.content =
      contentOf(request, asked.pose, X_WO, reach, segmentation, *hand, *object);
  contacts.object = object->file;
  contacts.set = std::move(posed.set);
  contacts.set.name = request.name();
  contacts.set.object = request.object();
  std::vector<std::string>& notes = contacts.set.notes;
  notes.insert(notes.begin(), std::make_move_iterator(asked.notes.begin()),
               std::make_move_iterator(asked.notes.end()));
  notes.insert(notes.begin(),
               fmt::format("what hand {} touches in a pose, by distance up to "
                           "{:.3g} mm",
                           handgraft::quoted(request.hand()), 1e3 * reach.reach_m));
  contacts.threshold = contact::thresholdOf(posed.map, segmentation);
  contacts.map = std::make_shared<const contact::ContactMap>(std::move(posed.map));

  const auto recipe = [&] {
    ReadRequest how;
    how.kind = ReadKind::kContacts;
    how.name = contacts.name;
    return ModelRecipe{
        readForm(), pack(how),
        pack(ReadModel(ReadContacts{contacts.set, *contacts.map, contacts.threshold})),
        object->origin.row, object->name};
  };
  return enterModel(contacts, context, by, "pose_contacts", recipe);
}

}  // namespace handgraft::server
