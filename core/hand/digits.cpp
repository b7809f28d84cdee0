#include "core/hand/digits.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/hand/digit_closing.h"
#include "core/hand/part_words.h"

namespace handgraft::hand {

const char* nameOf(Chirality side) {
  switch (side) {
    case Chirality::kUnknown:
      return "";
    case Chirality::kRight:
      return "right";
    case Chirality::kLeft:
      return "left";
  }
  throw BrokenContract("a side of no hand");
}

Chirality sideNamed(const std::string& text, const char* field) {
  for (const Chirality side : {Chirality::kRight, Chirality::kLeft})
    if (text == nameOf(side)) return side;
  rejectInput("field '{}' is {}; permitted are 'right' and 'left'", field, quoted(text));
}

namespace {

/// Share of the distance within which points are equally far.
constexpr double kEquallyFar = 1e-3;

/// What is smaller is no fingertip.
constexpr double kSmallestTip = 0.005;  // m

/// m; a bar of a mechanism lies so near the plane in which its finger moves.
constexpr double kInPlane = 0.008;  // m

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

/// Whether a link has a surface as large as a fingertip's.
bool hasBody(const Link& link) {
  const std::vector<Shape>& shapes = link.surface();
  return std::any_of(shapes.begin(), shapes.end(), [](const Shape& shape) {
    const auto& p_L = shape.mesh_L.vertices();
    return p_L.cols() > 0 &&
           (p_L.rowwise().maxCoeff() - p_L.rowwise().minCoeff()).maxCoeff() > kSmallestTip;
  });
}

/// Links with a body that carry no other such link by a joint that moves.
std::vector<int> lastMovingLinks(const HandModel& model) {
  const auto count = static_cast<std::size_t>(model.linkCount());
  // The movable joint that carries each link, as the child link of that joint; 0 is the root.
  std::vector<int> body(count, 0);
  std::vector<char> has_body(count, 0);
  std::vector<char> carries(count, 0);
  for (std::size_t link = 0; link < count; ++link) {
    if (link > 0) {
      const HandModel::Node& node = nodeOf(model, static_cast<int>(link));
      body[link] = node.type == JointType::kFixed
                       ? body[static_cast<std::size_t>(node.parent_link)]
                       : static_cast<int>(link);
    }
    if (hasBody(model.links()[link])) has_body[static_cast<std::size_t>(body[link])] = 1;
  }
  for (std::size_t link = count; link-- > 1;) {
    if (body[link] != static_cast<int>(link)) continue;
    const auto below = static_cast<std::size_t>(
        body[static_cast<std::size_t>(nodeOf(model, static_cast<int>(link)).parent_link)]);
    if (has_body[link] != 0 || carries[link] != 0) carries[below] = 1;
  }
  std::vector<int> last;
  for (std::size_t link = 1; link < count; ++link)
    if (body[link] == static_cast<int>(link) && has_body[link] != 0 && carries[link] == 0)
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

/// The four-fingered hand whose links are numbered, link_0.0 to link_15.0: its thumb comes
/// last; which side the others are counted from depends on the hand.
bool isNumberedThumb(const HandModel& model, const std::string& link_name) {
  return model.maybeLinkIndex("link_0.0") && link_name == "link_15.0";
}

/// The digit that most of the names say.
std::string hintIn(const HandModel& model, const std::vector<int>& links_from_tip) {
  constexpr int kClear = 100;  // one clear name outweighs all vague ones
  std::vector<std::pair<std::string, int>> votes;
  const auto count = [&](const std::string& name) {
    const PartWords words = partWordsOf(name);
    if (words.digit.empty() || words.digit == "palm") return;
    auto vote = std::find_if(votes.begin(), votes.end(), [&](const auto& one) {
      return one.first == words.digit;
    });
    if (vote == votes.end()) vote = votes.insert(votes.end(), {words.digit, 0});
    vote->second += words.is_vague ? 1 : kClear;
  };
  for (const int link : links_from_tip) {
    const std::string& name = model.links()[static_cast<std::size_t>(link)].name;
    if (isNumberedThumb(model, name)) return "thumb";
    count(name);
    count(nodeOf(model, link).joint_name);
  }
  const auto most =
      std::max_element(votes.begin(), votes.end(), [](const auto& a, const auto& b) {
        return a.second < b.second;
      });
  return most == votes.end() ? "" : most->first;
}

/// A digit's tip, and where it points, by the surfaces that its last joint moves.
void findTip(const HandModel& model, const LinkPoses& X_SL, int last_link, Digit& digit) {
  // What slides reaches as far as it does across its slide: a rack is no finger.
  const HandModel::Node& last = nodeOf(model, last_link);
  const auto across = [&](Eigen::Vector3d way) {
    if (last.type != JointType::kPrismatic) return way;
    const Eigen::Vector3d slide =
        X_SL[static_cast<std::size_t>(last_link)].linear() * last.axis_J;
    return Eigen::Vector3d(way - way.dot(slide) * slide);
  };
  const auto reach = [&](const Eigen::Vector3d& p) {
    return across(p - digit.last_joint).norm();
  };
  std::vector<Eigen::Vector3d> surface;
  double farthest = 0.0;
  for (const int link : digit.tip_links) {
    for (const Shape& shape : model.links()[static_cast<std::size_t>(link)].surface()) {
      for (int v = 0; v < shape.mesh_L.vertexCount(); ++v) {
        surface.push_back(X_SL[static_cast<std::size_t>(link)] * shape.mesh_L.vertex(v));
        farthest = std::max(farthest, reach(surface.back()));
      }
    }
  }
  // A tip that ends in a face has corners equally far: its middle, not one of them.
  double count = 0.0;
  for (const Eigen::Vector3d& p : surface) {
    if (reach(p) < (1.0 - kEquallyFar) * farthest) continue;
    digit.tip += p;
    count += 1.0;
  }
  if (count > 0.0) digit.tip /= count;
  for (const Eigen::Vector3d& p : surface) {
    if (reach(p) < (1.0 - kEquallyFar) * farthest) continue;
    digit.tip_radius = std::max(digit.tip_radius, (p - digit.tip).norm());
  }
  // What is the same all round its slide points nowhere.
  const Eigen::Vector3d way = across(digit.tip - digit.last_joint);
  if (way.norm() > kEquallyFar * farthest) digit.outward = way.normalized();
}

/// `users` holds how many digits each link carries: what several share is no finger's own.
Digit makeDigit(const HandModel& model,
                const LinkPoses& X_SL,
                int last_link,
                int palm_link,
                const std::vector<int>& users) {
  Digit digit;
  digit.tip_links = rigidGroupOf(model, last_link);
  std::vector<int> named(digit.tip_links.rbegin(), digit.tip_links.rend());
  for (const int link : pathToRoot(model, last_link)) {
    if (link == palm_link || link == 0) break;
    const bool is_shared = users[static_cast<std::size_t>(link)] > 1;
    std::vector<int>& nodes = is_shared ? digit.carriers : digit.nodes;
    if (nodeOf(model, link).type != JointType::kFixed) nodes.insert(nodes.begin(), link - 1);
    if (link != last_link && !is_shared) named.push_back(link);
  }
  digit.hint = hintIn(model, named);
  digit.base = X_SL[static_cast<std::size_t>(digit.nodes.front()) + 1].translation();
  digit.last_joint = X_SL[static_cast<std::size_t>(last_link)].translation();

  findTip(model, X_SL, last_link, digit);
  return digit;
}

/// Whether a chain of one joint is a bar that guides a finger, as the inner knuckles of
/// grippers with parallel jaws: it moves beside the finger in one plane, by the same motor and
/// to the same side, and ends before it does.
bool isBarOf(const HandModel& model,
             const LinkPoses& X_SL,
             const Digit& bar,
             const Digit& finger) {
  const auto dof_of = [&](const Digit& digit) {
    return model.nodes()[static_cast<std::size_t>(digit.nodes.front())].dof;
  };
  if (bar.nodes.size() != 1 || finger.nodes.size() + finger.carriers.size() < 2 ||
      dof_of(bar) != dof_of(finger))
    return false;
  const Eigen::Vector3d& axis = finger.flexion_axis;
  // A finger that forks has its tips to both sides of the plane.
  const bool forks = !finger.carriers.empty();
  const Eigen::Vector3d base =
      forks ? X_SL[static_cast<std::size_t>(finger.carriers.front()) + 1].translation()
            : finger.base;
  return std::abs(bar.flexion_axis.dot(axis)) > kBendAlike &&
         bar.closing.dot(finger.closing) > 0.0 &&
         std::abs((bar.base - base).dot(axis)) < kInPlane &&
         (forks || std::abs((bar.tip - finger.tip).dot(axis)) < kInPlane) &&
         (bar.tip - bar.base).norm() < (finger.tip - base).norm();
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

std::vector<int> palmBodyOf(const HandModel& model, int palm_link) {
  std::vector<int> body{palm_link};
  const auto link_at = [&](int link) -> const Link& {
    return model.links()[static_cast<std::size_t>(link)];
  };
  // A palm with both looks and geometry to collide wears what is only to be seen.
  const bool wears =
      !link_at(palm_link).visuals.empty() && !link_at(palm_link).collisions.empty();
  for (const int link : rigidGroupOf(model, palm_link)) {
    const bool is_worn =
        wears && link_at(link).collisions.empty() && !link_at(link).visuals.empty();
    if (link != palm_link && !is_worn) body.push_back(link);
  }
  return body;
}

Digits findDigits(const HandModel& model, const LinkPoses& X_SL) {
  Digits result;
  const std::vector<int> last_links = lastMovingLinks(model);
  result.palm_link = commonAncestor(model, last_links);
  std::vector<int> users(static_cast<std::size_t>(model.linkCount()), 0);
  for (const int last : last_links)
    for (const int link : pathToRoot(model, last))
      ++users[static_cast<std::size_t>(link)];
  result.palm_links = palmBodyOf(model, result.palm_link);
  const std::vector<int> above = pathToRoot(model, result.palm_link);
  for (const HandModel::Node& node : model.nodes()) {
    const bool is_above = std::find(above.begin(), above.end(), node.link) != above.end();
    if (is_above || node.type == JointType::kFixed ||
        users[static_cast<std::size_t>(node.link)] < 2)
      continue;
    const std::vector<int> group = rigidGroupOf(model, node.link);
    result.palm_links.insert(result.palm_links.end(), group.begin(), group.end());
  }

  for (const int link : last_links)
    result.digits.push_back(makeDigit(model, X_SL, link, result.palm_link, users));
  orientDigits(model, X_SL, result.digits);
  const std::vector<Digit> all = result.digits;
  std::erase_if(result.digits, [&](const Digit& digit) {
    return std::any_of(all.begin(), all.end(), [&](const Digit& finger) {
      return isBarOf(model, X_SL, digit, finger);
    });
  });
  orientPair(model, X_SL, result.digits);
  return result;
}

}  // namespace handgraft::hand
