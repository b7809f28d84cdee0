#include "core/io/hand_joints_file.h"

#include <exception>
#include <iterator>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/io/file_bytes.h"

namespace handgraft::io {
namespace {

using nlohmann::json;

contact::HandJoints jointsFrom(const json& list) {
  contact::HandJoints joints;
  if (!list.is_array() || list.size() != static_cast<std::size_t>(joints.p_O.cols())) {
    rejectInput("joints are {}; a list of {} places is needed",
                list.is_array() ? fmt::format("{} items", list.size()) : "no list",
                joints.p_O.cols());
  }
  for (std::size_t i = 0; i < list.size(); ++i) {
    const json& place = list[i];
    if (!place.is_array() || place.size() != 3) rejectInput("joint {} is no [x, y, z]", i);
    for (std::size_t k = 0; k < 3; ++k) {
      if (!place[k].is_number()) rejectInput("joint {} is no [x, y, z]", i);
      joints.p_O(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(i)) =
          place[k].get<double>();
    }
  }
  validate(joints);
  return joints;
}

bool isValid(const json& hand) {
  if (!hand.is_object() || !hand.contains("joints")) return false;
  const auto valid = hand.find("valid");
  return valid == hand.end() || (valid->is_boolean() && valid->get<bool>());
}

/// The index of the hand that is meant.
std::size_t handOf(const json& hands, std::optional<int> wanted) {
  if (!hands.is_array()) rejectInput("field 'hands' is no list");
  std::vector<std::size_t> valid;
  for (std::size_t i = 0; i < hands.size(); ++i) {
    if (isValid(hands[i])) valid.push_back(i);
  }
  if (valid.empty()) rejectInput("none of {} hands is valid", hands.size());
  if (!wanted) {
    if (valid.size() > 1)
      rejectInput("has {} valid hands: {}; say which", valid.size(), fmt::join(valid, ", "));
    return valid.front();
  }
  if (*wanted < 0 || *wanted >= std::ssize(hands) ||
      !isValid(hands[static_cast<std::size_t>(*wanted)])) {
    rejectInput("hand {} is not among its valid hands: {}", *wanted, fmt::join(valid, ", "));
  }
  return static_cast<std::size_t>(*wanted);
}

HandsOfFile handsFrom(const json& hands, std::optional<int> wanted) {
  const std::size_t own = handOf(hands, wanted);
  HandsOfFile result{jointsFrom(hands[own].at("joints")), {}};
  for (std::size_t i = 0; i < hands.size(); ++i) {
    if (i != own && isValid(hands[i]))
      result.others.push_back(jointsFrom(hands[i].at("joints")));
  }
  return result;
}

HandsOfFile handsIn(const json& root, std::optional<int> hand) {
  if (root.is_array()) return {jointsFrom(root), {}};
  if (!root.is_object()) rejectInput("is neither a list of joints nor an object that has one");
  if (root.contains("hands")) return handsFrom(root["hands"], hand);
  if (root.contains("joints")) return {jointsFrom(root["joints"]), {}};
  rejectInput("has neither of the fields 'hands' and 'joints'");
}

}  // namespace

HandsOfFile readHands(const std::filesystem::path& path, std::optional<int> hand) {
  constexpr std::size_t kMostBytes = 64U << 20U;
  if (requireFile(path) > kMostBytes)
    rejectInput("{}: is larger than {} bytes", quoted(path.string()), kMostBytes);
  const std::string text = readFileBytes(path);
  try {
    return handsIn(json::parse(text), hand);
  } catch (const std::exception& error) {  // json's own, or ours
    rejectInput("{}: {}", quoted(path.string()), error.what());
  }
}

contact::HandJoints readHandJoints(const std::filesystem::path& path, std::optional<int> hand) {
  return readHands(path, hand).joints;
}

}  // namespace handgraft::io
