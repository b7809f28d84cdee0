// From files to models: options, units, and the bytes between the server and its readers.

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/io/sites_file.h"
#include "server/reading/frames.h"
#include "server/reading/packed.h"
#include "server/reading/read_model.h"
#include "server/reading/units.h"

#include "tests/server/small_grasp.h"
#include "tests/support/shared_data.h"

namespace handgraft::server {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

// === Files to read

fs::path written(const std::string& name, const std::string& text) {
  const fs::path path = test::scratchDirectory() / name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

/// A PLY of a ball with contact near its top, `points_alone` or with faces; lengths times
/// `scale`.
std::string ballPly(double radius, double scale, bool points_alone = false, double top = 0.5) {
  const geometry::TriangleMesh ball = geometry::makeSphere(radius, 3);
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
      "property double z\nproperty double contact\n",
      ball.vertexCount());
  if (!points_alone)
    text += fmt::format("element face {}\nproperty list uchar int vertex_indices\n",
                        ball.faceCount());
  text += "end_header\n";
  for (int v = 0; v < ball.vertexCount(); ++v) {
    const Eigen::Vector3d p = ball.vertex(v);
    text += fmt::format("{} {} {} {}\n", scale * p.x(), scale * p.y(), scale * p.z(),
                        p.z() > top * radius ? 1.0 : 0.0);
  }
  for (int f = 0; f < ball.faceCount() && !points_alone; ++f)
    text += fmt::format("3 {} {} {}\n", ball.face(f)[0], ball.face(f)[1], ball.face(f)[2]);
  return text;
}

ReadRequest requestFor(ReadKind kind, const fs::path& path) {
  ReadRequest request;
  request.kind = kind;
  request.name = path.stem().string();
  request.main_uri = path.filename().string();
  request.files[request.main_uri] = path;
  return request;
}

ReadRequest clampRequest() {
  ReadRequest request = requestFor(ReadKind::kHand, written("clamp.urdf", test::kClampUrdf));
  request.files["sites.yaml"] = written("sites.yaml", test::kClampSites);
  request.files["clamp.srdf"] = written("clamp.srdf", R"(<robot name="clamp">
    <group_state name="open" group="g"><joint name="hinge" value="-0.4"/></group_state>
    <group_state name="shut" group="g"><joint name="hinge" value="1.1"/></group_state>
    </robot>)");
  return request;
}

io::MeshFile objectOf(const ReadRequest& request) {
  return std::get<io::MeshFile>(readModel(request, Progress()));
}

/// Contacts in `map`, on the object in `object`.
ReadRequest mapRequest(const fs::path& map, const ReadRequest& object) {
  ReadRequest request = requestFor(ReadKind::kContacts, map);
  request.contacts.object = std::make_shared<const io::MeshFile>(objectOf(object));
  request.contacts.object_units = object.units;
  return request;
}

ReadContacts contactsOf(const ReadRequest& request) {
  return std::get<ReadContacts>(readModel(request, Progress()));
}

std::string faultOf(const ReadRequest& request) {
  try {
    (void)readModel(request, Progress());
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "no error";
}

TEST(Hands, WithoutASurfaceAreRefused) {
  const std::string bare = "<robot name=\"bare\"><link name=\"palm\"/></robot>";
  EXPECT_EQ(faultOf(requestFor(ReadKind::kHand, written("bare.urdf", bare))),
            "hand 'bare': none of its links has a surface");
}

// === Units

TEST(Units, AsksWhereMetresMakeNoSense) {
  EXPECT_EQ(objectScale(0.152, "", "cup"), 1.0);
  EXPECT_EQ(objectScale(2.9, "", "cup"), 1.0);
  for (const auto& [size, unit] : {std::pair(152.0, "--units mm"),
                                   {61.0, "--units mm"},
                                   {15.2, "--units cm"},
                                   {3.5, "--units cm"},
                                   {1500.0, "--units mm"}}) {
    try {
      objectScale(size, "", "object 'cup'");
      FAIL() << size;
    } catch (const UnitsInDoubt& doubt) {
      EXPECT_THAT(doubt.what(), AllOf(HasSubstr("object 'cup'"), HasSubstr(unit))) << size;
    }
  }
  try {
    objectScale(152.0, "", "object 'cup'");
  } catch (const UnitsInDoubt& doubt) {
    EXPECT_STREQ(doubt.what(),
                 "object 'cup': 152 m across as metres; as millimetres 152 mm: say --units mm");
  }
}

TEST(Units, TakesWhatIsGivenWithinReason) {
  EXPECT_EQ(objectScale(152.0, "mm", "cup"), 1e-3);
  EXPECT_EQ(objectScale(15.2, "cm", "cup"), 1e-2);
  EXPECT_EQ(objectScale(6.0, "in", "cup"), 0.0254);
  EXPECT_EQ(objectScale(6.0, "m", "cup"), 1.0);
  for (const auto& [size, units] : {std::pair(0.1, "mm"),
                                    {11.0, "m"},
                                    {2e4, "mm"},
                                    {0.0002, ""},
                                    {1e6, ""},
                                    {std::nan(""), ""}}) {
    try {
      objectScale(size, units, "cup");
      FAIL() << size << units;
    } catch (const UnitsInDoubt&) {
      FAIL() << "no other units help: " << size << units;
    } catch (const InvalidInput& error) {
      EXPECT_THAT(error.what(), HasSubstr("1 mm to 10 m")) << size << units;
    }
  }
  EXPECT_THROW(objectScale(1.0, "ft", "cup"), InvalidInput);
}

TEST(Units, TakesAMapToLieOnItsObject) {
  // Of its object's units, of its own, and in metres though others were said.
  EXPECT_EQ(mapScale(152.0, "", "mm", 0.152, "map").scale, 1e-3);
  EXPECT_EQ(mapScale(152.0, "mm", "", 0.152, "map").scale, 1e-3);
  EXPECT_EQ(mapScale(0.152, "", "", 0.152, "map").scale, 1.0);
  const MapScale metres = mapScale(0.152, "mm", "mm", 0.152, "map");
  EXPECT_EQ(metres.scale, 1.0);
  EXPECT_THAT(metres.note, HasSubstr("taken as metres"));
  // Touched points alone are less than the object.
  EXPECT_EQ(mapScale(12.0, "", "mm", 0.152, "map").scale, 1e-3);
  EXPECT_EQ(mapScale(0.012, "", "", 0.152, "map").scale, 1.0);
  EXPECT_THROW((void)mapScale(152.0, "", "", 0.152, "map"), UnitsInDoubt);
}

TEST(ReadModel, ScalesObjectsAndClouds) {
  for (const bool points_alone : {false, true}) {
    const auto metres =
        requestFor(ReadKind::kObject, written("m.ply", ballPly(0.04, 1.0, points_alone)));
    auto others =
        requestFor(ReadKind::kObject, written("mm.ply", ballPly(0.04, 1000.0, points_alone)));
    EXPECT_THROW((void)readModel(others, Progress()), UnitsInDoubt);
    others.units = "mm";
    const io::MeshFile a = objectOf(metres);
    const io::MeshFile b = objectOf(others);
    ASSERT_EQ(a.mesh.vertexCount(), b.mesh.vertexCount());
    EXPECT_LT((a.mesh.vertices() - b.mesh.vertices()).cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT((a.cloud_O - b.cloud_O).size() == 0
                  ? 0.0
                  : (a.cloud_O - b.cloud_O).cwiseAbs().maxCoeff(),
              1e-12);
    EXPECT_EQ(a.notes, b.notes);
  }
}

TEST(ReadModel, ScalesMapsWithTheirObjects) {
  auto object = requestFor(ReadKind::kObject, written("o.ply", ballPly(0.04, 1000.0)));
  object.units = "mm";
  const auto in_metres = requestFor(ReadKind::kObject, written("o_m.ply", ballPly(0.04, 1.0)));
  const ReadContacts truth = contactsOf(mapRequest(in_metres.files.begin()->second, in_metres));
  for (const bool points_alone : {false, true}) {
    for (const double scale : {1.0, 1000.0}) {
      const ReadContacts read = contactsOf(
          mapRequest(written("map.ply", ballPly(0.04, scale, points_alone)), object));
      ASSERT_EQ(read.set.patches.size(), 1u) << scale;
      ASSERT_TRUE(read.map.has_value());
      EXPECT_NEAR(read.map->mesh_O.diagonal(), truth.map->mesh_O.diagonal(), 1e-3);
      EXPECT_EQ(read.threshold, 0.4);
      const auto object_mesh = objectOf(object).mesh;
      EXPECT_LT((positionOf(object_mesh, read.set.patches[0].root) -
                 positionOf(object_mesh, truth.set.patches[0].root))
                    .norm(),
                0.005)
          << scale;
    }
  }
}

TEST(ReadModel, NamesAMeshOfAHandThatIsNotInMetres) {
  std::string urdf = test::kClampUrdf;
  const std::string box = "<box size=\"0.02 0.06 0.06\"/>";
  urdf.replace(urdf.find(box), box.size(), "<mesh filename=\"meshes/palm.ply\"/>");
  ReadRequest request = requestFor(ReadKind::kHand, written("large.urdf", urdf));
  request.files["meshes/palm.ply"] = written("palm.ply", ballPly(0.04, 1000.0));
  EXPECT_THAT(faultOf(request), AllOf(HasSubstr("'meshes/palm.ply'"), HasSubstr("138.6 m"),
                                      HasSubstr("scale=\"0.001 0.001 0.001\"")));
  request.units = "mm";
  const auto read = std::get<ReadHand>(readModel(request, Progress()));
  EXPECT_NEAR(read.model.links()[0].visuals[0].mesh_L.diagonal(), 0.1386, 1e-4);
  EXPECT_NEAR(read.model.links()[1].visuals[0].mesh_L.diagonal(), 0.065, 1e-4) << "a box";
}

// === Hands

TEST(ReadModel, RestsAHandInANamedPoseAndMirrorsIt) {
  ReadRequest request = clampRequest();
  request.hand.srdf_uri = "clamp.srdf";
  request.hand.rest_pose = "shut";
  const auto right = std::get<ReadHand>(readModel(request, Progress()));
  ASSERT_EQ(right.poses.size(), 2u);
  EXPECT_EQ(right.model.restPose()[0], 1.1);
  EXPECT_EQ(right.model.zeroPose()[0], 0.0);

  request.hand.mirrored = true;
  const auto left = std::get<ReadHand>(readModel(request, Progress()));
  EXPECT_EQ(left.model.restPose()[0], 1.1);
  const Eigen::Vector3d S(-1.0, 1.0, 1.0);
  EXPECT_TRUE(
      left.model.joints()[0].axis_J.isApprox(-S.cwiseProduct(right.model.joints()[0].axis_J)));
}

TEST(ReadModel, MirrorsSitesUnlessTheyAreOfTheMirroredHand) {
  ReadRequest request = clampRequest();
  request.hand.mirrored = true;
  const auto left = std::get<ReadHand>(readModel(request, Progress()));
  EXPECT_EQ((*left.sites)[0].p_L, Eigen::Vector3d(-0.01, 0, 0));
  EXPECT_EQ((*left.sites)[0].n_L, Eigen::Vector3d(-1, 0, 0));
  // What is written of the mirrored hand, as a file to edit, is read as it stands.
  request.files["sites.yaml"] = written("left.yaml", io::sitesText(*left.sites, true));
  const auto again = std::get<ReadHand>(readModel(request, Progress()));
  EXPECT_EQ((*again.sites)[0].p_L, Eigen::Vector3d(-0.01, 0, 0));
  request.hand.mirrored = false;
  const auto right = std::get<ReadHand>(readModel(request, Progress()));
  EXPECT_EQ((*right.sites)[0].p_L, Eigen::Vector3d(0.01, 0, 0));
}

TEST(ReadModel, ListsThePosesThereAre) {
  ReadRequest request = clampRequest();
  request.hand.srdf_uri = "clamp.srdf";
  request.hand.rest_pose = "wide";
  EXPECT_THAT(faultOf(request), AllOf(HasSubstr("'wide'"), HasSubstr("'open', 'shut'")));
  request.hand.srdf_uri = "other.srdf";
  EXPECT_THAT(faultOf(request), AllOf(HasSubstr("'other.srdf'"), HasSubstr("not uploaded")));
}

// === Contact maps

TEST(ReadModel, HonoursHowAMapIsToBeSplit) {
  const auto object = requestFor(ReadKind::kObject, written("o.ply", ballPly(0.04, 1.0)));
  ReadRequest request = mapRequest(object.files.begin()->second, object);
  request.contacts.segmentation.threshold = 2.0;
  EXPECT_THAT(faultOf(request), HasSubstr("no patch"));
  request.contacts.segmentation.rule = contact::ThresholdRule::kOtsu;
  EXPECT_THAT(faultOf(request), Not("no error"));  // one value alone parts nothing
  request.contacts.segmentation = {};
  request.contacts.segmentation.threshold = 0.25;
  request.contacts.segmentation.interpolation_count = 12;
  const ReadContacts read = contactsOf(request);
  EXPECT_EQ(read.threshold, 0.25);
  EXPECT_EQ(read.set.patches[0].interpolation_boundary.size(), 12u);
  EXPECT_EQ(read.set.name, request.name);
  request.contacts.source.value_property = "heat";
  EXPECT_THAT(faultOf(request), HasSubstr("'heat'"));
  request.contacts.picture_uri = "x.png";
  EXPECT_THAT(faultOf(request), AllOf(HasSubstr("'x.png'"), HasSubstr("not uploaded")));
}

TEST(ReadModel, SaysWhichObjectASetLiesOn) {
  const auto request = requestFor(
      ReadKind::kObjectName, test::sourceDirectory() / "server/models/contacts/lemon_6.json");
  EXPECT_EQ(std::get<ObjectName>(readModel(request, Progress())).name, "lemon");
}

// === Packed

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
  return {motion};
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
          {pack(ReadModel(smallMotion(map))), map.contacts.object}};
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
