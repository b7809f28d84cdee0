#include <fstream>

#include <fmt/format.h>

#include "client/editor/editor.h"
#include "client/link/session_text.h"
#include "client/present/export_file.h"
#include "client/present/failure.h"
#include "client/present/output_file.h"
#include "client/present/text_output.h"
#include "core/base/error.h"

// The editor's commands that read and write files.
namespace handgraft::client::editor {

namespace fs = std::filesystem;

CommandOutput Editor::save(const fs::path& path) {
  requireWritable({"save", path});
  writeFile(path, server_.saveSession(session_->id()).get());
  return {fmt::format("wrote {}\n", handgraft::quoted(path.string())),
          {{"file", path.string()}}};
}

CommandOutput Editor::load(const fs::path& path) {
  const std::uint64_t left = session_->id();
  const bool has_ended = session_->hasEnded();
  const std::string text = readSessionText(path);
  goOnIn(askAbout(path, [&] {
    return server_.loadSession(text).get();
  }));
  return {fmt::format("session {}, revision {}{}\n", session_->id(),
                      session_->state().revision(), farewell(left, has_ended)),
          {{"session_id", session_->id()}, {"revision", session_->state().revision()}}};
}

CommandOutput Editor::replay(const fs::path& path) {
  const std::string text = readSessionText(path);
  const v1::ReplayReply reply = askAbout(path, [&] {
    return server_.replay(text).get();
  });
  if (!reply.same()) {
    throw CommandFailed({1, fmt::format("{}: {} entries played, and it ends differently: {}",
                                        handgraft::quoted(path.string()), reply.entries(),
                                        text::plain(reply.message()))});
  }
  return {fmt::format("{} entries played; it ends the same\n", reply.entries()),
          {{"entries", reply.entries()}, {"same", true}}};
}

CommandOutput Editor::exportTo(const std::string& format, const fs::path& path) {
  std::vector<std::string> notes =
      exportSession(server_, session_->id(), format, {"export", path});
  for (const std::string& note : beyondOwnLimits(server_.settings(session_->id()).get()))
    notes.push_back(note);
  return {fmt::format("wrote {}\n{}", handgraft::quoted(path.string()), text::notes(notes)),
          {{"format", format}, {"file", path.string()}, {"notes", notes}}};
}

CommandOutput Editor::drawTo(const fs::path& path) {
  requireWritable({"png", path});
  if (hasMotion()) {
    // What was answered is told again, with its summary.
    v1::SolveMotionRequest request;
    request.session_id(session_->id());
    MotionResult motion = motionAsItStands();
    motion.summary = server_.solveMotion(request).get();
    writeMotionPicture(server_, path, motion);
    return {fmt::format("wrote {}\n", handgraft::quoted(path.string())),
            {{"file", path.string()}}};
  }
  GraspResult result;
  result.solution = requireSolution();
  result.session = session_->state();
  result.transfer = server_.transfer(session_->id()).get();
  result.hand = session_->handWithMeshes();
  writePicture(server_, path, result);
  return {fmt::format("wrote {}\n", handgraft::quoted(path.string())),
          {{"file", path.string()}}};
}

CommandOutput Editor::script(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error))
    rejectInput("{}: that is a folder", handgraft::quoted(path));
  std::ifstream in(path);
  if (!in) rejectInput("{}: cannot be read", handgraft::quoted(path));
  runScript(
      [&]() -> std::optional<std::string> {
        std::string line;
        if (!std::getline(in, line)) return std::nullopt;
        return line;
      },
      path);
  return {"", {{"file", path}}};
}

}  // namespace handgraft::client::editor
