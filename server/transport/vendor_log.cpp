#include <chrono>
#include <memory>
#include <mutex>
#include <string>

#include <fastdds/dds/log/Log.hpp>

#include "server/log/log.h"
#include "server/transport/fast_endpoints.h"

namespace handgraft::server {

namespace {

namespace dds = eprosima::fastdds::dds;

class ToOurLog final : public dds::LogConsumer {
 public:
  void Consume(const dds::Log::Entry& entry) override {
    const std::string category =
        entry.context.category == nullptr ? "" : entry.context.category;
    if (category.rfind("SECURITY", 0) == 0) return consumeSecurity(entry.message);
    const auto level =
        entry.kind == dds::Log::Kind::Error ? log::Level::kError : log::Level::kWarning;
    log::at(level, "component=fastdds category={} message={}", category,
            handgraft::quoted(entry.message));
  }

 private:
  /// Who is not let in says so several times a second, for as long as he is there.
  void consumeSecurity(const std::string& message) {
    constexpr std::chrono::seconds kPause(10);
    const auto now = std::chrono::steady_clock::now();
    if (now < next_) {
      ++left_out_;
      return;
    }
    log::warn("event=kept_out message={} left_out={}", handgraft::quoted(message), left_out_);
    next_ = now + kPause;
    left_out_ = 0;
  }

  std::chrono::steady_clock::time_point next_{};
  std::uint64_t left_out_ = 0;  ///< since the last line; of Fast DDS' one logging thread
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
