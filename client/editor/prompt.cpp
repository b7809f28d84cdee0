#include "client/editor/prompt.h"

#include <algorithm>
#include <cerrno>
#include <clocale>
#include <cwchar>

#include <fmt/format.h>
#include <histedit.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "core/base/environment.h"

namespace handgraft::client::editor {

namespace fs = std::filesystem;

namespace {

constexpr int kHistoryLines = 1000;
constexpr int kLookMs = 50;  // between looks at Ctrl-C and at what others do
constexpr std::size_t kWidth = 96;

// What all candidates begin with.
std::string commonStart(const std::vector<std::string>& words) {
  std::string start = words.front();
  for (const std::string& word : words) {
    const auto [end, rest] =
        std::mismatch(start.begin(), start.end(), word.begin(), word.end());
    start.erase(end, start.end());
  }
  return start;
}

std::string inLines(const std::vector<std::string>& words) {
  std::string text;
  std::size_t width = 0;
  for (const std::string& word : words) {
    if (width > 0 && width + word.size() + 2 > kWidth) {
      text += "\n";
      width = 0;
    }
    text += (width == 0 ? "" : "  ") + word;
    width += word.size() + 2;
  }
  return text + "\n";
}

}  // namespace

fs::path historyFile() {
  const auto state = userFolder("XDG_STATE_HOME", ".local/state");
  return state ? *state / "handgraft" / "edit_history" : fs::path();
}

struct Prompt::Impl {
  Impl(Help the_help, Interruption& the_interruption, const fs::path& file, std::FILE* the_out)
      : help(std::move(the_help)),
        interruption(the_interruption),
        history_file(file),
        out(the_out),
        lines(history_init()),
        editor(el_init("handgraft", stdin, out, stderr)) {
    // Letters beyond ASCII are typed in file names, also where no language is set.
    // NOLINTBEGIN(concurrency-mt-unsafe): before anybody types, and nobody else sets it.
    std::setlocale(LC_CTYPE, "");
    if (MB_CUR_MAX == 1) std::setlocale(LC_CTYPE, "C.UTF-8");
    // NOLINTEND(concurrency-mt-unsafe)
    el_set(editor, EL_CLIENTDATA, this);
    el_set(editor, EL_EDITOR, "emacs");
    el_set(editor, EL_PROMPT, showPrompt);
    el_set(editor, EL_GETCFN, readLetter);
    el_set(editor, EL_HIST, history, lines);
    el_set(editor, EL_ADDFN, "handgraft-complete", "Complete a word", complete);
    el_set(editor, EL_ADDFN, "handgraft-explain", "Say what may follow", explain);
    el_set(editor, EL_BIND, "^I", "handgraft-complete", nullptr);
    el_set(editor, EL_BIND, "?", "handgraft-explain", nullptr);
    el_set(editor, EL_BIND, "^R", "em-inc-search-prev", nullptr);
    HistEvent event{};
    history(lines, &event, H_SETSIZE, kHistoryLines);
    history(lines, &event, H_SETUNIQUE, 1);
    if (!history_file.empty()) history(lines, &event, H_LOAD, history_file.c_str());
  }

  ~Impl() {
    el_end(editor);
    history_end(lines);
  }

  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  static Impl& of(EditLine* editor) {
    void* self = nullptr;
    el_get(editor, EL_CLIENTDATA, &self);
    return *static_cast<Impl*>(self);
  }

  static char* showPrompt(EditLine* editor) { return of(editor).prompt.data(); }

  // === Letters

  // The next letter, looking up now and then: 1, 0 at the end, -1 once the user interrupts.
  static int readLetter(EditLine* editor, wchar_t* letter) {
    Impl& self = of(editor);
    std::mbstate_t state{};
    while (true) {
      pollfd input{STDIN_FILENO, POLLIN, 0};
      const int ready = poll(&input, 1, kLookMs);
      // Before what came after Ctrl-C is read: that belongs to the next line.
      if (self.interruption.requested()) {
        self.interrupted = true;
        self.moveToEnd();
        return -1;
      }
      if (ready < 0 && errno != EINTR) return -1;
      if (ready <= 0) {
        self.fitToTerminal();
        self.tellNews();
        continue;
      }
      char byte = 0;
      const ssize_t count = read(STDIN_FILENO, &byte, 1);
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) return 0;
      // NOLINTNEXTLINE(concurrency-mt-unsafe): with a state of its own.
      const std::size_t used = std::mbrtowc(letter, &byte, 1, &state);
      if (used == static_cast<std::size_t>(-2)) continue;  // more bytes belong to it
      if (used == static_cast<std::size_t>(-1)) {
        *letter = static_cast<unsigned char>(byte);
      }
      return 1;
    }
  }

