#include "client/gateway/web_server.h"

#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <mutex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/gateway/web_request.h"
#include "core/base/error.h"

#include "tests/client/gateway/bare_page.h"

namespace handgraft::client::gateway {

namespace {

using test::BarePage;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

/// Remembers what it is told.
class Listener : public Audience {
 public:
  void joined(PageId page, Rights rights) override {
    const std::lock_guard lock(mutex_);
    pages_.push_back(page);
    rights_.push_back(rights);
    news_.notify_all();
  }

  void said(PageId /*page*/, const std::string& text) override {
    const std::lock_guard lock(mutex_);
    texts_.push_back(text);
    news_.notify_all();
  }

  void gave(PageId /*page*/, const std::string& frame) override {
    const std::lock_guard lock(mutex_);
    texts_.push_back("bytes " + frame);
    news_.notify_all();
  }

  void left(PageId /*page*/) override {
    const std::lock_guard lock(mutex_);
    ++left_;
    news_.notify_all();
  }

  PageId awaitPage() {
    std::unique_lock lock(mutex_);
    wait(lock, [&] {
      return !pages_.empty();
    });
    return pages_.back();
  }

  std::string awaitText() {
    std::unique_lock lock(mutex_);
    wait(lock, [&] {
      return !texts_.empty();
    });
    return texts_.back();
  }

  /// All, once so many came.
  std::vector<std::string> awaitTexts(std::size_t count) {
    std::unique_lock lock(mutex_);
    wait(lock, [&] {
      return texts_.size() >= count;
    });
    return texts_;
  }

  void awaitLeaving(std::size_t count) {
    std::unique_lock lock(mutex_);
    wait(lock, [&] {
      return left_ >= count;
    });
  }

  std::vector<Rights> rights() {
    const std::lock_guard lock(mutex_);
    return rights_;
  }

 private:
  template <class Predicate>
  void wait(std::unique_lock<std::mutex>& lock, Predicate come) {
    if (!news_.wait_for(lock, std::chrono::seconds(20), come)) {
      throw std::runtime_error("nothing was told");
    }
  }

  std::mutex mutex_;
  std::condition_variable news_;
  std::vector<PageId> pages_;
  std::vector<Rights> rights_;
  std::vector<std::string> texts_;
  std::size_t left_ = 0;
};

WebFiles smallPage() {
  return {{"/", {"text/html; charset=utf-8", "<!doctype html>", ""}},
          {"/page.js", {"text/javascript; charset=utf-8", "1;", ""}}};
}

class WebServerTest : public testing::Test {
 protected:
  std::uint16_t serve(const WebOptions& options = {}) {
    server = std::make_unique<WebServer>(options, smallPage(), listener);
    return server->port();
  }

  static WebServer::Shared shared(std::string text) {
    return std::make_shared<const std::string>(std::move(text));
  }

