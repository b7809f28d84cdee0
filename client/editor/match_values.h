#pragma once

#include <array>
#include <string>

#include <Eigen/Core>

#include "client/editor/grammar.h"
#include "idl/edits.h"

/// What the makers of edits share: values by their place in the pattern, names looked up.
namespace handgraft::client::editor {

// A body with the edit of a struct that has one label of its own.
template <class Edit>
v1::EditBody bodyOf(void (v1::EditBody::*set)(const Edit&), const Edit& edit) {
  v1::EditBody body;
  (body.*set)(edit);
  return body;
}

inline const std::string& word(const Match& match, std::size_t index) {
  return match.values.at(index).text;
}

inline double number(const Match& match, std::size_t index) {
  return match.values.at(index).number;
}

inline Eigen::Vector3d vectorAt(const Match& match, std::size_t index) {
  return {number(match, index), number(match, index + 1), number(match, index + 2)};
}

inline Eigen::Vector3d vectorOf(const std::array<double, 3>& xyz) {
  return {xyz[0], xyz[1], xyz[2]};
}

}  // namespace handgraft::client::editor
