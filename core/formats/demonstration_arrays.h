#pragma once

#include <map>
#include <string>
#include <string_view>

#include "core/formats/demonstration_text.h"
#include "core/formats/npz_file.h"

namespace handgraft::formats {

/// What NumPy's arrays tell of a human hand over time, by the names of
/// `handgraft-demonstration/1` or those that MANO sequences go by (core/io/FORMATS.md).
/// Errors: InvalidInput naming the array, or the field and the frame.
Demonstration demonstrationFrom(const std::map<std::string, NpzArray>& arrays);

/// The object that a `.npz` names; empty where it does not say. Errors: InvalidInput.
std::string objectOfNpz(std::string_view bytes);

}  // namespace handgraft::formats