  Listener listener;
  std::unique_ptr<WebServer> server;
};

// === Files

TEST_F(WebServerTest, ServesThePageUnderAPolicyWithoutInlineScripts) {
  const std::string header = BarePage(serve()).get("/?session=3");
  EXPECT_THAT(header, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(header, HasSubstr("script-src 'self';"));
  EXPECT_THAT(header, HasSubstr("X-Content-Type-Options: nosniff"));
  EXPECT_THAT(header, Not(HasSubstr("unsafe")));
}

TEST_F(WebServerTest, HasNoPathOfThisMachine) {
  const std::uint16_t port = serve();
  for (const char* target :
       {"/../../../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/etc/passwd",
        "/page.js/../../web_server.cpp", "/page.js%00.txt", "http://127.0.0.1/etc/passwd"}) {
    EXPECT_THAT(BarePage(port).get(target), StartsWith("HTTP/1.1 404")) << target;
  }
}

TEST_F(WebServerTest, ReadsAloneAreServed) {
  BarePage page(serve());
  page.send("POST / HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_THAT(page.header(), StartsWith("HTTP/1.1 405"));
}

TEST_F(WebServerTest, RefusesHeadersAndBodiesThatAreTooLarge) {
  const std::uint16_t port = serve();
  BarePage talker(port);
  talker.send("GET / HTTP/1.1\r\nHost: localhost\r\nX: " + std::string(20000, 'x') +
              "\r\n\r\n");
  EXPECT_THAT(talker.header(), StartsWith("HTTP/1.1 431"));
  BarePage sender(port);
  sender.send("GET / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 100000000\r\n\r\n");
  EXPECT_THAT(sender.header(), StartsWith("HTTP/1.1 413"));
}

TEST_F(WebServerTest, RefusesANameThatSomebodyHadPointHere) {
  EXPECT_THAT(BarePage(serve()).get("/", "attacker.example"), StartsWith("HTTP/1.1 403"));
}

TEST(ReadWebFiles, SaysWhatIsMissingWhereNoPageWasBuilt) {
  EXPECT_THAT(
      [] {
        readWebFiles(std::filesystem::path(testing::TempDir()) / "no_page");
      },
      testing::ThrowsMessage<InvalidInput>(HasSubstr("npm")));
}

// === Who may join

TEST_F(WebServerTest, RefusesPagesOfOtherOrigins) {
  const std::uint16_t port = serve();
  EXPECT_THAT(BarePage(port).upgrade("/live", "Origin: http://attacker.example\r\n"),
              StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(BarePage(port).upgrade("/live", "Origin: null\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(BarePage(port).upgrade(
                  "/live", "Origin: http://127.0.0.1:" + std::to_string(port) + "\r\n"),
              StartsWith("HTTP/1.1 101"));
}

TEST_F(WebServerTest, LetsInByTokenAlone) {
  WebOptions options;
  options.edit_token = "edit-secret";
  options.look_token = "look-secret";
  const std::uint16_t port = serve(options);
  EXPECT_THAT(BarePage(port).upgrade(), StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(BarePage(port).upgrade("/live?token="), StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(BarePage(port).upgrade("/live?token=edit-secre"), StartsWith("HTTP/1.1 401"));
  EXPECT_THAT(BarePage(port).upgrade("/live?token=edit-secrets"), StartsWith("HTTP/1.1 401"));
  BarePage editor(port);
  EXPECT_THAT(editor.upgrade("/live?token=edit-secret"), StartsWith("HTTP/1.1 101"));
  listener.awaitPage();
  BarePage looker(port);
  EXPECT_THAT(looker.upgrade("/live?x=1&token=look-secret"), StartsWith("HTTP/1.1 101"));
  looker.say("hello");
  listener.awaitText();
  EXPECT_THAT(listener.rights(), testing::ElementsAre(Rights::kEdit, Rights::kLook));
}

TEST_F(WebServerTest, HearsBySessionsInAddressesWhatToShow) {
  const std::uint16_t port = serve();
  std::vector<std::string> said;
  for (const char* nonsense : {"/live?session=", "/live?session=7\"}", "/live?session=-1",
                               "/live?session=123456789012345678901"}) {
    BarePage page(port);
    EXPECT_THAT(page.upgrade(nonsense), StartsWith("HTTP/1.1 101"));
    page.say(nonsense);
    said.emplace_back(nonsense);
    EXPECT_EQ(listener.awaitTexts(said.size()), said);
  }
  BarePage page(port);
  page.upgrade("/live?token=x&session=7");
  EXPECT_EQ(listener.awaitTexts(said.size() + 1).back(), R"({"id":1,"do":"show","session":7})");
}

TEST_F(WebServerTest, ReadOnlyLetsNobodyEdit) {
  WebOptions options;
  options.read_only = true;
  BarePage page(serve(options));
  page.upgrade();
  listener.awaitPage();
  EXPECT_THAT(listener.rights(), testing::ElementsAre(Rights::kLook));
}

// === Pages that do too much, while others go on

TEST_F(WebServerTest, EndsAPageThatSendsTooMuch) {
  const std::uint16_t port = serve();
  BarePage page(port);
  page.upgrade();
  page.send(BarePage::frameHead(100000000));
  EXPECT_EQ(page.closingCode(), 1009);
  BarePage other(port);
  other.upgrade();
  other.say("I am fine");
  EXPECT_EQ(listener.awaitText(), "I am fine");
}

TEST_F(WebServerTest, EndsAPageThatSendsTooOften) {
  BarePage page(serve());
  page.upgrade();
  std::string many;
  for (int i = 0; i < 10000; ++i)
    many += BarePage::frameHead(2) + "{}";
  page.send(many);
  EXPECT_EQ(page.closingCode(), 1008);
  listener.awaitLeaving(1);
}

TEST_F(WebServerTest, TellsBytesFromText) {
  BarePage page(serve());
  page.upgrade();
  page.send(BarePage::frameHead(2, 2) + "ab");
  EXPECT_EQ(listener.awaitText(), "bytes ab");
}

TEST_F(WebServerTest, HasOnlySoManyConnections) {
  const std::uint16_t port = serve();
  std::vector<std::unique_ptr<BarePage>> pages;
  std::size_t refused = 0;
  for (int i = 0; i < 200; ++i) {
    pages.push_back(std::make_unique<BarePage>(port));
    const std::string status = pages.back()->upgrade();
    if (status.rfind("HTTP/1.1 101", 0) != 0) {
      EXPECT_THAT(status, StartsWith("HTTP/1.1 503"));
      ++refused;
    }
  }
  EXPECT_EQ(refused, 200 - WebLimits{}.connections);
  pages.clear();
  listener.awaitLeaving(WebLimits{}.connections);
  EXPECT_THAT(BarePage(port).upgrade(), StartsWith("HTTP/1.1 101"));
}

TEST_F(WebServerTest, TellsASlowPageTheNewestAlone) {
  BarePage page(serve());
  page.upgrade();
  const PageId id = listener.awaitPage();
  const std::string filling(1000000, 'x');
  constexpr int kCount = 300;
  for (int i = 0; i < kCount; ++i)
    server->sendLatest(id, "pose", shared(std::to_string(i) + " " + filling));
  server->send(id, shared("what was asked for"));
  int told = 0;
  std::string last;
  bool is_answered = false;
  while (!is_answered || last != std::to_string(kCount - 1)) {
    const auto frame = page.frame();
    ASSERT_TRUE(frame.has_value()) << "after " << told << " poses";
    if (frame->payload == "what was asked for") {
      is_answered = true;
    } else {
      last = frame->payload.substr(0, frame->payload.find(' '));
      ++told;
    }
  }
  EXPECT_LT(told, kCount / 2);
}

TEST(IsLoopback, TellsThisMachineFromOthers) {
  EXPECT_TRUE(isLoopback("127.0.0.1"));
  EXPECT_TRUE(isLoopback("127.0.0.2"));
  EXPECT_TRUE(isLoopback("::1"));
  EXPECT_TRUE(isLoopback("localhost"));
  EXPECT_FALSE(isLoopback("0.0.0.0"));
  EXPECT_FALSE(isLoopback("192.168.1.5"));
  EXPECT_FALSE(isLoopback("::"));
}

}  // namespace

}  // namespace handgraft::client::gateway
