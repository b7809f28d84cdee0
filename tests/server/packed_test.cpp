// The bytes between the server and its readers.

#include "server/reading/packed.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "server/reading/frames.h"
#include "server/reading/read_model.h"

#include "tests/server/files_to_read.h"

namespace handgraft::server {
namespace {

namespace fs = std::filesystem;
using files::ballPly;
using files::clampRequest;
using files::contactsOf;
using files::mapRequest;
using files::objectOf;
using files::requestFor;
using files::written;

void expectEqual(const hand::HandModel& a, const hand::HandModel& b) {
  EXPECT_EQ(a.name(), b.name());
  ASSERT_EQ(a.linkCount(), b.linkCount());
  for (std::size_t l = 0; l < a.links().size(); ++l) {
    const hand::Link& link = a.links()[l];
    const hand::Link& other = b.links()[l];
    EXPECT_EQ(link.name, other.name);
    ASSERT_EQ(link.visuals.size(), other.visuals.size());
    ASSERT_EQ(link.collisions.size(), other.collisions.size());
    for (std::size_t s = 0; s < link.visuals.size(); ++s) {
      EXPECT_EQ(link.visuals[s].mesh_L.vertices(), other.visuals[s].mesh_L.vertices());
      EXPECT_EQ(link.visuals[s].mesh_L.faces(), other.visuals[s].mesh_L.faces());
      EXPECT_EQ(link.visuals[s].source, other.visuals[s].source);
    }
  }
  EXPECT_EQ(a.dofNames(), b.dofNames());
  EXPECT_EQ(a.lower(), b.lower());
  EXPECT_EQ(a.upper(), b.upper());
  EXPECT_EQ(a.restPose(), b.restPose());
  for (std::size_t i = 0; i < a.nodes().size(); ++i) {
    const hand::HandModel::Node& node = a.nodes()[i];
    const hand::HandModel::Node& other = b.nodes()[i];
    EXPECT_EQ(node.X_PJ.matrix(), other.X_PJ.matrix());
    EXPECT_TRUE(node.axis_J.isApprox(other.axis_J, 1e-15));
    EXPECT_EQ(node.multiplier, other.multiplier);
    EXPECT_EQ(node.offset, other.offset);
    EXPECT_EQ(node.parent_link, other.parent_link);
  }
}

void expectEqual(const contact::ContactSet& a, const contact::ContactSet& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.notes, b.notes);
  ASSERT_EQ(a.posture.size(), b.posture.size());
  for (std::size_t i = 0; i < a.posture.size(); ++i) {
    EXPECT_EQ(a.posture[i].part, b.posture[i].part);
    EXPECT_EQ(a.posture[i].outward_O, b.posture[i].outward_O);
    EXPECT_EQ(a.posture[i].palmar_O, b.posture[i].palmar_O);
  }
  ASSERT_EQ(a.patches.size(), b.patches.size());
  for (std::size_t i = 0; i < a.patches.size(); ++i) {
    EXPECT_EQ(a.patches[i].name, b.patches[i].name);
    EXPECT_EQ(a.patches[i].root.face, b.patches[i].root.face);
    EXPECT_EQ(a.patches[i].root.barycentric, b.patches[i].root.barycentric);
    EXPECT_EQ(a.patches[i].direction_O, b.patches[i].direction_O);
    EXPECT_EQ(a.patches[i].boundary, b.patches[i].boundary);
    EXPECT_EQ(a.patches[i].weight, b.patches[i].weight);
    EXPECT_EQ(a.patches[i].interpolation_boundary.size(),
              b.patches[i].interpolation_boundary.size());
  }
}

TEST(Packed, HandsComeBackAsTheyWere) {
  for (const char* name : {"human20", "allegro16", "barrett8", "tendon16"}) {
    const fs::path folder = test::sourceDirectory() / "server/models/hands" / name;
    ReadRequest request = requestFor(ReadKind::kHand, folder / (std::string(name) + ".urdf"));
    request.files["sites.yaml"] = folder / "sites.yaml";
    const auto read = std::get<ReadHand>(readModel(request, Progress()));
    const auto back = std::get<ReadHand>(unpackModel(pack(ReadModel(read))));
    expectEqual(read.model, back.model);
    EXPECT_EQ(read.urdf, back.urdf);
    EXPECT_EQ(read.notes, back.notes);
    ASSERT_EQ(read.sites->size(), back.sites->size());
    for (std::size_t i = 0; i < read.sites->size(); ++i) {
      EXPECT_EQ((*read.sites)[i].link, (*back.sites)[i].link);
      EXPECT_EQ((*read.sites)[i].p_L, (*back.sites)[i].p_L);
    }
    EXPECT_EQ(pack(ReadModel(read)), pack(ReadModel(read)));
  }
}

TEST(Packed, ObjectsAndContactsComeBackAsTheyWere) {
  for (const auto& [name, set] : {std::pair("box", "box_5"),
                                  {"lemon", "lemon_6"},
                                  {"wine_glass", "wine_glass_4"},
                                  {"scissors", "scissors_3"}}) {
    const fs::path models = test::sourceDirectory() / "server/models";
    const auto object =
        requestFor(ReadKind::kObject, models / "objects" / (std::string(name) + ".obj"));
    const io::MeshFile read = objectOf(object);
    const auto back = std::get<io::MeshFile>(unpackModel(pack(ReadModel(read))));
    EXPECT_EQ(read.mesh.vertices(), back.mesh.vertices());
    EXPECT_EQ(read.mesh.faces(), back.mesh.faces());
    EXPECT_EQ(read.file_vertex, back.file_vertex);
    EXPECT_EQ(read.mesh_vertex, back.mesh_vertex);
    EXPECT_EQ(read.file_face, back.file_face);
    EXPECT_EQ(read.is_turned, back.is_turned);

    const ReadRequest request =
        mapRequest(models / "contacts" / (std::string(set) + ".json"), object);
    ReadContacts contacts = contactsOf(request);
    contacts.set.posture = {
        {"index_distal", Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()},
        {"palm", Eigen::Vector3d(0.6, 0.8, 0.0), Eigen::Vector3d::Zero()}};
    const auto contacts_back = std::get<ReadContacts>(
        unpackModel(pack(ReadModel(contacts)), request.contacts.object.get()));
    expectEqual(contacts.set, contacts_back.set);
    EXPECT_FALSE(contacts_back.map.has_value());
  }
}

/// Bytes of form 1: without the `count` of them where these two begin to differ.
std::string withoutNews(std::string bytes, const std::string& other, std::ptrdiff_t count) {
  const auto [at, there] =
      std::mismatch(bytes.begin(), bytes.end(), other.begin(), other.end());
  bytes.erase(at, at + count);
  return bytes;
}

TEST(Packed, WhatOlderStoresKeepIsReadStill) {
  const fs::path models = test::sourceDirectory() / "server/models";
  const auto object = requestFor(ReadKind::kObject, models / "objects" / "box.obj");
  const io::MeshFile box = objectOf(object);
  io::MeshFile turned = box;
  turned.is_turned.assign(static_cast<std::size_t>(box.mesh.faceCount()), 1);
  constexpr std::ptrdiff_t kCount = sizeof(std::uint64_t);
  const std::string old_box =
      withoutNews(pack(ReadModel(box)), pack(ReadModel(turned)), kCount);
  const auto back = std::get<io::MeshFile>(unpackModel(old_box, nullptr, 1));
  EXPECT_EQ(back.mesh.faces(), box.mesh.faces());
  EXPECT_EQ(back.notes, box.notes);
  EXPECT_THROW((void)unpackModel(old_box), InvalidInput);

  const ReadRequest request = mapRequest(models / "contacts" / "box_5.json", object);
  ReadContacts contacts = contactsOf(request);
  const std::string as_it_is = pack(ReadModel(contacts));
  contacts.set.side = hand::Chirality::kLeft;
  const std::string left = pack(ReadModel(contacts));
  EXPECT_EQ(std::get<ReadContacts>(unpackModel(left, &box)).set.side, hand::Chirality::kLeft);
  const auto contacts_back =
      std::get<ReadContacts>(unpackModel(withoutNews(as_it_is, left, 1), &box, 1));
  EXPECT_EQ(contacts_back.set.side, hand::Chirality::kUnknown);
  EXPECT_EQ(contacts_back.set.patches.size(), contacts.set.patches.size());
}

TEST(Packed, RequestsComeBackAsTheyWere) {
  const auto object = requestFor(ReadKind::kObject, written("o.ply", ballPly(0.04, 1.0)));
  ReadRequest request = mapRequest(object.files.begin()->second, object);
  request.units = "cm";
  request.hand.mirrored = true;
  request.hand.skin.edge_m = 0.004;
  request.hand.skin.source = hand::SurfaceSource::kCollisions;
  request.contacts.joints_hand = 1;
  request.contacts.segmentation.low_share = 0.5;
  request.contacts.segmentation.outline_share = 0.25;
  request.contacts.source.color_scale = "jet";
  const ReadRequest back = unpackRequest(pack(request));
  EXPECT_EQ(back.files, request.files);
  EXPECT_EQ(back.units, "cm");
  EXPECT_EQ(back.hand.skin.source, hand::SurfaceSource::kCollisions);
  EXPECT_EQ(back.contacts.joints_hand, 1);
  EXPECT_EQ(back.contacts.object->mesh.faces(), request.contacts.object->mesh.faces());
  EXPECT_EQ(pack(back), pack(request));
}

/// What is left of the promises of a model that was unpacked from anything.
void expectSound(const ReadModel& model, const io::MeshFile* object) {
  if (const auto* hand = std::get_if<ReadHand>(&model)) {
    for (const hand::NamedPose& pose : hand->poses)
      EXPECT_NO_THROW((void)hand->model.withRestPose(pose.q));
    if (hand->sites) {
      EXPECT_NO_THROW(hand::validate(hand->model, *hand->sites));
    }
  }
  if (const auto* contacts = std::get_if<ReadContacts>(&model)) {
    for (const contact::Patch& patch : contacts->set.patches)
      EXPECT_NO_THROW(contact::validate(object->mesh, patch));
    if (contacts->map) {
      EXPECT_NO_THROW(contact::validate(*contacts->map));
    }
  }
  EXPECT_NO_THROW((void)unpackModel(pack(model), object));
}

/// Two frames, a patch in both of them.
ReadMotion smallMotion(const ReadRequest& map) {
  manipulation::Motion motion;
  motion.name = "small";
  motion.time_s = {0.0, 0.5};
  motion.X_WO = {Pose::Identity(), Pose::Identity()};
  manipulation::PatchTrack track;
  track.name = "thumb";
  track.end = 2;
  track.keys.resize(1);
  track.keys[0].patch = contactsOf(map).set.patches.at(0);
  track.keys[0].hand_points.resize(track.keys[0].patch.interpolation_boundary.size(),
                                   {"tip", Eigen::Vector3d::UnitX()});
  motion.tracks.push_back(track);
  manipulation::DemonstratorKey shown;
  shown.frame = 1;
  shown.X_OD.translation().y() = 0.2;
  shown.posture = {{"palm", Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()}};
  motion.demonstrator.push_back(shown);
  return {motion};
}

/// Two frames of a hand with one joint.
ReadHandTrajectory smallTrajectory() {
  ReadHandTrajectory read;
  read.plan.name = "small";
  read.plan.hand = "clamp";
  read.plan.every_s = 0.02;
  read.plan.trajectory.joints = {"close"};
  read.plan.trajectory.tells_root = true;
  read.plan.trajectory.frames.resize(2);
  for (io::HandTrajectoryFile::Frame& frame : read.plan.trajectory.frames)
    frame.q = Eigen::VectorXd::Constant(1, 0.25);
  read.plan.trajectory.frames[1].time_s = 0.5;
  read.plan.trajectory.frames[1].X_WO.translation().x() = 0.1;
  return read;
}

TEST(Packed, AMotionsDemonstratorComesBackAndOlderStoresHaveNone) {
  const auto object = requestFor(ReadKind::kObject, written("o.ply", ballPly(0.04, 1.0)));
  const ReadRequest map = mapRequest(object.files.begin()->second, object);
  ReadMotion motion = smallMotion(map);
  const std::string bytes = pack(ReadModel(motion));
  const auto back = std::get<ReadMotion>(unpackModel(bytes, map.contacts.object.get())).motion;
  ASSERT_EQ(back.demonstrator.size(), 1u);
  EXPECT_EQ(back.demonstrator[0].frame, 1);
  EXPECT_EQ(back.demonstrator[0].X_OD.translation().y(), 0.2);
  ASSERT_EQ(back.demonstrator[0].posture.size(), 1u);
  EXPECT_EQ(back.demonstrator[0].posture[0].part, "palm");

  const std::string shown = pack(ReadModel(motion));
  motion.motion.demonstrator.clear();
  const std::string old = withoutNews(pack(ReadModel(motion)), shown, sizeof(std::uint64_t));
  const auto older =
      std::get<ReadMotion>(unpackModel(old, map.contacts.object.get(), 2)).motion;
  EXPECT_EQ(older.time_s, motion.motion.time_s);
  EXPECT_TRUE(older.demonstrator.empty());
  EXPECT_THROW((void)unpackModel(old, map.contacts.object.get()), InvalidInput);
}

TEST(Packed, AHandsTrajectoryComesBack) {
  const ReadHandTrajectory before = smallTrajectory();
  const auto after = std::get<ReadHandTrajectory>(unpackModel(pack(ReadModel(before))));
  EXPECT_EQ(after.plan.name, "small");
  EXPECT_EQ(after.plan.hand, "clamp");
  EXPECT_EQ(after.plan.reach_m, std::nullopt);
  EXPECT_EQ(after.plan.every_s, 0.02);
  EXPECT_EQ(after.plan.trajectory.joints, before.plan.trajectory.joints);
  EXPECT_TRUE(after.plan.trajectory.tells_root);
  ASSERT_EQ(after.plan.trajectory.frames.size(), 2u);
  EXPECT_EQ(after.plan.trajectory.frames[1].time_s, 0.5);
  EXPECT_EQ(after.plan.trajectory.frames[1].q[0], 0.25);
  EXPECT_EQ(after.plan.trajectory.frames[1].X_WO.translation().x(), 0.1);
}

/// A small model of each kind, its bytes, and the object it lies on.
std::vector<std::pair<std::string, std::shared_ptr<const io::MeshFile>>> smallModels() {
  ReadRequest hand = clampRequest();
  hand.hand.srdf_uri = "clamp.srdf";
  const auto object = requestFor(ReadKind::kObject, written("o.ply", ballPly(0.04, 1.0)));
  const ReadRequest map = mapRequest(object.files.begin()->second, object);
  return {{pack(readModel(hand, Progress())), nullptr},
          {pack(readModel(object, Progress())), nullptr},
          {pack(readModel(map, Progress())), map.contacts.object},
          {pack(ReadModel(ObjectName{"lemon"})), nullptr},
          {pack(ReadModel(smallMotion(map))), map.contacts.object},
          {pack(ReadModel(smallTrajectory())), nullptr}};
}

TEST(Packed, RefusesWhatIsCutShortOrTooLong) {
  for (const auto& [bytes, object] : smallModels()) {
    const std::size_t step = std::max<std::size_t>(1, bytes.size() / 3000);
    for (std::size_t size = 0; size < bytes.size();
         size += size < 400 || size + 400 > bytes.size() ? 1 : step)
      EXPECT_THROW((void)unpackModel(std::string_view(bytes).substr(0, size), object.get()),
                   InvalidInput);
    EXPECT_THROW((void)unpackModel(bytes + "x", object.get()), InvalidInput);
  }
}

TEST(Packed, GivesASoundModelOrNoneWhateverTheBytes) {
  std::mt19937 random(7);
  for (const auto& [bytes, object] : smallModels()) {
    int refused = 0;
    for (int round = 0; round < 400; ++round) {
      std::string damaged = bytes;
      // Where sizes and indices stand, at the start and end, most of the damage matters.
      const std::size_t reach =
          round % 2 == 0 ? damaged.size() : std::min<std::size_t>(damaged.size(), 200);
      for (int flip = 0; flip <= round % 5; ++flip)
        damaged[random() % reach] ^= static_cast<char>(1u << random() % 8);
      try {
        expectSound(unpackModel(damaged, object.get()), object.get());
      } catch (const InvalidInput&) {
        ++refused;
      }
    }
    EXPECT_GT(refused, 0);
  }
}

TEST(Packed, TakesNoMemoryForWhatIsOnlyClaimed) {
  // A mesh of 20 million vertices and a list as long as its claim can be, in 17 bytes.
  for (const std::uint64_t claim : {20'000'000ull, ~0ull, 1ull << 63}) {
    std::string bytes(1, '\x01');
    bytes.append(reinterpret_cast<const char*>(&claim), sizeof(claim));
    bytes.append(8, '\0');
    EXPECT_THROW((void)unpackModel(bytes), InvalidInput);
  }
}

TEST(Frames, ArePutTogetherFromPieces) {
  const std::string stream =
      progressFrame("one\x1b[31m", 0.25) + framed(FrameKind::kModel, std::string(1000, 'm'));
  FrameReader frames;
  std::vector<Frame> heard;
  for (const char byte : stream) {
    frames.add({&byte, 1});
    while (auto frame = frames.next())
      heard.push_back(std::move(*frame));
  }
  ASSERT_EQ(heard.size(), 2u);
  EXPECT_EQ(progressIn(heard[0].payload).stage, "one?[31m");
  EXPECT_EQ(progressIn(heard[0].payload).fraction, 0.25);
  EXPECT_EQ(heard[1].payload, std::string(1000, 'm'));
}

}  // namespace
}  // namespace handgraft::server
