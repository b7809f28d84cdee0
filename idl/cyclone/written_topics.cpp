#include "idl/cyclone/written_topics.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <utility>

#include <dds/dds.h>

namespace handgraft::idl::cyclone {

WrittenTopics::WrittenTopics(const Participant& participant,
                             std::string prefix,
                             std::function<void()> on_change)
    : participant_(participant),
      prefix_(std::move(prefix)),
      on_change_(std::move(on_change)),
      reader_(createReader(), "no reader", "written topics") {}

std::int32_t WrittenTopics::createReader() {
  const std::unique_ptr<dds_listener_t, void (*)(dds_listener_t*)> listener(
      dds_create_listener(this), dds_delete_listener);
  dds_lset_data_available(listener.get(), [](dds_entity_t, void* self) {
    static_cast<const WrittenTopics*>(self)->on_change_();
  });
  return dds_create_reader(participant_.handle(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr,
                           listener.get());
}

void WrittenTopics::forget(const Writer& writer) {
  const auto found = topics_.find(writer);
  if (found == topics_.end()) return;
  const auto count = writers_.find(found->second);
  if (--count->second == 0) writers_.erase(count);
  topics_.erase(found);
}

void WrittenTopics::hear() {
  void* sample = nullptr;
  dds_sample_info_t info{};
  while (dds_take(reader_.get(), &sample, &info, 1, 1) == 1) {
    const auto& told = *static_cast<const dds_builtintopic_endpoint_t*>(sample);
    Writer writer{};
    std::copy(std::begin(told.key.v), std::end(told.key.v), writer.begin());
    forget(writer);
    if (info.valid_data && info.instance_state == DDS_IST_ALIVE) {
      const std::string topic = told.topic_name;
      if (topic.compare(0, prefix_.size(), prefix_) == 0) {
        topics_[writer] = topic;
        ++writers_[topic];
      }
    }
    dds_return_loan(reader_.get(), &sample, 1);
    sample = nullptr;
  }
}

bool WrittenTopics::contains(const std::string& topic) {
  hear();
  return writers_.count(topic) != 0;
}

}  // namespace handgraft::idl::cyclone
