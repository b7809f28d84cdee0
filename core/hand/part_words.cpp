#include "core/hand/part_words.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace handgraft::hand {

namespace {

using Meaning = std::pair<std::string_view, std::string_view>;

/// A word may go on after these ("thumbtip", "ringfinger").
constexpr Meaning kDigitBeginnings[] = {{"thumb", "thumb"},
                                        {"index", "index"},
                                        {"forefinger", "index"},
                                        {"middle", "middle"},
                                        {"ring", "ring"},
                                        {"little", "little"},
                                        {"pinky", "little"},
                                        {"pinkie", "little"},
                                        {"palm", "palm"},
                                        // German words are put together ("daumenspitze").
                                        {"daumen", "thumb"},
                                        {"zeigefinger", "index"},
                                        {"mittelfinger", "middle"},
                                        {"kleinfinger", "little"},
                                        {"kleinerfinger", "little"},
                                        {"kleinefinger", "little"}};
constexpr Meaning kDigitWords[] = {
    {"th", "thumb"},
    {"thb", "thumb"},
    {"thm", "thumb"},
    {"ff", "index"},
    {"if", "index"},
    {"idx", "index"},
    {"ind", "index"},
    {"mf", "middle"},
    {"mid", "middle"},
    {"rf", "ring"},
    {"rng", "ring"},
    {"lf", "little"},
    {"lit", "little"},
    {"ltl", "little"},
    {"pky", "little"},
    {"pnk", "little"},
    {"pinkey", "little"},
    // Spanish, French, Italian, accents left out; "medio" may be a segment, too.
    {"pulgar", "thumb"},
    {"indice", "index"},
    {"medio", "middle"},
    {"corazon", "middle"},
    {"anular", "ring"},
    {"menique", "little"},
    {"pouce", "thumb"},
    {"majeur", "middle"},
    {"annulaire", "ring"},
    {"auriculaire", "little"},
    {"pollice", "thumb"},
    {"anulare", "ring"},
    {"mignolo", "little"},
    // Chinese, in Pinyin without tones.
    {"muzhi", "thumb"},
    {"damuzhi", "thumb"},
    {"shizhi", "index"},
    {"zhongzhi", "middle"},
    {"wumingzhi", "ring"},
    {"xiaozhi", "little"},
    {"xiaomuzhi", "little"}};
/// Two letters that may stand right before a segment's word or a joint's letter.
constexpr Meaning kDigitPrefixes[] = {{"th", "thumb"},  {"ff", "index"}, {"if", "index"},
                                      {"mf", "middle"}, {"rf", "ring"},  {"lf", "little"}};
constexpr Meaning kSegmentWords[] = {{"metacarpal", "metacarpal"},
                                     {"meta", "metacarpal"},
                                     {"knuckle", "proximal"},
                                     {"proximal", "proximal"},
                                     {"proximate", "proximal"},
                                     {"prox", "proximal"},
                                     {"pm", "proximal"},
                                     {"middle", "middle"},
                                     {"intermediate", "middle"},
                                     {"inter", "middle"},
                                     {"medial", "middle"},
                                     {"med", "middle"},
                                     {"mid", "middle"},
                                     {"medio", "middle"},
                                     {"md", "middle"},
                                     {"distal", "distal"},
                                     {"dist", "distal"},
                                     {"dd", "distal"},
                                     {"tip", "distal"},
                                     {"fingertip", "distal"}};
/// What else stands after a digit's two letters: joints, and links that are no segments.
constexpr std::array<std::string_view, 8> kOtherEndings = {"j",    "joint", "base",   "hub",
                                                           "link", "fixed", "finger", "act"};

std::string_view meaningOf(std::span<const Meaning> words, std::string_view word) {
  for (const auto& [known, meaning] : words)
    if (word == known) return meaning;
  return {};
}

struct Word {
  std::string text;  ///< lower case
  bool is_numbered = false;
};

bool isUpper(char c) {
  return std::isupper(static_cast<unsigned char>(c)) != 0;
}

bool isLetter(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0;
}

bool isNumeral(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

/// Without the accents of the languages whose words are known: UTF-8 of U+00C0 to U+00FF, and
/// the combining ones of U+0300 to U+036F.
std::string withoutAccents(const std::string& name) {
  // Of U+00C0 on; '?' is no letter of those words.
  constexpr std::string_view kPlain =
      "AAAAAA?CEEEEIIII?NOOOOO?OUUUUY??aaaaaa?ceeeeiiii?nooooo?ouuuuy?y";
  static_assert(kPlain.size() == 0x40);
  std::string plain;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto lead = static_cast<unsigned char>(name[i]);
    const auto next = i + 1 < name.size() ? static_cast<unsigned char>(name[i + 1]) : 0U;
    if (lead == 0xC3U && next >= 0x80U && next <= 0xBFU) {
      plain += kPlain[next - 0x80U];
      ++i;
    } else if ((lead == 0xCCU && next >= 0x80U && next <= 0xBFU) ||
               (lead == 0xCDU && next >= 0x80U && next <= 0xAFU)) {
      ++i;
    } else {
      plain += name[i];
    }
  }
  return plain;
}

/// Fingers that are called by two words: "kleiner Finger", "ZeigeFinger".
void joinFingers(std::vector<Word>& words) {
  constexpr std::array<std::string_view, 5> kFirst = {"klein", "kleine", "kleiner", "zeige",
                                                      "mittel"};
  for (std::size_t i = 0; i + 1 < words.size(); ++i) {
    const bool is_first =
        std::find(kFirst.begin(), kFirst.end(), words[i].text) != kFirst.end();
    if (!is_first || words[i].is_numbered || words[i + 1].text != "finger") continue;
    words[i].text += "finger";
    words[i].is_numbered = words[i + 1].is_numbered;
    words.erase(words.begin() + static_cast<std::ptrdiff_t>(i) + 1);
  }
}

/// Runs of letters; a capital after a small letter begins the next. What a numeral begins
/// ("4th") is none.
std::vector<Word> wordsOf(const std::string& accented) {
  const std::string name = withoutAccents(accented);
  std::vector<Word> words;
  bool continues = false;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    if (isNumeral(c)) {
      const bool follows_word =
          !words.empty() && (continues || (i > 0 && !isLetter(name[i - 1])));
      if (follows_word) words.back().is_numbered = true;
      continues = false;
      // The letters of "4th" belong to the numeral; those of "index1_distal" do not.
      const bool begins = i == 0 || (!isLetter(name[i - 1]) && !isNumeral(name[i - 1]));
      while (begins && i + 1 < name.size() && isLetter(name[i + 1]))
        ++i;
      continue;
    }
    if (!isLetter(c)) {
      continues = false;
      continue;
    }
    const bool is_capital_word = i > 0 && isUpper(c) && !isUpper(name[i - 1]);
    if (!continues || is_capital_word) words.emplace_back();
    words.back().text += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    continues = true;
  }
  joinFingers(words);
  return words;
}

