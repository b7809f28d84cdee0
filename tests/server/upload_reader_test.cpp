// The process that reads an upload, whatever becomes of it.

#include "server/store/upload_reader.h"

#include <atomic>
#include <csignal>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/base/sanitized.h"
#include "server/reading/sandbox.h"
#include "server/reading/units.h"

#include "tests/server/small_grasp.h"
#include "tests/support/shared_data.h"

namespace handgraft::server {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kReal = HANDGRAFT_READER;
constexpr const char* kFake = HANDGRAFT_FAKE_READER;

ReadRequest objectRequest(const std::string& name) {
  ReadRequest request;
  request.kind = ReadKind::kObject;
  request.name = name;
  request.main_uri = "cup.obj";
  request.files["cup.obj"] = test::sourceDirectory() / "server/models/objects/lemon.obj";
  return request;
}

/// What the error of a reader that behaves as `name` says is.
std::string endOf(const std::string& name, ReaderLimits limits = {}) {
  try {
    (void)UploadReader(kFake, limits).read(objectRequest(name), Progress());
  } catch (const InvalidInput& error) {
    return error.what();
  }
  return "no error";
}

TEST(UploadReader, ReadsWhatTheServerWouldReadItself) {
  const ReadModel read = UploadReader(kReal).read(objectRequest("cup"), Progress());
  const ReadModel here = readModel(objectRequest("cup"), Progress());
  const auto& there_mesh = std::get<io::MeshFile>(read).mesh;
  const auto& here_mesh = std::get<io::MeshFile>(here).mesh;
  EXPECT_EQ(there_mesh.vertices(), here_mesh.vertices());
  EXPECT_EQ(there_mesh.faces(), here_mesh.faces());
}

TEST(UploadReader, GivesErrorsAsTheyAre) {
  ReadRequest request = objectRequest("cup");
  const auto path = test::scratchDirectory() / "broken.obj";
  std::ofstream(path) << "v 0 0 0\nf 1 2 9\n";
  request.files["cup.obj"] = path;
  std::string here;
  std::string there;
  try {
    (void)readModel(request, Progress());
  } catch (const InvalidInput& error) {
    here = error.what();
  }
  try {
    (void)UploadReader(kReal).read(request, Progress());
  } catch (const InvalidInput& error) {
    there = error.what();
  }
  EXPECT_THAT(here, HasSubstr("broken.obj"));
  EXPECT_EQ(there, here);
}

TEST(UploadReader, DoubtsUnitsAcrossTheProcesses) {
  ReadRequest request = objectRequest("cup");
  const auto path = test::scratchDirectory() / "large.obj";
  std::ofstream(path) << "v 0 0 0\nv 100 0 0\nv 0 100 0\nf 1 2 3\n";
  request.files["cup.obj"] = path;
  EXPECT_THROW((void)UploadReader(kReal).read(request, Progress()), UnitsInDoubt);
}

TEST(UploadReader, SaysHowAReaderEnded) {
  const auto blames_the_file =
      AllOf(HasSubstr("'cup.obj'"), HasSubstr("damaged or beyond what is supported"));
  EXPECT_THAT(endOf("quits"), AllOf(HasSubstr("exit code 7"), blames_the_file));
  if (!kIsSanitized) {
    EXPECT_THAT(endOf("crashes"), AllOf(HasSubstr("signal 11"), blames_the_file));
    EXPECT_THAT(endOf("aborts"),
                AllOf(HasSubstr("signal 6"), blames_the_file, Not(HasSubstr("story"))));
  }
}

TEST(UploadReader, BoundsMemory) {
  if (kIsSanitized) GTEST_SKIP() << "sanitizers need all addresses";
  ReaderLimits limits;
  limits.memory_mb = 256;
  EXPECT_THAT(endOf("eats", limits), HasSubstr("needed more than 256 MB"));
}

TEST(UploadReader, BoundsTime) {
  ReaderLimits limits;
  limits.time = std::chrono::seconds(1);
  EXPECT_THAT(endOf("sleeps", limits), HasSubstr("took more than 1 s"));
  EXPECT_THAT(endOf("spins", limits), HasSubstr("took more than 1 s"));
}

TEST(UploadReader, BelievesNothing) {
  EXPECT_THAT(endOf("babbles"), HasSubstr("gave no sensible answer"));
  EXPECT_THAT(endOf("boasts"), HasSubstr("gave no sensible answer"));
  EXPECT_THAT(endOf("stops_short"), HasSubstr("without an answer"));
  EXPECT_THAT(endOf("lies"), HasSubstr("gave a model that is none"));
  EXPECT_THAT(endOf("mistakes_kinds"), HasSubstr("another kind of model"));
}

TEST(UploadReader, LetsAReaderWriteNothingAndInheritsItNothing) {
  std::filesystem::remove("/dev/shm/handgraft-fake-reader");
  const std::ifstream other(kReal);  // one descriptor more here
  EXPECT_THAT(endOf("writes"), Not(HasSubstr("wrote")));
  std::filesystem::remove("/dev/shm/handgraft-fake-reader");
  EXPECT_EQ(endOf("counts"), "3 open descriptors");
}

TEST(UploadReader, KillsAReaderThatDoesMoreThanRead) {
  if (sandboxOfThisKernel() != "files, system calls")
    GTEST_SKIP() << "this kernel can forbid: " << sandboxOfThisKernel();
  const auto is_killed = AllOf(HasSubstr("'cup.obj'"), HasSubstr("is forbidden"));
  for (const char* deed : {"writes", "connects", "forks", "executes", "signals", "removes"})
    EXPECT_THAT(endOf(deed), is_killed) << deed;
  EXPECT_EQ(endOf("opens"), "denied");
  // Nobody else noticed.
  EXPECT_NO_THROW((void)UploadReader(kReal).read(objectRequest("cup"), Progress()));
}

TEST(UploadReader, TellsMistakesFromWrongInput) {
  try {
    (void)UploadReader(kFake).read(objectRequest("errs"), Progress());
    FAIL() << "no error";
  } catch (const InvalidInput& error) {
    FAIL() << error.what();
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "it is?my fault");
  }
}

