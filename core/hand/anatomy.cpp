#include "core/hand/anatomy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <Eigen/Geometry>

#include <fmt/format.h>

#include "core/base/angle.h"
#include "core/hand/facing.h"
#include "core/hand/part_words.h"

namespace handgraft::hand {

namespace {

constexpr double kShortest = 0.008;     // m
constexpr double kShortestShare = 0.1;  // of the digit
/// Links before the first bend that are longer are metacarpals: part of the palm.
constexpr double kMetacarpal = 0.02;  // m
constexpr double kParallelCosine = 0.7;
/// Sine between a joint's axis and a bone that it moves.
constexpr double kLever = 0.5;
/// Mean of the fingers' directions from which on they stand side by side.
constexpr double kSideBySide = 0.7;
/// Of a thumb's length: what is shorter and comes before three segments is none.
constexpr double kStubShare = 0.25;
constexpr std::size_t kPhalanges = 3;
constexpr double kSameLength = 1e-4;  // m; alike fingers are parted alike
/// Cosine; palms that are found look no farther away from where the fingers close.
constexpr double kPalmFacing = 0.5;

constexpr std::array<const char*, 5> kOrder{"thumb", "index", "middle", "ring", "little"};

Eigen::Vector3d originOf(const LinkPoses& X_SL, int node) {
  return X_SL[static_cast<std::size_t>(node) + 1].translation();
}

/// Where what `digit.nodes[i]` moves ends: at the next joint that is elsewhere, or the tip.
Eigen::Vector3d endOf(const Digit& digit, const LinkPoses& X_SL, std::size_t i) {
  for (std::size_t k = i + 1; k < digit.nodes.size(); ++k) {
    Eigen::Vector3d p = originOf(X_SL, digit.nodes[k]);
    if ((p - originOf(X_SL, digit.nodes[i])).norm() > 1e-3) return p;
  }
  return digit.tip;
}

bool bends(const HandModel& model,
           const LinkPoses& X_SL,
           const Digit& digit,
           std::size_t i,
           bool is_thumb) {
  const HandModel::Node& node = model.nodes()[static_cast<std::size_t>(digit.nodes[i])];
  if (node.type != JointType::kRevolute) return false;
  const Eigen::Vector3d axis = X_SL[static_cast<std::size_t>(node.link)].linear() * node.axis_J;
  if (!is_thumb) return std::abs(axis.dot(digit.flexion_axis)) > kParallelCosine;
  const Eigen::Vector3d bone = endOf(digit, X_SL, i) - originOf(X_SL, digit.nodes[i]);
  return bone.norm() > 0.0 && axis.cross(bone.normalized()).norm() > kLever;
}

/// Whether a joint bends and nothing of the hand lies between it and the next one that does:
/// the halves of a joint that rolls.
bool isHalfAJoint(const HandModel& model,
                  const LinkPoses& X_SL,
                  const Digit& digit,
                  std::size_t i,
                  bool is_thumb) {
  if (!bends(model, X_SL, digit, i, is_thumb)) return false;
  for (; i + 1 < digit.nodes.size(); ++i) {
    for (const int link : rigidGroupOf(model, digit.nodes[i] + 1))
      if (!model.links()[static_cast<std::size_t>(link)].surface().empty()) return false;
    if (bends(model, X_SL, digit, i + 1, is_thumb)) return true;
  }
  return false;
}

Eigen::Vector3d palmarOf(const Digit& digit, const Eigen::Vector3d& bone) {
  Eigen::Vector3d palmar = digit.flexion_axis.cross(bone);
  // A bone along the last joint's axis: the side to which the tip closes.
  if (palmar.norm() < kLever) palmar = digit.closing - digit.closing.dot(bone) * bone;
  if (palmar.norm() < 1e-6) palmar = bone.unitOrthogonal();
  return palmar.normalized();
}

/// A bone that bends in more places than a metacarpal and three phalanges do is a strand of
/// short links: to three segments, the shortest with the shorter one beside it.
void mergeShortest(const LinkPoses& X_SL,
                   const Digit& digit,
                   std::vector<std::size_t>& starts) {
  const auto length = [&](std::size_t s) {
    const Eigen::Vector3d end =
        s + 1 < starts.size() ? originOf(X_SL, digit.nodes[starts[s + 1]]) : digit.tip;
    return (end - originOf(X_SL, digit.nodes[starts[s]])).norm();
  };
  while (starts.size() > kPhalanges) {
    std::size_t shortest = 0;
    for (std::size_t s = 1; s < starts.size(); ++s)
      if (length(s) < length(shortest) - kSameLength) shortest = s;
    const bool with_next =
        shortest == 0 || (shortest + 1 < starts.size() &&
                          length(shortest + 1) < length(shortest - 1) - kSameLength);
    starts.erase(starts.begin() + static_cast<std::ptrdiff_t>(shortest + (with_next ? 1 : 0)));
  }
}

/// Which of a digit's nodes begin a segment.
std::vector<std::size_t> segmentStarts(const HandModel& model,
                                       const LinkPoses& X_SL,
                                       const Digit& digit,
                                       bool is_thumb) {
  const double whole = (digit.tip - digit.knuckle).norm();
  const double shortest = std::max(kShortest, kShortestShare * whole);
  std::vector<std::size_t> starts;
  for (std::size_t i = 0; i < digit.nodes.size(); ++i) {
    if (!bends(model, X_SL, digit, i, is_thumb) ||
        isHalfAJoint(model, X_SL, digit, i, is_thumb))
      continue;
    const Eigen::Vector3d here = originOf(X_SL, digit.nodes[i]);
    if (!starts.empty() &&
        (here - originOf(X_SL, digit.nodes[starts.back()])).norm() < shortest)
      continue;
    if (!starts.empty() && (digit.tip - here).norm() < shortest) continue;
    starts.push_back(i);
  }
  if (starts.empty()) starts.push_back(0);
  if (starts.size() > kPhalanges + 1) mergeShortest(X_SL, digit, starts);
  // A finger has three phalanges: what bends before them is in the palm.
  if (!is_thumb && starts.size() > kPhalanges)
    starts.erase(starts.begin(), starts.end() - kPhalanges);
  // What is short before a thumb's three segments is none of its own.
  while (
      is_thumb && starts.size() > kPhalanges &&
      (originOf(X_SL, digit.nodes[starts[1]]) - originOf(X_SL, digit.nodes[starts[0]])).norm() <
          kStubShare * whole)
    starts.erase(starts.begin());
  return starts;
}

/// Splits a digit; gives the links that are rather the palm's to `metacarpals`.
std::vector<Segment> segmentsOf(const HandModel& model,
                                const LinkPoses& X_SL,
                                const Digit& digit,
                                bool is_thumb,
                                std::vector<int>& metacarpals) {
  const std::vector<std::size_t> starts = segmentStarts(model, X_SL, digit, is_thumb);
  // A side joint before the first bend goes with it, unless it is long.
  std::vector<Segment> segments(starts.size());
  std::size_t next = 0;
  for (std::size_t i = 0; i < digit.nodes.size(); ++i) {
    if (next < starts.size() && i == starts[next]) ++next;
    const std::vector<int> group = rigidGroupOf(model, digit.nodes[i] + 1);
    const Eigen::Vector3d before =
        originOf(X_SL, digit.nodes[starts.front()]) - originOf(X_SL, digit.nodes[i]);
    const bool is_metacarpal = next == 0 && !is_thumb && before.norm() > kMetacarpal;
    // What half a joint carries turns with what comes behind it rather than with what is
    // before.
    const bool is_of_next =
        next > 0 && next < starts.size() && isHalfAJoint(model, X_SL, digit, i, is_thumb);
    const std::size_t segment = is_of_next ? next : std::max<std::size_t>(next, 1) - 1;
    std::vector<int>& links = is_metacarpal ? metacarpals : segments[segment].links;
    links.insert(links.end(), group.begin(), group.end());
  }
  const std::vector<std::string> names = segmentNames(segments.size());
  for (std::size_t s = 0; s < segments.size(); ++s) {
    Segment& segment = segments[s];
    segment.name = names[s];
    segment.base_S = originOf(X_SL, digit.nodes[starts[s]]);
    segment.end_S =
        s + 1 < segments.size() ? originOf(X_SL, digit.nodes[starts[s + 1]]) : digit.tip;
    segment.palmar_S = palmarOf(digit, segment.boneInSkin());
  }
  return segments;
}

/// Whether the last joint turns about several axes, so that none of them tells the pad's side.
bool endsInABall(const HandModel& model, const LinkPoses& X_SL, const Digit& digit) {
  int axes = 0;
  for (const int node : digit.nodes) {
    const bool is_there = (originOf(X_SL, node) - digit.last_joint).norm() < 1e-3;
    if (is_there && model.nodes()[static_cast<std::size_t>(node)].type == JointType::kRevolute)
      ++axes;
  }
  return axes > 1;
}

/// A thumb of ball joints looks to the fingers' side: what its axes do not tell.
void turnThumbToFingers(const HandModel& model, const LinkPoses& X_SL, Anatomy& anatomy) {
  for (NamedDigit& digit : anatomy.digits) {
    if (digit.name != "thumb" || !endsInABall(model, X_SL, digit.digit)) continue;
    for (Segment& segment : digit.segments) {
      const Eigen::Vector3d bone = segment.boneInSkin();
      Eigen::Vector3d side = -anatomy.palm->thumb_side_S;
      side -= side.dot(bone) * bone;
      if (side.norm() > kLever) segment.palmar_S = side.normalized();
    }
  }
}

/// Which way a palm looks, and the way to its fingers, as a site of that name has them.
struct ToldPalm {
  Eigen::Vector3d facing_S;
  Eigen::Vector3d outward_S;
};

std::optional<ToldPalm> palmIn(const std::vector<ContactSite>& sites,
                               const HandModel& model,
                               const LinkPoses& X_SL) {
  for (const ContactSite& site : sites) {
    if (site.name != "palm") continue;
    const Eigen::Matrix3d& R_SL =
        X_SL[static_cast<std::size_t>(model.linkIndex(site.link))].linear();
    return ToldPalm{R_SL * site.n_L, -(R_SL * site.direction_L)};
  }
  return std::nullopt;
}

std::optional<Palm> palmOf(const Anatomy& anatomy, const std::optional<ToldPalm>& told) {
  Palm palm;
  std::vector<const NamedDigit*> fingers;
  const NamedDigit* thumb = anatomy.maybeDigit("thumb");
  for (const NamedDigit& digit : anatomy.digits)
    if (&digit != thumb) fingers.push_back(&digit);
  if (fingers.size() < 2) return std::nullopt;
  for (const NamedDigit* finger : fingers) {
    palm.facing_S += finger->digit.bone_closing / static_cast<double>(fingers.size());
    palm.outward_S += finger->digit.bone_outward / static_cast<double>(fingers.size());
  }
  if (palm.outward_S.norm() < kSideBySide || palm.facing_S.norm() < kSideBySide)
    return std::nullopt;
  // A site that looks elsewhere than the fingers close is somebody's own word, or that of a
  // claw, whose palm looks along its fingers.
  if (told && told->facing_S.dot(palm.facing_S.normalized()) < kPalmFacing) {
    palm.facing_S = told->facing_S;
    palm.outward_S = told->outward_S;
  }
  palm.outward_S.normalize();
  palm.facing_S -= palm.facing_S.dot(palm.outward_S) * palm.outward_S;
  palm.facing_S.normalize();
  Eigen::Vector3d side = palm.outward_S.cross(palm.facing_S);
  const auto across = [&](const NamedDigit* finger) {
    return finger->digit.knuckle.dot(side);
  };
  const auto by_place = [&](const NamedDigit* a, const NamedDigit* b) {
    return across(a) < across(b);
  };
  const auto [low, high] = std::minmax_element(fingers.begin(), fingers.end(), by_place);
  const double middle = 0.5 * (across(*low) + across(*high));
  const bool is_low =
      thumb != nullptr
          ? (thumb->digit.base + 0.5 * (thumb->digit.tip - thumb->digit.base)).dot(side) <
                middle
          : fingers.front() == *low;
  palm.first_knuckle_S = (is_low ? *low : *high)->digit.knuckle;
  palm.last_knuckle_S = (is_low ? *high : *low)->digit.knuckle;
  palm.thumb_side_S = is_low ? -side : side;
  palm.links = anatomy.palm_links;
  return palm;
}

void noteAPalmThatLeans(const ToldPalm& told, Anatomy& anatomy) {
  const double cosine = told.facing_S.dot(anatomy.palm->facing_S);
  if (cosine > kFacingWell) return;
  anatomy.notes.push_back(fmt::format(
      "the palm's site looks {:.0f} degrees away from where the fingers close: a sites file "
      "beside the URDF may put it elsewhere",
      inDegrees(std::acos(std::clamp(cosine, -1.0, 1.0)))));
}

/// What most names of the file say: right, left; unknown where they say neither. A mirrored
/// hand has the links of the other one; its own name may be that of either.
Chirality sideByNames(const HandModel& model) {
  int right = 0;
  const auto count = [&](const std::string& name) {
    const std::string side = partWordsOf(name).side;
    right += side == "right" ? 1 : side == "left" ? -1 : 0;
  };
  if (!model.isMirror()) count(model.name());
  for (const Link& link : model.links())
    count(link.name);
  if (model.isMirror()) right = -right;
  if (right == 0) return Chirality::kUnknown;
  return right > 0 ? Chirality::kRight : Chirality::kLeft;
}

}  // namespace

double NamedDigit::length() const {
  double sum = 0.0;
  for (const Segment& segment : segments)
    sum += segment.length();
  return sum;
}

const NamedDigit* Anatomy::maybeDigit(const std::string& name) const {
  const auto found = std::find_if(digits.begin(), digits.end(), [&](const NamedDigit& digit) {
    return digit.name == name;
  });
  return found == digits.end() ? nullptr : &*found;
}

Chirality sideOf(const Anatomy& anatomy) {
  const bool is_told =
      anatomy.digits.size() > kClawDigits || anatomy.named_side == anatomy.chirality;
  return is_told ? anatomy.chirality : Chirality::kUnknown;
}

std::vector<std::string> segmentNames(std::size_t count) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) {
    if (i + 1 == count) {
      names.emplace_back("distal");
    } else if (i == 0) {
      names.emplace_back("proximal");
    } else {
      names.push_back(i == 1 ? std::string("middle") : fmt::format("middle_{}", i));
    }
  }
  return names;
}

