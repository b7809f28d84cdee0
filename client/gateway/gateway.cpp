#include "client/gateway/gateway.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <random>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "client/gateway/given_files.h"
#include "client/gateway/measured_hands.h"
#include "client/gateway/model_frame.h"
#include "client/link/following.h"
#include "core/base/error.h"
#include "idl/fields.h"
#include "idl/json.h"

namespace handgraft::client::gateway {

namespace {

using idl::Json;
using Shared = WebServer::Shared;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostUnanswered = 32;                  // requests of a page
constexpr std::size_t kMostFollowed = 16;                    // sessions of a page
constexpr std::chrono::milliseconds kRestBeforeSaving(800);  // nobody waits for it

/// What pages that only look may ask, and what the others may besides. Nothing else.
bool isForLookers(v1::Operation operation) {
  switch (operation) {
    case v1::OP_LIST_MODELS:
    case v1::OP_LIST_SESSIONS:
    case v1::OP_DESCRIBE_SESSION:
    case v1::OP_TRANSFER:
    case v1::OP_EXPORT:
    case v1::OP_SUGGEST:
    case v1::OP_SESSION_SETTINGS:
    case v1::OP_COMPARE:
    case v1::OP_SAVE_SESSION:
    case v1::OP_MOTION_FRAMES:
      return true;
    default:
      return false;
  }
}

bool isForEditors(v1::Operation operation) {
  switch (operation) {
    case v1::OP_OPEN_SESSION:
    case v1::OP_OPTIMIZE:
    case v1::OP_LOAD_SESSION:
    case v1::OP_STOP_SOLVING:
    case v1::OP_SOLVE_MOTION:
    case v1::OP_SET_CLOCK:
      return true;
    default:
      return isForLookers(operation);
  }
}

Shared textOf(const Json& json) {
  return std::make_shared<const std::string>(idl::textOf(json));
}

Json errorJson(const char* code, const std::string& message) {
  return {{"code", code}, {"message", message}};
}

/// The server's own words, and a code that programs understand.
Json errorJson(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const Refused& refused) {
    return errorJson(v1::nameOf(refused.code()), refused.what());
  } catch (const NoServer& none) {
    return errorJson("no_server", none.what());
  } catch (const Cancelled& cancelled) {
    return errorJson("cancelled", cancelled.what());
  } catch (const InvalidInput& invalid) {
    return errorJson("invalid_input", invalid.what());
  } catch (const std::exception& other) {
    return errorJson("internal", other.what());
  }
}

std::uint64_t numberIn(const Json& message, const char* key) {
  const auto found = message.find(key);
  if (found == message.end()) return 0;
  if (!found->is_number_unsigned()) {
    rejectInput("{}: {} is no whole number", key, handgraft::quoted(idl::textOf(*found)));
  }
  return found->get<std::uint64_t>();
}

/// Where in a motion an edit is; nothing: of all of it.
std::optional<v1::EditTime> whenIn(const Json& message) {
  const auto found = message.find("when");
  if (found == message.end() || found->is_null()) return std::nullopt;
  return idl::fromJson<v1::EditTime>(*found, "when");
}

std::string textIn(const Json& message, const char* key) {
  const auto found = message.find(key);
  if (found == message.end() || !found->is_string()) rejectInput("{} is missing", key);
  return found->get<std::string>();
}

/// A frame of bytes: the length of its head in 4 of them, the lowest first; the head; the rest.
std::pair<Json, std::string_view> headAndBytes(const std::string& frame) {
  constexpr std::size_t kLength = 4;
  std::size_t length = 0;
  for (std::size_t i = 0; i < std::min(kLength, frame.size()); ++i)
    length |= std::size_t{static_cast<unsigned char>(frame[i])} << (8 * i);
  if (frame.size() < kLength || length > frame.size() - kLength) {
    rejectInput("a frame of {} bytes has no head", frame.size());
  }
  Json head = Json::parse(frame.substr(kLength, length), nullptr, false);
  if (!head.is_object()) rejectInput("a frame's head is one JSON object");
  return {std::move(head), std::string_view(frame).substr(kLength + length)};
}

bool isConflict(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const Refused& refused) {
    return refused.code() == v1::ERROR_CONFLICT;
  } catch (...) {
    return false;
  }
}

}  // namespace

