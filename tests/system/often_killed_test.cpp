// Edits, uploads and motions on a server that is killed again and again, on a disk that fails
// now and then: what was acknowledged is there, once; what was refused is not.
#include <functional>
#include <map>
#include <mutex>
#include <random>
#include <set>
#include <thread>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random_id.h"

#include "tests/server/motion_messages.h"
#include "tests/system/nothing_lost.h"

namespace handgraft::test {
namespace {

/// What one client was told, and what was wrong about it.
struct Told {
  std::uint64_t done = 0;
  std::uint64_t refused = 0;  ///< plainly, for want of the disk
  std::uint64_t again = 0;    ///< to be asked again, since the server was gone
  std::vector<std::string> wrong;
};

enum class Outcome { kDone, kRefused, kAgain };

/// Chunks of an upload do not outlive their server (server/DECISIONS.md): it is sent again.
bool isForgottenUpload(const Refused& error) {
  return error.code() == v1::ERROR_UPLOAD_GONE;
}

/// `ask`, until it is known what became of it.
Outcome tell(Told& told, const std::atomic<bool>& stops, const std::function<void()>& ask) {
  while (!stops) {
    try {
      ask();
      ++told.done;
      return Outcome::kDone;
    } catch (const Refused& error) {
      if (error.code() == v1::ERROR_STORAGE) {
        ++told.refused;
        return Outcome::kRefused;
      }
      if (!isForgottenUpload(error)) told.wrong.emplace_back(error.what());
    } catch (const idl::cyclone::NoServer&) {
    }
    ++told.again;
  }
  return Outcome::kAgain;
}

constexpr std::size_t kChunk = 524'288;

/// A tetrahedron in a file of so many chunks.
std::string tetrahedron(double size_m, std::size_t chunks) {
  std::string text = fmt::format(
      "v 0 0 0\nv {0} 0 0\nv 0 {0} 0\nv 0 0 {0}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", size_m);
  while (text.size() < (chunks - 1) * kChunk + 1)
    text += "# a comment, as scanners leave them in their files\n";
  return text;
}

/// Sends a file in its chunks, and makes an object of it.
void upload(Requester& requester, const std::string& name, const std::string& text) {
  const std::uint64_t id = randomId();
  for (std::size_t at = 0; at < text.size(); at += kChunk) {
    v1::RequestBody chunk = putFile(id, name + ".obj", text.substr(at, kChunk));
    v1::PutFileRequest file = chunk.put_file();
    file.offset(at);
    file.total_bytes(text.size());
    chunk.put_file(file);
    requester.ask(chunk);
  }
  requester.ask(loadModel(id, v1::MODEL_OBJECT, name, name + ".obj"));
}

std::set<std::string> objectsOf(Requester& requester) {
  std::set<std::string> names;
  for (const v1::ModelSummary& one :
       requester.ask(plain(v1::OP_LIST_MODELS)).models().models()) {
    if (one.kind() == v1::MODEL_OBJECT) names.insert(one.name());
  }
  return names;
}

class OftenKilled : public FailingDisk {
 protected:
  /// A session on a motion of a small hand.
  std::uint64_t openPull(Requester& mover) {
    for (const auto& [uri, bytes] :
         std::map<std::string, std::string>{{"plan.json", kPlan},
                                            {"first.json", builtIn("contacts/lemon_6.json")},
                                            {"path.csv", kPath}})
      mover.ask(putFile(9, uri, bytes));
    mover.ask(loadModel(9, v1::MODEL_MOTION, "pull", "plan.json", "fruit"));
    return mover.ask(openMotion("clamp", "fruit", "pull")).session().session_id();
  }

  /// Edits until it is to stop; each that is acknowledged is one revision.
  void edit(Requester& by, std::uint64_t session, Told& told, bool solves) {
    std::uint64_t revision = 0;
    double last = 0.0;
    for (int i = 0; !stops; ++i) {
      const double weight = 0.1 + 0.001 * (i % 800);
      std::uint64_t now = 0;
      const Outcome outcome = tell(told, stops, [&] {
        now = by.edit(session, 0, weightOf(weight)).revision();
      });
      if (outcome == Outcome::kAgain) unknown_at_the_end = true;
      if (outcome != Outcome::kDone) continue;
      ++answered;
      if (now != revision + 1)
        told.wrong.push_back(fmt::format("revision {} after {}", now, revision));
      revision = now;
      last = weight;
      if (!solves || i % 4 != 0) continue;
      tell(told, stops, [&] {
        const v1::MotionSummary summary = by.ask(solveMotion(session)).motion();
        if (summary.frame_count() != 16)
          told.wrong.push_back(fmt::format("a motion of {} frames", summary.frame_count()));
      });
    }
    const std::lock_guard lock(mutex);
    stands[session] = {revision, last};
  }

