// Cyclone DDS 0.10.2, C API. The topic comes from idlc's descriptor (type name, keys, QoS
// checks); samples travel as bytes that Fast CDR makes of fastddsgen's classes, so that both
// vendors share one C++ representation and no message is converted:
//   write: Fast CDR -> a throw-away serdata -> dds_forwardcdr, which validates the bytes
//   against the
//          descriptor and converts them to the writer's own type (ddsi_serdata_ref_as_type).
//   take:  dds_takecdr -> ddsi_serdata_to_ser_ref -> Fast CDR.
// This relies on ddsi_* internals of the version above. Nothing outside this file sees them.
#include "idl/cyclone/participant.h"

#include <atomic>
#include <cstring>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/q_protocol.h>
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include "core/base/error.h"
#include "idl/cyclone/domain.h"
#include "idl/cyclone/entity.h"
#include "idl/cyclone/quality.h"
#include "idl/cyclone/revocation_watch.h"
#include "idl/datagrams/datagram_filter.h"
#include "idl/edits.h"
#include "idl/hardware.h"
#include "idl/motions.h"
#include "idl/ros2.h"
#include "idl/security/identity.h"
#include "idl/sensor_msgs.h"
#include "idl/service.h"

namespace handgraft::idl::cyclone {

namespace {

/// As a server of a secured domain calls itself to all who discover it (server/transport).
constexpr const char* kSecuredServer = "handgraft-server, secured";

std::string nameOf(Discovers discovers) {
  return discovers == Discovers::kAll ? std::string() : std::string(DatagramFilter::kClient);
}

/// A server's GUIDs are for Fast DDS alone (makeCommonName).
std::optional<security::Identity> identityOf(const Network& network) {
  using security::Role;
  if (network.identity.empty()) return std::nullopt;
  return security::readIdentity(network.identity,
                                {Role::kOperator, Role::kEditor, Role::kViewer, Role::kHand});
}

// === Codec: Fast CDR <-> bytes, XCDR1 behind a header of 4 bytes

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;

struct Wire {
  FastBuffer buffer;
  std::uint32_t size = 0;
};

constexpr std::size_t kHeader = 4;

template <class Message>
void encode(const Message& message, Wire& wire) {
  // An upper bound; Cyclone may read up to the next multiple of 4.
  const std::size_t room = kHeader + Message::getCdrSerializedSize(message) + 2 * kHeader;
  if (room > std::numeric_limits<std::uint32_t>::max() || !wire.buffer.reserve(room)) {
    throw TransportError(fmt::format("a message of {} bytes is too large", room));
  }
  // Fast CDR skips what aligns numbers: whatever memory held there would go over the wire.
  std::memset(wire.buffer.getBuffer(), 0, room);
  Cdr cdr(wire.buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
  cdr.serialize_encapsulation();
  message.serialize(cdr);
  // RTPS payloads are multiples of 4; the header's last bits say how much of it is padding.
  const std::size_t length = cdr.getSerializedDataLength();
  const std::size_t padding = (kHeader - length % kHeader) % kHeader;
  HANDGRAFT_REQUIRE(length + padding + kHeader <= wire.buffer.getBufferSize());
  std::memset(wire.buffer.getBuffer() + length, 0, padding);
  wire.buffer.getBuffer()[3] = static_cast<char>(padding);
  wire.size = static_cast<std::uint32_t>(length + padding);
}

template <class Message>
bool decode(char* bytes, std::size_t size, Message& message) noexcept {
  // CDR_BE and CDR_LE alone: no XCDR2, no parameter lists.
  if (size < kHeader || bytes[0] != 0 || (bytes[1] != 0 && bytes[1] != 1)) return false;
  try {
    FastBuffer buffer(bytes, size);
    Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
    cdr.read_encapsulation();
    message.deserialize(cdr);
    return true;
  } catch (...) {  // truncated, a bad boolean, a length beyond the end, no memory
    return false;
  }
}

// === The throw-away serdata: bytes on our stack, lent to dds_forwardcdr

struct Blob : ddsi_serdata {
  const Wire* wire = nullptr;
};

const Blob& blobOf(const ddsi_serdata* data) {
  return *static_cast<const Blob*>(data);
}

const ddsi_serdata_ops blob_ops = [] {
  ddsi_serdata_ops ops{};
  ops.get_size = [](const ddsi_serdata* data) {
    return blobOf(data).wire->size;
  };
  ops.to_ser_ref = [](const ddsi_serdata* data, std::size_t offset, std::size_t size,
                      ddsrt_iovec_t* out) {
    out->iov_base = blobOf(data).wire->buffer.getBuffer() + offset;
    out->iov_len = size;
    return const_cast<ddsi_serdata*>(data);
  };
  ops.to_ser_unref = [](ddsi_serdata*, const ddsrt_iovec_t*) {};
  ops.free = [](ddsi_serdata*) {};
  return ops;
}();

const ddsi_sertype_ops blob_type_ops = [] {
  ddsi_sertype_ops ops{};
  ops.version = ddsi_sertype_v0;
  return ops;
}();

const ddsi_sertype blob_type = [] {
  ddsi_sertype type{};
  type.ops = &blob_type_ops;
  type.serdata_ops = &blob_ops;
  return type;
}();

/// idlc's descriptor of a message; specialised at the end of the file.
template <class Message>
const dds_topic_descriptor_t* descriptorOf();

}  // namespace

// === Participant

struct Participant::Impl {
  Impl(const Network& where, Discovers discovers)
      : network(where),
        identity(identityOf(where)),
        domain(where, discovers),
        revocations(identity ? std::make_unique<RevocationWatch>(where.domain, *identity)
                             : nullptr),
        entity(dds_create_participant(static_cast<dds_domainid_t>(where.domain),
                                      participantQos(identity, nameOf(discovers)).get(),
                                      nullptr),
               "no participant",
               describe(where)) {}

