#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/gateway/gateway.h"
#include "client/gateway/given_files.h"
#include "client/gateway/measured_hands.h"
#include "client/link/following.h"
#include "idl/json.h"

/// The inside of the gateway, for its own sources.
namespace handgraft::client::gateway {

using idl::Json;
using Shared = WebServer::Shared;
using Clock = std::chrono::steady_clock;

inline Shared textOf(const Json& json) {
  return std::make_shared<const std::string>(idl::textOf(json));
}

/// The server's own words, and a code that programs understand.
Json errorJson(const std::exception_ptr& error);
Json errorJson(const char* code, const std::string& message);

struct Gateway::Impl : Audience, std::enable_shared_from_this<Gateway::Impl> {
  struct Page {
    Rights rights = Rights::kLook;
    std::set<std::uint64_t> sessions;
    std::size_t unanswered = 0;
  };

  /// Frames of a motion that was solved anew, as far as they were told.
  struct ToldFrames {
    std::optional<std::uint64_t>
        since;  ///< the revision that they differ from; not known: none
    std::uint64_t revision = 0;
    bool is_last = false;
    std::uint32_t every = 1;  ///< of them, by index, a power of two
    Json frames = Json::array();
  };

  /// A session that pages follow.
  struct Followed {
    std::unique_ptr<Following> following;
    bool ended = false;           ///< its server is not heard any more
    bool closed = false;          ///< somebody ended it
    v1::SessionState state;       ///< as last heard
    std::uint64_t server_id = 0;  ///< that holds it
    Shared state_text;            ///< the same two as they are sent
    Shared pose_text;
    std::string saved;  ///< handgraft-session/1, of `saved_revision`
    std::uint64_t saved_revision = 0;
    bool saving = false;
    Clock::time_point heard = Clock::now();
    ToldFrames told_frames;
    std::map<std::uint64_t, PageId> editors;  ///< by the revisions that they made
  };

  explicit Impl(Client& to) : client(to), measured(to) {}

  // === What pages say

  void joined(PageId page, Rights rights) override;
  void said(PageId page, const std::string& text) override;
  void gave(PageId page, const std::string& frame) override;
  void left(PageId page) override;

  void handle(PageId page, std::uint64_t request, const Json& message);
  void follow(PageId page,
              std::uint64_t request,
              std::uint64_t session,
              bool with_models = false);
  void describeModels(PageId page, std::uint64_t request, const v1::SessionState& state);
  void unfollow(PageId page, std::uint64_t session);
  void ask(PageId page, std::uint64_t request, const Json& body);
  void edit(PageId page, std::uint64_t request, const Json& message);
  void describe(PageId page,
                std::uint64_t request,
                v1::ModelKind kind,
                const std::string& name);
  void load(PageId page, std::uint64_t request, const Json& message);
  void require(PageId page, Rights rights);

  /// Has the server read what a page gave. Another model of that name may be there; then this
  /// one is told apart by its content, as the command line does.
  void sendModel(PageId page,
                 std::uint64_t request,
                 const std::shared_ptr<const FileGroup>& group,
                 const ModelFiles& model,
                 bool is_apart);

  // === What they are told

  void answer(PageId page, std::uint64_t request, const Json& reply);
  void refuse(PageId page, std::uint64_t request, const Json& error);
  void tellAll(const Json& event);
  void tellPages();
  void tellFollowers(std::uint64_t session, const char* kind, const Shared& text);

  // === What sessions publish, on threads of theirs

  Listener listenerFor(std::uint64_t session);
  void onSolution(std::uint64_t session, const v1::PoseSolution& solution);
  void onState(std::uint64_t session, const v1::SessionState& state);
  static void add(ToldFrames& told, const v1::MotionFrame& frame);
  void onFrames(std::uint64_t session, const v1::MotionFrames& frames);
  void onClock(std::uint64_t session, const v1::MotionClock& clock);
  void onEnd(std::uint64_t session, const std::exception_ptr& why);

  // === The server goes and comes

  bool findServer();
  void resume(std::uint64_t session);
  void restore(std::uint64_t session);
  void lose(std::uint64_t session, const std::string& why);
  void moveTo(std::uint64_t session, const v1::SessionState& state, bool is_same);
  void saveWhatRests();
  void tellMeasured();

  /// Has `use` called with the outcome, unless this is gone by then.
  template <class T, class Use>
  void whenDone(Pending<T> pending, Use use) {
    pending.then([weak = weak_from_this(), use = std::move(use)](Outcome<T> outcome) {
      if (const auto self = weak.lock()) use(std::move(outcome));
    });
  }

  Client& client;
  MeasuredHands measured;      ///< of `tend` alone
  std::recursive_mutex mutex;  ///< guards what follows, but for `web` itself
  std::map<PageId, Page> pages;
  std::map<std::uint64_t, Followed> followed;
  std::vector<std::unique_ptr<Following>> past;  ///< to be ended by `tend`, without the lock
  GivenFiles given;
  std::vector<std::function<void()>> work;  ///< for `tend`: what takes longer than pages wait
  bool server_is_heard = true;
  bool ending = false;
  std::unique_ptr<WebServer> web;  ///< last, so that it ends before what it tells
};

}  // namespace handgraft::client::gateway
