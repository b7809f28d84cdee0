#include "core/hand/digits.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <utility>

namespace handgraft::hand {

namespace {

/// Joints whose axis leans less than this from the last one's bend the finger the same way.
constexpr double kParallelCosine = 0.8;
/// Share of the distance within which points are equally far.
constexpr double kEquallyFar = 1e-3;
/// Share of the range by which one side must outweigh the other to call it the closing side.
constexpr double kClearAsymmetry = 0.1;

const HandModel::Node& nodeOf(const HandModel& model, int link) {
  return model.nodes()[static_cast<std::size_t>(link - 1)];
}

/// Links from `link` up to the root, itself first.
std::vector<int> pathToRoot(const HandModel& model, int link) {
  std::vector<int> path{link};
  while (link != 0) {
    link = nodeOf(model, link).parent_link;
    path.push_back(link);
  }
  return path;
}

/// Links with a surface that carry no other such link by a joint that moves.
std::vector<int> lastMovingLinks(const HandModel& model) {
  const auto count = static_cast<std::size_t>(model.linkCount());
  // The movable joint that carries each link, as the child link of that joint; 0 is the root.
  std::vector<int> body(count, 0);
  std::vector<char> has_surface(count, 0);
  std::vector<char> carries(count, 0);
  for (std::size_t link = 0; link < count; ++link) {
    if (link > 0) {
      const HandModel::Node& node = nodeOf(model, static_cast<int>(link));
      body[link] = node.type == JointType::kFixed
                       ? body[static_cast<std::size_t>(node.parent_link)]
                       : static_cast<int>(link);
    }
    if (!model.links()[link].surface().empty())
      has_surface[static_cast<std::size_t>(body[link])] = 1;
  }
  for (std::size_t link = count; link-- > 1;) {
    if (body[link] != static_cast<int>(link)) continue;
    const auto below = static_cast<std::size_t>(
        body[static_cast<std::size_t>(nodeOf(model, static_cast<int>(link)).parent_link)]);
    if (has_surface[link] != 0 || carries[link] != 0) carries[below] = 1;
  }
  std::vector<int> last;
  for (std::size_t link = 1; link < count; ++link)
    if (body[link] == static_cast<int>(link) && has_surface[link] != 0 && carries[link] == 0)
      last.push_back(static_cast<int>(link));
  return last;
}

int commonAncestor(const HandModel& model, const std::vector<int>& links) {
  if (links.size() < 2) return 0;
  std::vector<int> shared = pathToRoot(model, links.front());
  for (const int link : links) {
    const std::vector<int> path = pathToRoot(model, link);
    std::erase_if(shared, [&](int candidate) {
      return std::find(path.begin(), path.end(), candidate) == path.end();
    });
  }
  return shared.front();
}

/// How much farther a node bends one way than the other, in [-1, 1]; 0 without limits.
double asymmetryOf(const HandModel& model, const HandModel::Node& node) {
  const double lower = model.lower()[node.dof];
  const double upper = model.upper()[node.dof];
  if (!std::isfinite(lower) || !std::isfinite(upper) || !(upper > lower)) return 0.0;
  const double asymmetry = std::clamp((upper + lower) / (upper - lower), -1.0, 1.0);
  return node.multiplier < 0.0 ? -asymmetry : asymmetry;
}

/// The finger that a name speaks of, "" if none. Names are split into runs of letters.
std::string fingerIn(const std::string& name) {
  static const std::array<std::pair<const char*, const char*>, 7> kWords{
      {{"thumb", "thumb"},
       {"index", "index"},
       {"middle", "middle"},
       {"ring", "ring"},
       {"little", "little"},
       {"pinky", "little"},
       {"pinkie", "little"}}};
  static const std::map<std::string, std::string> kTokens{{"th", "thumb"},  {"ff", "index"},
                                                          {"mf", "middle"}, {"rf", "ring"},
                                                          {"lf", "little"}, {"mid", "middle"}};
  std::string token;
  for (std::size_t i = 0; i <= name.size(); ++i) {
    const auto c = i < name.size() ? static_cast<unsigned char>(name[i]) : '\0';
    if (std::isalpha(c) != 0) {
      token += static_cast<char>(std::tolower(c));
      continue;
    }
    for (const auto& [word, finger] : kWords)
      if (token.starts_with(word)) return finger;
    if (const auto found = kTokens.find(token); found != kTokens.end()) return found->second;
    token.clear();
  }
  return "";
}

Digit makeDigit(const HandModel& model, const LinkPoses& X_SL, int last_link, int palm_link) {
  Digit digit;
  for (const int link : pathToRoot(model, last_link)) {
    if (link == palm_link || link == 0) break;
    const HandModel::Node& node = nodeOf(model, link);
    if (node.type != JointType::kFixed) digit.nodes.insert(digit.nodes.begin(), link - 1);
    if (digit.hint.empty())
      digit.hint = fingerIn(model.links()[static_cast<std::size_t>(link)].name);
    if (digit.hint.empty()) digit.hint = fingerIn(node.joint_name);
  }
  digit.tip_links = rigidGroupOf(model, last_link);
  digit.base = X_SL[static_cast<std::size_t>(digit.nodes.front() + 1)].translation();
  digit.last_joint = X_SL[static_cast<std::size_t>(last_link)].translation();

  std::vector<Eigen::Vector3d> surface;
  double farthest = 0.0;
  for (const int link : digit.tip_links) {
    for (const Shape& shape : model.links()[static_cast<std::size_t>(link)].surface()) {
      for (int v = 0; v < shape.mesh_L.vertexCount(); ++v) {
        surface.push_back(X_SL[static_cast<std::size_t>(link)] * shape.mesh_L.vertex(v));
        farthest = std::max(farthest, (surface.back() - digit.last_joint).norm());
      }
    }
  }
  // A tip that ends in a face has corners equally far: its middle, not one of them.
  double count = 0.0;
  for (const Eigen::Vector3d& p : surface) {
    if ((p - digit.last_joint).norm() < (1.0 - kEquallyFar) * farthest) continue;
    digit.tip += p;
    count += 1.0;
  }
  if (count > 0.0) digit.tip /= count;
  for (const Eigen::Vector3d& p : surface) {
    if ((p - digit.last_joint).norm() < (1.0 - kEquallyFar) * farthest) continue;
    digit.tip_radius = std::max(digit.tip_radius, (p - digit.tip).norm());
  }
  digit.outward = (digit.tip - digit.last_joint).normalized();
  return digit;
}

/// The axis of the last revolute joint, turned so that it closes; returns how clear that is.
double orientFlexion(const HandModel& model, const LinkPoses& X_SL, Digit& digit) {
  double asymmetry = 0.0;
  for (auto node_index = digit.nodes.rbegin(); node_index != digit.nodes.rend(); ++node_index) {
    const HandModel::Node& node = model.nodes()[static_cast<std::size_t>(*node_index)];
    if (node.type != JointType::kRevolute) continue;
    const Eigen::Vector3d axis =
        X_SL[static_cast<std::size_t>(node.link)].linear() * node.axis_J;
    if (digit.flexion_axis.isZero()) digit.flexion_axis = axis;
    const double cosine = axis.dot(digit.flexion_axis);
    if (std::abs(cosine) > kParallelCosine)
      asymmetry += (cosine > 0.0 ? 1.0 : -1.0) * asymmetryOf(model, node);
  }
  if (asymmetry < 0.0) digit.flexion_axis = -digit.flexion_axis;
  const Eigen::Vector3d motion = digit.flexion_axis.cross(digit.outward);
  if (motion.norm() > 1e-6) digit.closing = motion.normalized();
  return std::abs(asymmetry);
}

}  // namespace

std::vector<int> rigidGroupOf(const HandModel& model, int link) {
  std::vector<int> group{link};
  for (const HandModel::Node& node : model.nodes()) {
    if (node.type == JointType::kFixed &&
        std::find(group.begin(), group.end(), node.parent_link) != group.end())
      group.push_back(node.link);
  }
  return group;
}

Digits findDigits(const HandModel& model, const LinkPoses& X_SL) {
  Digits result;
  const std::vector<int> last_links = lastMovingLinks(model);
  result.palm_link = commonAncestor(model, last_links);

  std::vector<std::size_t> unclear;
  for (const int link : last_links) {
    Digit digit = makeDigit(model, X_SL, link, result.palm_link);
    const double clarity = orientFlexion(model, X_SL, digit);
    if (digit.closing.isZero()) continue;  // a slider, or turning about its own length
    if (clarity < kClearAsymmetry) unclear.push_back(result.digits.size());
    result.digits.push_back(std::move(digit));
  }

  Eigen::Vector3d consensus = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < result.digits.size(); ++i)
    if (std::find(unclear.begin(), unclear.end(), i) == unclear.end())
      consensus += result.digits[i].closing;
  for (const std::size_t i : unclear) {
    Digit& digit = result.digits[i];
    if (digit.closing.dot(consensus) >= 0.0) continue;
    digit.closing = -digit.closing;
    digit.flexion_axis = -digit.flexion_axis;
  }
  return result;
}

}  // namespace handgraft::hand
