#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "core/base/network.h"
#include "idl/edits.h"
#include "idl/motions.h"
#include "idl/security/identity.h"
#include "idl/sensor_msgs.h"
#include "idl/service.h"

namespace handgraft::server {

/// The participant that a message came from, as DDS itself says (its GUID's prefix, then
/// zeros): not what the message claims.
using Sender = std::array<std::uint8_t, 16>;

/// Hears what clients and other servers send. Called on DDS threads: must return soon and not
/// throw.
class BusListener {
 public:
  virtual ~BusListener() = default;
  virtual void onRequest(v1::Request request, const Sender& sender) = 0;
  virtual void onEdit(v1::Edit edit, const Sender& sender) = 0;

  /// A demonstrator's, for the session that it names.
  virtual void onDemonstrator(v1::DemonstratorFrame frame, const Sender& sender) = 0;

  /// A participant left, or was not heard for a lease.
  virtual void onGone(const Sender& /*sender*/) {}

  /// Any server's status, one's own among them.
  virtual void onStatus(const v1::ServerStatus& status) = 0;
};

/// What the service needs of DDS, and all that it sees of it.
///
/// Messages that arrive have the shape of their IDL type but are otherwise untrusted:
/// enumerators may not exist, bounded sequences may be longer, strings may hold anything. What
/// does not decode never arrives. Threads: every method from any thread.
class Bus {
 public:
  virtual ~Bus() = default;

  /// Begins to listen. `listener` must live until `stop` returned.
  virtual void start(BusListener& listener) = 0;
  /// Ends listening; no call of the listener is running or will come afterwards.
  virtual void stop() = 0;

  // What answers goes to who asked, and to nobody else.

  virtual void publish(const v1::Reply& reply, const Sender& whom) = 0;

  /// An answer whose request was repeated. What is large and may still be on its way is not
  /// sent anew.
  virtual void publishAgain(const v1::Reply& reply, const Sender& whom) {
    publish(reply, whom);
  }

  virtual void publish(const v1::Progress& progress, const Sender& whom) = 0;
  virtual void publish(const v1::EditReply& reply, const Sender& whom) = 0;

  // What is told to all.

  virtual void publish(const v1::ServerStatus& status) = 0;
  /// Keeps the last solution and state of each session for late joiners, until its state is
  /// PHASE_CLOSED; of closed ones a bounded number.
  virtual void publish(const v1::PoseSolution& solution) = 0;
  virtual void publish(const v1::SessionState& state) = 0;

  /// A session went to sleep: what is kept of it for late joiners may be given back, until it
  /// speaks again. Of so many that slept last it is kept.
  virtual void rest(std::uint64_t /*session_id*/) {}

  /// Frames of a session's motion as they are solved; for late joiners none are kept.
  virtual void publish(const v1::MotionFrames& frames) = 0;
  /// Kept for late joiners, as states are.
  virtual void publish(const v1::MotionClock& clock) = 0;
  /// On rt/handgraft/<session>/joint_command, until the session is closed.
  virtual void publishJointCommand(std::uint64_t session_id,
                                   const sensor_msgs::msg::dds_::JointState_& command) = 0;

  /// Who a participant is, as its certificate says; of no name where that is not known.
  /// Nothing in an open domain, where nobody knows.
  [[nodiscard]] virtual std::optional<idl::security::Named> whoIs(
      const Sender& /*sender*/) const {
    return std::nullopt;
  }

  /// Once a second: takes note of what changed outside, such as identities that were revoked.
  virtual void lookAround() {}

  /// Waits, at most half a second, until clients have received what was published.
  virtual void flush() = 0;
};

/// Joins by Fast DDS. Errors: InvalidInput for the network or its identity, which must be a
/// server's; TransportError if DDS refuses.
std::unique_ptr<Bus> openFastBus(const Network& network);

}  // namespace handgraft::server