  Network network;
  const std::optional<security::Identity> identity;
  Domain domain;
  const std::unique_ptr<RevocationWatch> revocations;
  Entity entity;
};

Participant::Participant(const Network& network, Discovers discovers)
    : impl_(std::make_shared<Impl>(network, discovers)) {}

Participant::~Participant() = default;

const Network& Participant::network() const {
  return impl_->network;
}

const std::optional<security::Identity>& Participant::identity() const {
  return impl_->identity;
}

std::int32_t Participant::handle() const {
  return impl_->entity.get();
}

bool Participant::isKeptOut() const {
  if (impl_->identity) return false;
  const Entity reader(dds_create_reader(impl_->entity.get(), DDS_BUILTIN_TOPIC_DCPSPARTICIPANT,
                                        nullptr, nullptr),
                      "no reader", "participants");
  void* sample = nullptr;
  dds_sample_info_t info{};
  bool is_there = false;
  while (dds_take(reader.get(), &sample, &info, 1, 1) == 1) {
    char* name = nullptr;
    const auto* qos = static_cast<const dds_builtintopic_participant_t*>(sample)->qos;
    if (info.valid_data && dds_qget_entity_name(qos, &name)) {
      is_there = is_there || std::strcmp(name, kSecuredServer) == 0;
      dds_free(name);
    }
    dds_return_loan(reader.get(), &sample, 1);
    sample = nullptr;
  }
  return is_there;
}

namespace {

// ROS 2's own middleware announces no type information, and where both sides announce it,
// Cyclone compares members' names: rosidl's end with an underscore, so that nothing ever
// matched. Without it types meet by name alone, and discovery fits into frames. The flags are
// fixed, so the descriptor is put together anew.
dds_topic_descriptor_t withoutTypeInformation(const dds_topic_descriptor_t& whole) {
  return {.m_size = whole.m_size,
          .m_align = whole.m_align,
          .m_flagset = whole.m_flagset & ~std::uint32_t{DDS_TOPIC_XTYPES_METADATA},
          .m_nkeys = whole.m_nkeys,
          .m_typename = whole.m_typename,
          .m_keys = whole.m_keys,
          .m_nops = whole.m_nops,
          .m_ops = whole.m_ops,
          .m_meta = whole.m_meta,
          .type_information = {nullptr, 0},
          .type_mapping = {nullptr, 0},
          .restrict_data_representation = whole.restrict_data_representation};
}

/// Cyclone tells a permission that is missing as any other error, and the reason to its log.
/// Errors: NotPermitted.
void requirePermitted(const Participant::Impl& participant,
                      dds_entity_t made,
                      const char* act,
                      const char* topic) {
  if (made >= 0 || !participant.identity) return;
  if (made != DDS_RETCODE_NOT_ALLOWED_BY_SECURITY && made != DDS_RETCODE_ERROR) return;
  throw NotPermitted(fmt::format("{}: identity {} is of role {}, which may not {} {}",
                                 participant.identity->folder.string(),
                                 participant.identity->name,
                                 security::nameOf(participant.identity->role), act, topic));
}

template <class Message>
bool isRos(const Topic<Message>& topic) {
  return topic.ros_type_hash[0] != '\0';
}

template <class Message>
dds_entity_t createTopic(const Participant::Impl& participant, const Topic<Message>& topic) {
  const dds_topic_descriptor_t& whole = *descriptorOf<Message>();
  const dds_topic_descriptor_t bare = withoutTypeInformation(whole);
  const dds_entity_t made =
      dds_create_topic(participant.entity.get(), &bare, topic.name, nullptr, nullptr);
  requirePermitted(participant, made, "write or read", topic.name);
  return made;
}

// As ROS since Iron finds out whether both sides mean the same type; of one server, in the
// partition of its name.
template <class Message>
QosPtr topicQos(const Participant::Impl& participant, const Topic<Message>& topic, int depth) {
  QosPtr qos = qosOf(topic.qos, depth);
  const std::string& server = participant.network.server;
  if (kIsOfOneServer<Message> && !server.empty())
    dds_qset_partition1(qos.get(), server.c_str());
  if (isRos(topic)) {
    const std::string data = fmt::format("typehash={};", topic.ros_type_hash);
    dds_qset_userdata(qos.get(), data.data(), data.size());
  }
  return qos;
}

}  // namespace

// === Writer

template <class Message>
struct Writer<Message>::Impl {
  Impl(std::shared_ptr<Participant::Impl> owner, const Topic<Message>& what)
      : participant(std::move(owner)),
        name(what.name),
        topic(createTopic(*participant, what), "no topic", name),
        writer(createWriter(what), "no writer", name) {}

