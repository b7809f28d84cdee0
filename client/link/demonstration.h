#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "client/link/client.h"
#include "idl/cyclone/participant.h"
#include "idl/models.h"
#include "idl/motions.h"
#include "idl/sessions.h"

namespace handgraft::client {

/// Sends a demonstrator's frames, for the hand of a session to follow. The poses that answer
/// come by the session's stream, each with its frame's time.
///
/// Threads: one.
class DemonstratorWriter {
 public:
  /// Waits until a server listens, 2 s at most. Errors: NoServer; what the client's checkpoint
  /// throws.
  DemonstratorWriter(Client& client, std::uint64_t session_id);

  /// Its number, whose it is and of which session are told here. A frame that nobody hears is
  /// lost. Errors: NoServer if the server has stopped answering.
  void write(v1::DemonstratorFrame frame);

  [[nodiscard]] std::uint64_t count() const { return sent_; }

 private:
  Client& client_;
  const std::uint64_t session_id_;
  idl::cyclone::Writer<v1::DemonstratorFrame> writer_;
  std::uint64_t sent_ = 0;
};

/// A recorded demonstrator.
struct Demonstration {
  std::string object;  ///< as the file names it; empty: it does not
  /// Times, side, joints' places or MANO's pose, the object's pose. Sessions and numbers are
  /// left to whoever sends them.
  std::vector<v1::DemonstratorFrame> frames;
  /// For whoever recorded it: frames that were left out, gaps in time, what is not read.
  std::vector<std::string> notes;
};

/// Reads `handgraft-demonstration/1` (core/io/FORMATS.md) as the frames that a server follows.
/// Errors: InvalidInput naming the file, the field and the frame.
Demonstration readDemonstration(const std::filesystem::path& path);

/// That a session holds another object than a demonstration names, which is no reason to refuse
/// it: objects of the same shape have several names. Empty if it does not, or none is named.
std::string noteOfAnotherObject(const Demonstration& demonstration,
                                const v1::SessionState& session);

/// That the hand which follows is of the other side than the demonstrator's. Empty if it is
/// not, or if that is not known.
std::string noteOfTheOtherSide(const Demonstration& demonstration,
                               const v1::HandDescription& hand);

}  // namespace handgraft::client
