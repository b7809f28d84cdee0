#pragma once

#include <cstdint>

#include "hardware/protocols/bytes.h"
#include "hardware/protocols/can_frame.h"
#include "hardware/protocols/stream_reader.h"

/// CAN frames as lines of text on a tty, as CAN adapters speak it ("Lawicel", "SLCAN").
///
/// A line ends in CR; an adapter says BEL alone for an error. There is no checksum: damage to a
/// digit gives another well-formed frame. It is safe only where the tty's own carrier has one,
/// as USB has.
/// Source: Lawicel AB, "CAN232 command set".
namespace handgraft::protocols::slcan {

/// Lines of at most 32 bytes, or the last 32 of a longer one, which are none of a CAN frame. A
/// frame's content is the line with its CR, or a BEL.
struct Framing {
  static constexpr std::size_t kLongest = 64;

  Cut cut(Bytes window, ByteBuffer& frame) const;
};

/// What an adapter, or a host, said in one line.
struct Line {
  enum class Kind {
    kFrame,  ///< a CAN frame
    kDone,   ///< the answer to a command that was done
    kError,  ///< BEL
    kOther,  ///< a command, a version, a flag; or nothing that we know
  };

  Kind kind = Kind::kOther;
  CanFrame frame;
};

/// Digits of either case; a time stamp of four digits after the data is read over.
Line lineOf(Bytes content);

/// Replaces `out` by the frame's line. Errors: BrokenContract for an id or size out of range.
void encode(const CanFrame& frame, ByteBuffer& out);

/// The digit of the command `S` for a bit rate; -1 if the protocol has none for it.
int bitRateDigit(int bits_per_second);

}  // namespace handgraft::protocols::slcan
