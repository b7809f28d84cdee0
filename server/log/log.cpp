#include "server/log/log.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

namespace handgraft::server::log {
namespace {

spdlog::level::level_enum levelOf(Level level) {
  switch (level) {
    case Level::kDebug:
      return spdlog::level::debug;
    case Level::kInfo:
      return spdlog::level::info;
    case Level::kWarning:
      return spdlog::level::warn;
    case Level::kError:
      return spdlog::level::err;
  }
  return spdlog::level::err;
}

}  // namespace

void begin(std::string_view least) {
  spdlog::set_default_logger(spdlog::stderr_logger_mt("handgraft"));
  spdlog::set_pattern("time=%Y-%m-%dT%H:%M:%S.%eZ level=%l %v", spdlog::pattern_time_type::utc);
  spdlog::set_level(spdlog::level::from_str(std::string(least)));
}

bool writes(Level level) {
  return spdlog::should_log(levelOf(level));
}

void write(Level level, const std::string& line) {
  spdlog::log(levelOf(level), line);
}

void flush() {
  spdlog::default_logger()->flush();
}

}  // namespace handgraft::server::log
