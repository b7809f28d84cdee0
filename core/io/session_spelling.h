#pragma once

#include <array>
#include <utility>

#include "core/optimize/pose_problem.h"
#include "core/session/fields.h"

/// What the writer and the reader of `handgraft-session/1` share.
namespace handgraft::io {

inline constexpr const char* kSessionFormat = "handgraft-session/1";

/// What core/session/fields.h lists the fields of.
template <class T>
concept HasFields = requires(T& value) {
  session::visitFields(value, [](const char*, auto&) {});
};

// === How enumerators are spelled, in their own order

inline constexpr std::array<std::pair<session::Side, const char*>, 2> kSides = {
    {{session::Side::kObject, "object"}, {session::Side::kHand, "hand"}}};
inline constexpr std::array<std::pair<optimize::NormalForm, const char*>, 2> kNormalForms = {
    {{optimize::NormalForm::kCosine, "cosine"}, {optimize::NormalForm::kSum, "sum"}}};

}  // namespace handgraft::io
