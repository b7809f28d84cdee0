#include "idl/cyclone/requester.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <random>
#include <thread>
#include <utility>

namespace handgraft::idl::cyclone {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kFirstAnswer(2000);  // a server that lives says so once a second
constexpr milliseconds kLost(3000);         // three missed, on a machine that may be busy
constexpr milliseconds kRepeat(50);         // idl/README: measured to lose nothing
constexpr milliseconds kSlowRepeat(1000);   // once the server is known to work on it
constexpr int kRepeatsBeforeSlowing = 10;
constexpr std::size_t kBytesPerMillisecond = 10'000;  // far below what loopback carries
constexpr std::size_t kMiB = 1024 * 1024;

v1::ClientId randomClient() {
  std::random_device device;
  v1::ClientId id{};
  for (auto& byte : id)
    byte = static_cast<std::uint8_t>(device());
  return id;
}

/// When to say it again: at once while discovery settles, ever slower when the server is at
/// work, and never so fast that a large body floods the wire.
class Pace {
 public:
  explicit Pace(std::size_t bytes)
      : interval_(kRepeat + milliseconds(static_cast<long>(bytes / kBytesPerMillisecond))) {}

  [[nodiscard]] bool due(Clock::time_point now) const { return now >= next_; }

  [[nodiscard]] Clock::time_point next() const { return next_; }

  void sent(Clock::time_point now) {
    if (++count_ % kRepeatsBeforeSlowing == 0) {
      interval_ = std::max(interval_, std::min(2 * interval_, kSlowRepeat));
    }
    next_ = now + interval_;
  }

  void slowDown() { interval_ = std::max(interval_, kSlowRepeat); }

  void hurry(Clock::time_point now) { next_ = now; }

 private:
  milliseconds interval_;
  Clock::time_point next_{};
  int count_ = 0;
};

}  // namespace

struct Requester::Impl {
  explicit Impl(const Participant& on)
      : participant(on),
        requests(participant, kRequestTopic),
        edits(participant, kEditTopic),
        replies(participant,
                kReplyTopic,
                [this] {
                  arrived();
                }),
        edit_replies(participant,
                     kEditReplyTopic,
                     [this] {
                       arrived();
                     }),
        progresses(participant,
                   kProgressTopic,
                   [this] {
                     arrived();
                   }),
        statuses(participant,
                 kStatusTopic,
                 [this] {
                   arrived();
                 }),
        receiver([this] {
          receive();
        }) {}

  ~Impl() {
    {
      const std::lock_guard lock(mutex);
      stopping = true;
    }
    something.notify_all();
    receiver.join();
  }

  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  // === Receiving: everything is taken as it comes, so that other clients' replies do not pile
  // up

  void arrived() {
    {
      const std::lock_guard lock(mutex);
      has_data = true;
    }
    something.notify_all();
  }

  void receive() {
    std::unique_lock lock(mutex);
    while (true) {
      something.wait(lock, [this] {
        return has_data || stopping;
      });
      if (stopping) return;
      has_data = false;
      lock.unlock();
      takeAll();
      lock.lock();
      news.notify_all();
    }
  }

  void takeAll() {
    statuses.take([this](const v1::ServerStatus& message) {
      const std::lock_guard lock(mutex);
      // A second server's goodbye does not end the first one.
      if (message.stopping() && status && status->server_id() != message.server_id()) return;
      status = message;
      seen = Clock::now();
    });
    progresses.take([this](const v1::Progress& message) {
      const std::lock_guard lock(mutex);
      if (message.client() != client || message.request_id() != awaited_request) return;
      progress = message;
      seen = Clock::now();
    });
    replies.take([this](const v1::Reply& message) {
      const std::lock_guard lock(mutex);
      if (message.client() != client || message.request_id() != awaited_request) return;
      reply = message;
      seen = Clock::now();
    });
    edit_replies.take([this](const v1::EditReply& message) {
      const std::lock_guard lock(mutex);
      if (message.client() != client || message.edit_id() != awaited_edit) return;
      edit_reply = message;
      seen = Clock::now();
    });
  }

  // === The server's life; `mutex` held

  [[nodiscard]] bool alive() const {
    return status && !status->stopping() && Clock::now() - seen < kLost;
  }

  void requireSameVersion() const {
    if (!status || status->protocol_version() == v1::PROTOCOL_VERSION) return;
    throw Refused(
        v1::ERROR_VERSION,
        fmt::format("the server ({}) speaks protocol {}, this program speaks {}",
                    status->version(), status->protocol_version(), v1::PROTOCOL_VERSION));
  }

  void requireLife(Clock::time_point asked) const {
    requireSameVersion();
    if (alive() || Clock::now() - asked < kFirstAnswer) return;
    if (!status) throw noServer();
    throw NoServer(fmt::format("handgraft-server on {} {}", describe(participant.network()),
                               status->stopping() ? "is stopping" : "stopped answering"));
  }

  [[nodiscard]] NoServer noServer() const {
    return NoServer(
        fmt::format("no handgraft-server answers on {}", describe(participant.network())));
  }

  // === Asking

