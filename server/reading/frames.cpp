#include "server/reading/frames.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/error.h"

namespace handgraft::server {

namespace {

constexpr std::size_t kHead = 1 + sizeof(std::uint64_t);

bool exists(char kind) {
  return std::string_view("pmwuox").find(kind) != std::string_view::npos;
}

std::size_t sizeIn(const std::string& bytes) {
  std::uint64_t size = 0;
  std::memcpy(&size, bytes.data() + 1, sizeof(size));
  return static_cast<std::size_t>(size);
}

/// Checked as soon as it is there, before what follows is kept.
void validateHead(const std::string& bytes) {
  if (bytes.empty()) return;
  if (!exists(bytes[0])) rejectInput("what the reader sent is damaged: no frame");
  if (bytes.size() < kHead) return;
  const bool is_model = bytes[0] == static_cast<char>(FrameKind::kModel);
  const std::size_t most = is_model ? kMostModelBytes : kMostWords;
  if (sizeIn(bytes) > most) {
    rejectInput("what was read takes {} bytes; permitted are {}", sizeIn(bytes), most);
  }
}

}  // namespace

std::string framed(FrameKind kind, std::string_view payload) {
  if (kind != FrameKind::kModel) payload = payload.substr(0, kMostWords);
  const std::uint64_t size = payload.size();
  std::string frame(kHead, static_cast<char>(kind));
  std::memcpy(frame.data() + 1, &size, sizeof(size));
  frame.append(payload);
  return frame;
}

std::string progressFrame(std::string_view stage, double fraction) {
  std::string payload(sizeof(fraction), '\0');
  std::memcpy(payload.data(), &fraction, sizeof(fraction));
  payload.append(stage);
  return framed(FrameKind::kProgress, payload);
}

void FrameReader::add(std::string_view bytes) {
  bytes_.append(bytes);
  validateHead(bytes_);
}

std::optional<Frame> FrameReader::next() {
  validateHead(bytes_);
  if (bytes_.size() < kHead || bytes_.size() - kHead < sizeIn(bytes_)) return std::nullopt;
  const std::size_t size = sizeIn(bytes_);
  Frame frame{static_cast<FrameKind>(bytes_[0]), {}};
  if (bytes_.size() == kHead + size) {
    // A model is large and comes last: no second copy of it.
    frame.payload = std::move(bytes_);
    frame.payload.erase(0, kHead);
    bytes_.clear();
    return frame;
  }
  frame.payload = bytes_.substr(kHead, size);
  bytes_.erase(0, kHead + size);
  return frame;
}

ProgressWords progressIn(const std::string& payload) {
  constexpr std::size_t kLongest = 100;
  ProgressWords words;
  if (payload.size() < sizeof(words.fraction))
    rejectInput("what the reader sent is damaged: progress without a fraction");
  std::memcpy(&words.fraction, payload.data(), sizeof(words.fraction));
  if (!(words.fraction >= 0.0 && words.fraction <= 1.0))
    rejectInput("what the reader sent is damaged: a fraction outside 0 to 1");
  words.stage = payload.substr(sizeof(words.fraction), kLongest);
  std::replace_if(
      words.stage.begin(), words.stage.end(),
      [](char c) {
        return c < ' ' || c > '~';
      },
      '?');
  return words;
}

}  // namespace handgraft::server
