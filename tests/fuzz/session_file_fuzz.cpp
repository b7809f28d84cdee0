// Session files. An even first byte: the text follows. An odd one: a true file is damaged, by
// edits of which each says where, how many bytes go, and which come instead. What can be opened
// is the same when it is written and read again, goes back and forth whole, and plays or says
// why not.

#include <cstdint>
#include <string>

#include "core/base/error.h"
#include "core/io/session_file.h"
#include "core/session/replay.h"

#include "tests/core/session/ball_grasp.h"
#include "tests/fuzz/byte_reader.h"
#include "tests/fuzz/promise.h"

namespace {

namespace io = handgraft::io;
namespace session = handgraft::session;
using handgraft::InvalidInput;
using handgraft::Pose;
using handgraft::Progress;
using handgraft::fuzz::ByteReader;

const session::SessionModels& models() {
  static const session::SessionModels known_models = [] {
    const handgraft::test::BallGrasp grasp;
    session::SessionModels all;
    all.hand_name = "hand";
    all.hand = grasp.hand();
    all.object_name = "ball";
    all.object_O = grasp.ball;
    all.contacts_name = "marks";
    all.contacts = std::make_shared<const handgraft::contact::ContactSet>(grasp.contacts);
    return all;
  }();
  return known_models;
}

/// Of a session with something of everything that files hold.
const std::string& trueText() {
  static const std::string session_text = [] {
    session::Session one(models(), Pose::Identity(), {});
    session::SolverSettings quick;
    quick.starts = 1;
    Pose X_WO = Pose::Identity();
    X_WO.translation().x() = 0.01;
    one.apply(session::PatchWeightEdit{"thumb", 0.5});
    one.commit(one.solve(quick, {}, Progress()));
    one.apply(session::SnapshotEdit{"before"});
    one.apply(session::JointLimitEdit{"index_1", 0.0, 1.0});
    one.apply(session::ObjectPoseEdit{X_WO});
    one.apply(session::PatchDirectionEdit{"index", session::Side::kObject, 0.2});
    one.apply(session::PatchRootEdit{"middle", session::Side::kHand,
                                     one.document().patches[2].placement->root_S});
    one.apply(session::DragEdit{"index_tip", {0, 0, 0.02}, {0.05, 0, 0.05}, {}});
    one.commit(one.solve(quick, {}, Progress()));
    one.apply(session::ChoiceEdit{0, std::nullopt});
    one.noteCancelledSolve();
    one.apply(session::PriorEdit{Pose::Identity(), {"thumb_1"}, {0.25}});
    one.apply(session::JointSoftEdit{"middle_2", 0.5, 10.0});
    one.apply(session::SolverSettingsEdit{quick});
    one.apply(session::RestoreEdit{"before"});
    one.apply(session::UndoEdit{2});
    return io::sessionText(one);
  }();
  return session_text;
}

std::string damaged(ByteReader& input) {
  std::string text = trueText();
  while (input.left() > 0 && !text.empty()) {
    const std::size_t at = input.take<std::uint16_t>() % text.size();
    const std::size_t gone = input.take<std::uint8_t>();
    const std::size_t count = input.take<std::uint8_t>() % 17U;
    text.replace(at, gone, input.takeText(count));
  }
  return text;
}

void open(const io::SessionFile& file) {
  session::Session one(models(), file.session);
  const std::string text = io::sessionText(one);
  session::Session again(models(), io::readSessionText(text).session);
  HANDGRAFT_PROMISE(again.document() == one.document());
  HANDGRAFT_PROMISE(io::sessionText(again) == text);

  // === All documents that it leads to were checked when it was opened
  const session::Document present = one.document();
  const auto undo = static_cast<int>(one.history().undoCount());
  const auto redo = static_cast<int>(one.history().redoCount());
  if (redo > 0) {
    one.apply(session::RedoEdit{redo});
    one.apply(session::UndoEdit{redo});
    HANDGRAFT_PROMISE(one.document() == present);
  }
  if (undo > 0) {
    one.apply(session::UndoEdit{undo});
    one.apply(session::RedoEdit{undo});
    HANDGRAFT_PROMISE(one.document() == present);
  }
  const session::Replay played = session::replay(models(), file.session, false, Progress());
  HANDGRAFT_PROMISE(played.same == played.message.empty());
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  ByteReader input(bytes, size);
  const bool is_damaged = input.take<std::uint8_t>() % 2 == 1;
  const std::string text =
      is_damaged ? damaged(input) : std::string(input.takeText(input.left()));
  try {
    const io::SessionFile file = io::readSessionText(text);
    try {
      // By its models' fingerprints; the other half asks what happens without them.
      (void)io::openSession(file, models(), Progress());
    } catch (const InvalidInput&) {
      // Most of what is damaged.
    }
    open(file);
  } catch (const InvalidInput&) {
    // Likewise.
  }
  return 0;
}
