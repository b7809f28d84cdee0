// Fast DDS 2.9.1 filters on the writer's side: for readers that announce a filter, which
// Cyclone DDS 0.10.2's never do, or by any filter that its RTPS layer is given. A DataWriter
// does not show its own part of that layer; the library finds it by GUID, for what is delivered
// within a process, and exports that function. Nothing outside this file knows of it.
#include <algorithm>
#include <iterator>

#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/rtps/interfaces/IReaderDataFilter.hpp>
#include <fastdds/rtps/writer/RTPSWriter.h>

#include "core/base/error.h"
#include "server/transport/addressed_writer.h"

namespace eprosima::fastrtps::rtps {

/// As src/cpp/rtps/RTPSDomainImpl.hpp of 2.9.1 has it.
class RTPSDomainImpl {
 public:
  // NOLINTNEXTLINE(readability-identifier-naming): Fast DDS' name
  static RTPSWriter* find_local_writer(const GUID_t& writer_guid);
};

}  // namespace eprosima::fastrtps::rtps

namespace handgraft::server {

namespace {

namespace rtps = eprosima::fastrtps::rtps;

/// Of this thread: Fast DDS asks for whom a sample is before `write` returns, on the thread
/// that writes, also where another one sends it.
thread_local const Sender* addressee = nullptr;

// Fast DDS' interface has no virtual destructor; nobody deletes this one.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wnon-virtual-dtor"

class ForOne final : public eprosima::fastdds::rtps::IReaderDataFilter {
 public:
  [[nodiscard]] bool is_relevant(const rtps::CacheChange_t& /*change*/,
                                 const rtps::GUID_t& reader) const override {
    const auto& prefix = reader.guidPrefix.value;
    return addressee != nullptr &&
           std::equal(std::begin(prefix), std::end(prefix), addressee->begin());
  }
};

#pragma GCC diagnostic pop

rtps::RTPSWriter& innerOf(const eprosima::fastdds::dds::DataWriter& writer) {
  rtps::RTPSWriter* const inner = rtps::RTPSDomainImpl::find_local_writer(writer.guid());
  HANDGRAFT_REQUIRE(inner != nullptr);
  return *inner;
}

}  // namespace

void askThoseWhoOweAnAnswer(eprosima::fastdds::dds::DataWriter& writer) {
  innerOf(writer).set_separate_sending(true);
}

void sendToOneAlone(eprosima::fastdds::dds::DataWriter& writer) {
  static ForOne filter;  // of no state, and of all writers
  innerOf(writer).reader_data_filter(&filter);
}

WritingTo::WritingTo(const Sender& whom) {
  addressee = &whom;
}

WritingTo::~WritingTo() {
  addressee = nullptr;
}

}  // namespace handgraft::server
