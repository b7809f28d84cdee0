// What the reading process answers: a true answer, damaged. The first byte says which answer;
// then come edits (where, what, how many bytes), of which the last may be an end cut off. What
// is believed must be sane, and be the same when it is packed and unpacked again.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/hand/kinematics.h"
#include "server/reading/packed.h"

#include "tests/fuzz/byte_reader.h"
#include "tests/fuzz/promise.h"
#include "tests/fuzz/scratch_file.h"
#include "tests/fuzz/small_hand.h"

namespace {

namespace server = handgraft::server;
using handgraft::fuzz::ByteReader;
using handgraft::fuzz::scratchFile;

constexpr const char* kPoses = R"(<robot name="hand"><group_state name="shut" group="all">
<joint name="j" value="1.0"/></group_state></robot>)";

constexpr const char* kSites = R"(format: handgraft-sites/1
sites:
  - {name: thumb, link: tip, point_m: [0.01, 0, 0], normal: [1, 0, 0], direction: [0, 0, 1]}
)";

/// A ball of 42 vertices, and the points of its upper half touched.
std::string ballPly(bool with_contact) {
  const auto ball = handgraft::geometry::makeSphere(0.03, 1);
  std::string ply = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\n"
      "property double z\n{}element face {}\nproperty list uchar int vertex_indices\n"
      "end_header\n",
      ball.vertexCount(), with_contact ? "property double contact\n" : "", ball.faceCount());
  for (const auto& p : ball.vertices().colwise()) {
    ply += fmt::format("{} {} {}", p.x(), p.y(), p.z());
    ply += with_contact ? fmt::format(" {}\n", p.z() > -1e-9 ? 1.0 : 0.0) : "\n";
  }
  for (const auto& f : ball.faces().colwise())
    ply += fmt::format("3 {} {} {}\n", f[0], f[1], f[2]);
  return ply;
}

struct Answer {
  std::string bytes;
  std::shared_ptr<const handgraft::io::MeshFile> object;  ///< of contacts
};

Answer answerTo(server::ReadRequest request) {
  const server::ReadModel model = readModel(request, {});
  return {pack(model), request.contacts.object};
}

/// A hand with sites and poses, an object, contacts with their map.
const std::vector<Answer>& answers() {
  static const std::vector<Answer> all_answers = [] {
    server::ReadRequest hand;
    hand.kind = server::ReadKind::kHand;
    hand.name = "hand";
    hand.main_uri = "hand.urdf";
    hand.files = {{"hand.urdf", scratchFile("hand.urdf", handgraft::fuzz::kSmallHand)},
                  {"hand.srdf", scratchFile("hand.srdf", kPoses)},
                  {"sites.yaml", scratchFile("sites.yaml", kSites)}};
    hand.hand.srdf_uri = "hand.srdf";
    server::ReadRequest object;
    object.name = "ball";
    object.main_uri = "ball.ply";
    object.files = {{"ball.ply", scratchFile("ball.ply", ballPly(false))}};
    server::ReadRequest contacts;
    contacts.kind = server::ReadKind::kContacts;
    contacts.name = "touch";
    contacts.main_uri = "touch.ply";
    contacts.files = {{"touch.ply", scratchFile("touch.ply", ballPly(true))}};
    contacts.contacts.object = std::make_shared<const handgraft::io::MeshFile>(
        std::get<handgraft::io::MeshFile>(readModel(object, {})));
    return std::vector{answerTo(hand), answerTo(object), answerTo(contacts)};
  }();
  return all_answers;
}

void requireSane(const server::ReadModel& model, const Answer& answer) {
  if (const auto* hand = std::get_if<server::ReadHand>(&model)) {
    HANDGRAFT_PROMISE(hand->model.restPose().allFinite());
    for (const handgraft::hand::NamedPose& pose : hand->poses) {
      HANDGRAFT_PROMISE(pose.q.size() == hand->model.dofCount() && pose.q.allFinite());
    }
    if (hand->sites) validate(hand->model, *hand->sites);
  } else if (const auto* file = std::get_if<handgraft::io::MeshFile>(&model)) {
    HANDGRAFT_PROMISE(file->mesh.vertices().allFinite());
    for (const int v : file->file_vertex)
      HANDGRAFT_PROMISE(v >= 0);
    for (const int v : file->mesh_vertex)
      HANDGRAFT_PROMISE(v >= -1 && v < file->mesh.vertexCount());
  } else if (const auto* contacts = std::get_if<server::ReadContacts>(&model)) {
    for (const auto& patch : contacts->set.patches)
      validate(answer.object->mesh, patch);
    if (contacts->map) validate(*contacts->map);
  }
}

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  ByteReader input(bytes, size);
  const Answer& answer = answers()[input.take<std::uint8_t>() % answers().size()];
  std::string damaged = answer.bytes;
  while (input.left() > 0 && !damaged.empty()) {
    const std::size_t at = input.take<std::uint16_t>() % damaged.size();
    const auto count = input.take<std::uint8_t>();
    if (count == 0xff) {
      damaged.resize(at);
    } else {
      const std::string_view text = input.takeText(count % 9U);
      damaged.replace(at, std::min(text.size(), damaged.size() - at), text);
    }
  }
  const handgraft::io::MeshFile* object = answer.object.get();
  try {
    const server::ReadModel model = server::unpackModel(damaged, object);
    requireSane(model, answer);
    const std::string once = pack(model);
    HANDGRAFT_PROMISE(pack(server::unpackModel(once, object)) == once);
  } catch (const handgraft::InvalidInput&) {
    // The answer that most bytes deserve.
  }
  try {
    (void)server::unpackRequest(damaged);
  } catch (const handgraft::InvalidInput&) {
    // Likewise.
  }
  return 0;
}