  dds_entity_t createWriter(const Topic<Message>& what) {
    const dds_entity_t made = dds_create_writer(
        participant->entity.get(), topic.get(),
        topicQos(*participant, what, depthOf(what.qos).writer).get(), nullptr);
    requirePermitted(*participant, made, "write", what.name);
    return made;
  }

  std::shared_ptr<Participant::Impl> participant;
  std::string name;
  Entity topic;
  Entity writer;
};

template <class Message>
Writer<Message>::Writer(const Participant& participant, const Topic<Message>& topic)
    : impl_(std::make_unique<Impl>(participant.impl(), topic)) {}

template <class Message>
Writer<Message>::~Writer() = default;

template <class Message>
void Writer<Message>::write(const Message& message) {
  Wire wire;
  try {
    encode(message, wire);
  } catch (const eprosima::fastcdr::exception::Exception& error) {
    throw TransportError(fmt::format("{}: {}", impl_->name, error.what()));
  }
  Blob blob;
  ddsi_serdata_init(&blob, &blob_type, SDK_DATA);
  blob.wire = &wire;
  blob.statusinfo = 0;
  blob.timestamp.v = dds_time();
  // Drops our reference to the blob; the converted copy is Cyclone's.
  checked(dds_forwardcdr(impl_->writer.get(), &blob),
          "not written; a message must keep the bounds of its IDL", impl_->name);
}

template <class Message>
int Writer<Message>::readers() const {
  dds_publication_matched_status_t status{};
  checked(dds_get_publication_matched_status(impl_->writer.get(), &status), "no status",
          impl_->name);
  return static_cast<int>(status.current_count);
}

// === Reader

template <class Message>
struct Reader<Message>::Impl {
  Impl(std::shared_ptr<Participant::Impl> owner,
       const Topic<Message>& what,
       std::function<void()> listener)
      : participant(std::move(owner)),
        name(what.name),
        on_data(std::move(listener)),
        topic(createTopic(*participant, what), "no topic", name),
        reader(createReader(what), "no reader", name),
        condition(dds_create_readcondition(reader.get(), DDS_ANY_STATE), "no condition", name),
        waitset(dds_create_waitset(participant->entity.get()), "no waitset", name) {
    checked(dds_waitset_attach(waitset.get(), condition.get(), 0), "no waitset", name);
  }

  dds_entity_t createReader(const Topic<Message>& what) {
    const std::unique_ptr<dds_listener_t, void (*)(dds_listener_t*)> listener(
        dds_create_listener(this), dds_delete_listener);
    if (on_data) {
      dds_lset_data_available(listener.get(), [](dds_entity_t, void* self) {
        static_cast<Impl*>(self)->on_data();
      });
    }
    const dds_entity_t made =
        dds_create_reader(participant->entity.get(), topic.get(),
                          topicQos(*participant, what, depthOf(what.qos).reader).get(),
                          on_data ? listener.get() : nullptr);
    requirePermitted(*participant, made, "read", what.name);
    return made;
  }