  /// Sends until `answer` is there. `send` and `on_progress` run without the lock.
  template <class Answer>
  Answer await(std::optional<Answer>& answer,
               std::size_t bytes,
               const std::function<void()>& send,
               const OnProgress& on_progress) {
    const Clock::time_point asked = Clock::now();
    Pace pace(bytes);
    std::optional<std::uint64_t> cancel_id;
    std::unique_lock lock(mutex);
    while (!answer) {
      requireLife(asked);
      if (cancelled && !cancel_id) {
        cancel_id = next_request++;
        pace.hurry(Clock::now());
      }
      if (progress) {
        const v1::Progress latest = *std::exchange(progress, std::nullopt);
        pace.slowDown();
        if (on_progress) {
          lock.unlock();
          on_progress(latest.stage(), latest.fraction());
          lock.lock();
          continue;
        }
      }
      if (pace.due(Clock::now())) {
        lock.unlock();
        if (cancel_id) {
          tryWrite([&] {
            requests.write(cancelRequest(*cancel_id));
          });
        }
        tryWrite(send);
        pace.sent(Clock::now());
        lock.lock();
        continue;
      }
      news.wait_until(lock, pace.next());
    }
    return *std::exchange(answer, std::nullopt);
  }

  /// A reader that does not keep up is not an error: what is lost now is repeated soon.
  static void tryWrite(const std::function<void()>& write) {
    try {
      write();
    } catch (const WriteTimeout&) {
    }
  }

  [[nodiscard]] v1::Request cancelRequest(std::uint64_t id) const {
    v1::Request request;
    request.client(client);
    request.request_id(id);
    request.protocol_version(v1::PROTOCOL_VERSION);
    v1::CancelRequest body;
    body.request_id(awaited_request);
    request.body().cancel(body);
    request.body()._d(v1::OP_CANCEL);
    return request;
  }

  /// What waits for an answer, for as long as this lives.
  struct Awaiting {
    Awaiting(Impl& owner, std::uint64_t& slot, std::uint64_t id) : impl(owner), awaited(slot) {
      const std::lock_guard lock(impl.mutex);
      awaited = id;
      impl.cancelled = false;
      impl.progress.reset();
      impl.reply.reset();
      impl.edit_reply.reset();
    }

    ~Awaiting() {
      const std::lock_guard lock(impl.mutex);
      awaited = 0;
    }

    Awaiting(const Awaiting&) = delete;
    Awaiting& operator=(const Awaiting&) = delete;

    Impl& impl;
    std::uint64_t& awaited;
  };

  Participant participant;
  const v1::ClientId client = randomClient();
  std::uint64_t next_request = 1;
  std::uint64_t next_edit = 1;

  mutable std::mutex mutex;           // guards what follows, down to the writers
  std::condition_variable something;  // for the receiver
  std::condition_variable news;       // for who asks
  bool has_data = false;
  bool stopping = false;
  bool cancelled = false;
  std::uint64_t awaited_request = 0;  // 0: none
  std::uint64_t awaited_edit = 0;
  std::optional<v1::Reply> reply;
  std::optional<v1::EditReply> edit_reply;
  std::optional<v1::Progress> progress;
  std::optional<v1::ServerStatus> status;
  Clock::time_point seen{};

  Writer<v1::Request> requests;
  Writer<v1::Edit> edits;
  // Their listeners touch all of the above: made last, gone first.
  Reader<v1::Reply> replies;
  Reader<v1::EditReply> edit_replies;
  Reader<v1::Progress> progresses;
  Reader<v1::ServerStatus> statuses;
  std::thread receiver;
};

Requester::Requester(const Participant& participant)
    : impl_(std::make_unique<Impl>(participant)) {}

Requester::~Requester() = default;

bool Requester::waitForServer(milliseconds timeout) {
  const Clock::time_point deadline = Clock::now() + timeout;
  std::unique_lock lock(impl_->mutex);
  return impl_->news.wait_until(lock, deadline, [this] {
    return impl_->alive();
  });
}

void Requester::requireServer() {
  if (!waitForServer()) throw impl_->noServer();
  const std::lock_guard lock(impl_->mutex);
  impl_->requireSameVersion();
}

v1::ReplyBody Requester::ask(const v1::RequestBody& body, const OnProgress& on_progress) {
  v1::Request request;
  request.client(impl_->client);
  request.request_id(impl_->next_request++);
  request.protocol_version(v1::PROTOCOL_VERSION);
  request.body(body);
  const std::size_t bytes = v1::Request::getCdrSerializedSize(request);
  if (bytes > kLargestRequest) {
    // The server would drop it, and it would be repeated in silence.
    throw TransportError(
        fmt::format("this would be a request of {:.1f} MiB; the server takes "
                    "at most {} MiB",
                    static_cast<double>(bytes) / kMiB, kLargestRequest / kMiB));
  }
  const Impl::Awaiting awaiting(*impl_, impl_->awaited_request, request.request_id());
  v1::Reply reply = impl_->await(
      impl_->reply, bytes,
      [&] {
        impl_->requests.write(request);
      },
      on_progress);
  if (reply.error() != v1::ERROR_NONE) throw Refused(reply.error(), reply.message());
  return std::move(reply.body());
}

v1::EditReply Requester::edit(std::uint64_t session_id,
                              std::uint64_t base_revision,
                              const v1::EditBody& body) {
  v1::Edit edit;
  edit.client(impl_->client);
  edit.edit_id(impl_->next_edit++);
  edit.session_id(session_id);
  edit.base_revision(base_revision);
  edit.body(body);
  const Impl::Awaiting awaiting(*impl_, impl_->awaited_edit, edit.edit_id());
  const v1::EditReply reply =
      impl_->await(impl_->edit_reply, v1::EditBody::getCdrSerializedSize(body),
                   [&] {
                     impl_->edits.write(edit);
                   },
                   {});
  if (reply.error() != v1::ERROR_NONE) throw Refused(reply.error(), reply.message());
  return reply;
}

void Requester::cancel() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->cancelled = impl_->awaited_request != 0;
  }
  impl_->news.notify_all();
}

v1::ClientId Requester::client() const {
  return impl_->client;
}

v1::ServerStatus Requester::status() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->status.value_or(v1::ServerStatus());
}

}  // namespace handgraft::idl::cyclone