  // The line is written anew once the terminal has another size.
  void fitToTerminal() {
    winsize now{};
    if (ioctl(STDIN_FILENO, TIOCGWINSZ, &now) != 0) return;
    if (now.ws_col == size.ws_col && now.ws_row == size.ws_row) return;
    const bool was_known = size.ws_col != 0;
    size = now;
    if (!was_known) return;
    el_resize(editor);
    fmt::print(out, "\r\x1b[J");
    std::fflush(out);
    el_set(editor, EL_REFRESH);
  }

  // What is written next stands behind the line.
  void moveToEnd() const {
    const LineInfo* line = el_line(editor);
    el_cursor(editor, static_cast<int>(line->lastchar - line->cursor));
    el_set(editor, EL_REFRESH);
  }

  void tellNews() {
    const std::vector<std::string> news = help.news();
    if (news.empty()) return;
    for (const std::string& line : news)
      fmt::print(out, "\r\x1b[K{}\n", line);
    std::fflush(out);
    prompt = help.prompt();  // it may tell of what the news changed
    el_set(editor, EL_REFRESH);
  }

  // === Keys

  [[nodiscard]] std::string beforeCursor() const {
    const LineInfo* line = el_line(editor);
    return {line->buffer, line->cursor};
  }

  static unsigned char complete(EditLine* editor, int /*key*/) {
    Impl& self = of(editor);
    const Unfinished unfinished = unfinishedOf(self.beforeCursor());
    if (unfinished.comment) return CC_ERROR;
    const std::vector<std::string> words =
        self.help.complete(unfinished.words, unfinished.prefix);
    if (words.empty()) return CC_ERROR;
    const std::string start = commonStart(words);
    std::string more = start.substr(unfinished.prefix.size());
    if (words.size() == 1 && start.back() != '/') {
      if (unfinished.quote != 0) more += unfinished.quote;
      more += ' ';
    }
    if (!more.empty()) {
      return el_insertstr(editor, more.c_str()) == 0 ? CC_REFRESH : CC_ERROR;
    }
    fmt::print(self.out, "\n{}", inLines(words));
    std::fflush(self.out);
    return CC_REDISPLAY;
  }

  static unsigned char explain(EditLine* editor, int /*key*/) {
    Impl& self = of(editor);
    const Unfinished unfinished = unfinishedOf(self.beforeCursor());
    if (!unfinished.prefix.empty() || unfinished.quote != 0 || unfinished.comment) {
      return el_insertstr(editor, "?") == 0 ? CC_REFRESH : CC_ERROR;
    }
    fmt::print(self.out, "?\n{}", self.help.explain(unfinished.words));
    std::fflush(self.out);
    return CC_REDISPLAY;
  }

  // === History

  void remember(const std::string& line) const {
    if (line.find_first_not_of(" \t") == std::string::npos) return;
    HistEvent event{};
    history(lines, &event, H_ENTER, line.c_str());
    if (history_file.empty()) return;
    std::error_code error;
    fs::create_directories(history_file.parent_path(), error);
    history(lines, &event, H_SAVE, history_file.c_str());
  }

  Help help;
  Interruption& interruption;
  fs::path history_file;
  std::FILE* out;
  History* lines;
  EditLine* editor;
  std::string prompt;
  winsize size{};  ///< of the terminal; 0: not looked at yet
  bool interrupted = false;
};

Prompt::Prompt(Help help, Interruption& interruption, const fs::path& history, std::FILE* out)
    : impl_(std::make_unique<Impl>(std::move(help), interruption, history, out)) {}

Prompt::~Prompt() = default;

Prompt::Input Prompt::readLine() {
  impl_->prompt = impl_->help.prompt();
  impl_->interrupted = false;
  el_resize(impl_->editor);  // the terminal may have another size by now
  int count = 0;
  const char* line = el_gets(impl_->editor, &count);
  if (impl_->interrupted) {
    fmt::print(impl_->out, "^C\n");
    std::fflush(impl_->out);
    return {End::kInterrupted, ""};
  }
  if (line == nullptr || count <= 0) {
    fmt::print(impl_->out, "\n");
    std::fflush(impl_->out);
    return {End::kEnd, ""};
  }
  std::string text(line, static_cast<std::size_t>(count));
  if (!text.empty() && text.back() == '\n') text.pop_back();
  impl_->remember(text);
  return {End::kLine, text};
}

}  // namespace handgraft::client::editor
