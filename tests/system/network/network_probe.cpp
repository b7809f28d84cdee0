// network_probe: what a client is told while its network is as networks are. Prints one line of
// JSON; exits with 1 if something was never answered, or was done more or less often than told.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <map>
#include <mutex>
#include <numbers>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/random_id.h"
#include "idl/cyclone/requester.h"
#include "idl/fields.h"

namespace {

using namespace handgraft;
using Clock = std::chrono::steady_clock;
using idl::cyclone::Participant;
using idl::cyclone::Refused;
using idl::cyclone::Requester;

double msSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// What an error is called in the table.
std::string nameOf(const std::exception_ptr& error) {
  try {
    std::rethrow_exception(error);
  } catch (const Refused& refused) {
    return v1::nameOf(refused.code());
  } catch (const idl::cyclone::NoServer&) {
    return "no server";
  } catch (const std::exception& other) {
    return other.what();
  }
}

/// Outcomes of one kind of question, as they are told.
class Tally {
 public:
  /// A question begins; what is returned is called with its outcome, by whichever thread.
  template <class Reply>
  std::function<void(Requester::Outcome<Reply>)> ask() {
    const std::lock_guard lock(mutex_);
    const std::size_t i = answers_.size();
    answers_.push_back(0);
    return [this, i, begin = Clock::now()](Requester::Outcome<Reply> outcome) {
      const std::lock_guard lock_again(mutex_);
      ++answers_[i];
      late_ms_.push_back(msSince(begin));
      if (const auto* error = std::get_if<std::exception_ptr>(&outcome)) {
        ++errors_[nameOf(*error)];
      } else {
        ++done_;
      }
      told_.notify_all();
    };
  }

  /// Until everything was told.
  bool wait(std::chrono::seconds most) {
    std::unique_lock lock(mutex_);
    return told_.wait_for(lock, most, [this] {
      return late_ms_.size() >= answers_.size();
    });
  }

  [[nodiscard]] nlohmann::json report() const {
    const std::lock_guard lock(mutex_);
    const auto never = std::count(answers_.begin(), answers_.end(), 0);
    const auto twice = std::count_if(answers_.begin(), answers_.end(), [](int n) {
      return n > 1;
    });
    return {{"asked", answers_.size()},
            {"done", done_},
            {"errors", errors_},
            {"unanswered", never},
            {"answered_twice", twice},
            {"p50_ms", std::round(10.0 * percentile(late_ms_, 0.5)) / 10.0},
            {"p95_ms", std::round(10.0 * percentile(late_ms_, 0.95)) / 10.0},
            {"latest_ms", std::round(percentile(late_ms_, 1.0))}};
  }

  [[nodiscard]] std::uint64_t done() const {
    const std::lock_guard lock(mutex_);
    return done_;
  }

