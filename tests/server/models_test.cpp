// The built-in library: what server/models/README.md promises about hands, objects and sets.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/contact/segmentation.h"
#include "core/geometry/log_map.h"
#include "core/hand/skin_cache.h"
#include "core/io/contact_file.h"
#include "core/io/sites_file.h"
#include "core/io/urdf_file.h"
#include "core/session/session.h"

#include "tests/support/shared_data.h"

namespace handgraft {
namespace {

std::filesystem::path library() {
  return test::sourceDirectory() / "server" / "models";
}

/// Names the case of a parameterised test by its facts' name.
struct NameOfCase {
  template <class Facts>
  std::string operator()(const testing::TestParamInfo<Facts>& info) const {
    return info.param.name;
  }
};

// === Hands
struct HandFacts {
  std::string name;
  int joints;
  std::set<std::string> sites;
};

struct LoadedHand {
  io::UrdfFile file;
  std::vector<hand::ContactSite> sites;
};

LoadedHand loadHand(const std::string& name) {
  const auto folder = library() / "hands" / name;
  io::UrdfFile file = io::readUrdf(folder / (name + ".urdf"));
  std::vector<hand::ContactSite> sites = io::readSites(folder / "sites.yaml", file.model);
  return {std::move(file), std::move(sites)};
}

/// The pad of every site in H, at joints q.
std::map<std::string, Eigen::Vector3d> padsAt(const LoadedHand& hand,
                                              const Eigen::VectorXd& q) {
  hand::LinkPoses X_HL;
  hand::forwardKinematics(hand.file.model, Pose::Identity(), q, X_HL);
  std::map<std::string, Eigen::Vector3d> pads;
  for (const hand::ContactSite& site : hand.sites)
    pads[site.name] =
        X_HL[static_cast<std::size_t>(hand.file.model.linkIndex(site.link))] * site.p_L;
  return pads;
}

class BuiltInHand : public testing::TestWithParam<HandFacts> {};

TEST_P(BuiltInHand, IsReadWithoutNotesAndHasItsJoints) {
  const LoadedHand hand = loadHand(GetParam().name);
  EXPECT_TRUE(hand.file.notes.empty()) << hand.file.notes.front();
  EXPECT_EQ(hand.file.model.name(), GetParam().name);
  EXPECT_EQ(hand.file.model.dofCount(), GetParam().joints);
  EXPECT_EQ(hand.file.model.mimicCount(), 0);
}

TEST_P(BuiltInHand, LimitsPositionAndSpeedOfEveryJoint) {
  const LoadedHand hand = loadHand(GetParam().name);
  for (int dof = 0; dof < hand.file.model.dofCount(); ++dof) {
    const hand::Joint& joint = hand.file.model.dofJoint(dof);
    EXPECT_GT(joint.lower, -std::numbers::pi) << joint.name;
    EXPECT_LT(joint.upper, std::numbers::pi + 1e-6) << joint.name;
    EXPECT_GT(joint.upper - joint.lower, 0.3) << joint.name;
    EXPECT_GT(joint.velocity_limit, 0.0) << joint.name;
  }
}

TEST_P(BuiltInHand, NamesTheSitesItHas) {
  const LoadedHand hand = loadHand(GetParam().name);
  std::set<std::string> names;
  for (const hand::ContactSite& site : hand.sites)
    names.insert(site.name);
  EXPECT_EQ(names, GetParam().sites);
  EXPECT_EQ(names.size(), hand.sites.size());
}

TEST_P(BuiltInHand, IsARightHandWithItsIndexOnTheThumbsSide) {
  const LoadedHand hand = loadHand(GetParam().name);
  const auto pads = padsAt(hand, hand.file.model.restPose());
  double previous = std::numeric_limits<double>::infinity();
  for (const char* finger : {"index", "middle", "ring", "little"}) {
    if (!pads.contains(finger)) continue;
    EXPECT_LT(pads.at(finger).y(), previous) << finger;
    EXPECT_GT(pads.at(finger).z(), 0.1) << finger;
    previous = pads.at(finger).y();
  }
  if (pads.contains("ring")) {
    EXPECT_GT(pads.at("thumb").y(), pads.at("middle").y());
  }
}

TEST_P(BuiltInHand, BendsItsFingersTowardsThePalmsSide) {
  const LoadedHand hand = loadHand(GetParam().name);
  const Eigen::VectorXd rest = hand.file.model.restPose();
  Eigen::VectorXd bent = rest;
  for (int dof = 0; dof < hand.file.model.dofCount(); ++dof) {
    const std::string& joint = hand.file.model.dofJoint(dof).name;
    if (joint.ends_with("_flex") || joint.ends_with("_crease"))
      bent[dof] = std::min(rest[dof] + 0.4, hand.file.model.upper()[dof]);
  }
  const auto before = padsAt(hand, rest);
  const auto after = padsAt(hand, bent);
  for (const auto& [name, pad_H] : before)
    if (name != "palm" && name != "thumb") {
      EXPECT_GT(after.at(name).x(), pad_H.x() + 0.01) << name;
    }
}

TEST_P(BuiltInHand, HasAClosedSkinThatCarriesItsSites) {
  const LoadedHand hand = loadHand(GetParam().name);
  const hand::Skin skin =
      hand::SkinCache::fromEnvironment().get(hand.file.model, hand::SkinOptions{}, Progress{});
  EXPECT_TRUE(skin.mesh().isClosed());
  EXPECT_EQ(skin.mesh().eulerCharacteristic(), 2);
  EXPECT_EQ(skin.mesh().components().second, 1);

  // The library's sites are those that are found on any hand.
  const std::vector<hand::ContactSite> found = findContactSites(hand.file.model, skin);
  ASSERT_EQ(found.size(), hand.sites.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].name, hand.sites[i].name);
    EXPECT_EQ(found[i].link, hand.sites[i].link) << found[i].name;
    EXPECT_LT((found[i].p_L - hand.sites[i].p_L).norm(), 1e-6) << found[i].name;
    EXPECT_LT((found[i].n_L - hand.sites[i].n_L).norm(), 1e-6) << found[i].name;
    EXPECT_LT((found[i].direction_L - hand.sites[i].direction_L).norm(), 1e-6) << found[i].name;
  }

