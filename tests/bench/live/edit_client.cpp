#include "tests/bench/live/edit_client.h"

#include "idl/client_id.h"

namespace handgraft::bench {

namespace {

double msSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

}  // namespace

EditClient::EditClient(const Network& network)
    : participant_(network),
      requester_(participant_),
      client_(idl::randomClient()),
      edits_(participant_, idl::kEditTopic),
      replies_(participant_,
               idl::kEditReplyTopic,
               [this] {
                 takeReplies();
               }),
      solutions_(participant_, idl::kSolutionTopic, [this] {
        takeSolutions();
      }) {}

v1::SessionState EditClient::open(const v1::OpenSessionRequest& request) {
  v1::RequestBody body;
  body.open_session(request);
  return requester_.ask(body).session();
}

v1::ReplyBody EditClient::ofSession(v1::Operation operation, std::uint64_t session) {
  v1::SessionKey key;
  key.session_id(session);
  v1::RequestBody body;
  body.session(key);
  body._d(operation);
  return requester_.ask(body);
}

std::uint64_t EditClient::send(std::uint64_t session, const v1::EditBody& body) {
  v1::Edit edit;
  edit.client(client_);
  edit.edit_id(++last_edit_);
  edit.session_id(session);
  edit.body(body);
  {
    const std::lock_guard lock(mutex_);
    sent_[session][edit.edit_id()].at = Clock::now();
  }
  edits_.write(edit);
  return edit.edit_id();
}

void EditClient::takeReplies() {
  replies_.take([this](const v1::EditReply& reply) {
    if (reply.client() != client_) return;
    const std::lock_guard lock(mutex_);
    const auto session = sent_.find(reply.session_id());
    if (session == sent_.end()) return;
    const auto found = session->second.find(reply.edit_id());
    if (found == session->second.end() || found->second.fate.answered) return;
    EditFate& fate = found->second.fate;
    fate.answered = true;
    fate.error = reply.error();
    fate.message = reply.message();
    fate.revision = reply.revision();
    fate.reply_ms = msSince(found->second.at);
    // Topics overtake each other: the solution may be here already.
    const auto latest = latest_.find(reply.session_id());
    if (latest != latest_.end()) takeAnswer(latest->second, found->second);
  });
  news_.notify_all();
}

void EditClient::takeSolutions() {
  solutions_.take([this](const v1::PoseSolution& solution) {
    if (!solution.is_final()) return;
    const auto now_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
                            std::chrono::system_clock::now().time_since_epoch())
                            .count();
    const std::lock_guard lock(mutex_);
    Final& latest = latest_[solution.session_id()];
    latest = {solution.revision(),
              Clock::now(),
              1e-6 * static_cast<double>(now_ns - solution.stamp_ns()),
              {}};
    for (const v1::StageTime& stage : solution.times())
      latest.stages_ms[stage.stage()] = stage.duration_ms();
    const auto session = sent_.find(solution.session_id());
    if (session == sent_.end()) return;
    // Newest first: all that this revision holds and that no earlier solution did.
    for (auto at = session->second.rbegin(); at != session->second.rend(); ++at) {
      if (at->second.fate.solved) break;
      takeAnswer(latest, at->second);
    }
  });
  news_.notify_all();
}

void EditClient::takeAnswer(const Final& latest, Sent& sent) {
  EditFate& fate = sent.fate;
  if (!fate.answered || fate.error != v1::ERROR_NONE || fate.solved) return;
  if (fate.revision > latest.revision || latest.at < sent.at) return;
  fate.solved = true;
  fate.shared = fate.revision < latest.revision;
  fate.solution_ms = std::chrono::duration<double, std::milli>(latest.at - sent.at).count();
  fate.back_ms = latest.back_ms;
  fate.stages_ms = latest.stages_ms;
}

EditFate EditClient::await(std::uint64_t session, std::uint64_t edit, Clock::duration timeout) {
  std::unique_lock lock(mutex_);
  news_.wait_for(lock, timeout, [&] {
    return isOver(sent_[session][edit].fate);
  });
  return sent_[session][edit].fate;
}

std::vector<EditFate> EditClient::fates(std::uint64_t session) {
  const std::lock_guard lock(mutex_);
  std::vector<EditFate> list;
  for (const auto& [id, sent] : sent_[session])
    list.push_back(sent.fate);
  return list;
}

void EditClient::forget() {
  const std::lock_guard lock(mutex_);
  sent_.clear();
}

}  // namespace handgraft::bench
