#include "hardware/bridge/report_line.h"

#include <gtest/gtest.h>

#include "tests/hardware/bridge/messages.h"

namespace handgraft::bridge {
namespace {

using namespace test;

BridgeReport report() {
  BridgeReport r;
  r.message = "following session 3";
  r.state = v1::BRIDGE_ARMED;
  r.session_id = 3;
  r.hand = "tiny";
  r.names = {"a", "b"};
  r.position = {0.25, kNaN};
  r.target = {0.5, -1};
  return r;
}

TEST(ReportLine, SaysStateAndMessageToPeople) {
  EXPECT_EQ(textLine(report()), "handgraft-bridge: armed: following session 3");
}

TEST(ReportLine, IsOneLineOfJson) {
  EXPECT_EQ(jsonLine(report()),
            R"({"message":"following session 3","state":"armed","session_id":3,"hand":"tiny",)"
            R"("names":["a","b"],"position":[0.25,null],"target":[0.5,-1.0]})");
}

TEST(ReportLine, StaysValidWhateverTheHandIsCalled) {
  BridgeReport r = report();
  r.hand = "q\"b\\n\nt\x01 \xff";
  const std::string line = jsonLine(r);
  EXPECT_NE(line.find(R"("hand":"q\"b\\n\nt\u0001 )"), std::string::npos) << line;
  EXPECT_EQ(line.find('\n'), std::string::npos) << line;
}

}  // namespace
}  // namespace handgraft::bridge
