#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "client/editor/command_output.h"
#include "client/editor/command_table.h"
#include "client/editor/edited_session.h"
#include "client/editor/sink.h"
#include "client/link/client.h"
#include "client/present/interruption.h"
#include "client/present/motion_result.h"

namespace handgraft::client::editor {

/// Runs commands on one session after the other.
class Editor {
 public:
  Editor(Client& server,
         Interruption& interruption,
         const Sink& sink,
         const v1::SessionState& state);

  [[nodiscard]] EditedSession& session() { return *session_; }

  /// True once a command said so: leave.
  [[nodiscard]] bool finished() const { return finished_; }

  /// True once the session has been closed by `close`.
  [[nodiscard]] bool closed() const { return closed_; }

  /// From now on poses are shown before they are diagnosed, as it pleases who types. Scripts
  /// and programs wait for both.
  void showPosesAtOnce() { at_once_ = true; }

  /// All commands of a line, one after the other, each told by the sink as it is done.
  /// Errors: of the first one that fails, and nothing of the line is run after it; InvalidInput
  /// for words that are no command; those of Client; SolveFailed.
  void run(const std::string& line);

  /// The next line of a script; nothing at its end.
  using NextLine = std::function<std::optional<std::string>()>;

  /// Runs all lines until there are no more, or a command says to leave. Each command is told
  /// before it runs.
  /// Errors: CommandFailed by the first command that fails, naming `name` and the line;
  /// Cancelled.
  void runScript(const NextLine& next_line, const std::string& name);

  /// As the command `solve` does.
  CommandOutput solve(const std::optional<v1::SolveOptions>& options);
  /// The session's motion, by its starts and its seed alone.
  CommandOutput solveMotion(const Match& match);
  [[nodiscard]] bool hasMotion() const;
  /// All of it but the summary of its solve.
  MotionResult motionAsItStands();

 private:
  void runCommand(const Words& words);
  Parsed read(const Words& words);
  /// Goes on in the same session where the server was not heard for a while.
  void reachServer();
  CommandOutput execute(const Parsed& command);
  CommandOutput edit(const Parsed& command);
  CommandOutput publish(const v1::EditBody& body);
  CommandOutput editAt(const Match& match);
  /// What an edit changed of the motion; nothing where it is not solved.
  CommandOutput tellMotion(std::uint64_t revision);
  /// The pose that follows an edit; nullptr if none does. Ctrl-C stops its solve.
  /// Errors: CommandFailed if it was stopped; those of EditedSession::awaitFinal.
  const v1::PoseSolution* awaitPose(std::uint64_t revision);
  /// Tells the last pose, behind `before`, once it is diagnosed; where poses are shown at once,
  /// the diagnosis may come as news.
  CommandOutput tellPose(const std::string& before);
  /// That the search moved a joint which was just bent, if it did.
  std::string movedAgain(const Match& bend);
  CommandOutput suggest(const Match& match);
  CommandOutput showMotion();
  CommandOutput show(const Match& match);
  CommandOutput compare(const Match& match);
  CommandOutput save(const std::filesystem::path& path);
  CommandOutput load(const std::filesystem::path& path);
  CommandOutput replay(const std::filesystem::path& path);
  CommandOutput exportTo(const std::string& format, const std::filesystem::path& path);
  CommandOutput drawTo(const std::filesystem::path& path);
  CommandOutput watch(const Match& match);
  CommandOutput sessions();
  CommandOutput join(const Match& match);
  CommandOutput close();
  CommandOutput script(const std::string& path);
  CommandOutput help(const Match& match);
  /// Errors: InvalidInput if there is none.
  const v1::PoseSolution& requirePose();
  /// Waits until it is diagnosed, or will not be. Errors likewise.
  const v1::PoseSolution& requireSolution();
  void goOnIn(const v1::SessionState& state);
  /// What becomes of the session with id `left` when another one is taken, with a separator;
  /// empty if it is the same one.
  [[nodiscard]] std::string farewell(std::uint64_t left, bool has_ended) const;
  /// Where a dragged point is after the search, if that is not where it was dragged to.
  std::string endedAt(const v1::DragEdit& drag);

  Client& server_;
  Interruption& interruption_;
  const Sink& sink_;
  std::unique_ptr<EditedSession> session_;
  std::uint64_t before_ = 0;  ///< the session before it; 0: none
  bool finished_ = false;
  bool closed_ = false;
  bool at_once_ = false;
  int depth_ = 0;  ///< of scripts that run scripts
};

}  // namespace handgraft::client::editor
