#include "server/handlers/pose_contacts.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/content_hash.h"
#include "core/base/error.h"
#include "core/demonstration/posed_hand_contacts.h"
#include "core/hand/floating_base.h"
#include "server/handlers/enter_model.h"
#include "server/messages/convert.h"
#include "server/messages/load_messages.h"
#include "server/reading/packed.h"

namespace handgraft::server {

namespace {

constexpr double kShortestReach_m = 1e-4;
constexpr double kLongestReach_m = 0.1;
constexpr double kLimitTolerance = 1e-6;  // rad or m; what files round away

/// The pose as far as the request and the hand say it.
struct AskedPose {
  hand::HandPose pose;
  std::vector<std::string> notes;
};

Eigen::VectorXd startOf(const v1::PoseContactsRequest& request, const StoredHand& hand) {
  if (request.start_pose().empty()) return hand.hand->model().restPose();
  std::string names;
  for (const hand::NamedPose& pose : hand.poses) {
    if (pose.name == request.start_pose()) return pose.q;
    names += (names.empty() ? "" : ", ") + handgraft::quoted(pose.name);
  }
  rejectInput("hand {} has no pose {}; its poses are: {}", handgraft::quoted(hand.name),
              handgraft::quoted(request.start_pose()), names.empty() ? "none" : names);
}

/// The dof of the hand's floating base that is called so; -1 if there is none.
int freeRootDof(const StoredHand& hand, const std::string& joint) {
  if (!hand.floating_base) return -1;
  const std::vector<std::string> names = hand.floating_base->dofNames();
  const auto at = std::find(names.begin(), names.end(), joint);
  return at == names.end() ? -1 : static_cast<int>(at - names.begin());
}

void noteLimits(const hand::HandModel& model,
                const Eigen::VectorXd& q,
                std::vector<std::string>& notes) {
  for (int dof = 0; dof < model.dofCount(); ++dof) {
    const double lower = model.lower()[dof];
    const double upper = model.upper()[dof];
    if (q[dof] >= lower - kLimitTolerance && q[dof] <= upper + kLimitTolerance) continue;
    notes.push_back(
        fmt::format("joint {}: {:.4g} is beyond its limits {:.4g} to {:.4g}; taken "
                    "as it is",
                    handgraft::quoted(model.dofJoint(dof).name), q[dof], lower, upper));
  }
}

AskedPose askedPoseFrom(const v1::PoseContactsRequest& request, const StoredHand& hand) {
  if (request.joints().size() != request.joint_positions().size()) {
    rejectInput("pose: {} joints but {} values", request.joints().size(),
                request.joint_positions().size());
  }
  const hand::HandModel& model = hand.hand->model();
  AskedPose asked;
  Eigen::VectorXd& q = asked.pose.q;
  q = startOf(request, hand);
  Eigen::VectorXd q_root;
  if (hand.floating_base) q_root = hand.floating_base->restPose();

  std::set<std::string> named;
  std::string of_root;
  for (std::size_t i = 0; i < request.joints().size(); ++i) {
    const std::string& joint = request.joints()[i];
    const double value = request.joint_positions()[i];
    if (!std::isfinite(value)) {
      rejectInput("joint {}: {} is not finite", handgraft::quoted(joint), value);
    }
    if (!named.insert(joint).second) {
      rejectInput("joint {} is named twice", handgraft::quoted(joint));
    }
    if (const int dof = freeRootDof(hand, joint); dof >= 0) {
      q_root[dof] = value;
      of_root = joint;
    } else {
      q[model.dofIndex(joint)] = value;
    }
  }
  if (!of_root.empty() && !request.X_WH().empty()) {
    rejectInput("the pose of the hand's root is given twice: by X_WH and by joint {}",
                handgraft::quoted(of_root));
  }
  asked.pose.X_WH = of_root.empty() ? server::poseFrom(request.X_WH(), "X_WH")
                                    : hand::carriedPose(*hand.floating_base, q_root);
  noteLimits(model, q, asked.notes);
  return asked;
}

contact::PoseContactOptions reachFrom(const v1::PoseContactsRequest& request) {
  contact::PoseContactOptions options;
  if (request.reach_m() == 0.0) return options;
  if (!(request.reach_m() >= kShortestReach_m && request.reach_m() <= kLongestReach_m)) {
    rejectInput("reach is {} m; permitted are {} to {}", request.reach_m(), kShortestReach_m,
                kLongestReach_m);
  }
  options.reach_m = request.reach_m();
  return options;
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

v1::ModelList contactsOfPose(const v1::PoseContactsRequest& request,
                             HandlerContext& context,
                             const RequestKey& by,
                             const Progress& progress) {
  validateName(request.name());
  const auto hand = context.models.hand(request.hand());
  const auto object = context.models.object(request.object());
  const Pose X_WO = poseFrom(request.X_WO(), "X_WO");
  const contact::PoseContactOptions reach = reachFrom(request);
  const contact::SegmentationOptions segmentation = segmentationOf(request);
  AskedPose asked = askedPoseFrom(request, *hand);

  const hand::Hand ready = hand->hand->get(progress);
  demonstration::PosedContacts posed = demonstration::contactsOfPosedHand(
      ready, asked.pose, object->file->mesh, X_WO, reach, segmentation, progress);

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
        kReadForm, pack(how),
        pack(ReadModel(ReadContacts{contacts.set, *contacts.map, contacts.threshold})),
        object->origin.row, object->name};
  };
  return enterModel(contacts, context, by, "pose_contacts", recipe);
}

}  // namespace handgraft::server
