#pragma once

#include <atomic>
#include <chrono>
#include <deque>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "idl/cyclone/participant.h"
#include "idl/edits.h"
#include "idl/fields.h"

#include "tests/client/editor/small_context.h"
#include "tests/client/fake_server.h"

namespace handgraft::test {

/// A server of one session, 7, on the small context: edits count revisions, are refused when
/// they are stale, and are followed by a state, a final pose, and the same pose diagnosed.
class FakeEditServer {
 public:
  explicit FakeEditServer(const Network& network)
      : server_(network,
                [this](const v1::Request& request, v1::Reply& reply) {
                  return answer(request, reply);
                }),
        participant_(network),
        edits_(participant_, idl::kEditTopic),
        replies_(participant_, idl::kEditReplyTopic),
        states_(participant_, idl::kSessionTopic),
        solutions_(participant_, idl::kSolutionTopic),
        thread_([this] {
          serve();
        }) {}

  ~FakeEditServer() {
    stopping_ = true;
    thread_.join();
  }

  FakeEditServer(const FakeEditServer&) = delete;
  FakeEditServer& operator=(const FakeEditServer&) = delete;

  [[nodiscard]] v1::SessionState state() const {
    const std::lock_guard lock(mutex_);
    return stateNow();
  }

  /// Somebody else's edit; published only if `published`.
  void editByOther(const std::string& text, bool published) {
    const std::lock_guard lock(mutex_);
    ++revision_;
    last_edit_ = text;
    last_client_.fill(0xab);
    if (!published) return;
    states_.write(stateNow());
    solutions_.write(solutionNow(true));
  }

  /// What `hold_explanations` held back.
  void diagnose() {
    const std::lock_guard lock(mutex_);
    states_.write(stateNow());
    solutions_.write(solutionNow(true));
  }

  /// A state of a revision that is over, as those who come late are told.
  void repeatOldState() {
    const std::lock_guard lock(mutex_);
    v1::SessionState old = stateNow();
    old.revision(0);
    old.hand("another");
    states_.write(old);
  }

  /// What settings say of a patch from now on.
  void switchOff(const std::string& patch) {
    const std::lock_guard lock(mutex_);
    off_ = patch;
  }

  /// Edits that were applied, in order.
  [[nodiscard]] std::vector<v1::Edit> edits() const {
    const std::lock_guard lock(mutex_);
    return applied_;
  }

  [[nodiscard]] std::vector<v1::Operation> operations() const { return server_.operations(); }

  std::atomic<bool> hang{false};               ///< on solves, until they are cancelled
  std::atomic<bool> hanging{false};            ///< one does
  std::atomic<bool> fail{false};               ///< the solve that follows an edit
  std::atomic<bool> hold_poses{false};         ///< that follow edits: none comes
  std::atomic<bool> hold_explanations{false};  ///< poses come, and nothing more
  std::atomic<bool> same{true};                ///< what a replay says

 private:
  using Key = std::pair<v1::ClientId, std::uint64_t>;

  [[nodiscard]] v1::SessionState stateNow() const {
    v1::SessionState state;
    state.session_id(7);
    state.revision(revision_);
    state.phase(fail && revision_ > 0             ? v1::PHASE_FAILED
                : hold_poses || hold_explanations ? v1::PHASE_OPTIMIZING
                                                  : v1::PHASE_READY);
    if (fail) state.message("the hand has no point left");
    state.hand("claw");
    state.object("plate");
    state.contacts("plate_2");
    state.joint_names({"bend", "slide"});
    state.last_edit(last_edit_);
    state.last_client(last_client_);
    return state;
  }

  v1::PoseSolution solutionNow(bool is_diagnosed) {
    v1::PoseSolution solution;
    solution.session_id(7);
    solution.revision(revision_);
    solution.sequence_number(++sequence_);
    solution.is_final(true);
    solution.solver("lm");
    solution.joint_positions({0.5, 0.02});
    solution.terms().objective(10.0 + static_cast<double>(revision_));
    v1::PatchFit thumb;
    thumb.name("thumb");
    thumb.point_count(10);
    thumb.mean_mm(1.0);
    v1::PatchFit index;
    index.name("index");
    index.point_count(30);
    index.mean_mm(3.0);
    solution.patches({thumb, index});
    solution.is_diagnosed(is_diagnosed);
    if (!is_diagnosed) return solution;
    solution.verdict("2 of 2 patches reached");
    for (v1::PatchFit& patch : solution.patches())
      patch.diagnosis().verdict(v1::VERDICT_REACHED);
    return solution;
  }

