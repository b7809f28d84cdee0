#include "client/present/send_model.h"

#include <cstdio>
#include <regex>

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include "core/base/error.h"
#include "core/base/length_unit.h"
#include "core/base/progress.h"
#include "idl/fields.h"

namespace handgraft::client {

namespace {

constexpr int kPatienceMs = 100;  // between looks at whether the user wants to stop

// One line of standard input, without its break; nothing at its end.
std::optional<std::string> readLine(Interruption& interruption) {
  std::string line;
  for (;;) {
    interruption.checkpoint();
    pollfd input{STDIN_FILENO, POLLIN, 0};
    if (poll(&input, 1, kPatienceMs) <= 0) continue;
    char c = 0;
    const ssize_t count = read(STDIN_FILENO, &c, 1);
    if (count <= 0) return std::nullopt;
    if (c == '\n') return line;
    line += c;
  }
}

}  // namespace

std::vector<std::string> unitsIn(const std::string& refusal) {
  static const std::regex units_option(R"(--units (\w+))");
  std::vector<std::string> units;
  for (std::sregex_iterator found(refusal.begin(), refusal.end(), units_option), end;
       found != end; ++found) {
    if (lengthUnitCalled((*found)[1].str()) != nullptr) units.push_back((*found)[1]);
  }
  return units;
}

ModelSender::ModelSender(Client& server, Interruption& interruption, bool may_ask)
    : server_(server),
      interruption_(interruption),
      may_ask_(may_ask && isatty(STDIN_FILENO) != 0 && isatty(STDERR_FILENO) != 0) {}

std::string ModelSender::agreedUnits(const std::string& refusal) {
  const std::string text = quoted(refusal.substr(0, refusal.find(": say --units")));
  fmt::print(stderr, "\r\x1b[K{}\n", text.substr(1, text.size() - 2));
  for (const std::string& units : unitsIn(refusal)) {
    fmt::print(stderr, "Is it in {}? [Y/n] ", lengthUnitCalled(units)->plural);
    std::fflush(stderr);
    const auto answer = readLine(interruption_);
    if (!answer) break;
    if (answer->empty() || *answer == "y" || *answer == "Y" || *answer == "yes") return units;
  }
  return "";
}

v1::ModelSummary ModelSender::load(ModelFiles& model) {
  try {
    return loadOnce(model);
  } catch (const Refused& refused) {
    if (refused.code() != v1::ERROR_UNITS || !may_ask_) throw;
    const std::string units = agreedUnits(refused.what());
    if (units.empty()) throw;
    model.units = units;
  }
  return loadOnce(model);
}

v1::ModelSummary ModelSender::loadOnce(const ModelFiles& model) {
  try {
    return server_.load(model).get();
  } catch (const Refused& refused) {
    throw Refused(refused.code(), byGivenPaths(refused.what(), model));
  }
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

std::string ModelSender::import(ModelFiles& model, bool is_named) {
  if (is_named) return load(model).name();
  const std::string asked = model.name;
  const std::string name = send(model);
  if (name != asked)
    fmt::print(
        stderr,
        "handgraft: {} is on the server with other content and stays as it is: this is {}; "
        "`handgraft unload {} {}` before an import replaces it\n",
        quoted(asked), quoted(name), nameOf(model.kind), asked);
  return name;
}

std::string nameOnServer(ModelSender& sender,
                         const std::string& text,
                         std::optional<ModelFiles>& files) {
  return files ? sender.send(*files) : text;
}

}  // namespace handgraft::client
