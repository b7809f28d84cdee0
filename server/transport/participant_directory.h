#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include <fastdds/dds/domain/DomainParticipantListener.hpp>

#include "idl/security/certificates.h"
#include "idl/security/guids.h"
#include "idl/security/identity.h"
#include "server/transport/bus.h"

namespace handgraft::server {

/// Which participants there are; and who they are in a secured domain, by the certificates that
/// they show in their handshakes. Fast DDS 2.9.1 does not tell them. One is believed that our
/// authority signed, of GUIDs that begin as its subject has it: DDS itself compares a
/// participant's GUID with its certificate before it takes anything that is encrypted.
/// Threads: all methods from any.
class ParticipantDirectory final : public eprosima::fastdds::dds::DomainParticipantListener {
 public:
  /// Nothing: in an open domain. Errors: InvalidInput if the authority cannot be read.
  explicit ParticipantDirectory(const std::optional<idl::security::Identity>& own);

  [[nodiscard]] std::optional<idl::security::Named> whoIs(const Sender& sender) const;

  /// Whether a handshake may go on that shows this certificate in the name of a GUID that
  /// begins so. From anybody: Fast DDS 2.9.1 gives back nothing of a certificate that it
  /// refuses (`PKIDH::begin_handshake_reply`: 4 kB each), so it sees those of our authority
  /// alone.
  [[nodiscard]] bool admits(idl::security::GuidBegin begin, std::string_view pem);

  /// True where somebody reads that topic, of sessions' own topics (rt/handgraft/...).
  [[nodiscard]] bool isRead(const std::string& topic) const;

  /// From now on hears who is gone; null: nobody does. No call is running once this returned.
  void tell(BusListener* listener);

 private:
  void on_participant_discovery(
      eprosima::fastdds::dds::DomainParticipant* self,
      eprosima::fastrtps::rtps::ParticipantDiscoveryInfo&& found) override;

  void on_subscriber_discovery(eprosima::fastdds::dds::DomainParticipant* self,
                               eprosima::fastrtps::rtps::ReaderDiscoveryInfo&& found) override;

  std::optional<idl::security::Certificate> authority_;
  std::mutex listener_mutex_;
  BusListener* listener_ = nullptr;
  mutable std::mutex mutex_;
  /// Sessions' own topics and who reads them.
  std::map<std::string, std::set<eprosima::fastrtps::rtps::GUID_t>> read_;

  struct Known {
    idl::security::Named named;
    std::string pem;  ///< as it was shown
    idl::security::Lifetime lifetime;
  };

  /// Of all that were ever shown: as many as the authority signed.
  std::map<idl::security::GuidBegin, Known> known_;
};

}  // namespace handgraft::server
