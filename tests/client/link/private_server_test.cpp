#include "client/link/private_server.h"

#include <fstream>
#include <functional>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

#include "tests/support/shared_data.h"

namespace handgraft::client {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

bool eventually(const std::function<bool()>& condition) {
  for (int i = 0; i < 2000 && !condition(); ++i)
    std::this_thread::sleep_for(milliseconds(5));
  return condition();
}

fs::path script(const std::string& body) {
  static int count = 0;
  const fs::path path = test::scratchDirectory() / ("server" + std::to_string(++count));
  std::ofstream(path) << "#!/bin/sh\n" << body << "\n";
  fs::permissions(path, fs::perms::owner_all);
  return path;
}

TEST(PrivateServer, PassesTheNetworkOnAndKeepsNothing) {
  PrivateServer server(script("echo \"$@\""), {7, "lo"});
  EXPECT_TRUE(eventually([&] {
    return !server.running();
  }));
  EXPECT_EQ(server.lastWords(), "--domain 7 --interface lo --state :memory:");
}

TEST(PrivateServer, IsStoppedAtTheEnd) {
  const fs::path sign = test::scratchDirectory() / "stopped";
  {
    PrivateServer server(script("trap 'touch " + sign.string() +
                                "; exit 0' TERM\necho ready\nwhile :; do sleep "
                                "0.01; done"),
                         {});
    ASSERT_TRUE(eventually([&] {
      return server.lastWords() == "ready";
    }));
    EXPECT_TRUE(server.running());
  }
  EXPECT_TRUE(fs::exists(sign));
}

TEST(PrivateServer, KeepsTheReasonOfOneThatEnds) {
  PrivateServer server(script("echo starting; echo 'no models here' >&2; exit 1"), {});
  EXPECT_TRUE(eventually([&] {
    return !server.running();
  }));
  EXPECT_EQ(server.lastWords(), "no models here");
}

TEST(PrivateServer, EndsAtOnceWhenThereIsNoSuchProgram) {
  PrivateServer server("/no/such/program", {});
  EXPECT_TRUE(eventually([&] {
    return !server.running();
  }));
}

}  // namespace
}  // namespace handgraft::client
