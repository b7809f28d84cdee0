#pragma once

#include <string>

namespace handgraft {

/// A joint's limits, rad or m; infinite where it has none.
struct JointRange {
  double lower = 0.0;
  double upper = 0.0;
};

/// What to tell who set `limits`: angles that go round more than once seem to be degrees,
/// travels of more than a metre millimetres. As far as `own` goes, the hand's file, all is
/// meant; what the hand itself cannot do is told. Empty: nothing to tell.
std::string limitNote(const std::string& joint,
                      bool slides,
                      const JointRange& limits,
                      const JointRange& own);

}  // namespace handgraft
