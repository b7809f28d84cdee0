#pragma once

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "client/editor/edit_context.h"
#include "client/editor/grammar.h"
#include "client/link/client.h"
#include "client/link/session.h"

namespace handgraft::client::editor {

/// One session as an editor follows it: its streams, its edits, what can be asked about it.
///
/// Edits name the revision that the user has been shown, so that nobody changes what somebody
/// else changed without having seen that.
///
/// What became of a motion by an edit.
struct MotionUpdate {
  bool is_complete = false;
  std::uint32_t frame_count = 0;  ///< of the motion
  std::uint32_t changed = 0;
  double first_s = 0.0;  ///< of those that changed
  double last_s = 0.0;
  double max_depth_m = 0.0;
  double self_depth_m = 0.0;
};

/// Errors of every call: those of Session.
class EditedSession : public EditContext {
 public:
  EditedSession(Client& server, const v1::SessionState& state);

  [[nodiscard]] std::uint64_t id() const { return session_.id(); }

  [[nodiscard]] bool hasEnded() const { return session_.hasEnded(); }

  void requireStanding() const { session_.requireStanding(); }

  /// The user has been shown `revision`, and nothing of what others did since.
  void lookFrom(std::uint64_t revision) { shown_ = std::min(shown_, revision); }

  /// The revision that the user has been shown.
  [[nodiscard]] std::uint64_t shownRevision() const { return shown_; }

  [[nodiscard]] const v1::SessionState& state() const { return session_.state(); }

  // === EditContext
  const v1::SessionSettings& settings() override;
  const v1::HandDescription& hand() override;
  const v1::HandDescription& handWithMeshes() override;
  const v1::ObjectDescription& object() override;
  /// Waits up to 2 s, once, for the pose that a session joined just now has already.
  const v1::PoseSolution* solution() override;

  /// Names for reading commands; those that only completion needs are empty.
  Names names();
  /// All names; what the server does not tell is left out.
  Names allNames();

  /// Patches that do not count, as far as the last pose goes. Asks the server only where an
  /// edit may have changed that and no explanation has come since.
  const std::set<std::string>& patchesOff();

  /// Errors: Refused, ERROR_CONFLICT if somebody else's edit came first; what that was is in
  /// the message, and counts as shown from then on.
  v1::EditReply edit(const v1::EditBody& body);

  /// Edits from now on are at that time of the session's motion; nothing: of all of it.
  void editAt(const std::optional<v1::EditTime>& when) { when_ = when; }

  [[nodiscard]] const std::optional<v1::EditTime>& when() const { return when_; }

  /// Waits for the last of what an edit changed of the motion; nothing comes where the session
  /// rests, as before the first solve.
  MotionUpdate awaitMotion(std::uint64_t revision);

  using OnSample = Session::OnSolution;
  using OnState = Session::OnState;
  using Timeout = Session::Timeout;
  static constexpr Timeout kEndless = Session::kEndless;

  /// As of Session; the words of SolveFailed are plain.
  const v1::PoseSolution* awaitFinal(std::uint64_t revision, const OnSample& on_sample);
  const v1::PoseSolution& awaitDiagnosed(std::uint64_t revision, Timeout longest);

  /// The last pose was shown without its diagnosis, if it has none: `news` brings that.
  void diagnoseLater();

  const v1::PoseSolution& solve(const std::optional<v1::SolveOptions>& options);

  /// Stops the solve in flight, whoever asked for it. Works after an interruption, too.
  void stopSolving() { session_.stopSolving().get(); }

  /// What others did since the last call, explanations that were to come later, and whether the
  /// server is still there; for people, a line each. Does not wait.
  std::vector<std::string> news();

  /// Takes what has come on the streams, or waits up to 20 ms for something;
  /// the caller shows it.
  void follow(const OnSample& on_sample, const OnState& on_state);

 private:
  void take(const OnSample& on_sample = {}, const OnState& on_state = {});
  /// What the last pose tells of patches that do not count.
  void learn();
  [[nodiscard]] std::string toldBy(const v1::SessionState& state) const;

  Client& server_;
  Session session_;
  std::uint64_t shown_ = 0;
  std::optional<v1::EditTime> when_;
  bool end_was_told_ = false;
  bool server_answers_ = true;                   ///< as was told
  std::optional<std::uint64_t> owed_diagnosis_;  ///< of this revision's pose
  std::optional<v1::SessionSettings> settings_;
  std::uint64_t settings_sequence_ = 0;  ///< of the solution they were asked after
  std::optional<v1::HandDescription> hand_;
  std::string hand_of_;  ///< its model; an edit may change it; likewise the next
  bool hand_has_meshes_ = false;
  std::optional<v1::ObjectDescription> object_;
  std::string object_of_;
  std::vector<std::string> patches_;
  std::string patches_of_;     ///< that contact set
  std::set<std::string> off_;  ///< patches that do not count
  bool off_is_known_ = false;
};

}  // namespace handgraft::client::editor
