#include <csignal>
#include <future>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "idl/cyclone/requester.h"

#include "tests/support/test_domain.h"
#include "tests/system/service.h"

namespace handgraft::test {
namespace {

TEST(MissingServer, IsReportedWithDomainAndInterface) {
  const TestDomain domain;
  const Finished finished =
      run(program("handgraft"), {"models", "--domain", std::to_string(domain.number())});
  EXPECT_EQ(finished.exit_code, 1);
  EXPECT_NE(finished.err.find("domain " + std::to_string(domain.number())), std::string::npos)
      << finished.err;
  EXPECT_NE(finished.err.find("lo"), std::string::npos) << finished.err;
}

TEST(MissingServer, IsReportedByTheDoctor) {
  const TestDomain domain;
  const Finished finished =
      run(program("handgraft"), {"doctor", "--domain", std::to_string(domain.number())});
  EXPECT_EQ(finished.exit_code, 1);
  EXPECT_NE((finished.out + finished.err).find("domain " + std::to_string(domain.number())),
            std::string::npos);
}

/// The commonest slip with several machines: peers are named, and the interface is not.
TEST(MissingServer, IsSoughtOverAnInterfaceThatLeadsThere) {
  const TestDomain domain;
  const Finished finished =
      run(program("handgraft"), {"doctor", "--domain", std::to_string(domain.number()),
                                 "--interface", "lo", "--peers", "192.0.2.7"});
  EXPECT_EQ(finished.exit_code, 1);
  const std::string told = finished.out + finished.err;
  EXPECT_NE(told.find("leads to no other machine"), std::string::npos) << told;
  EXPECT_NE(told.find("192.0.2.7 (--interface auto"), std::string::npos) << told;
}

TEST(MissingServer, IsNotStartedPrivatelyForASessionThatIsKeptElsewhere) {
  const TestDomain domain;
  const Finished finished =
      run(program("handgraft"),
          {"grasp", "--hand", "barrett8", "--object", "lemon", "--contacts", "lemon_6",
           "--keep", "--peers", "127.0.0.1", "--domain", std::to_string(domain.number())});
  EXPECT_EQ(finished.exit_code, 1) << finished.out;
  EXPECT_EQ(finished.out.find("objective"), std::string::npos) << finished.out;
  EXPECT_NE(finished.err.find("no handgraft-server answers"), std::string::npos)
      << finished.err;
}

TEST(MissingServer, IsStartedPrivatelyByGraspAndEndsWithIt) {
  const TestDomain domain;
  const std::string id = std::to_string(domain.number());
  const Finished finished =
      run(program("handgraft"), {"grasp", "--hand", "barrett8", "--object", "lemon",
                                 "--contacts", "lemon_6", "--domain", id});
  EXPECT_EQ(finished.exit_code, 0) << finished.err;
  EXPECT_NE(finished.err.find("started"), std::string::npos) << finished.err;
  EXPECT_EQ(run(program("handgraft"), {"doctor", "--domain", id}).exit_code, 1)
      << "the private server outlived its command";
}

/// Each with a server of its own: one that asked another's would lose it with that command's
/// end.
TEST(MissingServer, IsStartedByEachOfSeveralCommandsAtOnce) {
  const TestDomain domain;
  const std::vector<std::string> words = {
      "grasp",    "--hand",   "barrett8",
      "--object", "lemon",    "--contacts",
      "lemon_6",  "--domain", std::to_string(domain.number())};
  std::vector<std::future<Finished>> commands;
  commands.reserve(3);
  for (int i = 0; i < 3; ++i) {
    commands.push_back(std::async(std::launch::async, [&words, i] {
      // Within the time in which each one's server is up and not yet gone.
      std::this_thread::sleep_for(std::chrono::milliseconds(600 * i));
      return run(program("handgraft"), words);
    }));
  }
  for (auto& command : commands) {
    const Finished finished = command.get();
    EXPECT_EQ(finished.exit_code, 0) << finished.err;
    EXPECT_NE(finished.err.find("started"), std::string::npos) << finished.err;
  }
}

TEST(MissingServer, IsNoticedWhenItDiesInTheMiddleOfARequest) {
  Service service;
  const idl::cyclone::Participant participant(service.network());
  idl::cyclone::Requester requester(participant);
  ASSERT_TRUE(requester.waitForServer(std::chrono::seconds(60)));
  service.server().send(SIGKILL);
  service.server().wait();
  v1::RequestBody body;
  body.nothing(v1::Nothing());
  body._d(v1::Operation::OP_LIST_MODELS);
  EXPECT_THROW(requester.ask(body), idl::cyclone::NoServer);
}

}  // namespace
}  // namespace handgraft::test
