#pragma once

#include <algorithm>
#include <chrono>
#include <functional>
#include <iterator>
#include <type_traits>
#include <utility>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/publisher/qos/DataWriterQos.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/subscriber/qos/DataReaderQos.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <fmt/format.h>

#include "core/base/error.h"
#include "idl/editsPubSubTypes.h"
#include "idl/motionsPubSubTypes.h"
#include "idl/sensor_msgsPubSubTypes.h"
#include "idl/servicePubSubTypes.h"
#include "idl/sessionsPubSubTypes.h"
#include "idl/topics.h"
#include "server/log/log.h"
#include "server/transport/bus.h"
#include "server/transport/delivery.h"

/// Writers and readers of one topic over Fast DDS; private to this folder.
namespace handgraft::server {

/// The flow controller of what is large, off the loopback.
inline constexpr const char* kPace = "pace";

/// What endpoints are made in; borrowed.
struct Endpoints {
  eprosima::fastdds::dds::DomainParticipant* participant = nullptr;
  eprosima::fastdds::dds::Publisher* publisher = nullptr;
  eprosima::fastdds::dds::Subscriber* subscriber = nullptr;
};

/// fastddsgen's type support of a message.
template <class Message>
struct SupportOf;

// clang-format off
template <> struct SupportOf<v1::Request> { using Type = v1::RequestPubSubType; };
template <> struct SupportOf<v1::Reply> { using Type = v1::ReplyPubSubType; };
template <> struct SupportOf<v1::Progress> { using Type = v1::ProgressPubSubType; };
template <> struct SupportOf<v1::Edit> { using Type = v1::EditPubSubType; };
template <> struct SupportOf<v1::DemonstratorFrame> { using Type = v1::DemonstratorFramePubSubType; };
template <> struct SupportOf<v1::MotionFrames> { using Type = v1::MotionFramesPubSubType; };
template <> struct SupportOf<v1::MotionClock> { using Type = v1::MotionClockPubSubType; };
template <> struct SupportOf<v1::EditReply> { using Type = v1::EditReplyPubSubType; };
template <> struct SupportOf<v1::PoseSolution> { using Type = v1::PoseSolutionPubSubType; };
template <> struct SupportOf<v1::SessionState> { using Type = v1::SessionStatePubSubType; };
template <> struct SupportOf<v1::ServerStatus> { using Type = v1::ServerStatusPubSubType; };
template <> struct SupportOf<sensor_msgs::msg::dds_::JointState_> { using Type = sensor_msgs::msg::dds_::JointState_PubSubType; };

// clang-format on

/// A message as taken from the wire, and whether it decoded.
template <class Message>
struct Taken : Message {
  bool sound = false;
};

/// Encodes a Message, decodes into a Taken, and survives every payload: the generated code lets
/// exceptions (bad_alloc, bad discriminators) escape into DDS threads, and a sample that failed
/// would be offered again. What Fast DDS carries as void* is a Message*, of a Taken where it is
/// read; so a participant, which knows a topic by one type support, may write and read it.
template <class Message>
class HardenedType final : public SupportOf<Message>::Type {
  using Base = typename SupportOf<Message>::Type;

 public:
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload,
                   void* data) override {
    auto& taken = takenOf(data);
    taken.sound = false;
    if (payload->length > idl::kLargestRequest) return true;
    try {
      taken.sound = Base::deserialize(payload, data);
    } catch (...) {
      taken.sound = false;
    }
    return true;
  }

  void* createData() override { return static_cast<Message*>(new Taken<Message>()); }

  void deleteData(void* data) override { delete &takenOf(data); }

 private:
  static Taken<Message>& takenOf(void* data) {
    return static_cast<Taken<Message>&>(*static_cast<Message*>(data));
  }
};

