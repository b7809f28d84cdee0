#pragma once

#include <string>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/cli/options/model_flags.h"

namespace handgraft::client {

/// What `grasp` and `edit` both take: the three models, how they are read, where the object is
/// and how the pose is searched. CLI11 writes into it until it has parsed, so it must stay
/// where it is.
class GraspFlags {
 public:
  void addTo(CLI::App& command);

  /// True if any of the three models was named.
  [[nodiscard]] bool named() const;

  /// What they say. Errors: InvalidInput naming the option, its value and what it may be; also
  /// if one of the three models is missing.
  [[nodiscard]] GraspOptions grasp() const;

  /// Errors: InvalidInput naming the first of them that was given besides the models: they are
  /// for `whom` alone.
  void requireUnused(const char* whom) const;

 private:
  std::vector<CLI::Option*> models_;
  std::vector<CLI::Option*> options_;  ///< but for those of the readers below
  GraspOptions grasp_;
  std::string normal_form_;
  std::vector<double> place_;
  std::vector<double> weights_;
  HandFlags hand_;
  ContactFlags contacts_;
};

}  // namespace handgraft::client
