#include "core/io/contact_file.h"

#include <cmath>
#include <fstream>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/plates.h"
#include "tests/support/shared_data.h"

namespace handgraft::io {
namespace {

using contact::ContactSet;
using contact::Patch;
using geometry::positionOf;
using geometry::TriangleMesh;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

std::filesystem::path write(const std::string& name, const std::string& text) {
  const std::filesystem::path path = test::scratchDirectory() / name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

/// A plate of 4 x 4 cells whose file has its vertices and faces backwards, and one face twice
/// as a polygon's second triangle.
MeshFile backwardsPlate() {
  MeshFile file;
  file.mesh = test::makePlate(4, 4, 0.01);
  const int vertices = file.mesh.vertexCount();
  file.mesh_vertex.resize(static_cast<std::size_t>(vertices));
  for (int v = 0; v < vertices; ++v) {
    file.file_vertex.push_back(vertices - 1 - v);
    file.mesh_vertex[vertices - 1 - v] = v;
  }
  // Each cell was a square in the file, cut into two triangles.
  for (int f = 0; f < file.mesh.faceCount(); ++f) {
    file.file_face.push_back((file.mesh.faceCount() - 1 - f) / 2);
  }
  return file;
}

constexpr const char* kSquareSet = R"({
  "format": "handgraft-contacts/1", "name": "two", "object": "plate",
  "patches": [
    {"name": "thumb", "root": {"vertex": 12}, "direction": [1, 0, 0],
     "boundary": [18, 17, 16, 11, 6, 7, 8, 13], "weight": 0.5},
    {"name": "index", "root": {"face": 3, "barycentric": [0.2, 0.3, 0.5]},
     "boundary": [18, 17, 16, 11, 6, 7, 8, 13], "interpolation_count": 8}],
  "notes": ["drawn by hand"]})";

TEST(ContactSetFile, IsReadInTheObjectFilesOwnOrder) {
  const MeshFile object = backwardsPlate();
  const ContactSet set = readContactSet(write("two.json", kSquareSet), object);
  EXPECT_EQ(set.name, "two");
  EXPECT_EQ(set.object, "plate");
  EXPECT_THAT(set.notes, ElementsAre("drawn by hand"));
  ASSERT_EQ(set.patches.size(), 2u);

  const Patch& thumb = set.patches[0];
  EXPECT_EQ(geometry::vertexAt(object.mesh, thumb.root), 12);  // 24 - 12
  EXPECT_THAT(thumb.boundary, ElementsAre(6, 7, 8, 13, 18, 17, 16, 11));
  EXPECT_EQ(thumb.interpolation_boundary.size(), 25u);
  EXPECT_EQ(thumb.weight, 0.5);
  ASSERT_TRUE(thumb.direction_O.has_value());

  const Patch& index = set.patches[1];
  EXPECT_EQ(object.file_face[index.root.face], 3);
  EXPECT_EQ(index.interpolation_boundary.size(), 8u);
  EXPECT_EQ(index.weight, 1.0);
  EXPECT_FALSE(index.direction_O.has_value());
}

TEST(ContactSetFile, WrittenAndReadAgainIsTheSame) {
  const MeshFile object = backwardsPlate();
  ContactSet set = readContactSet(write("two.json", kSquareSet), object);
  set.patches[1].boundary.clear();  // as carried patches have it
  const auto path = test::scratchDirectory() / "again.json";
  writeContactSet(path, set, object);
  const ContactSet again = readContactSet(path, object);
  EXPECT_EQ(again.name, set.name);
  EXPECT_EQ(again.object, set.object);
  EXPECT_EQ(again.notes, set.notes);
  ASSERT_EQ(again.patches.size(), set.patches.size());
  for (std::size_t i = 0; i < set.patches.size(); ++i) {
    const Patch& a = set.patches[i];
    const Patch& b = again.patches[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.direction_O, b.direction_O);
    EXPECT_EQ(a.boundary, b.boundary);
    EXPECT_EQ(a.weight, b.weight);
    EXPECT_EQ(positionOf(object.mesh, a.root), positionOf(object.mesh, b.root));
    ASSERT_EQ(a.interpolation_boundary.size(), b.interpolation_boundary.size());
    for (std::size_t k = 0; k < a.interpolation_boundary.size(); ++k) {
      EXPECT_LT((positionOf(object.mesh, a.interpolation_boundary[k]) -
                 positionOf(object.mesh, b.interpolation_boundary[k]))
                    .norm(),
                1e-16);
    }
  }
}

TEST(ContactSetFile, KeepsPlacesOnTheHandThatTouched) {
  const MeshFile object = backwardsPlate();
  ContactSet set = readContactSet(write("two.json", kSquareSet), object);
  set.patches[0].place = hand::HandLocation{"index", "middle", 3, 0.25, -0.5, 0.5, 0.4};
  set.patches[1].place = hand::HandLocation{"palm", "", 0, 0.75, 0.125, 0.3, -1.0};
  const auto path = test::scratchDirectory() / "places.json";
  writeContactSet(path, set, object);
  const ContactSet again = readContactSet(path, object);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_EQ(again.patches.at(i).place, set.patches[i].place) << i;
  const std::string text = contactSetText(set, object);
  EXPECT_THAT(text, HasSubstr("handgraft-contacts/2"));
  set.patches[0].place.reset();
  set.patches[1].place.reset();
  EXPECT_THAT(contactSetText(set, object), HasSubstr("handgraft-contacts/1"));
  std::string old = text;
  old.replace(old.find("handgraft-contacts/2"), 20, "handgraft-contacts/1");
  EXPECT_THAT(
      [&] {
        readContactSet(write("old.json", old), object);
      },
      ThrowsMessage<InvalidInput>(HasSubstr("'place' needs format")));
}

TEST(ContactSetFile, KeepsThePostureOfTheHandThatTouched) {
  const MeshFile object = backwardsPlate();
  ContactSet set = readContactSet(write("two.json", kSquareSet), object);
  set.side = hand::Chirality::kLeft;
  set.posture = {{"palm", {0.0, 0.6, 0.8}, {1.0, 0.0, 0.0}},
                 {"index_middle", {0.0, 0.0, 1.0}, Eigen::Vector3d::Zero()}};
  const std::string text = contactSetText(set, object);
  EXPECT_THAT(text, HasSubstr("handgraft-contacts/2"));
  const ContactSet again = readContactSet(write("posture.json", text), object);
  EXPECT_EQ(again.side, set.side);
  ASSERT_EQ(again.posture.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(again.posture[i].part, set.posture[i].part);
    EXPECT_LT((again.posture[i].outward_O - set.posture[i].outward_O).norm(), 1e-15);
    EXPECT_LT((again.posture[i].palmar_O - set.posture[i].palmar_O).norm(), 1e-15);
  }
  set.posture[1].outward_O.setZero();
  const std::string flat = contactSetText(set, object);
  EXPECT_THAT(
      [&] {
        readContactSet(write("flat.json", flat), object);
      },
      ThrowsMessage<InvalidInput>(HasSubstr("'outward' has no length")));
}

TEST(ContactSetFile, FaultsNameFilePatchAndField) {
  const MeshFile object = backwardsPlate();
  const auto refuses = [&](const std::string& from, const std::string& to, const char* text) {
    std::string spoilt = kSquareSet;
    const std::size_t at = spoilt.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    spoilt.replace(at, from.size(), to);
    EXPECT_THAT(
        [&] {
          readContactSet(write("bad.json", spoilt), object);
        },
        ThrowsMessage<InvalidInput>(AllOf(HasSubstr("bad.json"), HasSubstr(text))))
        << from << " -> " << to;
  };
  refuses("handgraft-contacts/1", "handgraft-contacts/9", "expected 'handgraft-contacts/1'");
  refuses("\"format\"", "\"fromat\"", "'format' is missing");
  refuses("\"patches\": [", "\"notes\": [", "'patches' is missing");
  refuses(
      "\"patches\"", "\"patch\"",
      "field 'patch' is unknown; permitted are format name object side patches posture notes");
  refuses("\"direction\"", "\"dirrection\"",
          "patch 'thumb': field 'dirrection' is unknown; permitted are name root direction");
  refuses("\"face\": 3", "\"face\": 3, \"baricentric\": 1",
          "field 'root': field 'baricentric' is unknown; permitted are vertex face triangle");
  refuses("\"index\"", "\"thumb\"", "patches 0 and 1 are both called 'thumb'");
  refuses("{\"vertex\": 12}", "{\"vertex\": 25}", "patch 'thumb': field 'root': vertex 25");
  refuses("{\"vertex\": 12}", "{\"vertex\": -1}", "field 'root' is '-1'");
  refuses("{\"vertex\": 12}", "{\"vertex\": 1e99}", "field 'root'");
  refuses("{\"vertex\": 12}", "[12]", "patch 'thumb': field 'root' is no object");
  refuses("18, 17", "18, 99", "field 'boundary': vertex 99");
  refuses("18, 17", "18, 4", "share no edge");
  refuses("\"face\": 3", "\"face\": 16", "patch 'index': face 16");
  refuses("0.2, 0.3, 0.5", "0.2, 0.3, 0.6", "patch 'index'");
  refuses("0.2, 0.3, 0.5", "0.2, 0.3", "'barycentric' must be an array of 3 numbers");
  refuses("[1, 0, 0]", "[0, 0, 1]", "parallel");
  refuses("[1, 0, 0]", "[1, \"0\", 0]", "'direction'");
  refuses("0.5}", "-2}", "'thumb': weight is -2");
  refuses("\"interpolation_count\": 8", "\"interpolation_count\": 2", "count is 2");
}

TEST(ContactSetFile, ThatIsNoJsonIsRefused) {
  const MeshFile object = backwardsPlate();
  for (const char* text : {"", "{", "[1, 2", "\xff\xfe\x00", "[]", "null", "{\"a\": 1e9999}"}) {
    EXPECT_THAT(
        [&] {
          readContactSet(write("bad.json", text), object);
        },
        ThrowsMessage<InvalidInput>(HasSubstr("bad.json")))
        << text;
  }
  const std::string deep(100'000, '[');
  EXPECT_THROW(readContactSet(write("bad.json", deep), object), InvalidInput);
  EXPECT_THROW(readContactSet(test::scratchDirectory() / "missing.json", object), InvalidInput);
  EXPECT_THROW(readContactSet(test::scratchDirectory(), object), InvalidInput);
}

TEST(ContactSetFile, ThatIsAListOfPointsIsToldWhatToWrite) {
  EXPECT_THAT(
      [] {
        readContactSet(write("points.json", "[[0, 0, 0], [0.1, 0, 0]]"), backwardsPlate());
      },
      ThrowsMessage<InvalidInput>(AllOf(HasSubstr("points.json: the file holds a list of 2"),
                                        HasSubstr("handgraft-contacts/1"),
                                        HasSubstr("contact at each vertex"))));
}

/// A plate as PLY with full contact within 12 mm of its middle, all of segment `link`.
std::string plyPlate(const std::string& comment, int link) {
  const TriangleMesh mesh = test::makePlate(40, 40, 0.001);
  std::ostringstream text;
  text << "ply\nformat ascii 1.0\ncomment " << comment << "\nelement vertex "
       << mesh.vertexCount()
       << "\nproperty float x\nproperty float y\nproperty float z\nproperty float contact\n"
          "property int link\nelement face "
       << mesh.faceCount() << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (int v = 0; v < mesh.vertexCount(); ++v) {
    const bool touches = mesh.vertex(v).norm() < 0.012;
    text << mesh.vertex(v).transpose() << (touches ? " 1 " : " 0 ") << (touches ? link : -1)
         << '\n';
  }
  for (int f = 0; f < mesh.faceCount(); ++f)
    text << "3 " << mesh.face(f).transpose() << '\n';
  return text.str();
}

TEST(ContactSetFile, ThatIsAMeshAsksForItsPicture) {
  for (const char* name : {"cup.glb", "cup.gltf", "cup.STL"}) {
    EXPECT_THAT(
        [&] {
          readContactSet(write(name, "{}"), backwardsPlate());
        },
        ThrowsMessage<InvalidInput>(AllOf(HasSubstr(name), HasSubstr("--picture FILE"))));
  }
}

TEST(ContactMapFile, TakesNamesFromTheComment) {
  const auto path =
      write("map.ply", plyPlate("made by hand, link index: 0=palm, 2=link_ff_dd 7=x", 2));
  const contact::ContactMap map = readContactMap(path);
  ASSERT_EQ(map.segment_names.size(), 8u);
  EXPECT_EQ(map.segment_names[0], "palm");
  EXPECT_EQ(map.segment_names[1], "");
  EXPECT_EQ(map.segment_names[2], "link_ff_dd");
  EXPECT_EQ(map.mesh_O.vertexCount(), 41 * 41);
  EXPECT_EQ(map.value.maxCoeff(), 1.0);
}

TEST(ContactMapFile, WithoutContactIsRefused) {
  std::string text = plyPlate("0=palm", 0);
  text.replace(text.find("float contact"), 13, "float warmth_");
  EXPECT_THAT(
      [&] {
        readContactMap(write("cold.ply", text));
      },
      ThrowsMessage<InvalidInput>(
          AllOf(HasSubstr("cold.ply"), HasSubstr("no vertex property 'contact'"))));
}

TEST(ContactMapFile, WithAnImpossibleLabelIsRefused) {
  EXPECT_THAT(
      [&] {
        readContactMap(write("odd.ply", plyPlate("0=palm", -7)));
      },
      ThrowsMessage<InvalidInput>(AllOf(HasSubstr("odd.ply"), HasSubstr("is -7"))));
}

TEST(ContactFile, IsAMapOrASetByItsContent) {
  const MeshFile object = backwardsPlate();
  EXPECT_EQ(readContacts(write("set.ply.json", kSquareSet), object).patches.size(), 2u);
  const ContactSet set =
      readContacts(write("map.anything", plyPlate("0=index_tip", 0)), object);
  ASSERT_EQ(set.patches.size(), 1u);
  EXPECT_EQ(set.patches[0].name, "index_distal");
  EXPECT_EQ(set.name, "map");
}

TEST(ContactFile, NamedPlyIsCalledNoJson) {
  const MeshFile object = backwardsPlate();
  for (const char* name : {"damaged.ply", "damaged.PLY"}) {
    EXPECT_THAT(
        [&] {
          readContacts(write(name, "what ever"), object);
        },
        ThrowsMessage<InvalidInput>(AllOf(HasSubstr(name), Not(HasSubstr("JSON")))));
    EXPECT_EQ(objectNameIn(write(name, "what ever")), "");
  }
}

TEST(ContactFile, NotesLinksThatTheHeaderDoesNotName) {
  const MeshFile object = backwardsPlate();
  const ContactSet named = readContacts(write("named.ply", plyPlate("0=index_tip", 0)), object);
  EXPECT_THAT(named.notes, Not(Contains(HasSubstr("header's list"))));
  const ContactSet anonymous = readContacts(write("plain.ply", plyPlate("none", 7)), object);
  EXPECT_THAT(anonymous.notes, Not(Contains(HasSubstr("header's list"))));
  const ContactSet unlisted = readContacts(write("odd.ply", plyPlate("0=wrist", 7)), object);
  EXPECT_THAT(unlisted.notes, Contains(AllOf(HasSubstr("link 7 of "),
                                             HasSubstr("is not in the header's list"))));
}

// === Real maps

struct RealMap {
  const char* map;
  const char* object;
  std::vector<std::string> fingers;
};

// NOLINTNEXTLINE(readability-identifier-naming): GoogleTest's name
void PrintTo(const RealMap& real, std::ostream* out) {
  *out << real.map;
}

class RealMapTest : public ::testing::TestWithParam<RealMap> {};

TEST_P(RealMapTest, GivesPatchesToEveryFingerThatTouches) {
  HANDGRAFT_NEEDS_SHARED_DATA("contacts/dexycb");
  const contact::ContactMap map = readContactMap(test::sharedData(GetParam().map));
  const ContactSet set = contact::segment(map, {});
  std::vector<std::string> names;
  for (const Patch& patch : set.patches) {
    const auto place = hand::placeNamed(patch.name);
    const std::string& digit = place ? place->digit : patch.name;
    if (names.empty() || names.back() != digit) names.push_back(digit);
    EXPECT_NO_THROW(validate(map.mesh_O, patch));
  }
  EXPECT_EQ(names, GetParam().fingers) << fmt::format("{}", fmt::join(set.notes, "\n"));
}

/// Distance from a point to the nearest edge of a loop.
double distanceToLoop(const TriangleMesh& mesh,
                      const std::vector<int>& loop,
                      const Eigen::Vector3d& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Eigen::Vector3d a = mesh.vertex(loop[i]);
    const Eigen::Vector3d d = mesh.vertex(loop[(i + 1) % loop.size()]) - a;
    const double t = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (p - a - t * d).norm());
  }
  return nearest;
}

TEST_P(RealMapTest, PutsInterpolationPointsOnTheBoundaryAtEqualArcs) {
  HANDGRAFT_NEEDS_SHARED_DATA("contacts/dexycb");
  const contact::ContactMap map = readContactMap(test::sharedData(GetParam().map));
  const TriangleMesh& mesh = map.mesh_O;
  for (const Patch& patch : contact::segment(map, {}).patches) {
    double length = 0.0;
    for (std::size_t i = 0; i < patch.boundary.size(); ++i) {
      length += (mesh.vertex(patch.boundary[(i + 1) % patch.boundary.size()]) -
                 mesh.vertex(patch.boundary[i]))
                    .norm();
    }
    const double spacing = length / static_cast<double>(patch.interpolation_boundary.size());
    for (std::size_t k = 0; k < patch.interpolation_boundary.size(); ++k) {
      const Eigen::Vector3d p = positionOf(mesh, patch.interpolation_boundary[k]);
      const Eigen::Vector3d next = positionOf(
          mesh, patch.interpolation_boundary[(k + 1) % patch.interpolation_boundary.size()]);
      EXPECT_LT(distanceToLoop(mesh, patch.boundary, p), 1e-9) << patch.name;
      EXPECT_LE((next - p).norm(), spacing * (1 + 1e-9)) << patch.name;
    }
  }
}

TEST_P(RealMapTest, LiesOnTheObjectItWasMadeFor) {
  HANDGRAFT_NEEDS_SHARED_DATA("objects/ycb");
  const MeshFile object = readMesh(test::sharedData(GetParam().object));
  const ContactSet set = readContacts(test::sharedData(GetParam().map), object);
  ASSERT_GE(set.patches.size(), GetParam().fingers.size());
  const contact::ContactMap map = readContactMap(test::sharedData(GetParam().map));
  const ContactSet on_map = contact::segment(map, {});
  for (std::size_t i = 0; i < set.patches.size(); ++i) {
    EXPECT_NO_THROW(validate(object.mesh, set.patches[i]));
    EXPECT_EQ(set.patches[i].interpolation_boundary.size(), 25u);
    EXPECT_LT((positionOf(object.mesh, set.patches[i].root) -
               positionOf(map.mesh_O, on_map.patches[i].root))
                  .norm(),
              0.0005);
  }
}

INSTANTIATE_TEST_SUITE_P(
    DexYcb,
    RealMapTest,
    ::testing::Values(RealMap{"contacts/dexycb/003_cracker_box_grasp0_contact.ply",
                              "objects/ycb/003_cracker_box.obj",
                              {"thumb", "index", "middle", "ring", "little"}},
                      RealMap{"contacts/dexycb/006_mustard_bottle_grasp0_contact.ply",
                              "objects/ycb/006_mustard_bottle.obj",
                              {"thumb", "index", "middle", "ring", "little", "palm"}},
                      RealMap{"contacts/dexycb/006_mustard_bottle_grasp3_contact.ply",
                              "objects/ycb/006_mustard_bottle.obj",
                              {"thumb", "index", "middle", "ring", "little"}},
                      RealMap{"contacts/dexycb/025_mug_grasp0_contact.ply",
                              "objects/ycb/025_mug.obj",
                              {"thumb", "index", "middle"}}));

TEST(RealMap, OfAnotherObjectIsRefused) {
  HANDGRAFT_NEEDS_SHARED_DATA("objects/ycb");
  const MeshFile banana = readMesh(test::sharedData("objects/ycb/011_banana.obj"));
  EXPECT_THAT(
      [&] {
        readContacts(test::sharedData("contacts/dexycb/003_cracker_box_grasp0_contact.ply"),
                     banana);
      },
      ThrowsMessage<InvalidInput>(
          AllOf(HasSubstr("003_cracker_box"), HasSubstr("do not fit the object"))));
}

TEST(RealMap, WithoutLabelsGivesAnonymousPatches) {
  HANDGRAFT_NEEDS_SHARED_DATA("contacts/contactpose");
  const contact::ContactMap map = readContactMap(
      test::sharedData("contacts/contactpose/full28_use_light_bulb_contact.ply"));
  const ContactSet set = contact::segment(map, {});
  ASSERT_GE(set.patches.size(), 2u);
  for (std::size_t i = 0; i < set.patches.size(); ++i) {
    EXPECT_EQ(set.patches[i].name, fmt::format("c{}", i + 1));
    EXPECT_NO_THROW(validate(map.mesh_O, set.patches[i]));
  }
}

}  // namespace
}  // namespace handgraft::io