template <class EntityQos>
void apply(idl::Qos profile, int depth, EntityQos& qos) {
  namespace dds = eprosima::fastdds::dds;
  qos.reliability().kind = dds::RELIABLE_RELIABILITY_QOS;
  qos.reliability().max_blocking_time = {1, 0};
  qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = depth;
  qos.durability().kind =
      idl::isKept(profile) ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
  // By default Fast DDS knows 10 instances, and sets memory aside for 100 samples of the
  // largest size; 0 means no limit, the depth above bounds what is kept.
  qos.resource_limits().max_samples = 0;
  qos.resource_limits().max_instances = 0;
  qos.resource_limits().max_samples_per_instance = 0;
  qos.resource_limits().allocated_samples = 1;
  // Exactly what a sample needs: generated types think of a hundred elements in each sequence.
  qos.endpoint().history_memory_policy = eprosima::fastrtps::rtps::DYNAMIC_RESERVE_MEMORY_MODE;
}

/// Registers the type, once, and makes or finds the topic: who is the last to use it deletes
/// it, since Fast DDS refuses that before.
template <class Message>
eprosima::fastdds::dds::Topic* topicFor(const Endpoints& endpoints,
                                        const idl::Topic<Message>& topic) {
  namespace dds = eprosima::fastdds::dds;
  const dds::TypeSupport type(new HardenedType<Message>());
  if (endpoints.participant->find_type(type.get_type_name()).empty()) {
    type.register_type(endpoints.participant);
  }
  if (auto* known = endpoints.participant->lookup_topicdescription(topic.name))
    return static_cast<dds::Topic*>(known);  // there are no filtered ones
  auto* made = endpoints.participant->create_topic(topic.name, type.get_type_name(),
                                                   dds::TOPIC_QOS_DEFAULT);
  if (made == nullptr) throw TransportError(fmt::format("{}: no topic", topic.name));
  return made;
}

/// With samples they go to all readers.
enum class Heartbeats { kWithSamples, kOnTheirOwn };

template <class Message>
class FastWriter {
 public:
  /// `is_paced`: by the participant's flow controller, which needs a thread of Fast DDS's own.
  FastWriter(const Endpoints& endpoints,
             const idl::Topic<Message>& topic,
             bool is_paced = false,
             Heartbeats heartbeats = Heartbeats::kWithSamples)
      : endpoints_(endpoints), topic_(topicFor(endpoints, topic)) {
    namespace dds = eprosima::fastdds::dds;
    dds::DataWriterQos qos = dds::DATAWRITER_QOS_DEFAULT;
    apply(topic.qos, idl::depthOf(topic.qos).writer, qos);
    // Large ones are sent by Fast DDS's own thread, all else by the thread that writes: it
    // is sooner there, and samples that were replaced in that other thread's queue left late
    // readers without any later one (README, Decisions).
    constexpr bool kIsLarge =
        std::is_same_v<Message, v1::Reply> || std::is_same_v<Message, v1::MotionFrames>;
    qos.publish_mode().kind =
        kIsLarge ? dds::ASYNCHRONOUS_PUBLISH_MODE : dds::SYNCHRONOUS_PUBLISH_MODE;
    if (is_paced) qos.publish_mode().flow_controller_name = kPace;
    qos.writer_data_lifecycle().autodispose_unregistered_instances = false;
    // What is lost, and gaps where newer states replaced older ones, are settled at once: a
    // reader holds back what came after them. Heartbeats go out only while something is not
    // acknowledged.
    qos.reliable_writer_qos().times.heartbeatPeriod = {0, 10'000'000};
    qos.reliable_writer_qos().disable_heartbeat_piggyback =
        heartbeats == Heartbeats::kOnTheirOwn;
    writer_ = endpoints.publisher->create_datawriter(topic_, qos);
    if (writer_ == nullptr) throw TransportError(fmt::format("{}: no writer", topic.name));
    askThoseWhoOweAnAnswer(*writer_);
  }

  ~FastWriter() {
    endpoints_.publisher->delete_datawriter(writer_);
    endpoints_.participant->delete_topic(topic_);
  }

  FastWriter(const FastWriter&) = delete;
  FastWriter& operator=(const FastWriter&) = delete;

  void write(const Message& message) {
    // Fast DDS takes void* and reads it only.
    if (!writer_->write(const_cast<Message*>(&message))) {
      log::warn("topic={} event=not_written", topic_->get_name());
    }
  }