  bool answer(const v1::Request& request, v1::Reply& reply) {
    const std::lock_guard lock(mutex_);
    v1::ReplyBody& body = reply.body();
    const v1::Operation operation = request.body()._d();
    switch (operation) {
      case v1::OP_DESCRIBE_SESSION:
        body.session(stateNow());
        break;
      case v1::OP_SESSION_SETTINGS: {
        v1::SessionSettings settings = context_.settings();
        settings.state(stateNow());
        settings.snapshots({"before"});
        for (const char* name : {"thumb", "index"}) {
          settings.patches().emplace_back();
          settings.patches().back().name(name);
          settings.patches().back().enabled(name != off_);
          settings.patches().back().weight(1.0);
        }
        body.settings(settings);
        break;
      }
      case v1::OP_DESCRIBE_MODEL: {
        v1::ModelDescription description;
        const v1::ModelKind kind = request.body().describe_model().model().kind();
        if (kind == v1::MODEL_HAND) description.hand(context_.hand());
        if (kind == v1::MODEL_OBJECT) description.object(context_.object());
        if (kind == v1::MODEL_CONTACTS) {
          v1::ContactsDescription contacts;
          contacts.patches().resize(2);
          contacts.patches()[0].name("thumb");
          contacts.patches()[1].name("index");
          description.contacts(contacts);
        }
        body.model(description);
        break;
      }
      case v1::OP_LOAD_MODEL:
        reply.error(v1::ERROR_UNITS);
        reply.message("152 m across: say --units mm");
        return true;
      case v1::OP_LIST_MODELS: {
        v1::ModelList list;
        for (const char* name : {"a_hand_with_a_long_name", "claw"}) {
          v1::ModelSummary model;
          model.kind(v1::MODEL_HAND);
          model.name(name);
          list.models().push_back(model);
        }
        body.models(list);
        break;
      }
      case v1::OP_LIST_SESSIONS: {
        v1::SessionList list;
        list.sessions().push_back(stateNow());
        body.sessions(list);
        break;
      }
      case v1::OP_OPTIMIZE:
        if (cancelled_) {
          cancelled_ = false;
          reply.error(v1::ERROR_CANCELLED);
          reply.message("cancelled");
          return true;
        }
        if (hang) {
          hanging = true;
          return false;
        }
        body.solution(solutionNow(true));
        break;
      case v1::OP_CANCEL:
        cancelled_ = true;
        break;
      case v1::OP_SAVE_SESSION: {
        v1::SaveSessionReply saved;
        saved.text("the session");
        body.saved_session(saved);
        break;
      }
      case v1::OP_REPLAY: {
        v1::ReplayReply replay;
        replay.entries(3);
        replay.same(same);
        replay.message("entry 2 differs");
        body.replay(replay);
        break;
      }
      case v1::OP_EXPORT: {
        const std::string text =
            std::string(nameOf(request.body().export_file().format())) + " of 7";
        v1::ExportReply exported;
        exported.content().assign(text.begin(), text.end());
        body.exported_file(exported);
        break;
      }
      default:
        break;
    }
    body._d(operation);
    return true;
  }

  void serve() {
    while (!stopping_) {
      edits_.take([this](const v1::Edit& edit) {
        take(edit);
      });
      edits_.wait(std::chrono::milliseconds(5));
    }
  }

  void take(const v1::Edit& edit) {
    const std::lock_guard lock(mutex_);
    const Key key(edit.client(), edit.edit_id());
    const auto known = replied_.find(key);
    if (known != replied_.end()) {
      replies_.write(known->second);
      return;
    }
    v1::EditReply reply;
    reply.client(edit.client());
    reply.edit_id(edit.edit_id());
    reply.session_id(edit.session_id());
    if (edit.base_revision() != 0 && edit.base_revision() != revision_) {
      reply.error(v1::ERROR_CONFLICT);
      reply.message("the session has moved on");
    } else {
      ++revision_;
      last_client_ = edit.client();
      last_edit_ = "an edit";
      applied_.push_back(edit);
    }
    reply.revision(revision_);
    replied_[key] = reply;
    replies_.write(reply);
    if (reply.error() != v1::ERROR_NONE) return;
    states_.write(stateNow());
    if (fail || hold_poses) return;
    solutions_.write(solutionNow(false));
    if (!hold_explanations) solutions_.write(solutionNow(true));
  }

  SmallContext context_;
  mutable std::mutex mutex_;
  std::uint64_t revision_ = 0;
  std::uint64_t sequence_ = 0;
  std::string last_edit_;
  std::string off_;
  v1::ClientId last_client_{};
  bool cancelled_ = false;
  std::map<Key, v1::EditReply> replied_;
  std::vector<v1::Edit> applied_;
  FakeServer server_;
  idl::cyclone::Participant participant_;
  idl::cyclone::Reader<v1::Edit> edits_;
  idl::cyclone::Writer<v1::EditReply> replies_;
  idl::cyclone::Writer<v1::SessionState> states_;
  idl::cyclone::Writer<v1::PoseSolution> solutions_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace handgraft::test
