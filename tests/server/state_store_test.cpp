#include "server/store/state_store.h"

#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/base/error.h"
#include "server/base/rejection.h"
#include "server/store/database.h"
#include "server/store/state_schema.h"

namespace handgraft::server {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class StateStoreTest : public testing::Test {
 protected:
  StateStoreTest() {
    std::string name = (fs::temp_directory_path() / "handgraft-store-XXXXXX").string();
    folder = mkdtemp(name.data());
    path = (folder / "store.db").string();
  }

  ~StateStoreTest() override { fs::remove_all(folder); }

  static KeptSession session(const std::string& text, std::vector<std::int64_t> models = {}) {
    KeptSession kept;
    kept.text = text;
    kept.models = std::move(models);
    return kept;
  }

  static PersistedModel model(const std::string& name, std::int64_t base = 0) {
    PersistedModel kept;
    kept.kind = 1;
    kept.name = name;
    kept.content = "content of " + name;
    kept.form = "test";
    kept.base = base;
    return kept;
  }

  static void expectSound(const StateStore& store) { EXPECT_THAT(store.check(), IsEmpty()); }

  fs::path folder;
  std::string path;
};

TEST_F(StateStoreTest, KeepsItsServersIdForAsLongAsTheFileLives) {
  std::uint64_t id = 0;
  {
    StateStore store(path);
    id = store.serverId();
    EXPECT_EQ(store.openings(), 1u);
  }
  StateStore again(path);
  EXPECT_EQ(again.serverId(), id);
  EXPECT_EQ(again.openings(), 2u);
  EXPECT_NE(StateStore(":memory:").serverId(), id);
}

TEST_F(StateStoreTest, IsOpenInOneServerAtATime) {
  StateStore store(path);
  try {
    StateStore second(path);
    FAIL() << "two have it open";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("another handgraft-server has it open"));
  }
}

// === What the disk refuses

std::string complaintOf(const std::function<void()>& writes) {
  try {
    writes();
  } catch (const StorageError& error) {
    return error.what();
  }
  return "it was written";
}

TEST_F(StateStoreTest, AFullDiskIsToldWithTheFileAndWhatToDo) {
  Database database(path);
  database.execute("CREATE TABLE things(thing BLOB)");
  database.execute("PRAGMA max_page_count=8");
  EXPECT_THAT(
      complaintOf([&] {
        database.execute("INSERT INTO things VALUES(zeroblob(1000000))");
      }),
      testing::AllOf(HasSubstr(path), HasSubstr("the disk is full"), HasSubstr("--state")));
}

TEST_F(StateStoreTest, AReadOnlyFileIsToldWithWhatToDo) {
  Database database(path);
  database.execute("PRAGMA query_only=ON");
  EXPECT_THAT(complaintOf([&] {
                database.execute("CREATE TABLE things(thing BLOB)");
              }),
              testing::AllOf(HasSubstr(path), HasSubstr("it is read-only"),
                             HasSubstr("let the server's user write")));
}

TEST_F(StateStoreTest, ADamagedFileIsToldWithWhatToDo) {
  std::ofstream(path) << std::string(8192, 'x');
  EXPECT_THAT(complaintOf([&] {
                StateStore store(path);
              }),
              testing::AllOf(HasSubstr(path), HasSubstr("it is damaged"), HasSubstr("--backup"),
                             HasSubstr("--check")));
}

TEST_F(StateStoreTest, OtherFaultsAreToldInSqlitesWords) {
  Database database(path);
  EXPECT_THAT(complaintOf([&] {
                database.execute("INSERT INTO nowhere VALUES(1)");
              }),
              testing::AllOf(HasSubstr(path), HasSubstr("no such table: nowhere")));
}

TEST_F(StateStoreTest, GivesBackASessionWithItsHistoryAndItsEdits) {
  {
    StateStore store(path);
    store.addSession(7, session("text"), "state", {"me", 1}, "open");
    const RequestKey edit{"me", 41};
    store.append(7, 0, {"a"}, &edit, {7, 1, "2 mm short"});
    store.append(7, 1, {"b", "c"}, "later", 1);
  }
  StateStore store(path);
  const KeptSession kept = store.session(7);
  EXPECT_EQ(kept.text, "text");
  EXPECT_THAT(kept.entries, ElementsAre("a", "b", "c"));
  ASSERT_THAT(store.sessions(), SizeIs(1));
  EXPECT_EQ(store.sessions().front().state, "later");
  EXPECT_EQ(store.sessions().front().revision, 1u);
  ASSERT_TRUE(store.edit({"me", 41}).has_value());
  EXPECT_EQ(store.edit({"me", 41})->message, "2 mm short");
  EXPECT_FALSE(store.edit({"me", 42}).has_value());
  EXPECT_FALSE(store.edit({"you", 41}).has_value());
  EXPECT_EQ(store.request({"me", 1})->subject, 7);
  expectSound(store);
}

