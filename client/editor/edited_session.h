#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "client/editor/grammar.h"
#include "client/editor/scene.h"
#include "client/link/interruption.h"
#include "client/link/server_link.h"
#include "idl/cyclone/participant.h"

namespace handgraft::client::editor {

/// The server could not solve what an edit asked for: its own words.
class SolveFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One session as an editor follows it: its streams, its edits, what can be asked about it.
///
/// Edits name the revision that the user has been shown, so that nobody changes what somebody
/// else changed without having seen that.
///
/// Errors of every call: those of ServerLink.
class EditedSession : public Scene {
 public:
  EditedSession(ServerLink& server, Interruption& interruption, const v1::SessionState& state);

  [[nodiscard]] std::uint64_t id() const { return state_.session_id(); }

  /// Its server is gone and another one answers, which may give its id to another session.
  [[nodiscard]] bool hasEnded() const { return server_.status().server_id() != server_id_; }

  /// Errors: Refused (ERROR_NOT_FOUND) if it has been closed or has ended with its server.
  void requireStanding() const;

  /// The user has been shown `revision`, and nothing of what others did since.
  void lookFrom(std::uint64_t revision) { shown_ = std::min(shown_, revision); }

  /// The revision that the user has been shown.
  [[nodiscard]] std::uint64_t shownRevision() const { return shown_; }

  [[nodiscard]] const v1::SessionState& state() const { return state_; }

  // === Scene
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

  using OnSample = std::function<void(const v1::PoseSolution&)>;

  /// Waits for the final pose of `revision` or a later one, explained or not; `on_sample` sees
  /// those before it. nullptr if none follows: the session rests at that revision.
  /// Errors: SolveFailed; Cancelled once the user wants to stop (the server goes on); Refused
  /// (ERROR_NOT_FOUND) if the session is closed meanwhile.
  const v1::PoseSolution* awaitFinal(std::uint64_t revision, const OnSample& on_sample);

  using Patience = std::chrono::milliseconds;
  static constexpr Patience kEndless = std::chrono::hours(1000);

  /// Waits until the last final pose, of `revision`, is explained. Returns what is the last by
  /// then: it is not explained if an edit came first, the explanation was stopped, or
  /// `longest` is over. There must be a final pose. Errors: as for `awaitFinal`, but for
  /// SolveFailed.
  const v1::PoseSolution& awaitExplained(std::uint64_t revision, Patience longest);

  /// The last pose was shown without its explanation, if it has none: `news` brings that.
  void explainLater();

  const v1::PoseSolution& solve(const std::optional<v1::SolveOptions>& options);

  /// Stops the solve in flight, whoever asked for it. Works after an interruption, too.
  void stopSolving() { server_.stopSolving(id()); }

  /// What others did since the last call, explanations that were to come later, and whether the
  /// server is still there; for people, a line each. Does not wait.
  std::vector<std::string> news();

  using OnState = std::function<void(const v1::SessionState&)>;

  /// Takes what has come on the streams, or waits up to 20 ms for something;
  /// the caller shows it.
  void follow(const OnSample& on_sample, const OnState& on_state);

 private:
  void take(const OnSample& on_sample, const OnState& on_state);
  void requireOpen();
  void adopt(const v1::PoseSolution& solution);
  /// True if nothing more will come for `revision`, unless it is on its way.
  [[nodiscard]] bool restsAt(std::uint64_t revision) const;
  /// Forgets descriptions of models that the session no longer has.
  void keepUp(const v1::SessionState& state);
  std::string toldBy(const v1::SessionState& state) const;

  ServerLink& server_;
  Interruption& interruption_;
  idl::cyclone::Reader<v1::SessionState> states_;
  idl::cyclone::Reader<v1::PoseSolution> solutions_;
  v1::SessionState state_;
  const std::uint64_t server_id_;
  const std::chrono::steady_clock::time_point joined_ = std::chrono::steady_clock::now();
  std::uint64_t shown_ = 0;
  bool end_was_told_ = false;
  bool server_answers_ = true;                     ///< as was told
  std::optional<std::uint64_t> owed_explanation_;  ///< of this revision's pose
  std::optional<v1::PoseSolution> solution_;
  std::optional<v1::SessionSettings> settings_;
  std::uint64_t settings_sequence_ = 0;  ///< of the solution they were asked after
  std::optional<v1::HandDescription> hand_;
  bool hand_has_meshes_ = false;
  std::optional<v1::ObjectDescription> object_;
  std::vector<std::string> patches_;
  std::set<std::string> off_;  ///< patches that do not count
  bool off_is_known_ = false;
};

}  // namespace handgraft::client::editor