  hand::LinkPoses X_SL;
  hand::forwardKinematics(hand.file.model, Pose::Identity(), skin.qReference(), X_SL);
  for (const hand::ContactSite& site : hand.sites) {
    const int link = hand.file.model.linkIndex(site.link);
    const Pose& X = X_SL[static_cast<std::size_t>(link)];
    const geometry::SurfacePoint place = skin.skinPointOf(link, site.p_L);
    const Eigen::Vector3d p_S = geometry::positionOf(skin.mesh(), place);
    const Eigen::Vector3d n_S = geometry::normalOf(skin.mesh(), place);
    EXPECT_LT((p_S - X * site.p_L).norm(), 0.002) << site.name;
    EXPECT_GT(n_S.dot(X.linear() * site.n_L), std::cos(0.35)) << site.name;
    const auto back = skin.project(p_S, n_S);
    ASSERT_TRUE(back.has_value()) << site.name;
    EXPECT_EQ(back->link, link) << site.name;
  }
}

const std::set<std::string> all_sites{"thumb", "index", "middle", "ring", "little", "palm"};

INSTANTIATE_TEST_SUITE_P(
    Library,
    BuiltInHand,
    testing::Values(HandFacts{"human20", 20, all_sites},
                    HandFacts{"allegro16", 16, {"thumb", "index", "middle", "ring", "palm"}},
                    HandFacts{"barrett8", 8, {"thumb", "index", "middle", "palm"}},
                    HandFacts{"tendon16", 16, all_sites}),
    NameOfCase{});

// === Objects
struct ObjectFacts {
  std::string name;
  int genus;
  Eigen::Vector3d size_m;
};

io::MeshFile loadObject(const std::string& name) {
  return io::readMesh(library() / "objects" / (name + ".obj"));
}

