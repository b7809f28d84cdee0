#pragma once

#include "tests/bench/live/room.h"

namespace handgraft::bench {

/// One edit after another, each waited for.
void latency(const LiveOptions& options);

/// Many sessions, each edited at the same rate: whether all are served alike, and what a
/// session takes.
void crowd(const LiveOptions& options);

/// A session edited calmly, while another process floods a second one.
void flood(const LiveOptions& options);

/// The flood: publishes edits of a session at a rate, and counts what became of them; a process
/// of its own.
void pour(const LiveOptions& options);

}  // namespace handgraft::bench
