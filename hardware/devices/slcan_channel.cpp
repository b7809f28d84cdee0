#include "hardware/devices/slcan_channel.h"

#include <string_view>
#include <utility>

namespace handgraft::devices {

namespace {

constexpr std::chrono::milliseconds kAnswerPatience(50);  // some adapters answer nothing

}  // namespace

SlcanChannel::SlcanChannel(ByteChannel& bytes, int bits_per_second, Clock clock)
    : bytes_(bytes),
      rate_digit_(protocols::slcan::bitRateDigit(bits_per_second)),
      clock_(std::move(clock)) {
  if (rate_digit_ < 0) {
    rejectInput("CAN bit rate {} is none of 10, 20, 50, 100, 125, 250, 500, 800, 1000 kbit/s",
                bits_per_second);
  }
}

void SlcanChannel::open() {
  bytes_.open();
  reader_.clear();
  // A line that somebody else began ends here; an adapter that is closed refuses to close.
  expectAnswer("\rC\r", true);
  const std::array<char, 4> rate = {'S', static_cast<char>('0' + rate_digit_), '\r', '\0'};
  expectAnswer(rate.data(), false);
  expectAnswer("O\r", false);
  first_ = last_ = 0;
}

void SlcanChannel::close() {
  try {
    command("C\r");
  } catch (const TransportError&) {
    // It is gone, which is what was wanted.
  }
  bytes_.close();
}

void SlcanChannel::send(const protocols::CanFrame& frame) {
  protocols::ByteBuffer line;
  protocols::slcan::encode(frame, line);
  bytes_.send(line.bytes());
}

bool SlcanChannel::receive(protocols::CanFrame& frame, TimePoint deadline) {
  while (first_ == last_) {
    if (!fill(deadline)) return false;
  }
  frame = queue_[first_++];
  return true;
}

std::uint64_t SlcanChannel::damaged() const {
  return errors_ + reader_.counters().garbage_bytes;
}

void SlcanChannel::command(const char* text) {
  const std::string_view view(text);
  bytes_.send({reinterpret_cast<const std::uint8_t*>(view.data()), view.size()});
}

void SlcanChannel::expectAnswer(const char* text, bool is_refusable) {
  done_ = refused_ = 0;
  command(text);
  const TimePoint deadline = clock_() + kAnswerPatience;
  // One that may be refused may get several answers, or none: all of them pass.
  while ((is_refusable || done_ + refused_ == 0) && fill(deadline)) {
  }
  if (refused_ > 0 && !is_refusable) {
    throw TransportError(
        fmt::format("the CAN adapter refuses the command {}", std::string_view(text, 1)));
  }
}

bool SlcanChannel::fill(TimePoint deadline) {
  std::array<std::uint8_t, kChunk> chunk{};
  const std::size_t count = bytes_.receive(chunk, deadline);
  if (first_ == last_) first_ = last_ = 0;
  reader_.feed({chunk.data(), count}, [&](protocols::Bytes line) {
    take(line);
  });
  return count > 0;
}

void SlcanChannel::take(protocols::Bytes content) {
  using Kind = protocols::slcan::Line::Kind;
  const protocols::slcan::Line line = protocols::slcan::lineOf(content);
  if (line.kind == Kind::kDone) ++done_;
  if (line.kind == Kind::kError) {
    ++refused_;
    ++errors_;
  }
  if (line.kind == Kind::kOther) ++errors_;
  // While commands are answered, frames may come in any number; those are old ones.
  if (line.kind == Kind::kFrame && last_ < queue_.size()) queue_[last_++] = line.frame;
}

}  // namespace handgraft::devices
