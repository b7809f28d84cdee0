#include "core/formats/demonstration_text.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/time_note.h"
#include "core/formats/demonstration_arrays.h"
#include "core/formats/json_keys.h"
#include "core/formats/npz_file.h"
#include "core/formats/zip_file.h"

namespace handgraft::formats {

namespace {

using nlohmann::json;

constexpr std::size_t kJoints = 21;
constexpr std::size_t kManoPose = 48;

const json& listIn(const json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end()) rejectInput("field '{}' is missing", name);
  if (!found->is_array()) rejectInput("field '{}' is no list", name);
  return *found;
}

const json& rowIn(const json& list, const char* name, std::size_t index) {
  if (index >= list.size())
    rejectInput("field '{}' has {} frames, fewer than 'time_s'", name, list.size());
  return list[index];
}

/// Frames whose time nobody tells would be lost without a word.
void requireNoMore(const json& root, std::size_t frames) {
  for (const char* name :
       {"object_pose", "joints_W_m", "mano_pose_rad", "mano_translation_m"}) {
    const auto list = root.find(name);
    if (list == root.end() || list->size() <= frames) continue;
    rejectInput("field '{}' has {} frames, more than 'time_s', which has {}", name,
                list->size(), frames);
  }
}

/// Trackers write so what they lost.
bool isLost(const json& number) {
  return number.is_null() || (number.is_number() && std::isnan(number.get<double>()));
}

/// A list of `count` finite numbers, behind those in `numbers`; NaN for what was lost.
void append(const json& row,
            const char* name,
            std::size_t frame,
            std::size_t count,
            std::vector<double>& numbers) {
  if (row.is_null()) {
    numbers.insert(numbers.end(), count, std::nan(""));
    return;
  }
  if (!row.is_array() || row.size() != count)
    rejectInput("field '{}', frame {}: it must be a list of {} numbers", name, frame, count);
  for (const json& number : row) {
    if (isLost(number)) {
      numbers.push_back(std::nan(""));
      continue;
    }
    if (!number.is_number() || !std::isfinite(number.get<double>()))
      rejectInput("field '{}', frame {}: {} is no finite number", name, frame, shown(number));
    numbers.push_back(number.get<double>());
  }
}

void appendPlaces(const json& row,
                  const char* name,
                  std::size_t frame,
                  std::vector<double>& numbers) {
  if (row.is_null()) {
    numbers.assign(3 * kJoints, std::nan(""));
    return;
  }
  if (!row.is_array() || row.size() != kJoints)
    rejectInput("field '{}', frame {}: it must be a list of {} places", name, frame, kJoints);
  for (const json& place : row)
    append(place, name, frame, 3, numbers);
}

std::vector<double> timesIn(const json& root) {
  std::vector<double> times;
  for (const json& time : listIn(root, "time_s")) {
    if (!time.is_number() || !std::isfinite(time.get<double>()))
      rejectInput("field 'time_s', frame {}: {} is no finite number", times.size(),
                  shown(time));
    times.push_back(time.get<double>());
    const std::size_t count = times.size();
    if (count > 1 && times[count - 1] <= times[count - 2])
      rejectInput("field 'time_s', frame {}: {} s does not lie behind the one before",
                  count - 1, times.back());
  }
  if (times.empty()) rejectInput("field 'time_s' has no frames");
  return times;
}

/// Leaves out what the tracker lost, and says so.
void leaveOutLost(Demonstration& demonstration) {
  const auto is_lost = [](const DemonstrationFrame& frame) {
    const auto is_nan = [](double number) {
      return std::isnan(number);
    };
    return std::any_of(frame.values.begin(), frame.values.end(), is_nan) ||
           std::any_of(frame.object_pose.begin(), frame.object_pose.end(), is_nan);
  };
  std::vector<DemonstrationFrame>& frames = demonstration.frames;
  const auto first = std::find_if(frames.begin(), frames.end(), is_lost);
  if (first == frames.end()) return;
  const double first_s = first->time_s;
  const std::size_t before = frames.size();
  std::erase_if(frames, is_lost);
  const std::size_t lost = before - frames.size();
  if (frames.empty())
    rejectInput("each of the {} frames has null or NaN in place of a number", before);
  demonstration.notes.push_back(
      fmt::format("left out {} of {} frames, which have null or NaN in place of a number{} "
                  "{:.3f} s",
                  lost, before, lost == 1 ? ": at" : ", the first at", first_s));
}

/// What is to be told of the frames that are left.
void noteGaps(Demonstration& demonstration) {
  std::vector<double> times;
  for (const DemonstrationFrame& frame : demonstration.frames)
    times.push_back(frame.time_s);
  if (std::string note = timeGapNote(times); !note.empty())
    demonstration.notes.push_back(std::move(note));
}

bool isLeftIn(const json& root) {
  const std::string side = root.value("side", std::string("right"));
  if (side != "right" && side != "left")
    rejectInput("field 'side' is {}; it is right or left", quoted(side));
  return side == "left";
}

}  // namespace

Demonstration demonstrationFrom(const json& root) {
  if (!root.is_object() || root.value("format", json()) != kDemonstrationFormat)
    rejectInput("field 'format' must be '{}'", kDemonstrationFormat);
  if (const auto fault =
          unknownKeyIn(root, {"format", "object", "side", "time_s", "object_pose", "joints_W_m",
                              "mano_pose_rad", "mano_translation_m"}))
    rejectInput("{}", *fault);
  Demonstration demonstration;
  if (const auto object = root.find("object"); object != root.end() && object->is_string())
    demonstration.object = *object;
  demonstration.is_left = isLeftIn(root);
  demonstration.is_mano = root.contains("mano_pose_rad");
  if (demonstration.is_mano == root.contains("joints_W_m"))
    rejectInput("one of the fields 'joints_W_m' and 'mano_pose_rad' must be there");
  // One pose: the object stands still.
  const json& objects = listIn(root, "object_pose");
  for (const double time_s : timesIn(root)) {
    const std::size_t k = demonstration.frames.size();
    DemonstrationFrame frame;
    frame.time_s = time_s;
    std::vector<double> pose;
    append(rowIn(objects, "object_pose", objects.size() == 1 ? 0 : k), "object_pose", k, 7,
           pose);
    std::copy(pose.begin(), pose.end(), frame.object_pose.begin());
    if (demonstration.is_mano) {
      for (const auto& [name, count] : {std::pair("mano_pose_rad", kManoPose),
                                        std::pair("mano_translation_m", std::size_t{3})})
        append(rowIn(listIn(root, name), name, k), name, k, count, frame.values);
    } else {
      constexpr const char* kPlaces = "joints_W_m";
      appendPlaces(rowIn(listIn(root, kPlaces), kPlaces, k), kPlaces, k, frame.values);
    }
    demonstration.frames.push_back(std::move(frame));
  }
  requireNoMore(root, demonstration.frames.size());
  leaveOutLost(demonstration);
  noteGaps(demonstration);
  return demonstration;
}

Demonstration parseDemonstration(std::string_view bytes) {
  try {
    return isZip(bytes) ? demonstrationFrom(readNpz(bytes))
                        : demonstrationFrom(parsedJson(bytes));
  } catch (const json::exception& error) {
    rejectInput("{}", error.what());
  }
}

}  // namespace handgraft::formats
