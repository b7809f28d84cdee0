#pragma once

#include "tests/support/environment_variable.h"

namespace handgraft::test {

/// While it lives, servers that this process starts keep hands' skins in a folder of the build,
/// where all tests find them: a skin takes seconds to make. Sound because a skin's file is
/// named by all that it was made of, written whole or not at all, and checked when it is read;
/// and the folder is another one for every server that was built, so that no test sees what an
/// older one made.
///
/// Declare it before the Service.
class SharedSkins {
 public:
  SharedSkins();

 private:
  EnvironmentVariable cache_;
};

}  // namespace handgraft::test
