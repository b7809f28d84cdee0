#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "client/cli/commands/commands.h"
#include "client/link/client.h"
#include "client/link/grasp_result.h"
#include "client/link/model_files.h"
#include "client/present/output_file.h"
#include "client/present/send_model.h"

/// What `grasp` and `edit` share: from models, named or in files, to an open session.
namespace handgraft::client {

/// The three models of a grasp: files to send first, or nothing where the server has the model.
struct GraspInputs {
  std::optional<ModelFiles> hand;
  std::optional<ModelFiles> object;
  std::optional<ModelFiles> contacts;
};

/// Finds every file. Errors: InvalidInput as those of model_files.h.
GraspInputs collectInputs(const GraspOptions& options);

/// All files that are read, by the options that name them.
std::vector<NamedFile> filesOf(const GraspInputs& inputs);

/// The session's options; its models have no names yet. Errors: InvalidInput for `--place`.
v1::OpenSessionRequest sessionRequest(const GraspOptions& options);

/// How the options have the pose searched.
v1::SolveOptions solvingOf(const GraspOptions& options);

/// Sends what is in files and opens the session. `request` holds the models' names afterwards.
v1::SessionState openSession(Client& server,
                             ModelSender& sender,
                             const GraspOptions& options,
                             GraspInputs& inputs,
                             v1::OpenSessionRequest& request);

}  // namespace handgraft::client
