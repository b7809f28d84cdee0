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
  std::ofstream(folder / "hands/clamp/clamp.urdf") << test::kClampUrdf;
  std::ofstream(folder / "hands/clamp/sites.yaml") << test::kClampSites;
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

}  // namespace
}  // namespace handgraft::server
