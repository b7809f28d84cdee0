#include "client/present/send_model.h"

#include <cstdio>
#include <regex>

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/base/progress.h"

namespace handgraft::client {

namespace {

constexpr int kPatience_ms = 100;  // between looks at whether the user wants to stop

std::string unitName(const std::string& units) {
  if (units == "mm") return "millimetres";
  if (units == "cm") return "centimetres";
  if (units == "in") return "inches";
  return "metres";
}

// One line of standard input, without its break; nothing at its end.
std::optional<std::string> readLine(Interruption& interruption) {
  std::string line;
  for (;;) {
    interruption.checkpoint();
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (poll(&input, 1, kPatience_ms) <= 0) continue;
    char c = 0;
    const ssize_t count = read(STDIN_FILENO, &c, 1);
    if (count <= 0) return std::nullopt;
    if (c == '\n') return line;
    line += c;
  }
}

}  // namespace

std::string unitsIn(const std::string& refusal) {
  static const std::regex kUnits(R"(--units (mm|cm|in|m)\b)");
  std::smatch found;
  return std::regex_search(refusal, found, kUnits) ? found[1].str() : "";
}

ModelSender::ModelSender(Client& server, Interruption& interruption, bool may_ask)
    : server_(server),
      interruption_(interruption),
      may_ask_(may_ask && isatty(STDIN_FILENO) != 0 && isatty(STDERR_FILENO) != 0) {}

bool ModelSender::agreed(const std::string& refusal, const std::string& units) {
  const std::string text = quoted(refusal.substr(0, refusal.find(": say --units")));
  fmt::print(stderr, "\r\x1b[K{}\nIs it in {}? [Y/n] ", text.substr(1, text.size() - 2),
             unitName(units));
  std::fflush(stderr);
  const auto answer = readLine(interruption_);
  return answer && (answer->empty() || *answer == "y" || *answer == "Y" || *answer == "yes");
}

v1::ModelSummary ModelSender::load(ModelFiles& model) {
  try {
    return server_.load(model).get();
  } catch (const Refused& refused) {
    const std::string units = unitsIn(refused.what());
    if (refused.code() != v1::ERROR_UNITS || !may_ask_ || units.empty()) throw;
    if (!agreed(refused.what(), units)) throw;
    model.units = units;
  }
  return server_.load(model).get();
}

std::string ModelSender::send(ModelFiles& model) {
  try {
    return load(model).name();
  } catch (const Refused& refused) {
    if (refused.code() != v1::ERROR_CONFLICT) throw;
  }
  model.name = nameApart(model);
  return load(model).name();
}

std::string nameOnServer(ModelSender& sender,
                         const std::string& text,
                         std::optional<ModelFiles>& files) {
  return files ? sender.send(*files) : text;
}

}  // namespace handgraft::client
