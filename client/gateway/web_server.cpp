#include "client/gateway/web_server.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <map>
#include <optional>
#include <thread>
#include <utility>

// Beast is seen by this file alone.
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "client/gateway/web_request.h"
#include "core/base/error.h"

namespace handgraft::client::gateway {

namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using std::chrono::seconds;
using SteadyClock = std::chrono::steady_clock;
using HttpRequest = http::request<http::empty_body>;
using HttpResponse = http::response<http::string_body>;

constexpr seconds kHttpPatience(10);  // for a request's header, and between requests
constexpr seconds kSilence(30);       // half of it later a page is pinged, then given up
constexpr std::uint32_t kLongestHeader = 8192;
constexpr const char* kLivePath = "/live";

// No script or style but the page's own files; frames of notebooks on this machine may show it.
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'self' http://localhost:* http://127.0.0.1:*";

std::string textOf(beast::string_view text) {
  return {text.data(), text.size()};
}

/// So many messages a second, and some at once.
class Allowance {
 public:
  explicit Allowance(const WebLimits& limits)
      : rate_(limits.messages_per_s), most_(limits.burst), left_(limits.burst) {}

  bool take() {
    const auto now = SteadyClock::now();
    left_ = std::min(most_, left_ + rate_ * std::chrono::duration<double>(now - last_).count());
    last_ = now;
    if (left_ < 1.0) return false;
    left_ -= 1.0;
    return true;
  }

 private:
  const double rate_;
  const double most_;
  double left_;
  SteadyClock::time_point last_ = SteadyClock::now();
};

}  // namespace

// Everything below runs on the thread of `context`.
struct WebServer::Impl {
  class Connection;
  class Live;

  Impl(WebOptions with, WebFiles with_files, Audience& with_audience)
      : options(std::move(with)), files(std::move(with_files)), audience(with_audience) {}

  void listen();
  void accept();
  void run();

  WebOptions options;
  const WebFiles files;
  Audience& audience;
  std::size_t connections = 0;
  asio::io_context context{1};
  tcp::acceptor acceptor{context};
  std::uint16_t port = 0;
  std::map<PageId, std::weak_ptr<Live>> pages;
  PageId last_page = 0;
  bool stopping = false;
  std::thread thread;
};

// === A page that is connected

class WebServer::Impl::Live : public std::enable_shared_from_this<Live> {
 public:
  Live(Impl& server, tcp::socket socket)
      : server_(server), stream_(std::move(socket)), allowance_(server.options.limits) {
    ++server_.connections;
  }

  ~Live() { --server_.connections; }

  /// `first`: what the page says with its address; empty: nothing.
  void start(const HttpRequest& request, Rights rights, const std::string& first) {
    websocket::stream_base::timeout patience{kHttpPatience, kSilence, true};
    stream_.set_option(patience);
    stream_.auto_fragment(false);
    stream_.read_message_max(server_.options.limits.message_bytes);
    stream_.async_accept(request,
                         [self = shared_from_this(), rights, first](beast::error_code error) {
                           if (error || self->server_.stopping) return;
                           self->page_ = ++self->server_.last_page;
                           self->server_.pages[self->page_] = self;
                           self->server_.audience.joined(self->page_, rights);
                           if (!first.empty()) self->server_.audience.said(self->page_, first);
                           self->read();
                         });
  }

  void send(Shared message, bool is_binary) {
    unread_bytes_ += message->size();
    queue_.push_back({std::move(message), is_binary});
    if (unread_bytes_ > server_.options.limits.unread_bytes) {
      close(websocket::close_code::policy_error, "what was asked for is not read");
      return;
    }
    write();
  }

  void sendLatest(const std::string& key, Shared text) {
    latest_[key] = std::move(text);
    write();
  }

  void close(websocket::close_code code, const char* reason) {
    if (closing_) return;
    leave();
    stream_.async_close({code, reason}, [self = shared_from_this()](beast::error_code) {});
  }

 private:
  struct Message {
    Shared bytes;
    bool is_binary = false;
  };

  void read() {
    stream_.async_read(buffer_,
                       [self = shared_from_this()](beast::error_code error, std::size_t) {
                         if (error) {
                           self->leave();
                           return;
                         }
                         self->heard();
                       });
  }

  void heard() {
    if (closing_) {
      // What comes until the other side has closed, too, is dropped.
    } else if (!allowance_.take()) {
      close(websocket::close_code::policy_error, "too many messages");
    } else if (stream_.got_text()) {
      server_.audience.said(page_, beast::buffers_to_string(buffer_.data()));
    } else {
      server_.audience.gave(page_, beast::buffers_to_string(buffer_.data()));
    }
    buffer_.consume(buffer_.size());
    if (!closing_) read();
  }

