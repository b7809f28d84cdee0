#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace handgraft::server {

/// The disk did not take, or not give, what was asked of it; nothing of the change was made.
/// The message names the file, and what to do where the disk is full, or the file read-only or
/// damaged.
class StorageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Database;

/// Bytes that are no text.
struct Bytes {
  std::string_view data;
};

/// One statement, prepared once and run any number of times. Not thread-safe: as its database.
class Statement {
 public:
  Statement(Database& database, const std::string& sql);
  ~Statement();
  Statement(Statement&&) noexcept;
  Statement& operator=(Statement&&) = delete;

  /// Begins anew with these values, in the order of its question marks; integers are stored by
  /// their bits, texts and bytes copied by reference: they must live until the run ends.
  template <class... Values>
  Statement& with(const Values&... values) {
    reset();
    int index = 0;
    (bind(++index, values), ...);
    return *this;
  }

  /// The next row, if there is one. Errors: StorageError.
  bool step();
  /// Runs a statement that gives no rows.
  void run();

  // === Of the present row, by column
  [[nodiscard]] std::int64_t integer(int column) const;
  [[nodiscard]] std::uint64_t id(int column) const;
  [[nodiscard]] std::string text(int column) const;

  [[nodiscard]] bool isNull(int column) const;

 private:
  void reset();
  void bind(int index, std::int64_t value);

  void bind(int index, int value) { bind(index, static_cast<std::int64_t>(value)); }

  void bind(int index, std::uint64_t value) { bind(index, static_cast<std::int64_t>(value)); }

  void bind(int index, Bytes bytes);
  void bind(int index, std::string_view text);

  void bind(int index, const std::string& text) { bind(index, std::string_view(text)); }

  Database& database_;
  sqlite3_stmt* statement_ = nullptr;
};

/// A SQLite database in a file of its own, in write-ahead mode: what was committed outlives the
/// process; when it outlives the machine is its owner's to see to. Not thread-safe.
class Database {
 public:
  /// `path` may be ":memory:". Errors: StorageError.
  explicit Database(const std::string& path);
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  void execute(const char* sql);
  /// The single value of a query's first row; nothing where there is none.
  std::optional<std::int64_t> ask(const std::string& sql);

  /// All that is done while it lives happens together or not at all.
  class Transaction {
   public:
    explicit Transaction(Database& database);
    /// Takes back what was not committed.
    ~Transaction();
    Transaction(const Transaction&) = delete;
    Transaction& operator=(const Transaction&) = delete;

    /// Errors: StorageError; nothing was done then.
    void commit();

   private:
    Database& database_;
    bool is_open_ = true;
  };

  /// Copies the whole of it as it stands into another file while others go on writing.
  void backUpTo(const std::string& path);

  /// Of the present file.
  [[nodiscard]] std::uint64_t bytes();

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  friend class Statement;
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  sqlite3* handle_ = nullptr;
};

}  // namespace handgraft::server