/// Positive when the faces look outwards (divergence theorem), m^3.
double volumeOf(const geometry::TriangleMesh& mesh) {
  double volume = 0.0;
  for (int f = 0; f < mesh.faceCount(); ++f) {
    const Eigen::Vector3i c = mesh.face(f);
    volume += mesh.vertex(c[0]).dot(mesh.vertex(c[1]).cross(mesh.vertex(c[2]))) / 6.0;
  }
  return volume;
}

double leastAngleOf(const geometry::TriangleMesh& mesh) {
  double least = std::numbers::pi;
  for (int f = 0; f < mesh.faceCount(); ++f)
    for (int corner = 0; corner < 3; ++corner) {
      const Eigen::Vector3d p = mesh.vertex(mesh.face(f)[corner]);
      const Eigen::Vector3d u = mesh.vertex(mesh.face(f)[(corner + 1) % 3]) - p;
      const Eigen::Vector3d w = mesh.vertex(mesh.face(f)[(corner + 2) % 3]) - p;
      least = std::min(least, std::atan2(u.cross(w).norm(), u.dot(w)));
    }
  return least;
}

class BuiltInObject : public testing::TestWithParam<ObjectFacts> {};

TEST_P(BuiltInObject, IsOneClosedSurfaceThatLooksOutwards) {
  const io::MeshFile object = loadObject(GetParam().name);
  EXPECT_TRUE(object.notes.empty()) << object.notes.front();
  EXPECT_TRUE(object.mesh.isClosed());
  EXPECT_EQ(object.mesh.nonManifoldEdgeCount(), 0);
  EXPECT_EQ(object.mesh.components().second, 1);
  EXPECT_EQ(object.mesh.eulerCharacteristic(), 2 - 2 * GetParam().genus);
  EXPECT_GT(volumeOf(object.mesh), 0.0);
}

TEST_P(BuiltInObject, HasItsSizeAndEvenTriangles) {
  const geometry::TriangleMesh mesh = loadObject(GetParam().name).mesh;
  const Eigen::Vector3d extent =
      mesh.vertices().rowwise().maxCoeff() - mesh.vertices().rowwise().minCoeff();
  EXPECT_LT((extent - GetParam().size_m).cwiseAbs().maxCoeff(), 0.001) << extent.transpose();
  EXPECT_GT(leastAngleOf(mesh), 12.0 * std::numbers::pi / 180.0);
  EXPECT_GT(mesh.meanEdgeLength(), 0.0018);
  EXPECT_LT(mesh.meanEdgeLength(), 0.004);
  EXPECT_GE(mesh.vertexCount(), 3000);
  EXPECT_LE(mesh.vertexCount(), 12000);
}

INSTANTIATE_TEST_SUITE_P(Library,
                         BuiltInObject,
                         testing::Values(ObjectFacts{"box", 0, {0.065, 0.040, 0.160}},
                                         ObjectFacts{"lemon", 0, {0.0598, 0.0598, 0.076}},
                                         ObjectFacts{"wine_glass", 0, {0.072, 0.072, 0.200}},
                                         ObjectFacts{"scissors", 2, {0.1823, 0.0791, 0.0114}}),
                         NameOfCase{});

// === Contact sets
struct SetFacts {
  std::string name;
  std::string object;
  std::vector<std::string> patches;
};

struct LoadedSet {
  io::MeshFile object;
  contact::ContactSet contacts;
};

LoadedSet loadSet(const SetFacts& facts) {
  io::MeshFile object = loadObject(facts.object);
  contact::ContactSet contacts =
      io::readContactSet(library() / "contacts" / (facts.name + ".json"), object);
  return {std::move(object), std::move(contacts)};
}

const std::vector<SetFacts>& allSets() {
  static const std::vector<SetFacts> sets{
      {"scissors_3", "scissors", {"thumb", "index", "middle"}},
      {"wine_glass_4", "wine_glass", {"thumb", "index", "middle", "ring"}},
      {"box_5", "box", {"thumb", "index", "middle", "ring", "little"}},
      {"lemon_6", "lemon", {"palm", "thumb", "index", "middle", "ring", "little"}},
      {"lemon_3", "lemon", {"thumb", "index", "middle"}}};
  return sets;
}

