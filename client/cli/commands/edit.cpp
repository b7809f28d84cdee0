#include <cerrno>
#include <cstdio>
#include <system_error>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include "client/cli/commands/commands.h"
#include "client/cli/commands/grasp_session.h"
#include "client/editor/editor.h"
#include "client/editor/prompt.h"
#include "client/link/client.h"
#include "client/link/session_id.h"
#include "client/present/failure.h"
#include "client/present/interactive_client.h"
#include "client/present/json_output.h"
#include "client/present/progress_line.h"
#include "client/present/send_model.h"
#include "client/present/text_output.h"
#include "core/base/error.h"
#include "core/base/progress.h"

namespace handgraft::client {

namespace {

using editor::Editor;
using editor::Sink;

// Lines of a script or a pipe. Looks up while nothing comes, so that Ctrl-C counts.
class LineReader {
 public:
  /// Errors: InvalidInput if the file cannot be read.
  LineReader(const std::filesystem::path& file, Interruption& interruption)
      : interruption_(interruption),
        fd_(file.empty() ? STDIN_FILENO : open(file.c_str(), O_RDONLY | O_CLOEXEC)) {
    std::error_code error;
    if (std::filesystem::is_directory(file, error)) {
      rejectInput("--script {}: that is a folder", quoted(file.string()));
    }
    if (fd_ < 0)
      rejectInput("{}: cannot be read ({})", quoted(file.string()),
                  std::generic_category().message(errno));
  }

  ~LineReader() {
    if (fd_ != STDIN_FILENO) close(fd_);
  }

  LineReader(const LineReader&) = delete;
  LineReader& operator=(const LineReader&) = delete;

  std::optional<std::string> next() {
    constexpr int kLookMs = 50;
    constexpr std::size_t kChunk = 4096;
    while (true) {
      if (const std::size_t end = read_.find('\n'); end != std::string::npos) {
        std::string line = read_.substr(0, end);
        read_.erase(0, end + 1);
        return line;
      }
      if (ended_) {
        if (read_.empty()) return std::nullopt;
        return std::exchange(read_, "");
      }
      interruption_.checkpoint();
      pollfd input{fd_, POLLIN, 0};
      if (poll(&input, 1, kLookMs) <= 0) continue;
      char bytes[kChunk];
      const ssize_t count = read(fd_, bytes, sizeof bytes);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) {
        ended_ = true;
      } else {
        read_.append(bytes, static_cast<std::size_t>(count));
      }
    }
  }

 private:
  Interruption& interruption_;
  int fd_;
  std::string read_;
  bool ended_ = false;
};

// A failure at the prompt is told, and the prompt comes again; also where the server is gone,
// since another one may come and load what was saved.
void runTyped(Editor& editor, const Sink& sink, const std::string& line) {
  try {
    editor.run(line);
  } catch (const std::exception& error) {
    if (!sink.isJson()) sink.failed(line, failureOf(error));
  }
}

void converse(Editor& editor, const Sink& sink, Interruption& interruption) {
  const auto complete = [&](const editor::Words& words, const std::string& prefix) {
    return editor::completions(words, prefix, editor.session().allNames());
  };
  const auto explain = [&](const editor::Words& words) {
    const std::string text = editor::helpFor(words, editor.session().allNames());
    return text.empty() ? std::string("no command begins like this\n") : text;
  };
  const auto news = [&] {
    return editor.session().news();
  };
  const auto shown = [&] {
    return fmt::format("{} {}> ", text::plain(editor.session().state().hand()),
                       editor.session().shownRevision());
  };
  // Programs read standard output.
  editor::Prompt prompt({complete, explain, news, shown}, interruption, editor::historyFile(),
                        sink.isJson() ? stderr : stdout);
  editor.showPosesAtOnce();
  sink.note("help lists the commands, Tab completes, ? explains, Ctrl-D leaves");
  while (!editor.finished() && !interruption.terminated()) {
    interruption.reset();
    const auto input = prompt.readLine();
    if (input.end == editor::Prompt::End::kEnd) break;
    if (input.end == editor::Prompt::End::kInterrupted) continue;
    runTyped(editor, sink, input.line);
  }
}

// Ctrl-C leaves the session as it was opened.
void solveFirst(Editor& editor,
                const Sink& sink,
                const GraspOptions& options,
                Interruption& interruption) {
  try {
    sink.done("solve", editor.solve(solvingOf(options)));
  } catch (const Cancelled&) {
    if (interruption.terminated()) throw;
    interruption.reset();
    sink.note("cancelled: the session is open and not solved");
  }
}

// What becomes of the session, and how to go on in it or to end it.
std::string farewell(const Client& server,
                     const editor::EditedSession& session,
                     const Network& network) {
  const std::uint64_t id = session.id();
  if (session.hasEnded()) return fmt::format("session {} has ended with its server", id);
  if (server.isPrivate())
    return fmt::format("session {} ends with the server that this command started", id);
  const std::string there = text::networkOptions(network);
  if (!server.alive()) {
    return fmt::format(
        "the server does not answer; started again on what it kept, it has the session still: "
        "handgraft edit {}{}",
        id, there);
  }
  return fmt::format(
      "session {0} stays open: handgraft edit {0}{1} (handgraft close {0}{1} ends it)", id,
      there);
}

}  // namespace

int run(const EditOptions& options, const CommonOptions& common, Interruption& interruption) {
  // === Everything that can be wrong before a server is asked
  const bool opens = options.session_id == 0;
  GraspInputs inputs;
  if (opens) inputs = collectInputs(options.grasp);
  const bool typed = options.script.empty() && isatty(STDIN_FILENO) != 0;
  LineReader lines(options.script, interruption);

  ProgressLine progress;
  Client server(interactiveClient(
      common.network, opens ? Absence::kStartShared : Absence::kFail, interruption, &progress));
  const Sink sink(common.json ? Sink::Form::kJson : Sink::Form::kText, progress);

  // === The session
  v1::SessionState state;
  if (opens) {
    v1::OpenSessionRequest request = sessionRequest(options.grasp);
    ModelSender sender(server, interruption, typed && !common.json);
    state = openSession(server, sender, options.grasp, inputs, request);
  } else {
    state = server.describeSession(sessionMeant(server, options.session_id)).get();
  }
  Editor editor(server, interruption, sink, state);
  sink.event(
      fmt::format("session {}: {} grasps {} by {}, revision {}", state.session_id(),
                  text::plain(state.hand()), text::plain(state.object()),
                  text::plain(state.motion().empty() ? state.contacts() : state.motion()),
                  state.revision()),
      json::stateEvent(state));

  // === Commands
  const auto leave = [&] {
    if (!editor.closed()) sink.note(farewell(server, editor.session(), common.network));
  };
  try {
    if (opens) solveFirst(editor, sink, options.grasp, interruption);
    if (options.at_s) editor.run(fmt::format("at {} {}", *options.at_s, options.falloff_s));
    if (typed) {
      converse(editor, sink, interruption);
    } else {
      editor.runScript(
          [&] {
            return lines.next();
          },
          options.script.empty() ? "standard input" : options.script.string());
    }
  } catch (...) {
    leave();  // the session stays, however a script ends
    throw;
  }
  leave();
  return 0;
}

}  // namespace handgraft::client
