#include "client/gateway/page_file.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "client/gateway/model_frame.h"
#include "client/link/session.h"
#include "core/base/base64.h"
#include "core/base/error.h"
#include "idl/json.h"

namespace handgraft::client::gateway {

namespace {

constexpr const char* kStyle = R"(<link rel="stylesheet" href="page.css" />)";
constexpr const char* kEarly = R"(<script src="early.js" async></script>)";
constexpr const char* kScript = R"(<script type="module" src="page.js"></script>)";

// Of what the file holds, and of nothing else.
constexpr const char* kFilePolicy =
    R"(<meta http-equiv="Content-Security-Policy" content="default-src 'none'; )"
    R"(script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:" />)";

void replaceAll(std::string& text, std::string_view what, std::string_view by) {
  for (std::size_t at = text.find(what); at != std::string::npos;
       at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
}

/// The one place where the page names a file of its own.
void inlineFile(std::string& page, std::string_view tag, const std::string& instead) {
  const std::size_t at = page.find(tag);
  if (at == std::string::npos) rejectInput("the page in {} is another one", "share/handgraft");
  page.replace(at, tag.size(), instead);
}

const std::string& fileOf(const WebFiles& files, std::string_view path) {
  const auto found = files.find(path);
  if (found == files.end()) rejectInput("the page has no {}", path);
  return found->second.bytes;
}

/// Of longer motions every second, third, ... frame, as the page itself shows them.
constexpr std::uint32_t kMostFrames = 600;
constexpr std::uint32_t kAtOnce = 60;

v1::MotionFrames framesShown(Client& client, std::uint64_t session_id) {
  v1::MotionFramesRequest request;
  request.session_id(session_id);
  request.count(1);
  request.with_shapes(false);
  const std::uint32_t count = client.motionFrames(request).get().frame_count();
  request.count(kAtOnce);
  request.every(std::max<std::uint32_t>(1, (count + kMostFrames - 1) / kMostFrames));
  request.with_shapes(true);
  v1::MotionFrames all = client.motionFrames(request).get();
  while (all.frames().size() * request.every() < count) {
    request.first(static_cast<std::uint32_t>(all.frames().size()) * request.every());
    v1::MotionFrames more = client.motionFrames(request).get();
    if (more.frames().empty() || more.revision() != all.revision())
      rejectInput("session {}: its motion was solved anew while it was read", session_id);
    std::move(more.frames().begin(), more.frames().end(), std::back_inserter(all.frames()));
  }
  return all;
}

}  // namespace

std::string pageFile(Client& client, std::uint64_t session_id, const WebFiles& files) {
  const v1::SessionState state = client.describeSession(session_id).get();
  Session session(client, state);
  const auto model_of = [&](v1::ModelKind kind, const std::string& name) {
    return base64Of(modelFrame(0, client.describe(kind, name, true).get()));
  };
  idl::Json data = {{"state", idl::jsonOf(state)},
                    {"settings", idl::jsonOf(session.settings().get())},
                    {"models",
                     {{"hand", model_of(v1::MODEL_HAND, state.hand())},
                      {"object", model_of(v1::MODEL_OBJECT, state.object())}}}};
  if (!state.motion().empty()) {
    data["models"]["motion"] = model_of(v1::MODEL_MOTION, state.motion());
    data["solution"] = nullptr;
    data["motion_frames"] = idl::jsonOf(framesShown(client, session_id));
  } else {
    const v1::PoseSolution* solution = session.joinedSolution();
    if (solution == nullptr) rejectInput("session {} has no pose yet", session_id);
    data["models"]["contacts"] = model_of(v1::MODEL_CONTACTS, state.contacts());
    data["solution"] = idl::jsonOf(*solution);
    data["transfer"] = idl::jsonOf(session.transfer().get());
  }
  // Neither ends the element that it stands in.
  std::string text = idl::textOf(data);
  replaceAll(text, "<", "\\u003c");
  std::string script = fileOf(files, "/page.js");
  replaceAll(script, "</script", "<\\/script");

  std::string page = fileOf(files, "/");
  inlineFile(page, kStyle, kFilePolicy + ("<style>" + fileOf(files, "/page.css") + "</style>"));
  inlineFile(page, kEarly, "");  // there is no connection to open
  inlineFile(page, kScript,
             R"(<script type="application/json" id="handgraft-data">)" + text +
                 "</script>\n<script type=\"module\">" + script + "</script>");
  return page;
}

}  // namespace handgraft::client::gateway