struct WordMeaning {
  std::string_view digit;
  std::string_view segment;
};

WordMeaning meaningOf(const std::string& word) {
  for (const auto& [beginning, digit] : kDigitBeginnings) {
    if (!word.starts_with(beginning)) continue;
    const std::string_view rest = std::string_view(word).substr(beginning.size());
    return {digit, meaningOf(kSegmentWords, rest)};
  }
  if (const auto digit = meaningOf(kDigitWords, word); !digit.empty()) return {digit, {}};
  for (const auto& [prefix, digit] : kDigitPrefixes) {
    if (!word.starts_with(prefix)) continue;
    const std::string_view rest = std::string_view(word).substr(prefix.size());
    const auto segment = meaningOf(kSegmentWords, rest);
    const bool is_other =
        std::find(kOtherEndings.begin(), kOtherEndings.end(), rest) != kOtherEndings.end();
    if (!segment.empty() || is_other) return {digit, segment};
  }
  return {{}, meaningOf(kSegmentWords, word)};
}

/// "LThumb1" and "rhand" begin with a side's letter, where the word as it stands says nothing.
std::vector<Word> withSidesApart(std::vector<Word> words) {
  constexpr std::array<std::string_view, 5> kSided = {"finger", "hand", "gripper", "wrist",
                                                      "palm"};
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string whole = words[i].text;
    if (whole.front() != 'l' && whole.front() != 'r') continue;
    const std::string rest = whole.substr(1);
    const WordMeaning known = meaningOf(whole);
    if (!known.digit.empty() || !known.segment.empty()) continue;
    const bool is_part = std::find(kSided.begin(), kSided.end(), rest) != kSided.end() ||
                         (rest.size() > 2 && !meaningOf(rest).digit.empty());
    if (!is_part) continue;
    words[i].text = rest;
    words.insert(words.begin() + static_cast<std::ptrdiff_t>(i), Word{whole.substr(0, 1)});
    ++i;
  }
  return words;
}

std::string_view sideIn(const std::vector<Word>& words) {
  for (const Word& word : words) {
    if (word.text == "right" || word.text == "rh") return "right";
    if (word.text == "left" || word.text == "lh") return "left";
  }
  if (words.size() < 2) return {};
  if (words.front().text == "r") return "right";
  return words.front().text == "l" ? std::string_view("left") : std::string_view();
}

}  // namespace

PartWords partWordsOf(const std::string& name) {
  const std::vector<Word> words = withSidesApart(wordsOf(name));
  PartWords parts;
  parts.side = sideIn(words);
  bool is_numbered_finger = false;
  std::size_t vague = words.size();  // where "middle" or "mid" stands alone
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i].text;
    if (word == "finger" || word == "f" || word == "digit") {
      const bool follows_digit = i > 0 && !meaningOf(words[i - 1].text).digit.empty();
      is_numbered_finger |= words[i].is_numbered && !follows_digit;
      continue;
    }
    const auto [digit, segment] = meaningOf(word);
    const bool may_be_segment = word == "middle" || word == "mid" || word == "medio";
    if (may_be_segment && vague == words.size() && parts.digit.empty()) {
      vague = i;
      continue;
    }
    if (!digit.empty() && parts.digit.empty() && !may_be_segment) parts.digit = digit;
    const std::string_view known = may_be_segment ? std::string_view("middle") : segment;
    if (!known.empty() && parts.segment.empty()) parts.segment = known;
  }
  if (vague == words.size()) return parts;
  const bool is_segment = is_numbered_finger || (!parts.digit.empty() && parts.digit != "palm");
  if (is_segment) {
    if (parts.segment.empty()) parts.segment = "middle";
  } else {
    parts.digit = "middle";
    parts.is_vague = parts.segment.empty();
  }
  return parts;
}

}  // namespace handgraft::hand
