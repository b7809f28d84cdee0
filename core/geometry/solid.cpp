#include "core/geometry/solid.h"

#include <utility>

namespace handgraft::geometry {

Solid::Solid(const TriangleMesh& mesh, const Progress& progress)
    : Solid(std::make_shared<const SignedDistance>(mesh, Holes::kOpenWideOnes), progress) {}

Solid::Solid(std::shared_ptr<const SignedDistance> exact, const Progress& progress)
    : walls_(*exact, Walls::Options(), progress),
      grid_(std::move(exact), DistanceGridOptions(), progress) {}

}  // namespace handgraft::geometry