  void write() {
    if (writing_ || closing_) return;
    if (!queue_.empty()) {
      now_ = std::move(queue_.front());
      queue_.pop_front();
      unread_bytes_ -= now_.bytes->size();
    } else if (!latest_.empty()) {
      // In turn, so that none waits for ever behind one that comes often.
      auto next = latest_.upper_bound(last_key_);
      if (next == latest_.end()) next = latest_.begin();
      last_key_ = next->first;
      now_ = {std::move(next->second), false};
      latest_.erase(next);
    } else {
      return;
    }
    writing_ = true;
    stream_.binary(now_.is_binary);
    stream_.async_write(asio::buffer(*now_.bytes),
                        [self = shared_from_this()](beast::error_code error, std::size_t) {
                          self->writing_ = false;
                          if (error) {
                            self->leave();
                          } else {
                            self->write();
                          }
                        });
  }

  void leave() {
    closing_ = true;
    if (page_ == 0) return;
    server_.pages.erase(page_);
    if (!server_.stopping) server_.audience.left(page_);
    page_ = 0;
  }

  Impl& server_;
  websocket::stream<beast::tcp_stream> stream_;
  beast::flat_buffer buffer_;
  Allowance allowance_;
  PageId page_ = 0;  ///< 0: not told to the audience, or no longer
  std::deque<Message> queue_;
  std::size_t unread_bytes_ = 0;
  std::map<std::string, Shared> latest_;
  std::string last_key_;
  Message now_;  ///< being written
  bool writing_ = false;
  bool closing_ = false;
};

// === A connection that asks for files, or to become the one above

class WebServer::Impl::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Impl& server, tcp::socket socket) : server_(server), stream_(std::move(socket)) {
    ++server_.connections;
  }

  ~Connection() { --server_.connections; }

  void read() {
    parser_.emplace();
    parser_->header_limit(kLongestHeader);
    parser_->body_limit(0);
    stream_.expires_after(kHttpPatience);
    http::async_read(stream_, buffer_, *parser_,
                     [self = shared_from_this()](beast::error_code error, std::size_t) {
                       self->heard(error);
                     });
  }

  void refuse(http::status status, const std::string& reason) {
    HttpResponse response{status, 11};
    response.set(http::field::content_type, "text/plain; charset=utf-8");
    response.body() = reason + "\n";
    response.keep_alive(false);
    answer(std::move(response));
  }

 private:
  void heard(beast::error_code error) {
    if (error == http::error::header_limit) {
      return refuse(http::status::request_header_fields_too_large, "the header is too large");
    }
    if (error == http::error::body_limit) {
      return refuse(http::status::payload_too_large, "requests have no body");
    }
    // Whoever speaks no HTTP is told so; whoever has gone is not.
    if (error &&
        error.category() == http::make_error_code(http::error::bad_method).category() &&
        error != http::error::end_of_stream) {
      return refuse(http::status::bad_request, "this is no request");
    }
    if (error) return;
    const HttpRequest& request = parser_->get();
    if (!isHostKnown(server_.options.address, textOf(request[http::field::host]))) {
      return refuse(http::status::forbidden, "this host is another one");
    }
    if (websocket::is_upgrade(request)) return upgrade(request);
    serve(request);
  }

  void upgrade(const HttpRequest& request) {
    const std::string target = textOf(request.target());
    if (pathOf(target) != kLivePath) {
      return refuse(http::status::not_found, "there is nothing of that name");
    }
    if (!isOriginKnown(textOf(request[http::field::host]),
                       textOf(request[http::field::origin]))) {
      return refuse(http::status::forbidden, "pages of other origins may not");
    }
    const std::optional<Rights> rights = rightsOf(server_.options, target);
    if (!rights) {
      return refuse(http::status::unauthorized, "the link's token is missing or wrong");
    }
    stream_.expires_never();
    std::make_shared<Live>(server_, stream_.release_socket())
        ->start(request, *rights, firstWord(target));
  }

  void serve(const HttpRequest& request) {
    if (request.method() != http::verb::get && request.method() != http::verb::head) {
      return refuse(http::status::method_not_allowed, "files are there to be read");
    }
    const std::string target = textOf(request.target());
    const auto found = server_.files.find(pathOf(target));
    if (found == server_.files.end()) {
      return refuse(http::status::not_found, "there is nothing of that name");
    }
    const WebFile& file = found->second;
    HttpResponse response{http::status::ok, request.version()};
    response.set(http::field::content_type, file.content_type);
    response.set(http::field::cache_control, "no-cache");
    const bool zipped = !file.gzipped.empty() && request[http::field::accept_encoding].find(
                                                     "gzip") != beast::string_view::npos;
    if (zipped) response.set(http::field::content_encoding, "gzip");
    const std::string& bytes = zipped ? file.gzipped : file.bytes;
    response.keep_alive(request.keep_alive());
    if (request.method() == http::verb::head) {
      response.content_length(bytes.size());
      return answer(std::move(response), false);
    }
    response.body() = bytes;
    answer(std::move(response));
  }

  void answer(HttpResponse response, bool has_body = true) {
    response.set(http::field::server, "handgraft");
    response.set("Content-Security-Policy", kPolicy);
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Referrer-Policy", "no-referrer");
    response.set("Cross-Origin-Opener-Policy", "same-origin");
    if (has_body) response.prepare_payload();
    response_ = std::move(response);
    stream_.expires_after(kHttpPatience);
    http::async_write(stream_, response_,
                      [self = shared_from_this()](beast::error_code error, std::size_t) {
                        if (error) return;
                        if (self->response_.keep_alive()) {
                          self->read();
                        } else {
                          beast::error_code ignored;
                          self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
                        }
                      });
  }

  Impl& server_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_{kLongestHeader + 1024};
  boost::optional<http::request_parser<http::empty_body>> parser_;
  HttpResponse response_;
};