/// Those that `human20` left; the last one is of `barrett8`.
std::vector<SetFacts> humanSets() {
  return {allSets().begin(), allSets().end() - 1};
}

class BuiltInContacts : public testing::TestWithParam<SetFacts> {};

TEST_P(BuiltInContacts, NamesItsObjectAndPatches) {
  const LoadedSet set = loadSet(GetParam());
  EXPECT_EQ(set.contacts.name, GetParam().name);
  EXPECT_EQ(set.contacts.object, GetParam().object);
  std::vector<std::string> names;
  for (const contact::Patch& patch : set.contacts.patches)
    names.push_back(patch.name);
  EXPECT_EQ(names, GetParam().patches);
}

TEST_P(BuiltInContacts, KeepsWhatPatchesPromise) {
  const LoadedSet set = loadSet(GetParam());
  for (const contact::Patch& patch : set.contacts.patches) {
    EXPECT_NO_THROW(contact::validate(set.object.mesh, patch)) << patch.name;
    const std::set<int> distinct(patch.boundary.begin(), patch.boundary.end());
    EXPECT_EQ(distinct.size(), patch.boundary.size()) << patch.name << ": not a simple loop";
    EXPECT_EQ(patch.interpolation_boundary.size(), 25U) << patch.name;
    ASSERT_TRUE(patch.direction_O.has_value()) << patch.name;
    EXPECT_NEAR(patch.direction_O->norm(), 1.0, 1e-5) << patch.name;
    const Eigen::Vector3d n_O = geometry::normalOf(set.object.mesh, patch.root);
    EXPECT_LT(std::abs(patch.direction_O->dot(n_O)), 0.05) << patch.name;
  }
}

TEST_P(BuiltInContacts, RunsOnceCounterClockwiseAroundEachRoot) {
  const LoadedSet set = loadSet(GetParam());
  for (const contact::Patch& patch : set.contacts.patches) {
    const geometry::LogMap map =
        geometry::computeLogMap(set.object.mesh, patch.root, *patch.direction_O, 0.03);
    double turned = 0.0;
    for (std::size_t i = 0; i < patch.boundary.size(); ++i) {
      const int a = patch.boundary[i];
      const int b = patch.boundary[(i + 1) % patch.boundary.size()];
      turned += std::remainder(map.phi[b] - map.phi[a], 2.0 * std::numbers::pi);
    }
    EXPECT_NEAR(turned, 2.0 * std::numbers::pi, 1e-6) << patch.name;
  }
}

TEST_P(BuiltInContacts, KeepsItsPatchesApart) {
  const LoadedSet set = loadSet(GetParam());
  std::set<int> taken;
  for (const contact::Patch& patch : set.contacts.patches)
    for (const int vertex : patch.boundary)
      EXPECT_TRUE(taken.insert(vertex).second) << patch.name << " at vertex " << vertex;
}

INSTANTIATE_TEST_SUITE_P(Library, BuiltInContacts, testing::ValuesIn(allSets()), NameOfCase{});

// === Grasps: every set on every hand, through the whole core
hand::Hand readyHand(const std::string& name) {
  LoadedHand loaded = loadHand(name);
  auto model = std::make_shared<const hand::HandModel>(std::move(loaded.file.model));
  auto skin = std::make_shared<const hand::Skin>(
      hand::SkinCache::fromEnvironment().get(*model, hand::SkinOptions{}, Progress{}));
  return {model, skin, std::move(loaded.sites)};
}

struct GraspOutcome {
  std::map<std::string, optimize::PatchFit> fits;
  std::set<std::string> dropped;
};

enum class Depth { kAvoided, kAllowed };