  std::atomic<bool> stops{false};
  std::atomic<bool> unknown_at_the_end{false};
  std::atomic<std::uint64_t> answered{0};
  std::mutex mutex;
  std::map<std::uint64_t, std::pair<std::uint64_t, double>> stands;
};

void sendModels(Requester& by,
                const std::atomic<bool>& stops,
                Told& told,
                std::map<std::string, bool>& is_there) {
  for (int i = 0; !stops; ++i) {
    const std::string name = fmt::format("part{}", i);
    const std::string text = tetrahedron(0.02 + 0.0001 * i, i % 4 == 0 ? 3 : 1);
    const Outcome sent = tell(told, stops, [&] {
      upload(by, name, text);
    });
    if (sent != Outcome::kAgain) is_there[name] = sent == Outcome::kDone;
    if (i % 3 != 0 || sent != Outcome::kDone) continue;
    const Outcome unloaded = tell(told, stops, [&] {
      by.ask(unloadModel(v1::MODEL_OBJECT, name));
    });
    if (unloaded == Outcome::kDone) is_there[name] = false;
    if (unloaded == Outcome::kAgain) is_there.erase(name);
  }
}

TEST_F(OftenKilled, EditsUploadsAndMotionsAreThereOnce) {
  const int kills = countOf("HANDGRAFT_KILLS", 6);
  constexpr unsigned char kFails = 8;  // of 256 writes
  Editor editor(service->network());
  const Participant participant(service->network());
  Requester sender(participant);
  Requester mover(participant);
  ASSERT_TRUE(sender.waitForServer(kLong) && mover.waitForServer(kLong));
  const std::uint64_t motion = openPull(mover);
  fail(kFails, 'r');

  Told edits;
  Told motions;
  Told models;
  std::map<std::string, bool> is_there;  // models, as they were told
  std::vector<std::thread> hands;
  hands.emplace_back([&] {
    edit(editor.requester, editor.session, edits, false);
  });
  hands.emplace_back([&] {
    edit(mover, motion, motions, true);
  });
  hands.emplace_back([&] {
    sendModels(sender, stops, models, is_there);
  });

  std::mt19937 chance(20);
  std::vector<double> seconds;
  for (int i = 0; i < kills && !HasFailure(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50 + chance() % 700));
    killServer();
    const std::uint64_t before = answered;
    const Clock::time_point begin = Clock::now();
    startOnFailingDisk(kFails);
    // Those that were answered just before the end may be counted after it.
    while (answered < before + 3 && Clock::now() - begin < kLong)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    seconds.push_back(std::chrono::duration<double>(Clock::now() - begin).count());
  }
  stops = true;
  for (std::thread& hand : hands)
    hand.join();
  killServer();
  startServer();  // on a sound disk
  ASSERT_TRUE(running->waitForText("event=ready")) << running->err();
  ASSERT_TRUE(mover.waitForServer(kLong) && sender.waitForServer(kLong));
  for (const auto& [session, stand] : stands) {
    const v1::SessionSettings settings =
        mover.ask(ofSession(v1::OP_SESSION_SETTINGS, session)).settings();
    EXPECT_EQ(settings.state().revision(), stand.first);
    EXPECT_EQ(settings.patches().front().weight(), stand.second);
  }
  const std::set<std::string> objects = objectsOf(sender);
  std::uint64_t lost = 0;
  std::uint64_t unasked = 0;
  for (const auto& [name, is_told] : is_there) {
    if (is_told && objects.count(name) == 0) ++lost;
    if (!is_told && objects.count(name) != 0) ++unasked;
  }
  EXPECT_EQ(lost, 0U) << "models that were acknowledged";
  EXPECT_EQ(unasked, 0U) << "models that were refused, or unloaded";
  for (const auto& [what, told] : std::map<std::string, const Told*>{
           {"edits", &edits}, {"motions", &motions}, {"models", &models}}) {
    std::printf("%s: done %llu, refused %llu, asked again %llu\n", what.c_str(),
                static_cast<unsigned long long>(told->done),
                static_cast<unsigned long long>(told->refused),
                static_cast<unsigned long long>(told->again));
    EXPECT_THAT(told->wrong, testing::IsEmpty()) << what;
    EXPECT_GT(told->done, 0U) << what;
  }
  std::printf("kills %d, goes on after p50 %.2f s, p95 %.2f s, max %.2f s\n", kills,
              percentile(seconds, 0.5), percentile(seconds, 0.95), percentile(seconds, 1.0));
  EXPECT_EQ(seconds.size(), static_cast<std::size_t>(kills));
  killServer();
  const Finished check = checkOf(folder / "state");
  EXPECT_EQ(check.exit_code, 0) << check.out << check.err;
}

}  // namespace
}  // namespace handgraft::test
