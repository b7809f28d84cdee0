#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "idl/models.h"
#include "idl/sessions.h"

/// Pieces that several documents share; json_output.h and transfer_json.h use them.
namespace handgraft::client::json {

using Json = nlohmann::ordered_json;

/// One line if `indent` is negative; bytes that are no UTF-8 are replaced.
std::string written(const Json& document, int indent);

/// Sequences and arrays of numbers or strings.
template <class Values>
Json listOf(const Values& values) {
  Json list = Json::array();
  for (const auto& value : values)
    list.push_back(value);
  return list;
}

Json pose(const v1::Pose& X);

/// [x, y, z] each.
Json points(const std::vector<double>& xyz);

Json surfacePoint(const v1::SurfacePoint& point);
Json fidelity(const v1::Fidelity& fidelity);
Json lostPoints(const std::vector<v1::LostPoint>& lost);

/// The places where the searches ended, best first.
Json minima(const v1::PoseSolution& solution, const v1::HandDescription& hand);

}  // namespace handgraft::client::json
