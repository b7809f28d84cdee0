#include "server/store/upload_store.h"

#include <chrono>
#include <csignal>
#include <fstream>
#include <iterator>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "core/base/error.h"
#include "server/base/rejection.h"

namespace handgraft::server {
namespace {

namespace fs = std::filesystem;

constexpr UploadStore::ClientId kClient = {7};

v1::PutFileRequest chunk(const std::string& uri,
                         const std::string& bytes,
                         std::uint64_t offset,
                         std::uint64_t total,
                         std::uint64_t upload = 1) {
  v1::PutFileRequest request;
  request.upload_id(upload);
  request.uri(uri);
  request.total_bytes(total);
  request.offset(offset);
  request.bytes({bytes.begin(), bytes.end()});
  return request;
}

std::string contentOf(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

v1::ErrorCode codeOf(const std::function<void()>& call) {
  try {
    call();
  } catch (const Rejection& rejection) {
    return rejection.code();
  }
  return v1::ERROR_NONE;
}

TEST(UploadStore, JoinsChunksAndRemovesTheFilesAfterUse) {
  UploadStore store;
  store.put(kClient, chunk("a.urdf", "abc", 0, 5));
  store.put(kClient, chunk("a.urdf", "de", 3, 5));
  auto files = store.finish(kClient, 1);
  const fs::path path = files->file("a.urdf");
  EXPECT_EQ(contentOf(path), "abcde");
  files.reset();
  EXPECT_FALSE(fs::exists(path));
}

/// Files of this process end at so many bytes, as a disk that is full ends them.
class FileLimit {
 public:
  explicit FileLimit(rlim_t bytes) : before_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }

  ~FileLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, before_handler_);
  }

  FileLimit(const FileLimit&) = delete;
  FileLimit& operator=(const FileLimit&) = delete;

 private:
  rlimit before_{};
  sighandler_t before_handler_;
};

TEST(UploadStore, AChunkThatFoundTheDiskFullMayComeAgain) {
  UploadStore store;
  store.put(kClient, chunk("a.urdf", "abc", 0, 8));
  {
    const FileLimit full(5);
    EXPECT_EQ(codeOf([&] {
                store.put(kClient, chunk("a.urdf", "defgh", 3, 8));
              }),
              v1::ERROR_OVERLOADED);
  }
  store.put(kClient, chunk("a.urdf", "defgh", 3, 8));
  EXPECT_EQ(contentOf(store.finish(kClient, 1)->file("a.urdf")), "abcdefgh");
}

TEST(UploadStore, GivesBackWhatAClientThatIsGoneHadBegun) {
  UploadStore store;
  const UploadStore::ClientId other = {8};
  store.put(kClient, chunk("a.urdf", "abc", 0, 5));
  store.put(other, chunk("a.urdf", "abcd", 0, 5));
  store.drop(kClient);
  EXPECT_EQ(store.bytes(), 4u);
  EXPECT_EQ(codeOf([&] {
              store.finish(kClient, 1);
            }),
            v1::ERROR_UPLOAD_GONE);
  store.put(other, chunk("a.urdf", "e", 4, 5));
  EXPECT_NO_THROW(store.finish(other, 1));
}

TEST(UploadStore, GivesBackWhatIsIdleThoughNobodyAsksForRoom) {
  UploadStore store({.idle = std::chrono::seconds(0)});
  store.put(kClient, chunk("a.urdf", "abc", 0, 5));
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
  store.dropIdle();
  EXPECT_EQ(store.bytes(), 0u);
}

TEST(UploadStore, NeverMakesAPathOfAUri) {
  UploadStore store;
  for (const char* uri : {"../../../tmp/escape.stl", "/etc/passwd", "package://a/../b.dae",
                          "file:///etc/x.obj", "a/b/c.../..%2f"}) {
    store.put(kClient, chunk(uri, "x", 0, 1));
  }
  const auto files = store.finish(kClient, 1);
  const fs::path folder = files->file("/etc/passwd").parent_path();
  for (const char* uri : {"../../../tmp/escape.stl", "package://a/../b.dae"}) {
    EXPECT_EQ(files->file(uri).parent_path(), folder);
    EXPECT_EQ(files->file(uri).string().find(".."), std::string::npos);
  }
  EXPECT_EQ(files->file("../../../tmp/escape.stl").extension(), ".stl");
  EXPECT_THROW((void)files->file("not sent"), InvalidInput);
}

TEST(UploadStore, RefusesChunksThatDoNotContinue) {
  UploadStore store;
  store.put(kClient, chunk("a", "abc", 0, 10));
  EXPECT_THROW(store.put(kClient, chunk("a", "x", 4, 10)), InvalidInput);
  EXPECT_THROW(store.put(kClient, chunk("a", "x", 3, 11)), InvalidInput);
  EXPECT_THROW(store.put(kClient, chunk("a", "01234567", 3, 10)), InvalidInput);
  EXPECT_THROW(store.finish(kClient, 1), InvalidInput);
  EXPECT_THROW(store.put(kClient, chunk("", "x", 0, 1)), InvalidInput);
}

