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
            R"("names":["a","b"],"position_rad":[0.250000,null],)"
            R"("target_rad":[0.500000,-1.000000]})");
}

TEST(ReportLine, EscapesWhatJsonForbids) {
  BridgeReport r = report();
  r.hand = "q\"b\\n\nt\x01";
  EXPECT_NE(jsonLine(r).find(R"("hand":"q\"b\\n\u000at\u0001")"), std::string::npos);
}

TEST(ReportLine, KeepsUtf8AndReplacesTheRest) {
  BridgeReport r = report();
  r.hand = "h\xc3\xa4nd \xf0\x9f\x96\x90 \xff \xc0\x80 \xed\xa0\x80 \xe2\x82";
  EXPECT_NE(jsonLine(r).find("\"h\xc3\xa4nd \xf0\x9f\x96\x90 ? ?? ??? ??\""), std::string::npos)
      << jsonLine(r);
}

}  // namespace
}  // namespace handgraft::bridge
