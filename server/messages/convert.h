#pragma once

#include <Eigen/Core>

#include "core/hand/digits.h"
#include "core/hand/hand_location.h"
#include "core/optimize/solve_report.h"
#include "core/quality/penetration.h"
#include "core/session/session.h"
#include "core/session/solver_settings.h"
#include "idl/models.h"
#include "idl/sensor_msgs.h"
#include "idl/service.h"
#include "idl/sessions.h"

/// The one place where messages become core types and back. What comes from the wire is checked
/// here: enumerators, bounds of sequences, finiteness of poses (InvalidInput).
namespace handgraft::server {

// === From the wire

Pose poseFrom(const v1::Pose& pose, const char* name);
geometry::SurfacePoint surfacePointFrom(const v1::SurfacePoint& point);
/// The defaults when empty.
optimize::Weights weightsFrom(const std::vector<v1::Weights>& weights);
optimize::Weights weightsFrom(const v1::Weights& weights);
/// Identity when empty.
Pose poseFrom(const std::vector<v1::Pose>& pose, const char* name);
/// Zeros and empty names become the defaults. Errors: InvalidInput for what is out of range,
/// and for a solver or starts beside the paper's way.
session::SolverSettings solverSettingsFrom(const v1::SolveOptions& message);

// === To the wire

v1::Pose toMessage(const Pose& X);
v1::SurfacePoint toMessage(const geometry::SurfacePoint& point);
v1::HandLocation toMessage(const hand::HandLocation& place);
std::array<double, 3> toMessage(const Eigen::Vector3d& v);
v1::Mesh toMessage(const geometry::TriangleMesh& mesh);
v1::Outcome toMessage(optimize::Outcome outcome);
v1::Chirality toMessage(hand::Chirality chirality);
v1::JointKind kindOf(const hand::Joint& joint);
v1::JointLimit limitOf(const std::string& joint, bool upper);
std::vector<v1::JointLimit> limitsMessage(const hand::HandModel& model,
                                          const std::vector<optimize::ActiveLimit>& limits);
/// Names what is a default, too.
v1::SolveOptions toMessage(const session::SolverSettings& solving);
v1::Terms toMessage(const optimize::Terms& terms);
v1::Penetration toMessage(const hand::HandModel& model, const quality::Penetration& found);
v1::MinimumInfo toMessage(const optimize::Minimum& minimum);

/// A pose on the way: joints, root and terms.
v1::PoseSolution solutionMessage(const session::Session& session,
                                 const hand::HandPose& pose,
                                 const optimize::Terms& terms);

/// A final pose: also links, patches, limits, minima. It answers the session's solved problem
/// and is not diagnosed (solution_messages.h).
v1::PoseSolution solutionMessage(const session::Session& session,
                                 const optimize::SolveReport& report);
/// As above, of a problem that was not solved but judged.
v1::PoseSolution solutionMessage(const session::Session& session,
                                 const optimize::PoseProblem& problem,
                                 const optimize::SolveReport& report);

/// Independent joints in their order, then those that mimic them.
sensor_msgs::msg::dds_::JointState_ jointCommand(const hand::HandModel& model,
                                                 const Eigen::VectorXd& q,
                                                 long long stamp_ns);

}  // namespace handgraft::server