Anatomy anatomyOf(const HandModel& model,
                  const LinkPoses& X_SL,
                  const std::vector<ContactSite>& sites) {
  Anatomy anatomy;
  const Digits found = findDigits(model, X_SL);
  DigitNames names = nameDigits(found.digits);
  anatomy.notes = std::move(names.notes);
  anatomy.chirality = names.chirality;

  // === Names: a site's word counts before all others
  std::vector<char> by_site(found.digits.size(), 0);
  for (const ContactSite& site : sites) {
    const int link = model.linkIndex(site.link);
    for (std::size_t i = 0; i < found.digits.size(); ++i) {
      const Digit& digit = found.digits[i];
      const bool is_on = std::any_of(digit.nodes.begin(), digit.nodes.end(), [&](int node) {
        const std::vector<int> group = rigidGroupOf(model, node + 1);
        return std::find(group.begin(), group.end(), link) != group.end();
      });
      if (!is_on || by_site[i] != 0) continue;
      by_site[i] = 1;
      names.names[i] = site.name;
    }
  }
  int number = 0;
  for (std::size_t i = 0; i < names.names.size(); ++i) {
    // A name that a site took from another digit.
    const auto is_taken = [&](const std::string& name) {
      return std::count(names.names.begin(), names.names.end(), name) > 1 ||
             std::any_of(sites.begin(), sites.end(), [&](const ContactSite& site) {
               return site.name == name;
             });
    };
    if (by_site[i] != 0 || !is_taken(names.names[i])) continue;
    do {
      names.names[i] = fmt::format("f{}", ++number);
    } while (is_taken(names.names[i]));
  }

  // === Segments and the palm
  anatomy.palm_links = found.palm_links;
  for (std::size_t i = 0; i < found.digits.size(); ++i) {
    NamedDigit digit;
    digit.name = names.names[i];
    digit.named_by_site = by_site[i] != 0;
    digit.named_by_parts = names.from_file[i] != 0;
    digit.digit = found.digits[i];
    digit.segments =
        segmentsOf(model, X_SL, digit.digit, digit.name == "thumb", anatomy.palm_links);
    anatomy.digits.push_back(std::move(digit));
  }
  std::stable_sort(anatomy.digits.begin(), anatomy.digits.end(),
                   [](const NamedDigit& a, const NamedDigit& b) {
                     const auto rank = [](const NamedDigit& digit) {
                       return std::find(kOrder.begin(), kOrder.end(), digit.name) -
                              kOrder.begin();
                     };
                     return rank(a) < rank(b);
                   });
  const std::optional<ToldPalm> told_palm = palmIn(sites, model, X_SL);
  anatomy.palm = palmOf(anatomy, told_palm);
  if (anatomy.palm) turnThumbToFingers(model, X_SL, anatomy);
  if (told_palm && anatomy.palm) noteAPalmThatLeans(*told_palm, anatomy);

  const Chirality told = sideByNames(model);
  anatomy.named_side = told;
  if (told != Chirality::kUnknown && anatomy.chirality != Chirality::kUnknown &&
      told != anatomy.chirality) {
    anatomy.side_note = fmt::format("its names say a {} hand; its palm is a {} one's",
                                    nameOf(told), nameOf(anatomy.chirality));
  }
  if (anatomy.chirality == Chirality::kUnknown) anatomy.chirality = told;
  // A claw that nobody gives a side is read as a right one: its mirror's places are the
  // mirror's.
  if (anatomy.chirality == Chirality::kUnknown && model.isMirror())
    anatomy.chirality = Chirality::kLeft;
  return anatomy;
}

}  // namespace handgraft::hand
