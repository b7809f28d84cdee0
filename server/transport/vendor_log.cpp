#include <memory>
#include <mutex>

#include <fastdds/dds/log/Log.hpp>
#include <spdlog/spdlog.h>

#include "server/transport/fast_endpoints.h"

namespace handgraft::server {

namespace {

namespace dds = eprosima::fastdds::dds;

class ToOurLog final : public dds::LogConsumer {
 public:
  void Consume(const dds::Log::Entry& entry) override {
    const auto level =
        entry.kind == dds::Log::Kind::Error ? spdlog::level::err : spdlog::level::warn;
    spdlog::log(level, "component=fastdds category={} message={}",
                entry.context.category == nullptr ? "" : entry.context.category,
                handgraft::quoted(entry.message));
  }
};

}  // namespace

void routeVendorLog() {
  static std::once_flag once;
  std::call_once(once, [] {
    dds::Log::ClearConsumers();
    dds::Log::RegisterConsumer(std::make_unique<ToOurLog>());
    dds::Log::SetVerbosity(dds::Log::Kind::Error);
  });
}

}  // namespace handgraft::server
