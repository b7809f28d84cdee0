#include "client/link/demonstration.h"

#include <chrono>
#include <thread>

#include <fmt/format.h>

#include "client/link/model_files.h"
#include "client/link/wire_pose.h"
#include "core/base/error.h"
#include "core/base/side_note.h"
#include "core/formats/demonstration_text.h"
#include "idl/topics.h"

namespace handgraft::client {

namespace {

std::vector<v1::DemonstratorFrame> framesOf(const formats::Demonstration& demonstration) {
  std::vector<v1::DemonstratorFrame> frames;
  for (const formats::DemonstrationFrame& read : demonstration.frames) {
    v1::DemonstratorFrame frame;
    frame.time_s(read.time_s);
    frame.chirality(demonstration.is_left ? v1::CHIRALITY_LEFT : v1::CHIRALITY_RIGHT);
    frame.kind(demonstration.is_mano ? v1::DEMONSTRATOR_MANO : v1::DEMONSTRATOR_JOINT_PLACES);
    frame.values(read.values);
    frame.X_WO(placeOf(read.object_pose, "field 'object_pose'"));
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace

DemonstratorWriter::DemonstratorWriter(Client& client, std::uint64_t session_id)
    : client_(client),
      session_id_(session_id),
      writer_(*client.participant(), idl::kDemonstratorTopic) {
  constexpr std::chrono::seconds kServersPatience(2);
  const auto give_up = std::chrono::steady_clock::now() + kServersPatience;
  while (writer_.readers() == 0) {
    client.checkpoint();
    if (std::chrono::steady_clock::now() >= give_up)
      throw NoServer("the server does not follow demonstrators");
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

void DemonstratorWriter::write(v1::DemonstratorFrame frame) {
  if (!client_.alive()) {
    throw NoServer(
        fmt::format("handgraft-server on {} stopped answering", describe(client_.network())));
  }
  frame.session_id(session_id_);
  frame.client(client_.id());
  frame.sequence_number(++sent_);
  writer_.write(frame);
}

Demonstration readDemonstration(const std::filesystem::path& path) {
  const std::string text = readFile(path);
  try {
    const formats::Demonstration read = formats::parseDemonstration(text);
    return {read.object, framesOf(read), read.notes};
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", quoted(path.string()), error.what());
  }
}

std::string noteOfAnotherObject(const Demonstration& demonstration,
                                const v1::SessionState& session) {
  const std::string held = nameCalled(session.object());
  if (demonstration.object.empty() || nameCalled(demonstration.object) == held) return "";
  return fmt::format(
      "the demonstration is of object {}, session {} holds {}: the hand follows as if that "
      "were "
      "touched",
      quoted(demonstration.object), session.session_id(), quoted(held));
}

std::string noteOfTheOtherSide(const Demonstration& demonstration,
                               const v1::HandDescription& hand) {
  const auto name_of = [](v1::Chirality side) {
    if (side == v1::CHIRALITY_UNKNOWN) return "";
    return side == v1::CHIRALITY_LEFT ? "left" : "right";
  };
  if (demonstration.frames.empty()) return "";
  return otherSideNote(name_of(demonstration.frames.front().chirality()),
                       name_of(hand.chirality()));
}

}  // namespace handgraft::client
