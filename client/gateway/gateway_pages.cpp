// What pages say becomes requests and edits, and what they are told.
#include <algorithm>
#include <optional>
#include <string_view>

#include <nlohmann/json.hpp>

#include "client/gateway/gateway_impl.h"
#include "client/gateway/model_frame.h"
#include "core/base/error.h"
#include "idl/fields.h"
#include "idl/operations.h"

namespace handgraft::client::gateway {

namespace {

constexpr std::size_t kMostUnanswered = 32;  // requests of a page
constexpr std::size_t kMostFollowed = 16;    // sessions of a page

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
  const auto when = idl::fromJson<v1::EditTime>(*found, "when");
  idl::requireWhole(idl::typeOf<v1::EditTime>(), *found, "when");
  return when;
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
    given.put(page, {numberIn(head, "group"), textIn(head, "path"),
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
    handle(page, request, message);
  } catch (...) {
    refuse(page, request, errorJson(std::current_exception()));
  }
}

void Gateway::Impl::handle(PageId page, std::uint64_t request, const Json& message) {
  const std::string what = textIn(message, "do");
  if (what == "follow" || what == "show")
    return follow(page, request, numberIn(message, "session"), what == "show");
  if (what == "unfollow") {
    const std::lock_guard lock(mutex);
    unfollow(page, numberIn(message, "session"));
    tellPages();
    return web->send(page, textOf({{"reply", request}}));
  }
  if (what == "ping") return web->send(page, textOf({{"reply", request}}));
  if (what == "drop") {
    const std::lock_guard lock(mutex);
    given.drop(page, numberIn(message, "group"));
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
    if (what == "describe") {
      const auto kind = v1::enumeratorFrom<v1::ModelKind>(textIn(message, "kind"), "kind");
      return describe(page, request, kind, textIn(message, "name"));
    }
    if (what == "load") return load(page, request, message);
    if (what == "ask" && body != message.end()) return ask(page, request, *body);
    if (what == "edit" && body != message.end()) return edit(page, request, message);
    rejectInput(
        "do: {}: it must be follow, show, unfollow, ping, describe, load, drop, ask or edit, "
        "the last two with a body",
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

void Gateway::Impl::follow(PageId page,
                           std::uint64_t request,
                           std::uint64_t session,
                           bool with_models) {
  {
    const std::lock_guard lock(mutex);
    if (pages[page].sessions.size() >= kMostFollowed) {
      throw Refused(v1::ERROR_OVERLOADED,
                    fmt::format("a page follows at most {} sessions", kMostFollowed));
    }
    ++pages[page].unanswered;
  }
  // It is known to exist before anybody listens.
  whenDone(client.describeSession(session), [this, page, request, session,
                                             with_models](Outcome<v1::SessionState> outcome) {
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
    if (with_models) describeModels(page, request, std::get<v1::SessionState>(outcome));
  });
}

/// What a session's picture takes, under the numbers behind the request's.
void Gateway::Impl::describeModels(PageId page,
                                   std::uint64_t request,
                                   const v1::SessionState& state) {
  const bool is_of_motion = !state.motion().empty();
  pages[page].unanswered += 3;
  describe(page, request + 1, v1::MODEL_HAND, state.hand());
  describe(page, request + 2, v1::MODEL_OBJECT, state.object());
  describe(page, request + 3, is_of_motion ? v1::MODEL_MOTION : v1::MODEL_CONTACTS,
           is_of_motion ? state.motion() : state.contacts());
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
  const idl::Pages pages = idl::traitsOf(message._d()).pages;
  if (pages == idl::Pages::kNone) {
    throw Refused(v1::ERROR_NOT_PERMITTED,
                  fmt::format("pages may not ask for {}", v1::nameOf(message._d())));
  }
  if (pages == idl::Pages::kThatEdit) require(page, Rights::kEdit);
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
  idl::requireWhole(idl::typeOf<v1::EditBody>(), message.at("body"), "body");
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

void Gateway::Impl::describe(PageId page,
                             std::uint64_t request,
                             v1::ModelKind kind,
                             const std::string& name) {
  whenDone(client.describe(kind, name, true),
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
  std::shared_ptr<const FileGroup> group;
  {
    const std::lock_guard lock(mutex);
    group = given.find(page, numberIn(message, "group"));
  }
  sendModel(page, request, group,
            group->model(kind, textIn(message, "main"), textIn(message, "object"),
                         textIn(message, "units")),
            false);
}

void Gateway::Impl::sendModel(PageId page,
                              std::uint64_t request,
                              const std::shared_ptr<const FileGroup>& group,
                              const ModelFiles& model,
                              bool is_apart) {
  whenDone(client.load(model),
           [this, page, request, group, model, is_apart](Outcome<v1::ModelSummary> outcome) {
             if (const auto* summary = std::get_if<v1::ModelSummary>(&outcome)) {
               return answer(page, request, {{"model", idl::jsonOf(*summary)}});
             }
             const auto& error = std::get<std::exception_ptr>(outcome);
             if (is_apart || !isConflict(error)) {
               Json told = errorJson(error);
               told["message"] = group->inPagesWords(told["message"]);
               return answer(page, request, {{"error", told}});
             }
             const std::lock_guard lock(mutex);
             work.push_back([this, page, request, group, model] {
               try {
                 ModelFiles apart = model;
                 apart.name = nameApart(model);
                 sendModel(page, request, group, apart, true);
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

}  // namespace handgraft::client::gateway