GraspOutcome grasp(const hand::Hand& hand,
                   const SetFacts& facts,
                   Depth depth = Depth::kAvoided) {
  const LoadedSet set = loadSet(facts);
  session::Session session(hand,
                           std::make_shared<const geometry::TriangleMesh>(set.object.mesh),
                           set.contacts, Pose::Identity(), optimize::Weights{});
  session::SolverSettings solving;
  solving.avoid_penetration = depth == Depth::kAvoided;
  const session::Solution solution = session.solve(solving, {}, Progress{});
  GraspOutcome outcome;
  for (const optimize::PatchFit& fit : solution.report.patches)
    outcome.fits[solution.patches[static_cast<std::size_t>(fit.patch)].patch.name] = fit;
  for (const session::SessionPatch& patch : solution.patches)
    if (!patch.dropped.empty()) outcome.dropped.insert(patch.patch.name);
  return outcome;
}

double meanOf(const GraspOutcome& outcome) {
  double sum = 0.0;
  for (const auto& [name, fit] : outcome.fits)
    sum += fit.mean_mm;
  return sum / static_cast<double>(outcome.fits.size());
}

TEST(BuiltInGrasp, HumanHandReachesEveryPatchThatItLeft) {
  const hand::Hand hand = readyHand("human20");
  for (const SetFacts& facts : humanSets()) {
    // 0.4 mm of it are kept free between hand and object.
    EXPECT_LT(meanOf(grasp(hand, facts)), 4.2) << facts.name;
    const GraspOutcome outcome = grasp(hand, facts, Depth::kAllowed);
    EXPECT_EQ(outcome.fits.size(), facts.patches.size()) << facts.name;
    EXPECT_TRUE(outcome.dropped.empty()) << facts.name;
    for (const auto& [name, fit] : outcome.fits) {
      EXPECT_LT(fit.mean_mm, 5.0) << facts.name << " " << name;
      EXPECT_LT(fit.normal_mean_deg, 75.0) << facts.name << " " << name;
    }
  }
}

TEST(BuiltInGrasp, ProsthesisFollowsTheHumanHand) {
  const hand::Hand hand = readyHand("tendon16");
  for (const SetFacts& facts : humanSets()) {
    const GraspOutcome outcome = grasp(hand, facts);
    EXPECT_TRUE(outcome.dropped.empty()) << facts.name;
    EXPECT_LT(meanOf(outcome), facts.name == "lemon_6" ? 8.0 : 5.0) << facts.name;
  }
}

TEST(BuiltInGrasp, AllegroHandGoesWithoutOneFingerAndReachesTheRest) {
  const hand::Hand hand = readyHand("allegro16");
  for (const SetFacts& facts : humanSets()) {
    const GraspOutcome outcome = grasp(hand, facts, Depth::kAllowed);
    const bool asks_five = facts.name == "box_5" || facts.name == "lemon_6";
    EXPECT_EQ(outcome.dropped.size(), asks_five ? 1U : 0U) << facts.name;
    EXPECT_FALSE(outcome.dropped.contains("thumb")) << facts.name;
    EXPECT_FALSE(outcome.dropped.contains("palm")) << facts.name;
    EXPECT_LT(meanOf(outcome), 6.0) << facts.name;
  }
}

TEST(BuiltInGrasp, BarrettHandReachesEveryPatchThatItLeft) {
  const GraspOutcome outcome = grasp(readyHand("barrett8"), allSets().back());
  EXPECT_TRUE(outcome.dropped.empty());
  EXPECT_EQ(outcome.fits.size(), 3U);
  for (const auto& [name, fit] : outcome.fits) {
    EXPECT_LT(fit.mean_mm, 3.0) << name;
    EXPECT_LT(fit.normal_mean_deg, 25.0) << name;
  }
}

// With the palm's as well it reached one of four.
TEST(BuiltInGrasp, BarrettHandTakesThreePatchesOfTheLemonAndReachesEach) {
  const GraspOutcome outcome = grasp(readyHand("barrett8"), humanSets().back());
  EXPECT_EQ(outcome.dropped, (std::set<std::string>{"palm", "middle", "little"}));
  EXPECT_EQ(outcome.fits.size(), 3U);
  for (const auto& [name, fit] : outcome.fits)
    EXPECT_LT(fit.mean_mm, 6.0) << name;
  EXPECT_LT(meanOf(outcome), 4.0);
}