TEST(UploadReader, ReportsProgressAndIsCancelled) {
  std::atomic<int> told = 0;
  Progress* to_cancel = nullptr;
  Progress progress([&](std::string_view stage, double fraction) {
    EXPECT_EQ(stage, "sleeping");
    EXPECT_EQ(fraction, 0.5);
    if (++told == 3) to_cancel->cancel();
  });
  to_cancel = &progress;
  // The limit is far away: it ends because it is cancelled.
  EXPECT_THROW((void)UploadReader(kFake).read(objectRequest("sleeps"), progress), Cancelled);
  EXPECT_GE(told, 3);
}

/// Whether a process is there and not just waiting to be reaped by whoever inherited it.
bool isAlive(pid_t process) {
  std::ifstream status("/proc/" + std::to_string(process) + "/stat");
  std::string word;
  std::string state;
  return (status >> word >> word >> state) && state != "Z" && state != "X";
}

TEST(UploadReader, LeavesNoReaderBehindWhenItIsKilled) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const pid_t server = fork();
  if (server == 0) {
    try {
      const Progress progress([&](std::string_view stage, double) {
        const pid_t reader = std::stoi(std::string(stage));
        if (write(ends[1], &reader, sizeof(reader)) < 0) _exit(1);
      });
      (void)UploadReader(kFake).read(objectRequest("tells_its_id"), progress);
    } catch (...) {
    }
    _exit(1);
  }
  pid_t reader = 0;
  ASSERT_EQ(read(ends[0], &reader, sizeof(reader)), static_cast<ssize_t>(sizeof(reader)));
  EXPECT_TRUE(isAlive(reader));
  kill(server, SIGKILL);
  waitpid(server, nullptr, 0);
  for (int i = 0; i < 1000 && isAlive(reader); ++i)
    usleep(10'000);
  EXPECT_FALSE(isAlive(reader));
  close(ends[0]);
  close(ends[1]);
}

TEST(UploadReader, ReadsInManyThreadsAtOnce) {
  const UploadReader real(kReal);
  const UploadReader fake(kFake);
  std::atomic<int> read = 0;
  std::atomic<int> failed = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) {
    threads.emplace_back([&, i] {
      try {
        const bool bad = i % 2 == 0;
        (void)(bad ? fake : real).read(objectRequest(bad ? "quits" : "cup"), Progress());
        ++read;
      } catch (const InvalidInput&) {
        ++failed;
      }
    });
  }
  for (std::thread& thread : threads)
    thread.join();
  EXPECT_EQ(read, 4);
  EXPECT_EQ(failed, 4);
}

TEST(UploadReader, NeedsItsProgramAndSensibleLimits) {
  try {
    const UploadReader none("/nowhere/handgraft-reader");
    FAIL() << "found it";
  } catch (const InvalidInput& error) {
    EXPECT_THAT(error.what(), HasSubstr("/nowhere/handgraft-reader"));
  }
  ReaderLimits limits;
  limits.memory_mb = 1;
  EXPECT_THROW(UploadReader(kReal, limits), InvalidInput);
  limits = {};
  limits.time = std::chrono::seconds(0);
  EXPECT_THROW(UploadReader(kReal, limits), InvalidInput);
}

}  // namespace
}  // namespace handgraft::server
