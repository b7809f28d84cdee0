#pragma once

namespace handgraft::client {

/// What to do when no server answers.
enum class Absence {
  kFail,          ///< NoServer within 2 s
  kStartPrivate,  ///< start one that ends with the client
};

}  // namespace handgraft::client