  std::shared_ptr<Participant::Impl> participant;
  std::string name;
  std::function<void()> on_data;
  std::atomic<unsigned> rejected{0};
  Entity topic;
  Entity reader;  // deleting it waits for a callback that is running
  Entity condition;
  Entity waitset;
};

template <class Message>
Reader<Message>::Reader(const Participant& participant,
                        const Topic<Message>& topic,
                        std::function<void()> on_data)
    : impl_(std::make_unique<Impl>(participant.impl(), topic, std::move(on_data))) {}

template <class Message>
Reader<Message>::~Reader() = default;

template <class Message>
int Reader<Message>::take(const std::function<void(const Message&)>& use) {
  return takeWithOrigin([&use](const Message& message, const Origin&) {
    use(message);
  });
}

template <class Message>
int Reader<Message>::takeWithOrigin(
    const std::function<void(const Message&, const Origin&)>& use) {
  int count = 0;
  ddsi_serdata* data = nullptr;
  dds_sample_info_t info{};
  while (dds_takecdr(impl_->reader.get(), &data, 1, &info, DDS_ANY_STATE) == 1) {
    const std::unique_ptr<ddsi_serdata, void (*)(ddsi_serdata*)> hold(data, ddsi_serdata_unref);
    if (!info.valid_data) continue;  // a writer went away; states say so themselves
    ddsrt_iovec_t bytes{};
    ddsi_serdata* const lent =
        ddsi_serdata_to_ser_ref(data, 0, ddsi_serdata_size(data), &bytes);
    Message message;
    const bool sound = decode(static_cast<char*>(bytes.iov_base), bytes.iov_len, message);
    ddsi_serdata_to_ser_unref(lent, &bytes);
    if (!sound) {
      ++impl_->rejected;
      continue;
    }
    ++count;
    use(message, {info.source_timestamp, static_cast<std::uint64_t>(info.publication_handle)});
  }
  return count;
}

template <class Message>
bool Reader<Message>::wait(std::chrono::milliseconds timeout) {
  const dds_duration_t nanoseconds = std::chrono::nanoseconds(timeout).count();
  return checked(dds_waitset_wait(impl_->waitset.get(), nullptr, 0, nanoseconds),
                 "waiting failed", impl_->name) > 0;
}

template <class Message>
int Reader<Message>::writers() const {
  dds_subscription_matched_status_t status{};
  checked(dds_get_subscription_matched_status(impl_->reader.get(), &status), "no status",
          impl_->name);
  return static_cast<int>(status.current_count);
}

template <class Message>
unsigned Reader<Message>::rejected() const {
  return impl_->rejected;
}

// === The messages there are: one line each

// NOLINTNEXTLINE(cppcoreguidelines-macro-usage): idlc's symbols can only be named by pasting.
#define HANDGRAFT_MESSAGE(cpp, c)                     \
  }                                                   \
  extern "C" const dds_topic_descriptor_t c##_desc;   \
  namespace handgraft::idl::cyclone {                 \
  namespace {                                         \
  template <>                                         \
  const dds_topic_descriptor_t* descriptorOf<cpp>() { \
    return &c##_desc;                                 \
  }                                                   \
  }                                                   \
  template class Writer<cpp>;                         \
  template class Reader<cpp>;

HANDGRAFT_MESSAGE(v1::Request, handgraft_v1_Request)
HANDGRAFT_MESSAGE(v1::Reply, handgraft_v1_Reply)
HANDGRAFT_MESSAGE(v1::Progress, handgraft_v1_Progress)
HANDGRAFT_MESSAGE(v1::Edit, handgraft_v1_Edit)
HANDGRAFT_MESSAGE(v1::EditReply, handgraft_v1_EditReply)
HANDGRAFT_MESSAGE(v1::PoseSolution, handgraft_v1_PoseSolution)
HANDGRAFT_MESSAGE(v1::SessionState, handgraft_v1_SessionState)
HANDGRAFT_MESSAGE(v1::MotionFrames, handgraft_v1_MotionFrames)
HANDGRAFT_MESSAGE(v1::MotionClock, handgraft_v1_MotionClock)
HANDGRAFT_MESSAGE(v1::DemonstratorFrame, handgraft_v1_DemonstratorFrame)
HANDGRAFT_MESSAGE(v1::ServerStatus, handgraft_v1_ServerStatus)
HANDGRAFT_MESSAGE(v1::HandCommand, handgraft_v1_HandCommand)
HANDGRAFT_MESSAGE(v1::JointState, handgraft_v1_JointState)
HANDGRAFT_MESSAGE(v1::BridgeStatus, handgraft_v1_BridgeStatus)
HANDGRAFT_MESSAGE(sensor_msgs::msg::dds_::JointState_, sensor_msgs_msg_dds__JointState_)
HANDGRAFT_MESSAGE(trajectory_msgs::msg::dds_::JointTrajectory_,
                  trajectory_msgs_msg_dds__JointTrajectory_)
HANDGRAFT_MESSAGE(diagnostic_msgs::msg::dds_::DiagnosticArray_,
                  diagnostic_msgs_msg_dds__DiagnosticArray_)
HANDGRAFT_MESSAGE(std_srvs::srv::dds_::Trigger_Request_, std_srvs_srv_dds__Trigger_Request_)
HANDGRAFT_MESSAGE(std_srvs::srv::dds_::Trigger_Response_, std_srvs_srv_dds__Trigger_Response_)

#undef HANDGRAFT_MESSAGE

}  // namespace handgraft::idl::cyclone