// What was begun with the server before this one.
TEST(UploadStore, TellsWhatIsNotHereSoThatItIsBegunAnew) {
  UploadStore store;
  const auto code_of = [&store](const v1::PutFileRequest& request) {
    return codeOf([&] {
      store.put(kClient, request);
    });
  };
  EXPECT_EQ(code_of(chunk("a", "x", 5, 10)), v1::ERROR_UPLOAD_GONE);
  EXPECT_EQ(codeOf([&] {
              store.finish(kClient, 2);
            }),
            v1::ERROR_UPLOAD_GONE);
  store.put(kClient, chunk("b", "01", 0, 2));  // its second file
  EXPECT_EQ(code_of(chunk("a", "", 10, 10)), v1::ERROR_UPLOAD_GONE);
  EXPECT_EQ(code_of(chunk("b", "", 2, 2)), v1::ERROR_NONE);
}

TEST(UploadStore, BoundsWhatAClientAndAllClientsUpload) {
  constexpr std::uint64_t kFile = UploadStore::kFileCost;
  UploadStore store({.bytes = 3 * kFile + 4, .bytes_per_client = 100});
  EXPECT_EQ(codeOf([&] {
              store.put(kClient, chunk("a", "x", 0, 101));
            }),
            v1::ERROR_OVERLOADED);
  store.put(kClient, chunk("a", "x", 0, 100));
  EXPECT_EQ(codeOf([&] {
              store.put(kClient, chunk("b", "x", 0, 1));
            }),
            v1::ERROR_OVERLOADED);
  EXPECT_EQ(codeOf([&] {
              store.put({8}, chunk("a", "xyz", 0, 100));
            }),
            v1::ERROR_NONE)
      << "what is announced and has not come counts for its client alone";
  EXPECT_EQ(codeOf([&] {
              store.put({9}, chunk("a", "x", 0, 1));
            }),
            v1::ERROR_OVERLOADED);
  EXPECT_EQ(codeOf([&] {
              store.put({9}, chunk("a", "x", 0, ~std::uint64_t{0}));
            }),
            v1::ERROR_OVERLOADED);
}

TEST(UploadStore, DropsAnUploadThatNobodyContinues) {
  UploadStore store({.idle = std::chrono::seconds(-1)});
  store.put(kClient, chunk("a", "xyz", 0, 100));
  store.put({8}, chunk("a", "x", 0, 10));
  EXPECT_EQ(store.bytes(), 1u);
}

TEST(UploadStore, IsNotBlockedByPromisesOfFourClients) {
  UploadStore store;
  for (std::uint8_t client = 1; client <= 4; ++client)
    store.put({client}, chunk("a", "x", 0, 256ull << 20));
  EXPECT_NO_THROW(store.put({9}, chunk("a", "x", 0, 256ull << 20)));
}

TEST(UploadStore, MakesRoomByDroppingTheLongestIdleUpload) {
  constexpr std::uint64_t kFile = UploadStore::kFileCost;
  UploadStore store({.bytes = 2 * kFile + 8, .idle_in_need = std::chrono::seconds(-1)});
  store.put({1}, chunk("a", "xyz", 0, 100));
  store.put({2}, chunk("a", "xyz", 0, 100));
  store.put({3}, chunk("a", "x", 0, 1));
  EXPECT_EQ(codeOf([&] {
              store.finish({1}, 1);
            }),
            v1::ERROR_UPLOAD_GONE);
  EXPECT_NO_THROW(store.finish({3}, 1));
}

TEST(UploadStore, CountsEmptyFiles) {
  UploadStore store({.bytes = 10 * UploadStore::kFileCost});
  const auto put = [&] {
    for (int i = 0; i < 11; ++i)
      store.put(kClient, chunk("file" + std::to_string(i), "", 0, 0));
  };
  EXPECT_EQ(codeOf(put), v1::ERROR_OVERLOADED);
}

TEST(UploadedFiles, PrintsDependOnNamesAndContentsNotOnOrder) {
  UploadStore store;
  const auto print_of = [&](std::vector<std::pair<std::string, std::string>> files) {
    for (const auto& [uri, bytes] : files) {
      store.put(kClient, chunk(uri, bytes, 0, bytes.size()));
    }
    return store.finish(kClient, 1)->contentHash();
  };
  const auto print = print_of({{"a", "1"}, {"b", "2"}});
  EXPECT_EQ(print, print_of({{"b", "2"}, {"a", "1"}}));
  EXPECT_NE(print, print_of({{"a", "2"}, {"b", "1"}}));
  EXPECT_NE(print, print_of({{"a", "1"}, {"c", "2"}}));
}

TEST(UploadedFiles, SpeakTheClientsWords) {
  UploadStore store;
  store.put(kClient, chunk("meshes/palm.stl", "x", 0, 1));
  const auto files = store.finish(kClient, 1);
  const std::string ours = "'" + files->file("meshes/palm.stl").string() + "': truncated";
  EXPECT_EQ(files->inClientsWords(ours), "'meshes/palm.stl': truncated");
}

}  // namespace
}  // namespace handgraft::server
