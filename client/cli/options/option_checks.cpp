#include "client/cli/options/option_checks.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>

#include "core/base/error.h"
#include "idl/fields.h"

namespace handgraft::client {

namespace {

const std::map<std::string, v1::ModelKind> kind_names = {{"hand", v1::MODEL_HAND},
                                                         {"object", v1::MODEL_OBJECT},
                                                         {"contacts", v1::MODEL_CONTACTS},
                                                         {"motion", v1::MODEL_MOTION}};

template <class Number>
std::string objectionTo(const std::string& text, const char* most) {
  Number number = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, number);
  if (error == std::errc() && rest == end) return "";
  return fmt::format("{} is no whole number from 0 to {}", quoted(text), most);
}

}  // namespace

std::string objectionToCount(const std::string& text) {
  return objectionTo<std::uint64_t>(text, "2^64 - 1");
}

std::string objectionToSmallCount(const std::string& text) {
  return objectionTo<std::uint32_t>(text, "2^32 - 1");
}

std::string objectionToFile(const std::string& name) {
  return name.empty() ? "the file's name is empty" : "";
}

std::string objectionToPng(const std::string& name) {
  std::string ending = std::filesystem::path(name).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  if (ending.empty() || ending == ".png") return objectionToFile(name);
  return fmt::format("{} is to be a PNG; its ending must be .png", quoted(name));
}

std::string objectionToSolver(const std::string& name) {
  if (v1::enumeratorOf<v1::Solver>(name)) return "";
  return fmt::format("{} is no solver; it must be one of {}", quoted(name),
                     fmt::join(idl::namesOf(idl::typeOf<v1::Solver>()), " "));
}

v1::ModelKind kindOf(const std::string& name) {
  const auto found = kind_names.find(name);
  if (found == kind_names.end()) {
    rejectInput("kind {}: it is hand, object, contacts or motion", quoted(name));
  }
  return found->second;
}

PackageMap packagesOf(const std::vector<std::string>& pairs) {
  PackageMap packages;
  for (const std::string& pair : pairs) {
    const std::size_t sign = pair.find('=');
    if (sign == std::string::npos || sign == 0 || sign + 1 == pair.size()) {
      rejectInput("--package {}: write NAME=DIR", quoted(pair));
    }
    const std::filesystem::path directory = pair.substr(sign + 1);
    std::error_code error;
    if (!std::filesystem::is_directory(directory, error)) {
      rejectInput("--package {}: there is no folder {}", pair.substr(0, sign),
                  quoted(directory.string()));
    }
    packages[pair.substr(0, sign)] = directory;
  }
  return packages;
}

void requireModel(const std::string& text, const char* option) {
  if (!isPath(text)) checkModelName(text, option);
}

void requireFinite(const std::vector<double>& numbers, const char* option, double least) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (std::isfinite(numbers[i]) && numbers[i] >= least) continue;
    rejectInput("{}: number {} is {}; it must be finite{}", option, i + 1, numbers[i],
                std::isfinite(least) ? " and not negative" : "");
  }
}

double scaled(const std::optional<double>& value,
              const char* option,
              double lowest,
              double highest,
              double to_si) {
  if (!value) return 0.0;
  if (!(*value >= lowest && *value <= highest)) {
    rejectInput("{} {}: it must be {} to {}", option, *value, lowest, highest);
  }
  return to_si * *value;
}

std::optional<Place> placeOf(const std::vector<double>& numbers) {
  if (numbers.empty()) return std::nullopt;
  requireFinite(numbers, "--place", -std::numeric_limits<double>::infinity());
  Place place{};
  std::copy_n(numbers.begin(), std::min(numbers.size(), place.size()), place.begin());
  return place;
}

}  // namespace handgraft::client
