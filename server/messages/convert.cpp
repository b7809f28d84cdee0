#include "server/messages/convert.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/hand/kinematics.h"
#include "core/io/posed_grasp.h"
#include "idl/fields.h"
#include "server/messages/session_messages.h"

namespace handgraft::server {

namespace {

template <class T>
void requireAtMost(const std::vector<T>& sequence, std::size_t most, const char* name) {
  if (sequence.size() > most) {
    rejectInput("{}: {} entries; at most {} are allowed", name, sequence.size(), most);
  }
}

optimize::NormalForm normalFormFrom(v1::NormalForm form) {
  switch (form) {
    case v1::NORMAL_COSINE:
      return optimize::NormalForm::kCosine;
    case v1::NORMAL_SUM:
      return optimize::NormalForm::kSum;
  }
  rejectInput("normal_form: {} is neither cosine (0) nor sum (1)", static_cast<unsigned>(form));
}

bool avoidsPenetration(v1::PenetrationCare care) {
  switch (care) {
    case v1::PENETRATION_REPORTED:
      return false;
    case v1::PENETRATION_AVOIDED:
      return true;
  }
  rejectInput("penetration: {} is neither avoided (0) nor reported (1)",
              static_cast<unsigned>(care));
}

std::vector<double> flat(const std::vector<Eigen::Vector3d>& points) {
  std::vector<double> values;
  values.reserve(3 * points.size());
  for (const Eigen::Vector3d& p : points)
    values.insert(values.end(), p.data(), p.data() + 3);
  return values;
}

std::vector<double> entries(const Eigen::VectorXd& values) {
  return {values.data(), values.data() + values.size()};
}

}  // namespace

// === From the wire

Pose poseFrom(const v1::Pose& pose, const char* name) {
  const auto& p = pose.p_m();
  const auto& q = pose.q_wxyz();
  return poseFromQuaternion({p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}, name);
}

Pose poseFrom(const std::vector<v1::Pose>& pose, const char* name) {
  requireAtMost(pose, 1, name);
  return pose.empty() ? Pose::Identity() : poseFrom(pose.front(), name);
}

geometry::SurfacePoint surfacePointFrom(const v1::SurfacePoint& point) {
  geometry::SurfacePoint result;
  result.face = point.face();
  result.barycentric = Eigen::Map<const Eigen::Vector3d>(point.barycentric().data());
  return result;
}

optimize::Weights weightsFrom(const v1::Weights& weights) {
  const auto checked = [](double value, const char* name) {
    constexpr double kMost = 1e12;
    if (!(value >= 0.0 && value <= kMost)) {
      rejectInput("weight of the {} term: {} is outside 0-{:g}", name, value, kMost);
    }
    return value;
  };
  optimize::Weights result;
  result.distance = checked(weights.distance(), "distance");
  result.normal = checked(weights.normal(), "normal");
  result.prior = checked(weights.prior(), "prior");
  return result;
}

optimize::Weights weightsFrom(const std::vector<v1::Weights>& weights) {
  requireAtMost(weights, 1, "weights");
  return weights.empty() ? optimize::Weights() : weightsFrom(weights.front());
}

session::SolverSettings solverSettingsFrom(const v1::SolveOptions& message) {
  const auto asked = [](std::uint32_t value, int usual, int most, const char* name) {
    if (value > static_cast<std::uint32_t>(most)) {
      rejectInput("{}: {} is outside 0-{}", name, value, most);
    }
    return value == 0 ? usual : static_cast<int>(value);
  };
  session::SolverSettings solving;
  // Also a default that is asked for by name does not go with the paper's way.
  if (message.paper() && message.solver() != v1::SOLVER_DEFAULT) {
    rejectInput("solver {}: the paper's way has its own, mma", nameOf(message.solver()));
  }
  if (message.paper() && message.starts() > 0) {
    rejectInput("starts: {} do not go with the paper's way, which has one", message.starts());
  }
  if (message.solver() != v1::SOLVER_DEFAULT)
    solving.solver = optimize::solverFrom(nameOf(message.solver()));
  solving.starts = asked(message.starts(), solving.starts, session::kMostStarts, "starts");
  solving.seed = message.seed();
  solving.max_evaluations = asked(message.max_evaluations(), solving.max_evaluations,
                                  session::kMostEvaluations, "max_evaluations");
  solving.paper = message.paper();
  solving.normal_form = normalFormFrom(message.normal_form());
  solving.avoid_penetration = avoidsPenetration(message.penetration());
  validate(solving);
  return solving;
}

// === To the wire

v1::Pose toMessage(const Pose& X) {
  const Eigen::Vector4d q = quaternionOf(X);
  v1::Pose pose;
  pose.p_m(toMessage(Eigen::Vector3d(X.translation())));
  pose.q_wxyz({q[0], q[1], q[2], q[3]});
  return pose;
}

v1::SurfacePoint toMessage(const geometry::SurfacePoint& point) {
  v1::SurfacePoint message;
  message.face(point.face);
  message.barycentric(toMessage(point.barycentric));
  return message;
}

std::array<double, 3> toMessage(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

v1::Mesh toMessage(const geometry::TriangleMesh& mesh) {
  v1::Mesh message;
  const Eigen::Matrix3Xf vertices = mesh.vertices().cast<float>();
  message.vertices_m().assign(vertices.data(), vertices.data() + vertices.size());
  const int* corners = mesh.faces().data();
  message.triangles().assign(corners, corners + mesh.faces().size());
  return message;
}

v1::Chirality toMessage(hand::Chirality chirality) {
  switch (chirality) {
    case hand::Chirality::kUnknown:
      return v1::CHIRALITY_UNKNOWN;
    case hand::Chirality::kLeft:
      return v1::CHIRALITY_LEFT;
    case hand::Chirality::kRight:
      return v1::CHIRALITY_RIGHT;
  }
  throw BrokenContract("a chirality that does not exist");
}

v1::Outcome toMessage(optimize::Outcome outcome) {
  switch (outcome) {
    case optimize::Outcome::kConverged:
      return v1::OUTCOME_CONVERGED;
    case optimize::Outcome::kStalled:
      return v1::OUTCOME_STALLED;
    case optimize::Outcome::kEvaluationLimit:
      return v1::OUTCOME_EVALUATION_LIMIT;
    case optimize::Outcome::kInfeasible:
      return v1::OUTCOME_INFEASIBLE;
  }
  throw BrokenContract("an outcome that does not exist");
}

v1::JointKind kindOf(const hand::Joint& joint) {
  return joint.type == hand::JointType::kPrismatic ? v1::JOINT_PRISMATIC : v1::JOINT_REVOLUTE;
}

v1::JointLimit limitOf(const std::string& joint, bool upper) {
  v1::JointLimit limit;
  limit.joint(joint);
  limit.side(upper ? v1::LIMIT_UPPER : v1::LIMIT_LOWER);
  return limit;
}

std::vector<v1::JointLimit> limitsMessage(const hand::HandModel& model,
                                          const std::vector<optimize::ActiveLimit>& limits) {
  std::vector<v1::JointLimit> messages;
  messages.reserve(limits.size());
  for (const optimize::ActiveLimit& limit : limits)
    messages.push_back(limitOf(model.dofJoint(limit.dof).name, limit.upper));
  return messages;
}

v1::SolveOptions toMessage(const session::SolverSettings& solving) {
  v1::SolveOptions message;
  message.paper(solving.paper);
  if (!solving.paper) {
    message.solver(v1::enumeratorFrom<v1::Solver>(optimize::nameOf(solving.solver), "solver"));
    message.starts(static_cast<std::uint32_t>(solving.starts));
  }
  message.seed(solving.seed);
  message.max_evaluations(static_cast<std::uint32_t>(solving.max_evaluations));
  message.normal_form(solving.normal_form == optimize::NormalForm::kSum ? v1::NORMAL_SUM
                                                                        : v1::NORMAL_COSINE);
  message.penetration(solving.avoid_penetration ? v1::PENETRATION_AVOIDED
                                                : v1::PENETRATION_REPORTED);
  return message;
}

v1::Terms toMessage(const optimize::Terms& terms) {
  v1::Terms message;
  message.distance_m2(terms.distance);
  message.normal(terms.normal);
  message.prior(terms.prior);
  message.objective(terms.objective);
  return message;
}

v1::Penetration toMessage(const hand::HandModel& model, const quality::Penetration& found) {
  const auto name_of = [&model](int link) {
    return model.links()[static_cast<std::size_t>(link)].name;
  };
  v1::Penetration message;
  message.max_depth_m(found.max_depth_m);
  message.mean_depth_m(found.mean_depth_m);
  message.volume_m3(found.volume_m3);
  for (const quality::LinkDepth& depth : found.links) {
    v1::LinkDepth one;
    one.link(name_of(depth.link));
    one.depth_m(depth.depth_m);
    message.links().push_back(one);
  }
  message.self_depth_m(found.self_depth_m);
  if (found.self_depth_m > 0.0) {
    for (const int link : found.self_links)
      message.self_links().push_back(name_of(link));
  }
  return message;
}

v1::MinimumInfo toMessage(const optimize::Minimum& minimum) {
  v1::MinimumInfo message;
  message.solver(minimum.solver);
  message.start(static_cast<std::uint32_t>(minimum.start));
  message.hits(static_cast<std::uint32_t>(minimum.hits));
  message.terms(toMessage(minimum.terms));
  message.X_WH(toMessage(minimum.pose.X_WH));
  message.joint_positions(entries(minimum.pose.q));
  return message;
}

v1::PoseSolution solutionMessage(const session::Session& session,
                                 const hand::HandPose& pose,
                                 const optimize::Terms& terms) {
  v1::PoseSolution message;
  message.X_WH(toMessage(pose.X_WH));
  message.X_WO(toMessage(session.objectPose()));
  message.joint_positions(entries(pose.q));
  message.terms(toMessage(terms));
  return message;
}

v1::PoseSolution solutionMessage(const session::Session& session,
                                 const optimize::SolveReport& report) {
  HANDGRAFT_REQUIRE(session.solvedProblem().has_value());
  return solutionMessage(session, *session.solvedProblem(), report);
}

v1::PoseSolution solutionMessage(const session::Session& session,
                                 const optimize::PoseProblem& problem,
                                 const optimize::SolveReport& report) {
  const hand::HandModel& model = *problem.model;
  v1::PoseSolution message = solutionMessage(session, report.pose, report.terms);
  message.is_final(true);
  message.outcome(toMessage(report.outcome));
  message.solver(report.solver);
  message.evaluations(static_cast<std::uint32_t>(report.evaluations));
  const hand::LinkPoses X_WL = hand::forwardKinematics(model, report.pose);
  for (const Pose& X : X_WL)
    message.X_WL().push_back(toMessage(X));

  for (const optimize::PatchFit& fit : report.patches) {
    const auto index = static_cast<std::size_t>(fit.patch);
    HANDGRAFT_REQUIRE(index < session.patches().size());
    std::vector<Eigen::Vector3d> on_hand_W;
    std::vector<Eigen::Vector3d> on_object_W;
    for (const optimize::PointPair& pair : problem.pairs) {
      if (pair.patch != fit.patch) continue;
      on_hand_W.emplace_back(X_WL[static_cast<std::size_t>(pair.link)] * pair.p_L);
      on_object_W.push_back(pair.p_W);
    }
    v1::PatchFit one;
    one.name(session.patches()[index].patch.name);
    one.point_count(static_cast<std::uint32_t>(fit.point_count));
    one.mean_mm(fit.mean_mm);
    one.rms_mm(fit.rms_mm);
    one.max_mm(fit.max_mm);
    one.normal_deg(fit.normal_mean_deg);
    one.within_2mm(fit.within_2mm);
    one.within_5mm(fit.within_5mm);
    one.hand_W_m(flat(on_hand_W));
    one.object_W_m(flat(on_object_W));
    message.patches().push_back(std::move(one));
  }
  for (const session::PinnedPoint& place : session.document().held)
    message.held().push_back(heldMessage(place, model, report.pose));
  message.joints_at_limit(limitsMessage(model, report.active_limits));
  for (const optimize::Minimum& minimum : report.minima)
    message.minima().push_back(toMessage(minimum));
  return message;
}

sensor_msgs::msg::dds_::JointState_ jointCommand(const hand::HandModel& model,
                                                 const Eigen::VectorXd& q,
                                                 long long stamp_ns) {
  constexpr long long kSecond = 1'000'000'000;
  sensor_msgs::msg::dds_::JointState_ command;
  command.header().stamp().sec(static_cast<std::int32_t>(stamp_ns / kSecond));
  command.header().stamp().nanosec(static_cast<std::uint32_t>(stamp_ns % kSecond));
  command.header().frame_id(model.name());
  for (const io::JointValue& joint : io::jointValues(model, q)) {
    command.name().push_back(joint.name);
    command.position().push_back(joint.value);
  }
  return command;
}

v1::HandLocation toMessage(const hand::HandLocation& place) {
  v1::HandLocation message;
  message.digit(place.digit);
  message.segment(place.segment);
  // The contract counts on the palm from the wrist and from the little finger's side.
  const bool is_palm = place.digit == hand::kPalmPart;
  const double along = std::clamp(place.along, 0.0, 1.0);
  message.along(is_palm ? 1.0 - along : along);
  message.around_rad(place.around_rad);
  message.across(is_palm ? 1.0 - std::clamp(place.across, 0.0, 1.0) : 0.0);
  return message;
}

}  // namespace handgraft::server
