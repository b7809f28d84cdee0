#pragma once

#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

/// The server's log: one event a line, `event=name key=value ...`, to standard error. From any
/// thread. The library behind it is seen by log.cpp alone, so that others compile without it.
namespace handgraft::server::log {

enum class Level { kDebug, kInfo, kWarning, kError };

/// Lines from `least` on are written: trace, debug, info, warning, error; off: none. Once,
/// before the first line; what is written earlier goes to standard output.
void begin(std::string_view least);
/// Whether lines of this level are written: what is not is not formatted, either.
[[nodiscard]] bool writes(Level level);
void write(Level level, const std::string& line);
/// Before a process that may not end in order.
void flush();

template <typename... Values>
void at(Level level, fmt::format_string<Values...> format, Values&&... values) {
  if (writes(level)) write(level, fmt::vformat(format, fmt::make_format_args(values...)));
}

template <typename... Values>
void debug(fmt::format_string<Values...> format, Values&&... values) {
  at<Values...>(Level::kDebug, format, std::forward<Values>(values)...);
}

template <typename... Values>
void info(fmt::format_string<Values...> format, Values&&... values) {
  at<Values...>(Level::kInfo, format, std::forward<Values>(values)...);
}

template <typename... Values>
void warn(fmt::format_string<Values...> format, Values&&... values) {
  at<Values...>(Level::kWarning, format, std::forward<Values>(values)...);
}

template <typename... Values>
void error(fmt::format_string<Values...> format, Values&&... values) {
  at<Values...>(Level::kError, format, std::forward<Values>(values)...);
}

}  // namespace handgraft::server::log
