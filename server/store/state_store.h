#pragma once

#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "server/base/session_access.h"
#include "server/store/database.h"

namespace handgraft::server {

/// A request or an edit as its client numbers it: `asker` tells the participant and the
/// client.
struct RequestKey {
  std::string asker;
  std::uint64_t number = 0;
  Who who = {};  ///< that is, in a secured domain
};

/// What became of an edit.
struct KeptEdit {
  std::uint64_t session = 0;
  std::uint64_t revision = 0;
  std::string message;
};

/// What a request made or ended.
struct KeptRequest {
  std::string what;          ///< its operation
  std::int64_t subject = 0;  ///< the session's id, or the model's row
};

/// A model, as the store keeps it: what it is made of, and on which others it rests.
struct PersistedModel {
  std::int64_t row = 0;
  int kind = 0;
  std::string name;
  std::string content;  ///< its Origin's
  std::string summary;  ///< for lists, as text
  std::string form;     ///< which of its makers reads `settings` and `bytes`
  std::string settings;
  std::int64_t base = 0;  ///< row of the model that it rests on; 0: a built-in one, or none
  std::string base_name;
};

/// A session between two of its texts.
struct KeptSession {
  std::string text;
  std::string motion;  ///< of which it is; empty: of contacts
  std::uint64_t next = 0;
  std::vector<std::string> entries;  ///< since the text, in order
  std::vector<std::int64_t> models;  ///< rows of those that it names
  std::int64_t used = 0;             ///< ns of the system's clock; of those that are read
  SessionAccess access;
};

struct KeptSessionState {
  std::uint64_t id = 0;
  std::string state;           ///< as it was last told
  std::uint64_t revision = 0;  ///< as it stands
  std::int64_t used = 0;       ///< ns of the system's clock
};

struct StateLimits {
  std::uint64_t bytes = 4ull << 30;  ///< of the store; edits have a little more
  std::size_t sessions = 10'000;
};

/// What a server knows, on disk: models, sessions with their history, and what of it was asked
/// for by whom (DECISIONS, "Nothing lost").
///
/// What a method did is there after kill -9 once it has returned, and within a second after
/// the machine went down; what it threw for was not done at all. Threads: all methods from any
/// thread. Errors of all that write: StorageError; Rejection (ERROR_STORAGE) beyond the limits.
class StateStore {
 public:
  /// Opens or makes the file; `path` may be ":memory:". A file of an earlier schema is brought
  /// to ours. Errors: InvalidInput naming the file if it is of a newer program, or another
  /// process has it open; StorageError.
  explicit StateStore(const std::string& path, StateLimits limits = {});
  ~StateStore();
  StateStore(const StateStore&) = delete;
  StateStore& operator=(const StateStore&) = delete;

  /// The server's, for as long as the file lives.
  [[nodiscard]] std::uint64_t serverId() const { return server_id_; }

  /// How often it was opened, this time included.
  [[nodiscard]] std::uint64_t openings() const { return openings_; }

  [[nodiscard]] std::uint64_t bytes() const;

  [[nodiscard]] const std::string& path() const { return path_; }

  // === Sessions

  void addSession(std::uint64_t id,
                  const KeptSession& session,
                  const std::string& state,
                  const RequestKey& by,
                  const std::string& operation);
  /// Adds entries that begin at number `first`, one edit's mark, and models that it brought in.
  void append(std::uint64_t id,
              std::uint64_t first,
              const std::vector<std::string>& entries,
              const RequestKey* edit = nullptr,
              const KeptEdit& outcome = {},
              const std::vector<std::int64_t>& models = {});
  /// Entries and the state that they lead to.
  void append(std::uint64_t id,
              std::uint64_t first,
              const std::vector<std::string>& entries,
              const std::string& state,
              std::uint64_t revision);
  /// Puts a text in place of all entries below `next`.
  void replaceText(std::uint64_t id,
                   const std::string& text,
                   std::uint64_t next,
                   const std::string& state,
                   std::uint64_t revision);
  /// `state` tells it, too.
  void keepAccess(std::uint64_t id, const SessionAccess& access, const std::string& state);
  void removeSession(std::uint64_t id, const RequestKey& by, const std::string& operation);

  [[nodiscard]] std::vector<KeptSessionState> sessions() const;
  /// Errors: StorageError, also if there is none.
  [[nodiscard]] KeptSession session(std::uint64_t id) const;

  // === What was done for whom: asked for where memory does not know

  [[nodiscard]] std::optional<KeptEdit> edit(const RequestKey& edit) const;
  [[nodiscard]] std::optional<KeptRequest> request(const RequestKey& request) const;

  // === Models

  /// Its row. `bytes` are kept once, however many models have the same.
  std::int64_t addModel(const PersistedModel& model,
                        std::string_view bytes,
                        const RequestKey& by,
                        const std::string& operation);
  /// Its name is free again; what sessions and other models rest on stays until they are gone.
  void removeModel(int kind,
                   const std::string& name,
                   const RequestKey& by,
                   const std::string& operation);
  /// Those with a name.
  [[nodiscard]] std::vector<PersistedModel> models() const;
  /// Errors: StorageError, also if there is none, or its bytes are not what they were.
  [[nodiscard]] PersistedModel model(std::int64_t row) const;
  [[nodiscard]] std::string bytesOf(std::int64_t row) const;

  // === Upkeep

  /// What is wrong with the file, a line each: its pages, blobs that are not what they are
  /// called, references to what is not there, counts that do not agree. Empty: nothing.
  [[nodiscard]] std::vector<std::string> check() const;
  /// Copies it into a new file, as it stands, while it is written to. Errors: InvalidInput if
  /// there is such a file.
  void backUpTo(const std::string& path) const;

 private:
  struct Statements;

  void open();
  [[nodiscard]] SessionAccess accessLocked(std::uint64_t id) const;
  void keepAccessLocked(std::uint64_t id, const SessionAccess& access);
  void requireRoom(std::uint64_t more, std::uint64_t most) const;
  void noteRequest(const RequestKey& by, const std::string& operation, std::int64_t subject);
  void appendLocked(std::uint64_t id,
                    std::uint64_t first,
                    const std::vector<std::string>& entries,
                    const RequestKey* edit,
                    const KeptEdit& outcome);
  std::string addBlob(std::string_view bytes);
  void dropModels();
  void keep();

  const std::string path_;
  const StateLimits limits_;
  int lock_ = -1;
  std::uint64_t server_id_ = 0;
  std::uint64_t openings_ = 0;
  std::set<std::string> earlier_askers_;  ///< of edits, when it was opened

  std::mutex blob_mutex_;  ///< one blob is written at a time; before `mutex_`
  mutable std::mutex mutex_;
  mutable std::unique_ptr<Database> database_;
  mutable std::unique_ptr<Statements> statements_;
  bool is_written_ = false;  ///< since the last flush

  std::condition_variable wake_;
  bool stops_ = false;
  std::thread keeper_;
};

/// What `--check` and `--backup` do on a file that no server has open, or has.
/// Errors: InvalidInput if there is none, or of a newer program; StorageError.
std::vector<std::string> checkStore(const std::string& path);
void backUpStore(const std::string& path, const std::string& to);

}  // namespace handgraft::server
