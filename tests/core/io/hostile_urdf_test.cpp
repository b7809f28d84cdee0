// Hands that are wrong in themselves: numbers, names, trees and the files they name.

#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/hand/digits.h"
#include "core/hand/kinematics.h"
#include "core/io/mesh_file.h"
#include "core/io/srdf_file.h"
#include "core/io/urdf_file.h"

#include "tests/core/io/hostile_reading.h"
#include "tests/support/shared_data.h"

namespace handgraft::io {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

fs::path write(const std::string& name, const std::string& text) {
  static const fs::path urdf_folder = test::scratchDirectory();
  fs::path path = urdf_folder / name;
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

fs::path robot(const std::string& inner) {
  return write("hand.urdf", "<robot name='r'>" + inner + "</robot>");
}

std::string faultOf(const fs::path& path) {
  try {
    (void)readUrdf(path);
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "it was read";
}

std::string link(const std::string& name) {
  return "<link name='" + name + "'/>";
}

std::string joint(const std::string& name,
                  const std::string& type,
                  const std::string& parent,
                  const std::string& child,
                  const std::string& inner = "") {
  return "<joint name='" + name + "' type='" + type + "'><parent link='" + parent +
         "'/><child link='" + child + "'/>" + inner + "</joint>";
}

constexpr const char* kLimit = "<limit lower='0' upper='1' effort='1' velocity='1'/>";

// === Numbers

TEST(HostileUrdf, NumbersThatAreNoneNameTheirJoint) {
  for (const std::string number : {"nan", "-nan", "inf", "-inf", "1e999", "", "1,5", "1e300"}) {
    for (const std::string& inner :
         {"<origin xyz='0 " + number + " 0'/>" + kLimit,
          "<axis xyz='0 " + number + " 0'/>" + kLimit,
          "<limit lower='" + number + "' upper='1' effort='1' velocity='1'/>",
          "<limit lower='-2e300' upper='" + number + "' effort='1' velocity='1'/>",
          std::string(kLimit) + "<mimic joint='i' multiplier='" + number + "'/>",
          std::string(kLimit) + "<mimic joint='i' offset='" + number + "'/>"}) {
      const bool has_direction = number == "1e300" && inner.starts_with("<axis");
      const fs::path path =
          robot(link("a") + link("b") + link("c") + joint("i", "revolute", "a", "b", kLimit) +
                joint("joint_x", "prismatic", "b", "c", inner));
      if (has_direction) {
        EXPECT_NO_THROW((void)readUrdf(path)) << inner;
        continue;
      }
      EXPECT_THAT(faultOf(path),
                  AllOf(HasSubstr("hand.urdf"), HasSubstr("joint_x"), Not(HasSubstr("\n"))))
          << inner;
    }
  }
}

TEST(HostileUrdf, TurnsThatAreNoNumbersNameTheirJoint) {
  for (const std::string number : {"nan", "inf", "1e999", ""}) {
    const fs::path path = robot(
        link("a") + link("b") +
        joint("joint_x", "revolute", "a", "b", "<origin rpy='" + number + " 0 0'/>" + kLimit));
    EXPECT_THAT(faultOf(path), AllOf(HasSubstr("hand.urdf"), HasSubstr("joint_x"))) << number;
  }
}

TEST(HostileUrdf, ScalesThatAreNoneNameTheirLink) {
  (void)write("tip.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  for (const std::string scale : {"nan 1 1", "1 inf 1", "0 1 1", "1 1", "1e300 1 1"}) {
    const fs::path path = robot(
        "<link name='link_x'><visual><geometry><mesh filename='tip.obj' "
        "scale='" +
        scale + "'/></geometry></visual></link>");
    EXPECT_THAT(faultOf(path), AllOf(HasSubstr("hand.urdf"), HasSubstr("link_x"))) << scale;
  }
}

TEST(HostileUrdf, MassesThatAreNoneDoNotMatter) {
  const fs::path path = robot(
      "<link name='a'><inertial><mass value='nan'/><inertia ixx='inf' ixy='x' ixz='0' "
      "iyy='-1' iyz='0' izz='0'/></inertial></link>");
  EXPECT_EQ(readUrdf(path).model.linkCount(), 1);
}

TEST(HostileUrdf, AxesWithoutLengthNameTheirJoint) {
  for (const std::string type : {"revolute", "continuous", "prismatic", "planar"}) {
    for (const std::string axis : {"0 0 0", "-0 0 0", "1e-300 0 0", "1e-13 0 1e-13"}) {
      const fs::path path =
          robot(link("a") + link("b") +
                joint("joint_x", type, "a", "b", "<axis xyz='" + axis + "'/>" + kLimit));
      EXPECT_THAT(faultOf(path), AllOf(HasSubstr("hand.urdf"), HasSubstr("joint_x")))
          << type << " " << axis;
    }
  }
}

TEST(HostileUrdf, MimicsDoNotMultiplyBeyondAllBounds) {
  std::string inner = link("l0") + link("l1") + joint("j1", "continuous", "l0", "l1");
  for (int i = 2; i < 40; ++i)
    inner += link(fmt::format("l{}", i)) +
             joint(fmt::format("j{}", i), "continuous", fmt::format("l{}", i - 1),
                   fmt::format("l{}", i),
                   fmt::format("<mimic joint='j{}' multiplier='10'/>", i - 1));
  EXPECT_THAT(faultOf(robot(inner)), AllOf(HasSubstr("j32"), HasSubstr("multiplier")));
}

// === Trees

TEST(HostileUrdf, LoopsNameTheirJoints) {
  EXPECT_THAT(faultOf(robot(link("a") + link("b") + joint("j", "fixed", "a", "b") +
                            joint("k", "continuous", "b", "a"))),
              AllOf(HasSubstr("hand.urdf"), HasSubstr("'j'"), HasSubstr("'k'")));
  EXPECT_THAT(faultOf(robot(link("a") + joint("j", "fixed", "a", "a"))), HasSubstr("'j'"));
  // Beside a tree that is well, where urdfdom does not look.
  EXPECT_THAT(faultOf(robot(link("root") + link("a") + link("b") + link("c") +
                            joint("j", "planar", "a", "b") + joint("k", "floating", "b", "c") +
                            joint("l", "fixed", "c", "a"))),
              AllOf(HasSubstr("loop"), HasSubstr("'l'")));
}

TEST(HostileUrdf, NamesThatAreThereTwiceAreNamed) {
  EXPECT_THAT(faultOf(robot(link("a") + link("link_x") + link("link_x") +
                            joint("j", "fixed", "a", "link_x"))),
              AllOf(HasSubstr("hand.urdf"), HasSubstr("link_x")));
  EXPECT_THAT(
      faultOf(robot(link("a") + link("b") + link("c") + joint("joint_x", "fixed", "a", "b") +
                    joint("joint_x", "fixed", "b", "c"))),
      HasSubstr("joint_x"));
  // Of a chain that a planar joint becomes.
  EXPECT_THAT(faultOf(robot(link("a") + link("b") + link("j_x") +
                            joint("j", "planar", "a", "b") + joint("k", "fixed", "b", "j_x"))),
              HasSubstr("'j_x'"));
}

TEST(HostileUrdf, NamesOfAMillionBytesAreRefusedShortly) {
  const std::string name(1'000'000, 'n');
  for (const std::string& inner :
       {link(name), link("a") + link("b") + joint(name, "fixed", "a", "b"),
        link("a") + joint("j", "fixed", "a", name), link("a") + joint("j", name, "a", "a"),
        "<xacro:" + name + "/>",
        link("a") + link("b") +
            joint("j", "continuous", "a", "b", "<mimic joint='" + name + "'/>"),
        "<link name='a'><visual><geometry><" + name + "/></geometry></visual></link>",
        "<link name='a'><visual><geometry><mesh filename='" + name +
            "'/></geometry></visual></link>"}) {
    const fs::path path = robot(inner);
    test::expectRefused(path, "", [&] {
      (void)readUrdf(path);
    });
  }
}

// Of chains and combs of as many links as there may be, questions cost up to their square.
TEST(HostileUrdf, TheLargestTreesAreStillRead) {
  constexpr int kLinks = 2000;
  std::string chain = link("l0");
  std::string comb = link("l0");
  std::string followers = link("l0");
  const std::string ball = "<visual><geometry><sphere radius='0.01'/></geometry></visual>";
  for (int i = 1; i < kLinks; ++i) {
    const std::string name = fmt::format("l{}", i);
    const std::string before = fmt::format("l{}", i - 1);
    const std::string axis = i % 2 == 0 ? "<axis xyz='0 0 1'/>" : "<axis xyz='1 0 0'/>";
    chain += link(name) + joint("j" + name, "prismatic", before, name, axis + kLimit);
    followers += link(name) + joint("j" + name, "continuous", before, name,
                                    i == 1 ? "" : "<mimic joint='j" + before + "'/>");
    const bool is_tip = i >= kLinks / 2;
    comb += "<link name='" + name + "'>" + (is_tip ? ball : "") + "</link>" +
            joint("j" + name, "continuous",
                  is_tip ? fmt::format("l{}", kLinks / 2 - 1) : before, name);
  }
  for (const std::string& inner : {chain, followers, comb}) {
    const fs::path path = robot(inner);
    const test::Reading reading = test::readApart([&] {
      const UrdfFile file = readUrdf(path);
      const auto X =
          hand::forwardKinematics(file.model, {Pose::Identity(), file.model.restPose()});
      (void)hand::findDigits(file.model, X);
    });
    EXPECT_EQ(reading.end, test::Reading::End::kRead) << reading.message;
  }
}

// === Files that it names

TEST(HostileUrdf, MissingAndCutMeshesNameFileLinkAndMesh) {
  (void)write("cut.stl", std::string(90, 'x'));
  (void)write("folder.stl/inside", "");
  for (const std::string mesh :
       {"gone.stl", "cut.stl", "folder.stl", "", "package://gone/a.stl",
        "http://example.com/a.stl", "cut.stl/gone.stl"}) {
    const fs::path path = robot("<link name='link_x'><collision><geometry><mesh filename='" +
                                mesh + "'/></geometry></collision></link>");
    EXPECT_THAT(faultOf(path),
                AllOf(HasSubstr("hand.urdf"), HasSubstr("link_x"), HasSubstr(mesh)))
        << mesh;
  }
}

TEST(HostileUrdf, AsksForMeshesByTheirWordsAloneAndOpensNoOther) {
  const fs::path secret = write("secret.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const std::string name = secret.filename().string();
  for (const std::string& uri :
       {secret.string(), "file://" + secret.string(), name, "../" + name, "%2e%2e/" + name,
        "a/../" + name, "..%2f" + name, "package://x/../" + name, std::string("secret%2eobj"),
        "&#x2e;&#x2e;/" + name}) {
    const fs::path path = robot("<link name='a'><visual><geometry><mesh filename='" + uri +
                                "'/></geometry></visual></link>");
    std::vector<std::string> asked;
    const ResourceFinder nothing_was_sent = [&](const std::string& wanted) -> fs::path {
      asked.push_back(wanted);
      rejectInput("{}: not among the files sent", quoted(wanted));
    };
    EXPECT_THROW((void)readUrdf(path, nothing_was_sent), InvalidInput) << uri;
    ASSERT_EQ(asked.size(), 1U) << uri;
    EXPECT_THAT(asked[0], HasSubstr(uri.starts_with("&") ? "../secret.obj" : uri));
  }
}

TEST(HostileUrdf, GltfsReachNoFileBeyondTheirFolder) {
  const std::string secret(36, '\0');
  const fs::path outside = write("outside.bin", secret);
  (void)write("inside/inside.bin", secret);
  const auto gltf = [](const std::string& uri) {
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
           R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"uri":")" +
           uri +
           R"(","byteLength":36}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36}],)"
           R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}]})";
  };
  const auto words_of = [&](const std::string& uri) {
    try {
      (void)readMesh(write("inside/mesh.gltf", gltf(uri)));
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string("it was read");
  };
  // Its own buffer is opened: three vertices in one place, no face with area.
  EXPECT_THAT(words_of("inside.bin"), HasSubstr("no face with area"));
  for (const std::string& uri :
       {std::string("../outside.bin"), std::string("%2e%2e/outside.bin"),
        std::string("..%2foutside.bin"), std::string("./x/../../outside.bin"), outside.string(),
        "file://" + outside.string()}) {
    EXPECT_THAT(words_of(uri),
                AllOf(HasSubstr("mesh.gltf"), Not(HasSubstr("no face with area"))))
        << uri;
  }
}

}  // namespace
}  // namespace handgraft::io
