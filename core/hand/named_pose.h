#pragma once

#include <string>

#include <Eigen/Core>

namespace handgraft::hand {

/// A pose of the fingers that somebody gave a name: "open", "pinch".
struct NamedPose {
  std::string name;
  Eigen::VectorXd q;  ///< of all dofs of a model, within their limits
};

}  // namespace handgraft::hand
