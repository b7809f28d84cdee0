#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "client/link/client.h"
#include "client/link/grasp_result.h"
#include "client/present/motion_result.h"
#include "client/present/output_file.h"

namespace handgraft::client {

/// Asks for what else the picture shows, and writes it. `result.hand` must have been described
/// with its meshes.
void writePicture(Client& server, const std::filesystem::path& png, const GraspResult& result);

/// The same of a motion. Cost: some 2 s.
void writeMotionPicture(Client& server,
                        const std::filesystem::path& png,
                        const MotionResult& result);

/// What a session can be written as by the server, for help and complaints.
const std::vector<std::string>& exportFormats();

/// What whoever puts this on motors must know: which joints of a grasp stand beyond the hand's
/// own limits; of a motion, which may go there.
std::vector<std::string> beyondOwnLimits(const v1::SessionSettings& settings);

/// Of a session with a motion.
enum class Exported {
  kAsSolved,
  kLive,  ///< what its hand did last after a demonstrator
};

/// Has the server write its session in a format, and keeps that in a file. For `problem`, the
/// hand's URDF is written beside it (`writeHand`). Complaints name the file by `file.option`.
/// Returns what its reader must know.
/// Errors: InvalidInput for a file that may not be written; Refused for a format that is none.
std::vector<std::string> exportSession(Client& server,
                                       std::uint64_t session_id,
                                       const std::string& format,
                                       const NamedFile& file,
                                       Exported what = Exported::kAsSolved);

/// Writes the hand's URDF into the folder and returns its name there. A file that others may
/// need stays, and so do those of `taken`, which are to be written later: then a hash of the
/// content tells this one apart.
/// Errors: InvalidInput if that name is taken, too, naming the file.
std::filesystem::path writeHand(const v1::HandDescription& hand,
                                const std::filesystem::path& folder,
                                const std::vector<std::filesystem::path>& taken);

}  // namespace handgraft::client
