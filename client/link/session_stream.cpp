#include "client/link/session_stream.h"

#include <condition_variable>
#include <mutex>

#include "idl/cyclone/participant.h"

namespace handgraft::client {

struct SessionStream::Readers {
  explicit Readers(std::shared_ptr<const idl::cyclone::Participant> on)
      : participant(std::move(on)),
        states(*participant,
               idl::kSessionTopic,
               [this] {
                 arrived();
               }),
        solutions(*participant,
                  idl::kSolutionTopic,
                  [this] {
                    arrived();
                  }),
        frames(*participant,
               idl::kMotionFramesTopic,
               [this] {
                 arrived();
               }),
        clocks(*participant, idl::kMotionClockTopic, [this] {
          arrived();
        }) {}

  void arrived() {
    {
      const std::lock_guard lock(mutex);
      has_news = true;
    }
    news.notify_all();
  }

  const std::shared_ptr<const idl::cyclone::Participant> participant;
  std::mutex mutex;
  std::condition_variable news;
  bool has_news = true;  // of a reader that is new it is not known
  idl::cyclone::Reader<v1::SessionState> states;
  idl::cyclone::Reader<v1::PoseSolution> solutions;
  idl::cyclone::Reader<v1::MotionFrames> frames;
  idl::cyclone::Reader<v1::MotionClock> clocks;
};

SessionStream::SessionStream(Client& client, std::uint64_t session_id)
    : client_(client), session_id_(session_id) {
  readers();
}

SessionStream::~SessionStream() = default;

SessionStream::Readers& SessionStream::readers() {
  auto on = client_.participant();
  if (!readers_ || readers_->participant != on) {
    readers_ = std::make_unique<Readers>(std::move(on));
  }
  return *readers_;
}

void SessionStream::take(const OnSolution& on_solution, const OnState& on_state) {
  Readers& from = readers();
  {
    const std::lock_guard lock(from.mutex);
    from.has_news = false;
  }
  from.solutions.take([&](const v1::PoseSolution& solution) {
    if (solution.session_id() == session_id_ && on_solution) on_solution(solution);
  });
  from.states.take([&](const v1::SessionState& state) {
    if (state.session_id() == session_id_ && on_state) on_state(state);
  });
}

std::vector<v1::MotionFrames> SessionStream::takeMotion() {
  std::vector<v1::MotionFrames> all;
  readers().frames.take([&](const v1::MotionFrames& frames) {
    if (frames.session_id() == session_id_) all.push_back(frames);
  });
  return all;
}

std::optional<v1::MotionClock> SessionStream::takeClock() {
  std::optional<v1::MotionClock> last;
  readers().clocks.take([&](const v1::MotionClock& clock) {
    if (clock.session_id() == session_id_) last = clock;
  });
  return last;
}

void SessionStream::wait(std::chrono::milliseconds timeout) {
  Readers& from = readers();
  std::unique_lock lock(from.mutex);
  from.news.wait_for(lock, timeout, [&] {
    return from.has_news;
  });
}

}  // namespace handgraft::client
