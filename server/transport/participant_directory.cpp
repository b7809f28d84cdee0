#include "server/transport/participant_directory.h"

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <iterator>
#include <string>

#include <fastdds/rtps/participant/ParticipantDiscoveryInfo.h>
#include <fastdds/rtps/reader/ReaderDiscoveryInfo.h>

#include "core/base/error.h"

namespace handgraft::server {

namespace security = idl::security;

namespace {

bool isWithin(const security::Lifetime& lifetime, std::int64_t now_s) {
  return lifetime.not_before_s <= now_s && now_s <= lifetime.not_after_s;
}

}  // namespace

ParticipantDirectory::ParticipantDirectory(const std::optional<security::Identity>& own) {
  if (!own) return;
  const std::string file = own->file(security::kAuthorityFile);
  authority_ = security::Certificate::read(security::readTextFile(file), file);
}

std::optional<security::Named> ParticipantDirectory::whoIs(const Sender& sender) const {
  security::GuidBegin begin;
  std::copy_n(sender.begin(), begin.size(), begin.begin());
  const std::lock_guard lock(mutex_);
  const auto found = known_.find(begin);
  if (found == known_.end()) return std::nullopt;
  return found->second.named;
}

bool ParticipantDirectory::admits(security::GuidBegin begin, std::string_view pem) {
  if (!authority_) return true;
  const std::int64_t now_s = std::time(nullptr);
  {
    const std::lock_guard lock(mutex_);
    const auto known = known_.find(begin);
    if (known != known_.end() && known->second.pem == pem)
      return isWithin(known->second.lifetime, now_s);
  }
  try {
    const auto shown = security::Certificate::read(std::string(pem), "");
    const std::string subject = shown.commonName();
    if (security::guidBeginOf(subject) != begin || !shown.isSignedBy(*authority_)) return false;
    const security::Named named = security::readCommonName(subject, "");
    const security::Lifetime lifetime = shown.lifetime();
    const std::lock_guard lock(mutex_);
    known_[begin] = {named, std::string(pem), lifetime};
    return isWithin(lifetime, now_s);
  } catch (const InvalidInput&) {  // none that `handgraft keys` makes
    return false;
  }
}

bool ParticipantDirectory::isRead(const std::string& topic) const {
  const std::lock_guard lock(mutex_);
  return read_.count(topic) != 0;
}

void ParticipantDirectory::on_subscriber_discovery(
    eprosima::fastdds::dds::DomainParticipant* /*self*/,
    eprosima::fastrtps::rtps::ReaderDiscoveryInfo&& found) {
  using Info = eprosima::fastrtps::rtps::ReaderDiscoveryInfo;
  constexpr std::string_view kBegin = "rt/handgraft/";
  constexpr std::size_t kMost = 4096;  // topics; anybody may say that he reads some
  const std::string topic = found.info.topicName().c_str();
  if (topic.compare(0, kBegin.size(), kBegin) != 0) return;
  const std::lock_guard lock(mutex_);
  if (found.status == Info::REMOVED_READER) {
    const auto at = read_.find(topic);
    if (at == read_.end()) return;
    at->second.erase(found.info.guid());
    if (at->second.empty()) read_.erase(at);
  } else if (read_.size() < kMost || read_.count(topic) != 0) {
    read_[topic].insert(found.info.guid());
  }
}

void ParticipantDirectory::tell(BusListener* listener) {
  const std::lock_guard lock(listener_mutex_);
  listener_ = listener;
}

void ParticipantDirectory::on_participant_discovery(
    eprosima::fastdds::dds::DomainParticipant* /*self*/,
    eprosima::fastrtps::rtps::ParticipantDiscoveryInfo&& found) {
  using Info = eprosima::fastrtps::rtps::ParticipantDiscoveryInfo;
  if (found.status != Info::REMOVED_PARTICIPANT && found.status != Info::DROPPED_PARTICIPANT)
    return;
  Sender sender{};
  const auto& guid = found.info.m_guid.guidPrefix.value;
  std::copy(std::begin(guid), std::end(guid), sender.begin());
  const std::lock_guard lock(listener_mutex_);
  if (listener_ != nullptr) listener_->onGone(sender);
}

}  // namespace handgraft::server
