#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "client/commands/commands.h"
#include "client/grasp_result.h"
#include "client/model_files.h"
#include "client/output_file.h"
#include "client/send_model.h"
#include "client/server_link.h"

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
v1::SessionState openSession(ServerLink& server,
                             ModelSender& sender,
                             const GraspOptions& options,
                             GraspInputs& inputs,
                             v1::OpenSessionRequest& request);

/// Asks for what else the picture shows, and writes it. `result.hand` must have been described
/// with its meshes.
void writePicture(ServerLink& server,
                  const std::filesystem::path& png,
                  const GraspResult& result);

/// Has the server write its session in a format, and keeps that in a file. For `problem`, the
/// hand's URDF is written beside it (`writeHand`). Complaints name the file by `file.option`.
/// Errors: InvalidInput for a file that may not be written; Refused for a format that is none.
void exportSession(ServerLink& server,
                   std::uint64_t session_id,
                   const std::string& format,
                   const NamedFile& file);

/// Writes the hand's URDF into the folder and returns its name there. A file that others may
/// need stays, and so do those of `taken`, which are to be written later: then a hash of the
/// content tells this one apart.
/// Errors: InvalidInput if that name is taken, too, naming the file.
std::filesystem::path writeHand(const v1::HandDescription& hand,
                                const std::filesystem::path& folder,
                                const std::vector<std::filesystem::path>& taken);

}  // namespace handgraft::client