TEST_F(StateStoreTest, TakesAnEditOnce) {
  StateStore store(path);
  store.addSession(7, session("text"), "state", {}, "open");
  const RequestKey edit{"me", 41};
  store.append(7, 0, {"a"}, &edit, {7, 1, ""});
  EXPECT_THROW(store.append(7, 1, {"a"}, &edit, {7, 2, ""}), StorageError);
  EXPECT_THAT(store.session(7).entries, ElementsAre("a"));
}

TEST_F(StateStoreTest, PutsATextInPlaceOfTheEntriesThatLedToIt) {
  StateStore store(path);
  store.addSession(7, session("text"), "state", {}, "open");
  store.append(7, 0, {"a", "b", "c"}, "state", 3);
  store.replaceText(7, "later text", 2, "state", 3);
  const KeptSession kept = store.session(7);
  EXPECT_EQ(kept.text, "later text");
  EXPECT_EQ(kept.next, 2u);
  EXPECT_THAT(kept.entries, ElementsAre("c"));
  expectSound(store);
}

TEST_F(StateStoreTest, ClosingDeletes) {
  StateStore store(path);
  store.addSession(7, session("text"), "state", {}, "open");
  const RequestKey edit{"me", 41};
  store.append(7, 0, {"a"}, &edit, {7, 1, ""});
  store.removeSession(7, {"me", 2}, "close");
  EXPECT_THAT(store.sessions(), IsEmpty());
  EXPECT_THROW((void)store.session(7), StorageError);
  EXPECT_EQ(store.request({"me", 2})->what, "close");
  expectSound(store);
}

// === Blobs

