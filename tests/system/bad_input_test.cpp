// Issue A, "Shows" 5: bad input gets one line that names the thing, exit code 2, a server
// alive.

#include <algorithm>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/support/shared_data.h"
#include "tests/system/service.h"

namespace handgraft::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTetrahedron =
    "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

fs::path write(const std::string& name, const std::string& text) {
  const fs::path path = scratchDirectory() / name;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

std::string textOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class BadInput : public testing::Test {
 protected:
  /// Runs the client; expects one line on stderr that holds `named`, exit code 2, a live
  /// server.
  void expectRefusal(const std::vector<std::string>& arguments, const std::string& named) {
    const Finished finished = service.client(arguments);
    EXPECT_EQ(finished.exit_code, 2) << finished.err;
    EXPECT_EQ(std::count(finished.err.begin(), finished.err.end(), '\n'), 1) << finished.err;
    EXPECT_NE(finished.err.find(named), std::string::npos)
        << "'" << named << "' is not named in: " << finished.err;
    EXPECT_TRUE(service.server().running());
    EXPECT_EQ(service.client({"doctor"}).exit_code, 0) << "the server does not answer any more";
  }

  Service service;
};

TEST_F(BadInput, TruncatedMesh) {
  const std::string whole = textOf(sourceDirectory() / "server/models/objects/lemon.obj");
  const std::size_t half = whole.rfind('\n', whole.size() / 4);
  // Cut inside the vertices; one face of the whole file still names a vertex that is gone.
  const fs::path path = write("cut_short.obj", whole.substr(0, half) + "\nf 1 2 999999\n");
  expectRefusal({"load", "object", path.string()}, "cut_short.obj");
}

TEST_F(BadInput, TruncatedBinaryStl) {
  std::string stl(84, '\0');
  stl[80] = 100;  // announces 100 facets
  stl += std::string(50, '\1');
  expectRefusal({"load", "object", write("cut_short.stl", stl).string()}, "cut_short.stl");
}

TEST_F(BadInput, NanVertex) {
  std::string text = kTetrahedron;
  text.replace(text.find("0.1"), 3, "nan");
  expectRefusal({"load", "object", write("nan_vertex.obj", text).string()}, "vertex");
}

TEST_F(BadInput, UrdfWithAMissingMesh) {
  const fs::path path = write("no_mesh.urdf",
                              R"(<robot name="r"><link name="palm"><visual><geometry>
                              <mesh filename="meshes/not_there.stl"/></geometry></visual></link>
                              </robot>)");
  expectRefusal({"load", "hand", path.string()}, "not_there.stl");
}

TEST_F(BadInput, UrdfWithAJointLoop) {
  const fs::path path = write("loop.urdf", R"(<robot name="r">
      <link name="a"/><link name="b"/><link name="c"/>
      <joint name="ab" type="fixed"><parent link="a"/><child link="b"/></joint>
      <joint name="bc" type="fixed"><parent link="b"/><child link="c"/></joint>
      <joint name="cb" type="fixed"><parent link="c"/><child link="b"/></joint></robot>)");
  expectRefusal({"load", "hand", path.string()}, "loop.urdf");
}

TEST_F(BadInput, UrdfThatIsNoXml) {
  expectRefusal({"load", "hand", write("noise.urdf", "\x01\x02<<<").string()}, "noise.urdf");
}

TEST_F(BadInput, ContactSetThatNamesAnUnknownSite) {
  std::string text = textOf(sourceDirectory() / "server/models/contacts/lemon_6.json");
  const std::size_t at = text.find("\"thumb\"");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, 7, "\"elbow\"");
  const fs::path path = write("elbow.json", text);
  expectRefusal(
      {"grasp", "--hand", "barrett8", "--object", "lemon", "--contacts", path.string()},
      "elbow");
}

TEST_F(BadInput, ContactSetWithAVertexThatIsNotThere) {
  const fs::path path = write("far_vertex.json", R"({"format": "handgraft-contacts/1",
      "name": "x", "object": "lemon", "patches": [{"name": "thumb",
      "root": {"vertex": 123456789}, "boundary": [0, 1, 2]}]})");
  expectRefusal(
      {"grasp", "--hand", "barrett8", "--object", "lemon", "--contacts", path.string()},
      "123456789");
}

TEST_F(BadInput, WrongOptions) {
  expectRefusal({"grasp", "--hnad", "barrett8"}, "--hnad");
  const std::vector<std::string> good = {"grasp", "--hand",     "barrett8", "--object",
                                         "lemon", "--contacts", "lemon_6"};
  auto with = [&](std::initializer_list<std::string> more) {
    std::vector<std::string> all = good;
    all.insert(all.end(), more);
    return all;
  };
  expectRefusal(with({"--solver", "simplex"}), "simplex");
  expectRefusal(with({"--place", "0", "0", "nan", "1", "0", "0", "0"}), "nan");
  expectRefusal(with({"--place", "0", "0", "0", "0", "0", "0", "0"}), "--place");
}

TEST_F(BadInput, NamesThatAreNotThere) {
  expectRefusal({"grasp", "--hand", "octopus", "--object", "lemon", "--contacts", "lemon_6"},
                "octopus");
  expectRefusal(
      {"grasp", "--hand", "barrett8", "--object", "/no/such/file.obj", "--contacts", "lemon_6"},
      "/no/such/file.obj");
}

TEST(BadDomain, IsRefusedByEveryProgram) {
  for (const char* name : {"handgraft-server", "handgraft-bridge"}) {
    const Finished finished = run(program(name), {"--domain", "101"});
    EXPECT_EQ(finished.exit_code, 2) << name << ": " << finished.err;
    EXPECT_NE(finished.err.find("101"), std::string::npos) << finished.err;
  }
  EXPECT_EQ(run(program("handgraft"), {"doctor", "--domain", "101"}).exit_code, 2);
  EXPECT_EQ(run(program("handgraft"), {"doctor", "--interface", "nope0"}).exit_code, 2);
}

}  // namespace
}  // namespace handgraft::test
