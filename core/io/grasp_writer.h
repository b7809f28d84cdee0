#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/io/posed_grasp.h"
#include "core/optimize/solve_report.h"

/// A posed grasp as numbers.
namespace handgraft::io {

/// `name,value,unit`: a line per joint, independent ones in the hand's order, then those that
/// mimic them, then the root in W as `X_WH.x` (m) to `X_WH.qz`. Values are exact. Names with
/// commas or quotes are quoted (RFC 4180).
std::string jointCsv(const PosedGrasp& grasp);

/// NVIDIA Isaac's `isaac_grasp` 1.0: one grasp, named after hand and object; position and
/// orientation are the hand's root in the object's frame, X_OH; independent joints only, since
/// Isaac lets the others follow; before the grasp they stand at `q_before`
/// (placement/pregrasp.h). `notes` become comments at the end, a line `# note: ...` each.
///
/// `confidence` is in [0, 1]. Twelve digits behind the point and no exponents, which YAML 1.1
/// readers take for text.
std::string isaacGraspYaml(const PosedGrasp& grasp,
                           double confidence,
                           const Eigen::VectorXd& q_before,
                           const std::vector<std::string>& notes = {});

/// A name as a scalar of YAML, whose double-quoted style takes JSON's escapes; what is no UTF-8
/// becomes U+FFFD.
std::string yamlName(const std::string& name);

/// What we call confidence: the share of all points that lie within 5 mm; 0 without points.
double confidenceOf(const optimize::SolveReport& report);

}  // namespace handgraft::io