  [[nodiscard]] std::uint64_t errors(const std::string& name) const {
    const std::lock_guard lock(mutex_);
    const auto found = errors_.find(name);
    return found == errors_.end() ? 0 : found->second;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable told_;
  std::vector<int> answers_;  ///< of each question
  std::vector<double> late_ms_;
  std::uint64_t done_ = 0;
  std::map<std::string, std::uint64_t> errors_;
};

v1::RequestBody ofSession(v1::Operation operation, std::uint64_t session) {
  v1::SessionKey key;
  key.session_id(session);
  v1::RequestBody body;
  body.session(key);
  body._d(operation);
  return body;
}

/// Once what was in the way is over.
v1::ReplyBody askUntilAnswered(Requester& requester, const v1::RequestBody& body) {
  for (const auto end = Clock::now() + std::chrono::seconds(90);;) {
    try {
      return requester.ask(body);
    } catch (const std::exception&) {
      if (Clock::now() > end) throw;
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
  }
}

// === A large answer

/// A sphere whose description takes some `bytes`.
std::string sphereOf(std::size_t bytes) {
  // A vertex is three floats, and two triangles of three numbers.
  const auto rings = static_cast<int>(std::sqrt(static_cast<double>(bytes) / 36.0));
  constexpr double kRadius = 0.05;  // m
  std::string text;
  const auto vertex = [&](double polar, double azimuth) {
    text +=
        fmt::format("v {:.6f} {:.6f} {:.6f}\n", kRadius * std::sin(polar) * std::cos(azimuth),
                    kRadius * std::sin(polar) * std::sin(azimuth), kRadius * std::cos(polar));
  };
  vertex(0.0, 0.0);
  vertex(std::numbers::pi, 0.0);
  for (int i = 1; i <= rings; ++i) {
    for (int j = 0; j < rings; ++j)
      vertex(std::numbers::pi * i / (rings + 1), 2.0 * std::numbers::pi * j / rings);
  }
  const auto at = [rings](int i, int j) {
    return 3 + i * rings + j % rings;
  };
  for (int j = 0; j < rings; ++j) {
    text += fmt::format("f 1 {} {}\n", at(0, j), at(0, j + 1));
    text += fmt::format("f 2 {} {}\n", at(rings - 1, j + 1), at(rings - 1, j));
    for (int i = 0; i + 1 < rings; ++i) {
      text += fmt::format("f {} {} {}\n", at(i, j), at(i + 1, j), at(i + 1, j + 1));
      text += fmt::format("f {} {} {}\n", at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  return text;
}

void upload(Requester& requester, const std::string& name, const std::string& text) {
  constexpr std::size_t kChunk = 524'288;
  v1::PutFileRequest chunk;
  chunk.upload_id(randomId());
  chunk.uri(name + ".obj");
  chunk.total_bytes(text.size());
  for (std::size_t at = 0; at < text.size(); at += kChunk) {
    const std::string part = text.substr(at, kChunk);
    chunk.offset(at);
    chunk.bytes().assign(part.begin(), part.end());
    v1::RequestBody body;
    body.put_file(chunk);
    requester.ask(body);
  }
  v1::LoadModelRequest load;
  load.kind(v1::MODEL_OBJECT);
  load.name(name);
  load.upload_id(chunk.upload_id());
  load.main_uri(chunk.uri());
  load.units("m");
  v1::RequestBody body;
  body.load_model(load);
  requester.ask(body);
}

v1::RequestBody descriptionOf(const std::string& name) {
  v1::DescribeModelRequest request;
  request.model().kind(v1::MODEL_OBJECT);
  request.model().name(name);
  request.with_meshes(true);
  v1::RequestBody body;
  body.describe_model(request);
  return body;
}

int askForMuch(Requester& requester, int times, std::size_t bytes, bool is_there) {
  const std::string name = "much";
  const Clock::time_point begin = Clock::now();
  if (!is_there) upload(requester, name, sphereOf(bytes));
  const double upload_ms = std::round(msSince(begin));
  std::vector<double> took_ms;
  std::size_t size = 0;
  for (int i = 0; i < times; ++i) {
    const Clock::time_point asked = Clock::now();
    size = v1::ReplyBody::getCdrSerializedSize(requester.ask(descriptionOf(name)));
    took_ms.push_back(std::round(msSince(asked)));
  }
  nlohmann::json report{{"answer_bytes", size}, {"took_ms", took_ms}};
  if (!is_there) report["upload_ms"] = upload_ms;
  fmt::print("{}\n", report.dump());
  return 0;
}

// === A stream of edits and small questions

int edit(Requester& requester, double seconds, double rate_hz, const std::string& said) {
  v1::OpenSessionRequest open;
  open.hand("barrett8");
  open.object("lemon");
  open.contacts("lemon_6");
  v1::RequestBody opening;
  opening.open_session(open);
  const std::uint64_t session = requester.ask(opening).session().session_id();
  fmt::print(stderr, "{} {}\n", said, session);
  Tally edits;
  Tally questions;
  const Clock::time_point end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                                   std::chrono::duration<double>(seconds));
  const auto period =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / rate_hz));
  int count = 0;
  for (auto next = Clock::now(); next < end; next += period) {
    std::this_thread::sleep_until(next);
    v1::PatchWeightEdit weight;
    weight.patch("palm");
    weight.weight(++count % 2 == 0 ? 1.0 : 0.5);
    v1::EditBody body;
    body.patch_weight(weight);
    requester.beginEdit(session, 0, body, edits.ask<v1::EditReply>());
    requester.begin(ofSession(v1::OP_DESCRIBE_SESSION, session),
                    questions.ask<v1::ReplyBody>());
  }
  constexpr std::chrono::seconds kMost(100);
  const bool all_edits = edits.wait(kMost);
  const bool all_questions = questions.wait(kMost);
  const std::uint64_t revision =
      askUntilAnswered(requester, ofSession(v1::OP_DESCRIBE_SESSION, session))
          .session()
          .revision();
  const nlohmann::json report{
      {"edits", edits.report()}, {"questions", questions.report()}, {"revision", revision}};
  fmt::print("{}\n", report.dump());
  // An edit is done once if it was told as done, and at most once if that is not known.
  askUntilAnswered(requester, ofSession(v1::OP_CLOSE_SESSION, session));
  const std::uint64_t unknown = edits.errors(v1::nameOf(v1::ERROR_OUTCOME_UNKNOWN));
  const bool is_once = revision >= edits.done() && revision <= edits.done() + unknown;
  return all_edits && all_questions && is_once ? 0 : 1;
}

// === A flood of the smallest questions, none of which waits for an answer

int flood(const Participant& participant, double seconds, double rate_hz) {
  idl::cyclone::Writer<v1::Request> requests(participant, idl::kRequestTopic);
  v1::Request question;
  v1::ClientId client{};
  const std::uint64_t mine = randomId();
  for (std::size_t i = 0; i < sizeof mine; ++i)
    client[i] = static_cast<std::uint8_t>(mine >> (8 * i));
  question.client(client);
  question.protocol_version(v1::PROTOCOL_VERSION);
  question.body().nothing(v1::Nothing());
  const Clock::time_point begin = Clock::now();
  std::uint64_t held_back = 0;
  std::uint64_t id = 0;
  while (Clock::now() - begin < std::chrono::duration<double>(seconds)) {
    question.request_id(++id);
    try {
      requests.write(question);
    } catch (const idl::cyclone::WriteTimeout&) {
      ++held_back;
    }
    constexpr std::uint64_t kTogether = 30;
    if (id % kTogether == 0)
      std::this_thread::sleep_until(
          begin + std::chrono::duration<double>(static_cast<double>(id) / rate_hz));
  }
  fmt::print("{}\n", nlohmann::json{{"sent", id}, {"held_back", held_back}}.dump());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("network_probe: what a client is told on a network as it is");
  Network network;
  int times = 5;
  double megabytes = 2.0;
  double seconds = 10.0;
  double rate_hz = 10.0;
  bool is_there = false;
  app.add_option("--domain", network.domain);
  app.add_option("--interface", network.interface);
  app.add_option("--identity", network.identity);
  app.add_option("--peers", network.peers)->delimiter(',');
  auto* much = app.add_subcommand("much", "an object's mesh, asked for several times");
  much->add_option("--times", times);
  much->add_option("--megabytes", megabytes);
  much->add_flag("--there", is_there, "the object was sent before");
  auto* edits = app.add_subcommand("edits", "edits of one session, and questions beside them");
  edits->add_option("--seconds", seconds);
  edits->add_option("--rate", rate_hz);
  auto* floods = app.add_subcommand("flood", "small questions, at a rate");
  floods->add_option("--seconds", seconds);
  floods->add_option("--rate", rate_hz);
  app.require_subcommand(1);
  CLI11_PARSE(app, argc, argv);
  try {
    const Participant participant(network, idl::cyclone::Discovers::kNoClients);
    Requester requester(participant);
    if (!requester.waitForServer(std::chrono::seconds(60))) throw TransportError("no server");
    if (*much)
      return askForMuch(requester, times, static_cast<std::size_t>(1e6 * megabytes), is_there);
    if (*floods) return flood(participant, seconds, rate_hz);
    return edit(requester, seconds, rate_hz, "session");
  } catch (const std::exception& error) {
    fmt::print(stderr, "network_probe: {}\n", error.what());
    return 1;
  }
}