/// A rod 10 mm thick, touched from below in its middle and from above on both sides of it.
contact::ContactMap pinchedRod() {
  contact::ContactMap map;
  map.mesh_O = transformed(geometry::makeSphere(1.0, 5),
                           Eigen::Affine3d(Eigen::Scaling(0.005, 0.005, 0.07)));
  map.value.setZero(map.mesh_O.vertexCount());
  for (const Eigen::Vector3d& touched :
       {Eigen::Vector3d(-0.005, 0, 0), {0.005, 0, 0.012}, {0.005, 0, -0.012}})
    for (int v = 0; v < map.mesh_O.vertexCount(); ++v)
      if ((map.mesh_O.vertex(v) - touched).norm() < 0.005) map.value[v] = 1.0;
  return map;
}

// A hand at rest or half curled opposes its thumb to nothing so thin.
TEST(BuiltInGrasp, APinchWithoutNamesIsTheThumbsAgainstTwoFingers) {
  const contact::ContactMap map = pinchedRod();
  const contact::ContactSet contacts = contact::segment(map, {});
  ASSERT_EQ(contacts.patches.size(), 3U);
  for (const char* const name : {"human20", "allegro16", "tendon16"}) {
    session::Session session(readyHand(name),
                             std::make_shared<const geometry::TriangleMesh>(map.mesh_O),
                             contacts, Pose::Identity(), optimize::Weights{});
    const session::Solution solution = session.solve({}, {}, Progress{});
    for (const session::SessionPatch& patch : solution.patches) {
      const bool is_below = positionOf(map.mesh_O, patch.patch.root).x() < 0.0;
      EXPECT_EQ(patch.site == "thumb", is_below) << name << " lays it on " << patch.site;
    }
    for (const optimize::PatchFit& fit : solution.report.patches)
      EXPECT_LT(fit.mean_mm, 4.0) << name;
  }
}

// By roots and normals alone its palm takes a finger's patch, and one of five is reached.
TEST(BuiltInGrasp, PatchesWithoutNamesGoWhereMostOfThemAreReached) {
  const LoadedSet set = loadSet({"box_5", "box", {}});
  contact::ContactSet contacts = set.contacts;
  int number = 0;
  for (contact::Patch& patch : contacts.patches) {
    patch.name = fmt::format("c{}", ++number);
    patch.place.reset();
  }
  session::Session session(readyHand("allegro16"),
                           std::make_shared<const geometry::TriangleMesh>(set.object.mesh),
                           contacts, Pose::Identity(), optimize::Weights{});
  const session::Solution solution = session.solve({}, {}, Progress{});
  std::ptrdiff_t dropped = 0;
  for (const session::SessionPatch& patch : solution.patches)
    dropped += patch.placement ? 0 : 1;
  EXPECT_EQ(dropped, 1);
  ASSERT_EQ(solution.report.patches.size(), 4U);
  for (const optimize::PatchFit& fit : solution.report.patches)
    EXPECT_LT(fit.mean_mm, 4.0);
}

// === Generator
std::string bytesOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(LibraryGenerator, ReproducesTheCommittedFiles) {
  if (std::system("python3 -c 'import sys; sys.exit(sys.version_info < (3, 9))' 2>/dev/null") !=
      0)
    GTEST_SKIP() << "needs python3, which the product itself does not";
  const auto output = test::scratchDirectory() / "library";
  const std::string command = "python3 '" + (library() / "make_library.py").string() +
                              "' --output '" + output.string() + "' >/dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0);
  int compared = 0;
  for (const char* folder : {"hands", "objects", "contacts"})
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(library() / folder)) {
      if (!entry.is_regular_file()) continue;
      if (entry.path().filename() == "sites.yaml") continue;  // found, see above
      const auto relative = std::filesystem::relative(entry.path(), library());
      EXPECT_TRUE(bytesOf(entry.path()) == bytesOf(output / relative)) << relative;
      ++compared;
    }
  EXPECT_EQ(compared, 13);
}

}  // namespace
}  // namespace handgraft
