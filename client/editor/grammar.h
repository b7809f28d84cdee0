#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "client/editor/quantity.h"
#include "client/editor/words.h"

/// What commands look like: patterns such as `limit JOINT upper VALUE`, from which come the
/// reading of a command, the complaints about a wrong one, completion and help.
namespace handgraft::client::editor {

/// What may stand at a place of a pattern.
enum class Kind {
  kLiteral,  ///< this word itself
  kPatch,    ///< PATCH, and so on
  kJoint,
  kSite,
  kPoint,  ///< a site, a site's `_tip`, or a link
  kSide,   ///< object or hand
  kNumber,
  kCount,
  kAngle,   ///< rad unless it says deg
  kLength,  ///< m unless it says mm or cm
  kValue,   ///< of a joint: an angle, or a length if it slides
  kFile,
  kHand,
  kObject,
  kName,  ///< of a new snapshot
  kSnapshot,
  kSession,
  kCommand,
  kFormat,  ///< of an export
  kTopic,   ///< of `show`
  kSolver,
  kNormalForm,  ///< of the normals' term
};

struct Slot {
  Kind kind = Kind::kLiteral;
  std::string literal;  ///< of literals alone
};

struct OptionSlot {
  std::string name;         ///< `--starts`
  std::vector<Slot> value;  ///< none or one
};

/// A pattern, taken apart: words in lower case stand for themselves, words in upper case for a
/// kind; `--name` or `--name KIND` may follow in any order, each once at most.
struct Pattern {
  std::vector<Slot> slots;
  std::vector<OptionSlot> options;
};

/// Errors: BrokenContract for a kind that does not exist.
Pattern patternOf(std::string_view text);

/// What names there are, for checking and for completion.
struct Names {
  std::vector<std::string> patches;
  std::vector<std::string> joints;
  std::map<std::string, std::string> followers;  ///< joints that mimic another: which one
  std::vector<std::string> sites;
  std::vector<std::string> points;
  std::vector<std::string> hands;
  std::vector<std::string> objects;
  std::vector<std::string> snapshots;
  std::vector<std::string> sessions;
  std::vector<std::string> commands;
};

/// A word that stood for a kind.
struct Value {
  std::string text;
  double number = 0.0;      ///< rad or m for angles and lengths
  Unit unit = Unit::kNone;  ///< that was written
  std::uint64_t count = 0;  ///< of counts
};

/// How far a command fits a pattern.
struct Match {
  bool complete = false;
  std::vector<Value> values;             ///< of the kinds, in order
  std::map<std::string, Value> options;  ///< given
  // === Unless it is complete
  std::size_t place = 0;       ///< of the first word that does not fit, or of the one missing
  std::vector<Slot> expected;  ///< there; none: nothing may follow
  std::string objection;  ///< to the word there, where more can be said than what may stand
};

Match match(const Pattern& pattern, const Words& words, const Names& names);

/// What may follow `words`, whether or not more must. Nothing if they do not fit.
std::vector<Slot> following(const Pattern& pattern, const Words& words, const Names& names);

/// "PATCH", "upper".
std::string nameOf(const Slot& slot);

/// All words that may stand there; for kinds of which there are too many, none.
const std::vector<std::string>& choices(const Slot& slot, const Names& names);

}  // namespace handgraft::client::editor