// === Listening

void WebServer::Impl::listen() {
  boost::system::error_code error;
  const std::string address = options.address == "localhost" ? "127.0.0.1" : options.address;
  const auto parsed = asio::ip::make_address(address, error);
  if (error)
    rejectInput("{} is no address of this machine", handgraft::quoted(options.address));
  const tcp::endpoint endpoint(parsed, options.port);
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  if (error) rejectInput("{}:{} cannot be served ({})", address, options.port, error.message());
  port = acceptor.local_endpoint().port();
}

void WebServer::Impl::accept() {
  acceptor.async_accept([this](beast::error_code error, tcp::socket socket) {
    if (stopping) return;
    if (!error) {
      boost::system::error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
      const bool full = connections >= options.limits.connections;
      const auto connection = std::make_shared<Connection>(*this, std::move(socket));
      if (full) {
        connection->refuse(http::status::service_unavailable, "too many connections");
      } else {
        connection->read();
      }
    }
    accept();
  });
}

void WebServer::Impl::run() {
  while (!stopping) {
    try {
      context.run();
      return;
    } catch (const std::exception&) {
      // What one page caused ends with its connection; the others go on.
    }
  }
}

WebServer::WebServer(WebOptions options, WebFiles files, Audience& audience)
    : impl_(std::make_unique<Impl>(std::move(options), std::move(files), audience)) {
  impl_->listen();
  impl_->accept();
  impl_->thread = std::thread([impl = impl_.get()] {
    impl->run();
  });
}

WebServer::~WebServer() {
  asio::post(impl_->context, [impl = impl_.get()] {
    impl->stopping = true;
    impl->context.stop();
  });
  impl_->thread.join();
}

std::uint16_t WebServer::port() const {
  return impl_->port;
}

namespace {

/// Has `use` called with the page, if it is still there.
template <class Pages, class Use>
void withPage(Pages& pages, PageId id, const Use& use) {
  const auto found = pages.find(id);
  if (found == pages.end()) return;
  if (const auto page = found->second.lock()) use(*page);
}

}  // namespace

void WebServer::send(PageId page, Shared text) {
  asio::post(impl_->context, [impl = impl_.get(), page, text = std::move(text)] {
    withPage(impl->pages, page, [&](Impl::Live& live) {
      live.send(text, false);
    });
  });
}

void WebServer::sendLatest(PageId page, const std::string& key, Shared text) {
  asio::post(impl_->context, [impl = impl_.get(), page, key, text = std::move(text)] {
    withPage(impl->pages, page, [&](Impl::Live& live) {
      live.sendLatest(key, text);
    });
  });
}

void WebServer::sendBytes(PageId page, Shared bytes) {
  asio::post(impl_->context, [impl = impl_.get(), page, bytes = std::move(bytes)] {
    withPage(impl->pages, page, [&](Impl::Live& live) {
      live.send(bytes, true);
    });
  });
}

}  // namespace handgraft::client::gateway
