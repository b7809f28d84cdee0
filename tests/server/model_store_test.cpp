#include "server/store/model_store.h"

#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "server/base/rejection.h"
#include "server/store/model_library.h"

#include "tests/server/small_grasp.h"

namespace handgraft::server {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

StoredObject object(const std::string& name, Origin origin) {
  return {name, origin, std::make_shared<const io::MeshFile>()};
}

template <class Call>
v1::ErrorCode codeOf(Call&& call) {
  try {
    call();
  } catch (const Rejection& rejection) {
    return rejection.code();
  }
  return v1::ERROR_NONE;
}

TEST(ModelStore, KeepsTheFirstOfEqualContentAndRefusesOther) {
  ModelStore store;
  store.add(object("cup", {false, "1"}));
  const auto first = store.object("cup");
  store.add(object("cup", {false, "1"}));
  EXPECT_EQ(store.object("cup"), first);
  EXPECT_EQ(codeOf([&] {
              store.add(object("cup", {false, "2"}));
            }),
            v1::ERROR_CONFLICT);
  store.replace(object("cup", {false, "2"}));
  EXPECT_NE(store.object("cup"), first);
}

TEST(ModelStore, KeepsItsOwnModels) {
  ModelStore store;
  store.add(object("cup", {true}));
  EXPECT_EQ(codeOf([&] {
              store.add(object("cup", {false}));
            }),
            v1::ERROR_CONFLICT);
  EXPECT_EQ(codeOf([&] {
              store.remove(v1::MODEL_OBJECT, "cup");
            }),
            v1::ERROR_CONFLICT);
}

TEST(ModelStore, ListsWhatThereIsWhenANameIsUnknown) {
  ModelStore store;
  store.add(object("cup", {}));
  try {
    (void)store.object("mug");
    FAIL() << "found a mug";
  } catch (const Rejection& rejection) {
    EXPECT_EQ(rejection.code(), v1::ERROR_NOT_FOUND);
    EXPECT_THAT(rejection.what(), HasSubstr("cup"));
  }
}

TEST(ModelStore, RefusesNamesThatCouldBePaths) {
  for (const char* bad : {"", ".hidden", "../x", "a/b", "a b", "a\nb", "\xc3\xa4"}) {
    EXPECT_THROW(validateName(bad), InvalidInput) << bad;
  }
  EXPECT_THROW(validateName(std::string(65, 'a')), InvalidInput);
  EXPECT_NO_THROW(validateName("006_mustard-bottle.v2"));
}

TEST(ModelLibrary, LeavesABadModelOutAndReadsTheRest) {
  const fs::path folder = test::scratchDirectory() / "library";
  for (const char* one : {"hands/clamp", "hands/broken", "objects", "contacts"}) {
    fs::create_directories(folder / one);
  }
  std::ofstream(folder / "hands/clamp/clamp.urdf") << test::clamp_urdf;
  std::ofstream(folder / "hands/clamp/sites.yaml") << test::clamp_sites;
  std::ofstream(folder / "hands/broken/broken.urdf") << "<robot";
  std::ofstream(folder / "objects/lemon.obj") << test::builtIn("objects/lemon.obj");
  std::ofstream(folder / "contacts/lemon_6.json") << test::builtIn("contacts/lemon_6.json");
  ModelStore store;
  EXPECT_EQ(readLibrary(folder, store), 1);
  EXPECT_EQ(store.size(), 3u);
  EXPECT_EQ(store.contacts("lemon_6")->set.object, "lemon");
  EXPECT_EQ(store.hand("clamp")->hand->ownSites()->size(), 2u);
  EXPECT_THROW(readLibrary(folder / "nowhere", store), InvalidInput);
}

TEST(ModelLibrary, KeepsTheLaterOfTwoOfOneNameThoughTheyAreReadSideBySide) {
  const fs::path folder = test::scratchDirectory() / "twice";
  fs::create_directories(folder / "objects");
  const auto write = [&](const std::string& name, double size_m) {
    std::ofstream file(folder / "objects" / name);
    file << "v 0 0 0\nv " << size_m << " 0 0\nv 0 " << size_m << " 0\nv 0 0 " << size_m
         << "\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  };
  for (int i = 0; i < 20; ++i)
    write("tetrahedron" + std::to_string(i) + ".obj", 0.01 * (1 + i));
  // The same name once more, and later.
  std::ofstream(folder / "objects/tetrahedron7.ply")
      << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
         "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
         "end_header\n0 0 0\n0.1 0 0\n0 0.1 0\n3 0 1 2\n";
  for (int round = 0; round < 20; ++round) {
    ModelStore store;
    EXPECT_EQ(readLibrary(folder, store), 0);
    EXPECT_EQ(store.size(), 20u);
    EXPECT_EQ(store.object("tetrahedron7")->file->mesh.faceCount(), 1) << "the .obj stayed";
    EXPECT_NEAR(store.object("tetrahedron19")->file->mesh.vertices().maxCoeff(), 0.2, 1e-9);
  }
}

}  // namespace
}  // namespace handgraft::server
