#include "server/reading/packed.h"

#include <utility>

#include "core/base/error.h"
#include "server/reading/packed_contacts.h"
#include "server/reading/packed_motion.h"
#include "server/reading/packed_parts.h"
#include "server/reading/packed_trajectory.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kLongestName = 4096;
constexpr std::size_t kMostFiles = 10'000;

void put(ByteWriter& out, bool flag) {
  out.number(static_cast<std::uint8_t>(flag));
}

// === Requests

void putReading(ByteWriter& out, const HandReading& hand) {
  put(out, hand.mirrored);
  out.text(hand.srdf_uri);
  out.text(hand.rest_pose);
  out.number(hand.skin.alpha_m);
  out.number(hand.skin.offset_m);
  out.number(hand.skin.edge_m);
  out.number(hand.skin.epsilon_m);
  out.number(static_cast<std::uint8_t>(hand.skin.source));
}

HandReading takeHandReading(ByteReader& in) {
  HandReading hand;
  hand.mirrored = in.flag();
  hand.srdf_uri = in.text(kLongestName);
  hand.rest_pose = in.text(kLongestName);
  hand.skin.alpha_m = in.finite();
  hand.skin.offset_m = in.finite();
  hand.skin.edge_m = in.finite();
  hand.skin.epsilon_m = in.finite();
  hand.skin.source = in.one(hand::SurfaceSource::kCollisions);
  return hand;
}

void putReading(ByteWriter& out, const ContactReading& contacts) {
  const contact::SegmentationOptions& options = contacts.segmentation;
  HANDGRAFT_REQUIRE(!options.joints_O && contacts.source.picture.empty());
  out.number(options.threshold);
  out.number(static_cast<std::uint8_t>(options.rule));
  out.number(options.low_share);
  out.number(options.outline_share);
  out.number(options.smoothing_steps);
  out.number(options.minimum_area_m2);
  out.number(options.interpolation_count);
  out.text(contacts.source.value_property);
  out.text(contacts.source.label_property);
  out.text(contacts.source.color_scale);
  out.text(contacts.picture_uri);
  out.text(contacts.joints_uri);
  put(out, contacts.joints_hand.has_value());
  if (contacts.joints_hand) out.number(*contacts.joints_hand);
  put(out, contacts.object != nullptr);
  if (contacts.object) put(out, *contacts.object);
  out.text(contacts.object_units);
}

ContactReading takeContactReading(ByteReader& in) {
  ContactReading contacts;
  contact::SegmentationOptions& options = contacts.segmentation;
  options.threshold = in.finite();
  options.rule = in.one(contact::ThresholdRule::kOtsu);
  options.low_share = in.finite();
  options.outline_share = in.finite();
  options.smoothing_steps = in.number<int>();
  options.minimum_area_m2 = in.finite();
  options.interpolation_count = in.number<int>();
  contacts.source.value_property = in.text(kLongestName);
  contacts.source.label_property = in.text(kLongestName);
  contacts.source.color_scale = in.text(kLongestName);
  contacts.picture_uri = in.text(kLongestName);
  contacts.joints_uri = in.text(kLongestName);
  if (in.flag()) contacts.joints_hand = in.number<int>();
  if (in.flag()) contacts.object = std::make_shared<const io::MeshFile>(takeMeshFile(in));
  contacts.object_units = in.text(kLongestName);
  return contacts;
}

// === Models

void putModel(ByteWriter& out, const ReadHand& hand) {
  put(out, hand.model);
  put(out, hand.floating_base.has_value());
  if (hand.floating_base) put(out, *hand.floating_base);
  out.text(hand.urdf);
  put(out, hand.notes);
  put(out, hand.sites.has_value());
  if (hand.sites) put(out, *hand.sites);
  put(out, hand.poses);
}

ReadHand takeHand(ByteReader& in) {
  ReadHand hand{takeHandModel(in), std::nullopt, {}, {}, std::nullopt, {}};
  if (in.flag()) hand.floating_base = takeHandModel(in);
  hand.urdf = in.text();
  hand.notes = takeTexts(in);
  if (in.flag()) hand.sites = takeSites(in, hand.model);
  hand.poses = takePoses(in, hand.model);
  return hand;
}

void putModel(ByteWriter& out, const io::MeshFile& object) {
  put(out, object);
}

void putModel(ByteWriter& out, const ReadContacts& contacts) {
  put(out, contacts.set);
  put(out, contacts.map.has_value());
  if (contacts.map) put(out, *contacts.map);
  out.number(contacts.threshold);
}

ReadContacts takeContacts(ByteReader& in, const io::MeshFile* object) {
  if (object == nullptr) rejectInput("contacts came back where none were asked for");
  ReadContacts contacts;
  contacts.set = takeContactSet(in, object->mesh);
  if (in.flag()) contacts.map = takeContactMap(in);
  contacts.threshold = in.finite();
  return contacts;
}

void putModel(ByteWriter& out, const ObjectName& object) {
  out.text(object.name);
}

void putModel(ByteWriter& out, const ReadMotion& motion) {
  put(out, motion.motion);
}

ReadMotion takeMotionOn(ByteReader& in, const io::MeshFile* object) {
  if (object == nullptr) rejectInput("a motion came back where none was asked for");
  return {takeMotion(in, object->mesh)};
}

void putModel(ByteWriter& out, const ReadHandTrajectory& read) {
  put(out, read.plan);
}

}  // namespace

std::string pack(const ReadRequest& request) {
  ByteWriter out;
  out.number(static_cast<std::uint8_t>(request.kind));
  out.text(request.name);
  out.text(request.main_uri);
  out.count(request.files.size());
  for (const auto& [uri, path] : request.files) {
    out.text(uri);
    out.text(path.string());
  }
  out.text(request.units);
  putReading(out, request.hand);
  putReading(out, request.contacts);
  return out.take();
}

ReadRequest unpackRequest(std::string_view bytes) {
  ByteReader in(bytes, kPackedForm);
  ReadRequest request;
  request.kind = in.one(ReadKind::kMotion);
  request.name = in.text(kLongestName);
  request.main_uri = in.text(kLongestName);
  const std::size_t files = in.count(kMostFiles, 2 * sizeof(std::uint64_t));
  for (std::size_t i = 0; i < files; ++i) {
    std::string uri = in.text(kLongestName);
    request.files[std::move(uri)] = in.text(kLongestName);
  }
  request.units = in.text(kLongestName);
  request.hand = takeHandReading(in);
  request.contacts = takeContactReading(in);
  in.requireEnd();
  return request;
}

std::string pack(const ReadModel& model) {
  ByteWriter out;
  out.number(static_cast<std::uint8_t>(model.index()));
  std::visit(
      [&](const auto& read) {
        putModel(out, read);
      },
      model);
  return out.take();
}

ReadModel unpackModel(std::string_view bytes, const io::MeshFile* object, int form) {
  ByteReader in(bytes, form);
  const auto take = [&]() -> ReadModel {
    switch (in.one(ReadKind::kHandTrajectory)) {
      case ReadKind::kHand:
        return takeHand(in);
      case ReadKind::kObject:
        return takeMeshFile(in);
      case ReadKind::kContacts:
        return takeContacts(in, object);
      case ReadKind::kObjectName:
        return ObjectName{in.text(kLongestName)};
      case ReadKind::kMotion:
        return takeMotionOn(in, object);
      case ReadKind::kHandTrajectory:
        return ReadHandTrajectory{takeHandTrajectoryPlan(in)};
    }
    throw BrokenContract("a kind of model that does not exist");
  };
  ReadModel model = take();
  in.requireEnd();
  return model;
}

}  // namespace handgraft::server
