#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "server/reading/packed.h"

namespace handgraft::server {

/// What a model is made of, so that it can be made again: in a store, or elsewhere.
struct ModelRecipe {
  std::string form;  ///< readForm, kVariantForm
  std::string settings;
  std::string bytes;
  std::int64_t base_row = 0;  ///< of the model that it rests on; 0: none that the store keeps
  std::string base_name = {};
};

/// What a reader read (reading/packed.h): settings are the request, bytes the answer in the
/// packed form of that number.
inline std::string readForm(int packed_form = kPackedForm) {
  return "read/" + std::to_string(packed_form);
}

/// The number of a form like that, of this version or an earlier one; nothing of others.
inline std::optional<int> packedFormOf(const std::string& form) {
  for (int packed_form = 1; packed_form <= kPackedForm; ++packed_form)
    if (form == readForm(packed_form)) return packed_form;
  return std::nullopt;
}

/// A variant: settings are the request's JSON, the base is the parent.
inline constexpr const char* kVariantForm = "variant/1";

}  // namespace handgraft::server
