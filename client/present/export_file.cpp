#include "client/present/export_file.h"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "client/link/model_files.h"
#include "client/present/grasp_picture.h"
#include "client/present/joint_unit.h"
#include "client/present/motion_picture.h"
#include "client/present/png_file.h"
#include "core/base/error.h"
#include "idl/fields.h"

namespace handgraft::client {

namespace fs = std::filesystem;

namespace {

// False also for what is no file.
bool holds(const fs::path& path, const std::string& text) {
  std::error_code error;
  if (!fs::is_regular_file(path, error) || fs::file_size(path, error) != text.size()) {
    return false;
  }
  return text.empty() || readFile(path) == text;
}

/// Equally far apart, from shortly before the first frame that touches, as the hand comes, to
/// about as long after the last one.
std::vector<v1::MotionFrame> shownFrames(Client& server, const MotionResult& result) {
  constexpr double kShortly = 0.5;  // s
  std::uint32_t first = 0;
  auto last = static_cast<std::uint32_t>(result.frames.size()) - 1;
  const auto touches = [](const v1::MotionFrame& frame) {
    return !frame.patches().empty();
  };
  const auto begin = std::find_if(result.frames.begin(), result.frames.end(), touches);
  if (begin != result.frames.end()) {
    const double from_s = begin->time_s() - kShortly;
    const double to_s =
        std::find_if(result.frames.rbegin(), result.frames.rend(), touches)->time_s() +
        kShortly;
    const auto is_shown = [&](const v1::MotionFrame& frame) {
      return frame.time_s() >= from_s && frame.time_s() <= to_s;
    };
    first = std::find_if(result.frames.begin(), result.frames.end(), is_shown)->index();
    last = std::find_if(result.frames.rbegin(), result.frames.rend(), is_shown)->index();
  }
  v1::MotionFramesRequest request;
  request.session_id(result.session.session_id());
  request.first(first);
  request.count(kFramesShown);
  request.every(std::max<std::uint32_t>(1, (last - first) / (kFramesShown - 1)));
  request.with_shapes(true);
  return server.motionFrames(request).get().frames();
}

}  // namespace

void writePicture(Client& server, const fs::path& png, const GraspResult& result) {
  const v1::SessionState& session = result.session;
  const v1::ModelDescription object =
      server.describe(v1::MODEL_OBJECT, session.object(), true).get();
  const v1::ModelDescription contacts =
      server.describe(v1::MODEL_CONTACTS, session.contacts(), false).get();
  const GraspPicture picture = pictureOf(result, object.object(), contacts.contacts());
  writePng(png, render::renderTwoViews(picture.scene, picture.caption));
}

void writeMotionPicture(Client& server, const fs::path& png, const MotionResult& result) {
  const std::vector<v1::MotionFrame> shown = shownFrames(server, result);
  const v1::ModelDescription hand =
      server.describe(v1::MODEL_HAND, result.session.hand(), true).get();
  const v1::ModelDescription object =
      server.describe(v1::MODEL_OBJECT, result.session.object(), true).get();
  writePng(png, motionPicture(result, shown, hand.hand(), object.object()));
}

fs::path writeHand(const v1::HandDescription& hand,
                   const fs::path& folder,
                   const std::vector<fs::path>& taken) {
  checkModelName(hand.name(), "hand");  // it becomes a file name
  const fs::path plain = hand.name() + ".urdf";
  const fs::path hashed = fmt::format("{}-{}.urdf", hand.name(), shortHash(hand.urdf()));
  for (const fs::path& name : {plain, hashed}) {
    const fs::path path = folder / name;
    const bool is_taken = std::any_of(taken.begin(), taken.end(), [&](const fs::path& file) {
      return !file.empty() &&
             fs::absolute(file).lexically_normal() == fs::absolute(path).lexically_normal();
    });
    if (is_taken) continue;
    if (holds(path, hand.urdf())) return name;
    std::error_code error;
    if (fs::exists(fs::symlink_status(path, error))) continue;
    writeFile(path, hand.urdf());
    return name;
  }
  rejectInput("a file {} with other content is there already",
              quoted((folder / hashed).string()));
}

const std::vector<std::string>& exportFormats() {
  static const std::vector<std::string> all_formats =
      idl::namesOf(idl::typeOf<v1::ExportFormat>());
  return all_formats;
}

std::vector<std::string> beyondOwnLimits(const v1::SessionSettings& settings) {
  const bool is_motion = !settings.state().motion().empty();
  constexpr double kSame = 1e-9;  // rad or m; what writing and reading a number may cost
  std::vector<std::string> notes;
  for (const v1::JointSetting& joint : settings.joints()) {
    const double least = is_motion ? joint.lower() : joint.value();
    const double most = is_motion ? joint.upper() : joint.value();
    if (least >= joint.model_lower() - kSame && most <= joint.model_upper() + kSame) continue;
    const JointUnit unit = unitOf(joint.kind());
    const std::string own = fmt::format("beyond the hand's own limits, {:.4g} to {:.4g} {}",
                                        unit.scale * joint.model_lower(),
                                        unit.scale * joint.model_upper(), unit.name);
    notes.push_back(is_motion
                        ? fmt::format("joint {} may go from {:.4g} to {:.4g} {}, {}",
                                      quoted(joint.name()), unit.scale * least,
                                      unit.scale * most, unit.name, own)
                        : fmt::format("joint {} is at {:.4g} {}, {}", quoted(joint.name()),
                                      unit.scale * least, unit.name, own));
  }
  return notes;
}

std::vector<std::string> exportSession(Client& server,
                                       std::uint64_t session_id,
                                       const std::string& format,
                                       const NamedFile& file,
                                       Exported what) {
  requireWritable(file);
  v1::ExportRequest request;
  request.session_id(session_id);
  request.format(v1::enumeratorFrom<v1::ExportFormat>(format, "format"));
  request.live(what == Exported::kLive);
  if (request.format() == v1::EXPORT_PROBLEM) {
    const std::string hand = server.describeSession(session_id).get().hand();
    request.urdf_path(writeHand(server.describe(v1::MODEL_HAND, hand, false).get().hand(),
                                fs::absolute(file.path).parent_path(), {file.path})
                          .string());
  }
  ExportedFile exported = server.exportSession(request).get();
  writeFile(file.path, exported.content);
  return std::move(exported.notes);
}

}  // namespace handgraft::client