  [[nodiscard]] eprosima::fastdds::dds::DataWriter& entity() { return *writer_; }

  /// True if every matched reader has acknowledged all that was written.
  [[nodiscard]] bool areAllThere() {
    return writer_->wait_for_acknowledgments({0, 0}) == ReturnCode_t::RETCODE_OK;
  }

  void forgetAll() {
    std::size_t removed = 0;
    writer_->clear_history(&removed);
  }

  /// A client that has just died would hold us up until its lease ends: hence not for long.
  void flush() { writer_->wait_for_acknowledgments({0, 100'000'000}); }

 private:
  Endpoints endpoints_;
  eprosima::fastdds::dds::Topic* topic_;
  eprosima::fastdds::dds::DataWriter* writer_ = nullptr;
};

template <class Message>
class FastReader : private eprosima::fastdds::dds::DataReaderListener {
 public:
  /// `use` runs on Fast DDS's receive thread and must not throw.
  FastReader(const Endpoints& endpoints,
             const idl::Topic<Message>& topic,
             std::function<void(Message&&, const Sender&)> use)
      : endpoints_(endpoints),
        use_(std::move(use)),
        is_kept_(idl::isKept(topic.qos)),
        topic_(topicFor(endpoints, topic)) {
    namespace dds = eprosima::fastdds::dds;
    dds::DataReaderQos qos = dds::DATAREADER_QOS_DEFAULT;
    apply(topic.qos, idl::depthOf(topic.qos).reader, qos);
    reader_ = endpoints.subscriber->create_datareader(topic_, qos, this,
                                                      dds::StatusMask::data_available());
    if (reader_ == nullptr) throw TransportError(fmt::format("{}: no reader", topic.name));
  }

  ~FastReader() override {
    reader_->set_listener(nullptr);
    endpoints_.subscriber->delete_datareader(reader_);
    endpoints_.participant->delete_topic(topic_);
  }

  FastReader(const FastReader&) = delete;
  FastReader& operator=(const FastReader&) = delete;

 private:
  void on_data_available(eprosima::fastdds::dds::DataReader* reader) override {
    while (true) {
      Taken<Message> taken;
      eprosima::fastdds::dds::SampleInfo info;
      if (reader->take_next_sample(static_cast<Message*>(&taken), &info) !=
          ReturnCode_t::RETCODE_OK)
        return;
      if (!info.valid_data || isOfBefore(info)) continue;
      if (!taken.sound) {
        log::warn("topic={} event=dropped reason=\"does not decode\"", topic_->get_name());
        continue;
      }
      Sender sender{};
      const auto& prefix = info.sample_identity.writer_guid().guidPrefix.value;
      std::copy(std::begin(prefix), std::end(prefix), sender.begin());
      use_(std::move(static_cast<Message&>(taken)), sender);
    }
  }

  /// Written before there was this reader, and so to a server that went: a writer offers anew
  /// what that one had not acknowledged. It was answered there, or is repeated by who asks.
  /// Clocks of machines differ, hence only while a server is young.
  [[nodiscard]] bool isOfBefore(const eprosima::fastdds::dds::SampleInfo& info) const {
    constexpr std::chrono::seconds kYoung(10);
    if (is_kept_ || std::chrono::system_clock::now() > begin_ + kYoung) return false;
    const std::chrono::nanoseconds written(info.source_timestamp.to_ns());
    if (written.count() <= 0 || written >= begin_.time_since_epoch()) return false;
    log::debug("topic={} event=dropped reason=\"written to a server before this one\"",
               topic_->get_name());
    return true;
  }

  Endpoints endpoints_;
  std::function<void(Message&&, const Sender&)> use_;
  bool is_kept_;
  /// Nobody can write to a reader before it is there.
  std::chrono::system_clock::time_point begin_ = std::chrono::system_clock::now();
  eprosima::fastdds::dds::Topic* topic_;
  eprosima::fastdds::dds::DataReader* reader_ = nullptr;
};

/// Sends Fast DDS's own errors to our log instead of standard output.
void routeVendorLog();

}  // namespace handgraft::server