TEST_F(StateStoreTest, KeepsEqualBytesOnceAndAsLongAsOneModelHasThem) {
  StateStore store(path);
  const std::string bytes(3'000'000, 'x');
  const std::int64_t first = store.addModel(model("a"), bytes, {}, "load");
  const std::uint64_t one = store.bytes();
  const std::int64_t second = store.addModel(model("b"), bytes, {}, "load");
  EXPECT_LT(store.bytes(), one + 100'000);
  store.removeModel(1, "a", {}, "unload");
  EXPECT_THROW((void)store.model(first), StorageError);
  EXPECT_EQ(store.bytesOf(second), bytes);
  store.removeModel(1, "b", {}, "unload");
  EXPECT_LT(store.bytes(), 200'000u);
  expectSound(store);
}

TEST_F(StateStoreTest, KeepsModelsThatAreMadeOfSettingsAlone) {
  StateStore store(path);
  const std::int64_t row = store.addModel(model("variant"), "", {}, "make_variant");
  EXPECT_EQ(store.bytesOf(row), "");
  EXPECT_THROW((void)store.bytesOf(row + 1), StorageError);
}

TEST_F(StateStoreTest, KeepsWhatASessionOrAnotherModelRestsOn) {
  StateStore store(path);
  const std::int64_t object = store.addModel(model("mug"), "mesh", {}, "load");
  const std::int64_t contacts = store.addModel(model("marks", object), "marks", {}, "load");
  store.addSession(7, session("text", {contacts}), "state", {}, "open");
  store.removeModel(1, "mug", {}, "unload");
  store.removeModel(1, "marks", {}, "unload");
  EXPECT_THAT(store.models(), IsEmpty());
  EXPECT_EQ(store.bytesOf(object), "mesh");
  EXPECT_EQ(store.bytesOf(contacts), "marks");
  // The name is free for another one meanwhile.
  store.addModel(model("mug"), "another mesh", {}, "load");
  store.removeSession(7, {}, "close");
  EXPECT_THROW((void)store.model(contacts), StorageError);
  EXPECT_THROW((void)store.model(object), StorageError);
  EXPECT_THAT(store.models(), SizeIs(1));
  expectSound(store);
}

TEST_F(StateStoreTest, RefusesPlainlyBeyondItsQuota) {
  StateLimits limits;
  limits.bytes = 4u << 20;
  limits.sessions = 2;
  StateStore store(path, limits);
  store.addModel(model("a"), std::string(3u << 20, 'a'), {}, "load");
  try {
    store.addModel(model("b"), std::string(3u << 20, 'b'), {}, "load");
    FAIL() << "the quota does not hold";
  } catch (const Rejection& refusal) {
    EXPECT_EQ(refusal.code(), v1::ERROR_STORAGE);
    EXPECT_THAT(refusal.what(), HasSubstr("of at most 4 MB"));
  }
  store.addSession(1, session("text"), "state", {}, "open");
  store.addSession(2, session("text"), "state", {}, "open");
  EXPECT_THROW(store.addSession(3, session("text"), "state", {}, "open"), Rejection);
  store.removeSession(1, {}, "close");
  EXPECT_NO_THROW(store.addSession(3, session("text"), "state", {}, "open"));
  expectSound(store);
}

// === Ends that nobody asked for

TEST_F(StateStoreTest, HasEverythingThatWasAcknowledgedWhenItsProcessWasKilled) {
  constexpr int kRounds = 12;
  std::uint64_t acknowledged = 0;
  { StateStore(path).addSession(7, session("text"), "state", {}, "open"); }
  for (int round = 0; round < kRounds; ++round) {
    int told[2];
    ASSERT_EQ(pipe(told), 0);
    const pid_t child = fork();
    if (child == 0) {
      close(told[0]);
      StateStore store(path);
      for (std::uint64_t i = store.session(7).entries.size();; ++i) {
        const RequestKey edit{"me", i};
        store.append(7, i, {std::to_string(i)}, &edit, {7, i + 1, ""});
        if (i % 10 == 0)
          store.addModel(model("m" + std::to_string(i)), std::string(100'000, 'm'), {}, "load");
        if (write(told[1], &i, sizeof i) != sizeof i) _exit(1);
      }
    }
    close(told[1]);
    std::this_thread::sleep_for(std::chrono::milliseconds(20 + 7 * round));
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    std::uint64_t last = 0;
    while (read(told[0], &last, sizeof last) == sizeof last)
      acknowledged = last + 1;
    close(told[0]);
    StateStore store(path);
    const KeptSession kept = store.session(7);
    ASSERT_GE(kept.entries.size(), acknowledged);
    for (std::size_t i = 0; i < kept.entries.size(); ++i) {
      ASSERT_EQ(kept.entries[i], std::to_string(i));
      ASSERT_EQ(store.edit({"me", i})->revision, i + 1);
    }
    expectSound(store);
  }
  EXPECT_GT(acknowledged, 100u);
}

// === Other versions

TEST_F(StateStoreTest, RefusesANewerFilePlainly) {
  { StateStore store(path); }
  Database(path).execute("PRAGMA user_version = 99");
  try {
    StateStore store(path);
    FAIL() << "it was opened";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("of a newer handgraft-server"));
  }
}

TEST_F(StateStoreTest, BringsFilesOfEveryEarlierFormatToItsOwn) {
  for (int schema = 1; schema < kStateSchema; ++schema) {
    const std::string old = (folder / ("from" + std::to_string(schema) + ".db")).string();
    std::ifstream file(fs::path(HANDGRAFT_STORES) /
                       ("schema" + std::to_string(schema) + ".sql"));
    ASSERT_TRUE(file) << "no stored file of schema " << schema;
    const std::string sql((std::istreambuf_iterator<char>(file)), {});
    Database(old).execute(sql.c_str());
    StateStore store(old);
    expectSound(store);
    EXPECT_EQ(store.serverId(), 4242424242424242u);
    EXPECT_THAT(store.session(1234567890123456).entries, ElementsAre("first", "second"));
    EXPECT_EQ(store.edit({"me", 5})->revision, 2u);
    EXPECT_EQ(store.session(1234567890123456).access, SessionAccess());
    EXPECT_EQ(store.bytesOf(store.models().front().row), "mesh");
    EXPECT_NO_THROW(store.removeSession(1234567890123456, {"me", 9}, "close"));
    EXPECT_EQ(store.request({"me", 9})->what, "close");
  }
}

// === Upkeep

TEST_F(StateStoreTest, SeesDamage) {
  {
    StateStore store(path);
    store.addModel(model("a"), "abc", {}, "load");
    store.addModel(model("b"), "xyz", {}, "load");
    store.addSession(7, session("text"), "state", {}, "open");
    store.append(7, 0, {"a", "b", "c"}, "state", 3);
    expectSound(store);
  }
  {
    Database damaged(path);
    damaged.execute("UPDATE blob_parts SET data = 'abd' WHERE data = x'616263'");
    damaged.execute("UPDATE blobs SET refs = 5 WHERE size = 3");
    damaged.execute("DELETE FROM entries WHERE number = 1");
  }
  const std::vector<std::string> problems = checkStore(path);
  EXPECT_THAT(problems, testing::Contains(HasSubstr("bytes are not what they were")));
  EXPECT_THAT(problems, testing::Contains(HasSubstr("miscounted")));
  EXPECT_THAT(problems, testing::Contains(HasSubstr("gap in its history: 7")));
}

TEST_F(StateStoreTest, IsBackedUpWhileItIsWritten) {
  StateStore store(path);
  store.addSession(7, session("text"), "state", {}, "open");
  store.addModel(model("a"), std::string(5'000'000, 'a'), {}, "load");
  std::atomic<bool> stops{false};
  std::thread writer([&] {
    for (std::uint64_t i = 0; !stops; ++i)
      store.append(7, i, {std::to_string(i)}, "state", i + 1);
  });
  const std::string copy = (folder / "copy.db").string();
  store.backUpTo(copy);
  stops = true;
  writer.join();
  EXPECT_THAT(checkStore(copy), IsEmpty());
  EXPECT_THROW(store.backUpTo(copy), InvalidInput) << "what is there is not written over";
  StateStore restored(copy);
  EXPECT_EQ(restored.serverId(), store.serverId());
  EXPECT_EQ(restored.session(7).text, "text");
}

}  // namespace
}  // namespace handgraft::server
