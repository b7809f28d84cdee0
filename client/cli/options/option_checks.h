#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "client/cli/commands/commands.h"

/// What options must look like before a command runs. Errors: InvalidInput, naming the option,
/// its value and what it may be.
namespace handgraft::client {

/// CLI11's way: empty, or what is wrong. CLI11 itself would wrap -1 to the largest number.
std::string objectionToCount(const std::string& text);
/// The same of numbers that are sent as 32 bits.
std::string objectionToSmallCount(const std::string& text);
std::string objectionToFile(const std::string& name);
/// A file's name whose ending, if it has one, is a PNG's.
std::string objectionToPng(const std::string& name);
std::string objectionToSolver(const std::string& name);

v1::ModelKind kindOf(const std::string& name);

/// `pairs` as NAME=DIR each.
PackageMap packagesOf(const std::vector<std::string>& pairs);

/// A path, or what may be a model's name.
void requireModel(const std::string& text, const char* option);

/// All finite and at least `least`.
void requireFinite(const std::vector<double>& numbers, const char* option, double least);

/// `value`, which must lie in [lowest, highest], times `to_si`; 0 if there is none.
double scaled(const std::optional<double>& value,
              const char* option,
              double lowest,
              double highest,
              double to_si);

/// Nothing if `numbers` is empty; else seven of them.
std::optional<Place> placeOf(const std::vector<double>& numbers);

}  // namespace handgraft::client