struct Gateway::Impl : Audience, std::enable_shared_from_this<Gateway::Impl> {
  struct Page {
    Rights rights = Rights::kLook;
    std::set<std::uint64_t> sessions;
    std::size_t unanswered = 0;
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
    std::map<std::uint64_t, PageId> editors;  ///< by the revisions that they made
  };

  explicit Impl(Client& to) : client(to), measured(to) {}

  // === What pages say

  void joined(PageId page, Rights rights) override;
  void said(PageId page, const std::string& text) override;
  void gave(PageId page, const std::string& frame) override;
  void left(PageId page) override;

  void heed(PageId page, std::uint64_t request, const Json& message);
  void follow(PageId page, std::uint64_t request, std::uint64_t session);
  void unfollow(PageId page, std::uint64_t session);
  void ask(PageId page, std::uint64_t request, const Json& body);
  void edit(PageId page, std::uint64_t request, const Json& message);
  void describe(PageId page, std::uint64_t request, const Json& message);
  void load(PageId page, std::uint64_t request, const Json& message);
  void require(PageId page, Rights rights);

  /// Has the server read what a page gave. Another model of that name may be there; then this
  /// one is told apart by its content, as the command line does.
  void sendModel(PageId page,
                 std::uint64_t request,
                 const std::shared_ptr<const Gift>& gift,
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

// === What pages say

void Gateway::Impl::joined(PageId page, Rights rights) {
  const std::lock_guard lock(mutex);
  pages[page].rights = rights;
  web->send(page, textOf({{"event", "welcome"},
                          {"page", page},
                          {"may_edit", rights == Rights::kEdit},
                          {"server_is_heard", server_is_heard}}));
  tellPages();
}

void Gateway::Impl::left(PageId page) {
  const std::lock_guard lock(mutex);
  const std::set<std::uint64_t> sessions = pages[page].sessions;
  for (const std::uint64_t session : sessions)
    unfollow(page, session);
  given.drop(page);
  pages.erase(page);
  tellPages();
}

void Gateway::Impl::gave(PageId page, const std::string& frame) {
  std::uint64_t request = 0;
  try {
    const auto [head, bytes] = headAndBytes(frame);
    request = numberIn(head, "id");
    if (textIn(head, "do") != "put") rejectInput("frames of bytes are parts of files: put");
    require(page, Rights::kEdit);
    const std::lock_guard lock(mutex);
    given.put(page, {numberIn(head, "gift"), textIn(head, "path"),
                     numberIn(head, "total_bytes"), numberIn(head, "offset"), bytes});
    web->send(page, textOf({{"reply", request}}));
  } catch (...) {
    refuse(page, request, errorJson(std::current_exception()));
  }
}

void Gateway::Impl::said(PageId page, const std::string& text) {
  std::uint64_t request = 0;
  try {
    const Json message = Json::parse(text, nullptr, false);
    if (!message.is_object()) rejectInput("a message is one JSON object");
    request = numberIn(message, "id");
    heed(page, request, message);
  } catch (...) {
    refuse(page, request, errorJson(std::current_exception()));
  }
}

void Gateway::Impl::heed(PageId page, std::uint64_t request, const Json& message) {
  const std::string what = textIn(message, "do");
  if (what == "follow") return follow(page, request, numberIn(message, "session"));
  if (what == "ping") return web->send(page, textOf({{"reply", request}}));
  if (what == "drop") {
    const std::lock_guard lock(mutex);
    given.drop(page, numberIn(message, "gift"));
    return web->send(page, textOf({{"reply", request}}));
  }
  {
    const std::lock_guard lock(mutex);
    if (pages[page].unanswered >= kMostUnanswered) {
      return web->send(
          page, textOf({{"reply", request},
                        {"error", errorJson("overloaded", "too many requests at once")}}));
    }
    ++pages[page].unanswered;
  }
  try {
    const auto body = message.find("body");
    if (what == "describe") return describe(page, request, message);
    if (what == "load") return load(page, request, message);
    if (what == "ask" && body != message.end()) return ask(page, request, *body);
    if (what == "edit" && body != message.end()) return edit(page, request, message);
    rejectInput(
        "do: {}: it must be follow, ping, describe, load, drop, ask or edit, the last two with "
        "a "
        "body",
        handgraft::quoted(what));
  } catch (...) {
    const std::lock_guard lock(mutex);
    --pages[page].unanswered;
    throw;
  }
}

void Gateway::Impl::require(PageId page, Rights rights) {
  const std::lock_guard lock(mutex);
  if (rights == Rights::kEdit && pages[page].rights != Rights::kEdit) {
    throw Refused(v1::ERROR_NOT_PERMITTED, "this link is for looking");
  }
}

void Gateway::Impl::follow(PageId page, std::uint64_t request, std::uint64_t session) {
  {
    const std::lock_guard lock(mutex);
    if (pages[page].sessions.size() >= kMostFollowed) {
      throw Refused(v1::ERROR_OVERLOADED,
                    fmt::format("a page follows at most {} sessions", kMostFollowed));
    }
    ++pages[page].unanswered;
  }
  // It is known to exist before anybody listens.
  whenDone(client.describeSession(session), [this, page, request,
                                             session](Outcome<v1::SessionState> outcome) {
    const std::lock_guard lock(mutex);
    if (const auto* error = std::get_if<std::exception_ptr>(&outcome)) {
      if (pages.contains(page)) --pages[page].unanswered;
      return refuse(page, request, errorJson(*error));
    }
    if (ending || !pages.contains(page)) return;
    Followed& one = followed[session];
    if (one.state_text == nullptr) one.state = std::get<v1::SessionState>(outcome);
    if (one.following == nullptr) {
      one.server_id = client.status().server_id();
      one.following = std::make_unique<Following>(client, session, listenerFor(session));
    }
    pages[page].sessions.insert(session);
    answer(page, request, {{"session", idl::jsonOf(std::get<v1::SessionState>(outcome))}});
    if (one.state_text) web->sendLatest(page, fmt::format("state {}", session), one.state_text);
    if (one.pose_text) web->sendLatest(page, fmt::format("pose {}", session), one.pose_text);
    tellPages();
  });
}

void Gateway::Impl::unfollow(PageId page, std::uint64_t session) {
  pages[page].sessions.erase(session);
  for (const auto& [id, other] : pages)
    if (other.sessions.contains(session)) return;
  const auto found = followed.find(session);
  if (found == followed.end()) return;
  past.push_back(std::move(found->second.following));
  followed.erase(found);
}

void Gateway::Impl::ask(PageId page, std::uint64_t request, const Json& body) {
  const auto message = idl::fromJson<v1::RequestBody>(body, "body");
  if (!isForEditors(message._d())) {
    throw Refused(v1::ERROR_NOT_PERMITTED,
                  fmt::format("pages may not ask for {}", v1::nameOf(message._d())));
  }
  if (!isForLookers(message._d())) require(page, Rights::kEdit);
  whenDone(client.ask(message), [this, page, request](Outcome<v1::ReplyBody> outcome) {
    if (const auto* error = std::get_if<std::exception_ptr>(&outcome)) {
      answer(page, request, {{"error", errorJson(*error)}});
    } else {
      answer(page, request, {{"body", idl::jsonOf(std::get<v1::ReplyBody>(outcome))}});
    }
  });
}

void Gateway::Impl::edit(PageId page, std::uint64_t request, const Json& message) {
  require(page, Rights::kEdit);
  const std::uint64_t session = numberIn(message, "session");
  const auto body = idl::fromJson<v1::EditBody>(message.at("body"), "body");
  whenDone(
      client.edit(session, numberIn(message, "base_revision"), body, whenIn(message)),
      [this, page, request, session](Outcome<v1::EditReply> outcome) {
        if (const auto* error = std::get_if<std::exception_ptr>(&outcome)) {
          return answer(page, request, {{"error", errorJson(*error)}});
        }
        const auto& reply = std::get<v1::EditReply>(outcome);
        answer(page, request, {{"revision", reply.revision()}, {"message", reply.message()}});
        const std::lock_guard lock(mutex);
        const auto found = followed.find(session);
        if (found == followed.end()) return;
        found->second.editors[reply.revision()] = page;
        while (found->second.editors.size() > kMostUnanswered)
          found->second.editors.erase(found->second.editors.begin());
        tellFollowers(session, "edited",
                      textOf({{"event", "edited"},
                              {"session", session},
                              {"revision", reply.revision()},
                              {"page", page}}));
      });
}

void Gateway::Impl::describe(PageId page, std::uint64_t request, const Json& message) {
  const auto kind = v1::enumeratorFrom<v1::ModelKind>(textIn(message, "kind"), "kind");
  whenDone(client.describe(kind, textIn(message, "name"), true),
           [this, page, request](Outcome<v1::ModelDescription> outcome) {
             if (const auto* error = std::get_if<std::exception_ptr>(&outcome)) {
               return answer(page, request, {{"error", errorJson(*error)}});
             }
             {
               const std::lock_guard lock(mutex);
               if (!pages.contains(page)) return;
               --pages[page].unanswered;
             }
             web->sendBytes(page, std::make_shared<const std::string>(modelFrame(
                                      static_cast<std::uint32_t>(request),
                                      std::get<v1::ModelDescription>(std::move(outcome)))));
           });
}

void Gateway::Impl::load(PageId page, std::uint64_t request, const Json& message) {
  require(page, Rights::kEdit);
  const auto kind = v1::enumeratorFrom<v1::ModelKind>(textIn(message, "kind"), "kind");
  std::shared_ptr<const Gift> gift;
  {
    const std::lock_guard lock(mutex);
    gift = given.find(page, numberIn(message, "gift"));
  }
  sendModel(page, request, gift,
            gift->model(kind, textIn(message, "main"), textIn(message, "object"),
                        textIn(message, "units")),
            false);
}

void Gateway::Impl::sendModel(PageId page,
                              std::uint64_t request,
                              const std::shared_ptr<const Gift>& gift,
                              const ModelFiles& model,
                              bool is_apart) {
  whenDone(client.load(model),
           [this, page, request, gift, model, is_apart](Outcome<v1::ModelSummary> outcome) {
             if (const auto* summary = std::get_if<v1::ModelSummary>(&outcome)) {
               return answer(page, request, {{"model", idl::jsonOf(*summary)}});
             }
             const auto& error = std::get<std::exception_ptr>(outcome);
             if (is_apart || !isConflict(error)) {
               Json told = errorJson(error);
               told["message"] = gift->inPagesWords(told["message"]);
               return answer(page, request, {{"error", told}});
             }
             const std::lock_guard lock(mutex);
             work.push_back([this, page, request, gift, model] {
               try {
                 ModelFiles apart = model;
                 apart.name = nameApart(model);
                 sendModel(page, request, gift, apart, true);
               } catch (...) {
                 answer(page, request, {{"error", errorJson(std::current_exception())}});
               }
             });
           });
}

// === What they are told

void Gateway::Impl::answer(PageId page, std::uint64_t request, const Json& reply) {
  const std::lock_guard lock(mutex);
  const auto found = pages.find(page);
  if (found == pages.end()) return;
  --found->second.unanswered;
  Json message = {{"reply", request}};
  message.update(reply);
  web->send(page, textOf(message));
}

void Gateway::Impl::refuse(PageId page, std::uint64_t request, const Json& error) {
  web->send(page, textOf({{"reply", request}, {"error", error}}));
}

void Gateway::Impl::tellAll(const Json& event) {
  const Shared text = textOf(event);
  for (const auto& [page, one] : pages)
    web->send(page, text);
}

void Gateway::Impl::tellPages() {
  Json list = Json::array();
  for (const auto& [page, one] : pages) {
    list.push_back({{"page", page},
                    {"may_edit", one.rights == Rights::kEdit},
                    {"sessions", one.sessions}});
  }
  const Shared text = textOf({{"event", "pages"}, {"pages", list}});
  for (const auto& [page, one] : pages)
    web->sendLatest(page, "pages", text);
}

void Gateway::Impl::tellFollowers(std::uint64_t session, const char* kind, const Shared& text) {
  const std::string key = fmt::format("{} {}", kind, session);
  for (const auto& [page, one] : pages)
    if (one.sessions.contains(session)) web->sendLatest(page, key, text);
}

// === What sessions publish

Listener Gateway::Impl::listenerFor(std::uint64_t session) {
  Listener listener;
  listener.on_solution = [this, session](const v1::PoseSolution& solution) {
    onSolution(session, solution);
  };
  listener.on_state = [this, session](const v1::SessionState& state) {
    onState(session, state);
  };
  listener.on_clock = [this, session](const v1::MotionClock& clock) {
    onClock(session, clock);
  };
  listener.on_end = [this, session](const std::exception_ptr& why) {
    onEnd(session, why);
  };
  return listener;
}

void Gateway::Impl::onSolution(std::uint64_t session, const v1::PoseSolution& solution) {
  if (!solution.is_final()) return;  // poses on the way do not say where the links are
  const Shared text =
      textOf({{"event", "pose"}, {"session", session}, {"solution", idl::jsonOf(solution)}});
  const std::lock_guard lock(mutex);
  const auto found = followed.find(session);
  if (found == followed.end()) return;
  found->second.pose_text = text;
  found->second.heard = Clock::now();
  tellFollowers(session, "pose", text);
}

void Gateway::Impl::onClock(std::uint64_t session, const v1::MotionClock& clock) {
  // How old it is when it is read is told apart from the clocks of other machines.
  const double age_s =
      1e-9 * static_cast<double>(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                     std::chrono::system_clock::now().time_since_epoch())
                                     .count() -
                                 clock.stamp_ns());
  const Shared text = textOf({{"event", "clock"},
                              {"session", session},
                              {"age_s", std::max(0.0, age_s)},
                              {"clock", idl::jsonOf(clock)}});
  const std::lock_guard lock(mutex);
  if (followed.find(session) == followed.end()) return;
  tellFollowers(session, "clock", text);
}

void Gateway::Impl::onState(std::uint64_t session, const v1::SessionState& state) {
  const std::lock_guard lock(mutex);
  const auto found = followed.find(session);
  if (found == followed.end()) return;
  Followed& one = found->second;
  const auto editor = one.editors.find(state.revision());
  one.state = state;
  one.closed = state.phase() == v1::PHASE_CLOSED;
  one.heard = Clock::now();
  one.state_text = textOf({{"event", "state"},
                           {"session", session},
                           {"state", idl::jsonOf(state)},
                           {"is_ours", state.last_client() == client.id()},
                           {"page", editor == one.editors.end() ? 0 : editor->second}});
  tellFollowers(session, "state", one.state_text);
}

void Gateway::Impl::onEnd(std::uint64_t session, const std::exception_ptr& why) {
  const std::lock_guard lock(mutex);
  const auto found = followed.find(session);
  if (found == followed.end()) return;
  if (why == nullptr) {
    found->second.closed = true;
  } else {
    found->second.ended = true;
  }
}

// === The server goes and comes

bool Gateway::Impl::findServer() {
  if (client.alive()) {
    const std::lock_guard lock(mutex);
    if (!std::exchange(server_is_heard, true))
      tellAll({{"event", "server"}, {"is_heard", true}});
    return true;
  }
  {
    const std::lock_guard lock(mutex);
    if (std::exchange(server_is_heard, false))
      tellAll({{"event", "server"}, {"is_heard", false}});
  }
  try {
    client.rejoin();
  } catch (const std::exception&) {
    return false;  // the next time, perhaps
  }
  return client.alive() && findServer();
}

/// The session again, on the server that is there now.
void Gateway::Impl::resume(std::uint64_t session) {
  whenDone(client.describeSession(session), [this, session](Outcome<v1::SessionState> outcome) {
    const std::lock_guard lock(mutex);
    const auto found = followed.find(session);
    if (found == followed.end()) return;
    if (!client.alive()) {
      found->second.ended = true;  // tried again when one is heard
      return;
    }
    if (const auto* state = std::get_if<v1::SessionState>(&outcome)) {
      const v1::SessionState& was = found->second.state;
      const bool is_same = state->hand() == was.hand() && state->object() == was.object() &&
                           state->contacts() == was.contacts() &&
                           state->revision() >= was.revision();
      if (is_same) return moveTo(session, *state, true);
    }
    if (client.status().server_id() == found->second.server_id) {
      return lose(session, "the session has been closed");
    }
    restore(session);
  });
}

void Gateway::Impl::lose(std::uint64_t session, const std::string& why) {
  followed[session].closed = true;
  tellAll({{"event", "lost"}, {"session", session}, {"message", why}});
}

void Gateway::Impl::restore(std::uint64_t session) {
  const auto found = followed.find(session);
  if (found->second.saved.empty()) return lose(session, "the session ended with its server");
  whenDone(client.loadSession(found->second.saved),
           [this, session](Outcome<v1::SessionState> outcome) {
             const std::lock_guard lock(mutex);
             if (!followed.contains(session)) return;
             if (const auto* error = std::get_if<std::exception_ptr>(&outcome)) {
               const Json reason = errorJson(*error);
               if (reason["code"] != "no_server") return lose(session, reason["message"]);
               followed[session].ended = true;  // tried again when one is heard
               return;
             }
             const auto& state = std::get<v1::SessionState>(outcome);
             v1::OptimizeRequest request;
             request.session_id(state.session_id());
             client.optimize(request);  // its pose comes by the stream
             moveTo(session, state, false);
           });
}

/// Its pages follow that one from now on.
void Gateway::Impl::moveTo(std::uint64_t session, const v1::SessionState& state, bool is_same) {
  auto node = followed.extract(session);
  Followed& one = node.mapped();
  past.push_back(std::move(one.following));
  const std::uint64_t now = state.session_id();
  one.ended = false;
  one.state = state;
  one.saved_revision = 0;
  one.editors.clear();
  if (!is_same) one.pose_text = one.state_text = nullptr;
  one.server_id = client.status().server_id();
  one.following = std::make_unique<Following>(client, now, listenerFor(now));
  node.key() = now;
  if (const auto other = followed.find(now); other != followed.end()) {
    past.push_back(std::move(other->second.following));
    followed.erase(other);
  }
  followed.insert(std::move(node));
  for (auto& [page, its] : pages) {
    if (its.sessions.erase(session) == 0) continue;
    its.sessions.insert(now);
    web->send(page, textOf({{"event", "moved"}, {"from", session}, {"to", now}}));
  }
}

/// Sessions are saved while nobody edits them, so that a server that dies takes little along.
void Gateway::Impl::saveWhatRests() {
  const std::lock_guard lock(mutex);
  for (auto& [session, one] : followed) {
    const bool is_saved = !one.saved.empty() && one.saved_revision == one.state.revision();
    if (is_saved || one.saving || one.ended || one.closed ||
        one.state.phase() != v1::PHASE_READY || Clock::now() - one.heard < kRestBeforeSaving)
      continue;
    one.saving = true;
    whenDone(client.saveSession(session),
             [this, session = session,
              revision = one.state.revision()](Outcome<std::string> outcome) {
               const std::lock_guard inner(mutex);
               const auto found = followed.find(session);
               if (found == followed.end()) return;
               found->second.saving = false;
               if (auto* text = std::get_if<std::string>(&outcome)) {
                 found->second.saved = std::move(*text);
                 found->second.saved_revision = revision;
               } else {
                 found->second.heard = Clock::now();  // not again at once
               }
             });
  }
}

/// Where the hands are that follow a session, as they say themselves.
void Gateway::Impl::tellMeasured() {
  {
    const std::lock_guard lock(mutex);
    if (followed.empty()) return measured.rest();
  }
  measured.take([this](const v1::JointState& state) {
    Json names = Json::array();
    Json positions = Json::array();
    for (std::size_t i = 0; i < std::min(state.names().size(), state.position_rad().size());
         ++i) {
      if (!std::isfinite(state.position_rad()[i])) continue;  // not measured
      names.push_back(state.names()[i]);
      positions.push_back(state.position_rad()[i]);
    }
    const Shared text = textOf({{"event", "measured"},
                                {"session", state.session_id()},
                                {"bridge", state.bridge_id()},
                                {"names", names},
                                {"positions", positions}});
    const std::lock_guard lock(mutex);
    tellFollowers(state.session_id(), "measured", text);
  });
}

// === The gateway

Gateway::Gateway(Client& client, const WebOptions& options, WebFiles files)
    : impl_(std::make_shared<Impl>(client)) {
  const std::lock_guard lock(impl_->mutex);  // nobody is heeded before there is a web server
  impl_->web = std::make_unique<WebServer>(options, std::move(files), *impl_);
}

Gateway::~Gateway() {
  std::map<std::uint64_t, Impl::Followed> followed;
  std::vector<std::unique_ptr<Following>> past;
  // Their threads end without the lock, which they may be waiting for.
  const std::lock_guard lock(impl_->mutex);
  impl_->ending = true;
  followed.swap(impl_->followed);
  past.swap(impl_->past);
  impl_->work.clear();
}

std::uint16_t Gateway::port() const {
  return impl_->web->port();
}

void Gateway::tend() {
  std::vector<std::unique_ptr<Following>> past;
  {
    const std::lock_guard lock(impl_->mutex);
    past.swap(impl_->past);
  }
  past.clear();
  std::vector<std::function<void()>> work;
  {
    const std::lock_guard lock(impl_->mutex);
    work.swap(impl_->work);
  }
  for (const auto& step : work)
    step();
  try {
    impl_->tellMeasured();
  } catch (const TransportError&) {
    impl_->measured.rest();  // looked for again
  }
  if (!impl_->findServer()) return;
  std::vector<std::uint64_t> ended;
  {
    const std::lock_guard lock(impl_->mutex);
    for (auto& [session, one] : impl_->followed) {
      if (!one.closed && std::exchange(one.ended, false)) ended.push_back(session);
    }
  }
  for (const std::uint64_t session : ended)
    impl_->resume(session);
  impl_->saveWhatRests();
}

std::string addressOf(const WebOptions& options, std::uint16_t port) {
  std::string host = options.address;
  if (host == "0.0.0.0" || host == "::") {
    std::array<char, 256> name{};  // of this machine, by which others reach it
    if (gethostname(name.data(), name.size() - 1) == 0) host = name.data();
  }
  const bool is_v6 = host.find(':') != std::string::npos;
  return fmt::format("http://{}{}{}:{}/", is_v6 ? "[" : "", host, is_v6 ? "]" : "", port);
}

std::string randomToken() {
  std::random_device device;
  std::string token;
  for (int i = 0; i < 4; ++i)
    token += fmt::format("{:08x}", device());
  return token;
}

}  // namespace handgraft::client::gateway
