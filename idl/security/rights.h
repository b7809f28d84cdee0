#pragma once

#include <string>
#include <vector>

#include "idl/operations.h"
#include "idl/topics.h"

namespace handgraft::idl::security {

/// What an identity may do. DDS itself refuses the rest, topic by topic, at both ends.
enum class Role {
  kServer,    ///< serves: the only one whose states, solutions and replies are taken
  kOperator,  ///< an editor who also arms hands, steers them by samples and unloads models
  kEditor,    ///< opens and edits sessions, loads models
  kViewer,    ///< reads the streams, asks what changes nothing
  kHand,      ///< a bridge: follows, tells what it measures, obeys operators alone
};

inline constexpr Role kRoles[] = {Role::kServer, Role::kOperator, Role::kEditor, Role::kViewer,
                                  Role::kHand};

const char* nameOf(Role role);

/// Errors: InvalidInput with the list of roles.
Role roleNamed(const std::string& name);

/// "server, operator, ..." for messages.
std::string namesOfRoles();

/// Topics by DDS Security's patterns: `*` stands for any characters.
struct Rights {
  std::vector<std::string> may_write;
  std::vector<std::string> may_read;
};

/// Of an identity of that role and name: a hand has ROS 2's namespace of its own name.
Rights rightsOf(Role role, const std::string& name);

const Topic<v1::Request>& requestTopicOf(Privilege privilege);

/// "operators", for messages: who has the privilege.
const char* holdersOf(Privilege privilege);

}  // namespace handgraft::idl::security
