#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/hand/digits.h"

namespace handgraft::hand {

namespace {

constexpr std::array<const char*, 4> kFingerNames{"index", "middle", "ring", "little"};
/// What a thumb must differ from the other digits to be called one (0 alike, 2 opposed).
constexpr double kThumbContrast = 0.1;
/// Fingers point the same way if their mean direction is at least this long.
constexpr double kSideBySide = 0.7;
/// Sine below which a side is no side.
constexpr double kClearSide = 0.05;

/// The digit that opposes the others: without it, the rest closes most alike, and it closes
/// least like them. -1 if none stands out.
int findThumb(const std::vector<Digit>& digits) {
  if (digits.size() < 2) return -1;
  if (digits.size() == 2) return digits[0].nodes.size() < digits[1].nodes.size() ? 0 : 1;

  int thumb = -1;
  double best = -std::numeric_limits<double>::infinity();
  double contrast = 0.0;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    Eigen::Vector3d others = Eigen::Vector3d::Zero();
    for (std::size_t j = 0; j < digits.size(); ++j)
      if (j != i) others += digits[j].flexion_axis;
    others /= static_cast<double>(digits.size() - 1);
    const double coherence = others.norm();
    const double likeness =
        coherence > 1e-9 ? digits[i].flexion_axis.dot(others) / coherence : 0.0;
    if (coherence - likeness > best + 1e-9) {
      best = coherence - likeness;
      contrast = 1.0 - likeness;
      thumb = static_cast<int>(i);
    }
  }
  return contrast > kThumbContrast ? thumb : -1;
}

/// The fingers side by side, from the one next to the thumb.
struct Row {
  std::vector<int> fingers;
  /// From the first to the last, at right angles to where fingers that stand side by side
  /// point: a knuckle may lie deep in the palm.
  Eigen::Vector3d across = Eigen::Vector3d::Zero();
  Eigen::Vector3d outward = Eigen::Vector3d::Zero();  ///< mean; short where they spread
  Eigen::Vector3d closing = Eigen::Vector3d::Zero();
  bool is_sided = false;  ///< the thumb is at one end of the row, not before its middle
};

Row orderFingers(const std::vector<Digit>& digits, int thumb) {
  Row row;
  for (int i = 0; i < static_cast<int>(digits.size()); ++i)
    if (i != thumb) row.fingers.push_back(i);
  const auto count = static_cast<double>(row.fingers.size());
  const auto knuckle_of = [&](int i) {
    return digits[static_cast<std::size_t>(i)].knuckle;
  };
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const int i : row.fingers) {
    row.outward += digits[static_cast<std::size_t>(i)].outward / count;
    row.closing += digits[static_cast<std::size_t>(i)].closing / count;
    centre += knuckle_of(i) / count;
  }
  const auto beside = [&](const Eigen::Vector3d& d) -> Eigen::Vector3d {
    if (row.outward.norm() < kSideBySide) return d;
    const Eigen::Vector3d u = row.outward.normalized();
    return d - d.dot(u) * u;
  };
  for (const int a : row.fingers) {
    for (const int b : row.fingers) {
      const Eigen::Vector3d way = beside(knuckle_of(b) - knuckle_of(a));
      if (way.norm() > row.across.norm() + 1e-9) row.across = way;
    }
  }
  if (thumb >= 0) {
    const Digit& one = digits[static_cast<std::size_t>(thumb)];
    // A thumb that springs from the palm's middle still points to its side.
    const Eigen::Vector3d to_thumb = one.base - centre + 0.5 * (one.tip - one.base);
    const double side = to_thumb.dot(row.across);
    row.is_sided = std::abs(side) > kClearSide * to_thumb.norm() * row.across.norm();
    if (row.is_sided && side > 0.0) row.across = -row.across;
  }
  std::stable_sort(row.fingers.begin(), row.fingers.end(), [&](int a, int b) {
    return knuckle_of(a).dot(row.across) < knuckle_of(b).dot(row.across) - 1e-12;
  });
  return row;
}

Chirality chiralityOf(const Row& row) {
  if (!row.is_sided || row.fingers.size() < 2 || row.outward.norm() < kSideBySide)
    return Chirality::kUnknown;
  const double right = (-row.across.normalized()).cross(row.outward).dot(row.closing);
  if (std::abs(right) < kClearSide) return Chirality::kUnknown;
  return right > 0.0 ? Chirality::kRight : Chirality::kLeft;
}

/// What the shape alone says; nothing where the usual names do not fit.
std::vector<std::string> namesByShape(const Row& row, int thumb, std::size_t count) {
  std::vector<std::string> names(count);
  const bool usual = thumb >= 0 && row.fingers.size() <= kFingerNames.size();
  for (std::size_t rank = 0; rank < row.fingers.size(); ++rank)
    names[static_cast<std::size_t>(row.fingers[rank])] =
        usual ? std::string(kFingerNames[rank]) : fmt::format("f{}", rank + 1);
  if (thumb >= 0) names[static_cast<std::size_t>(thumb)] = "thumb";
  return names;
}

/// Gives the nameless fingers the usual names that are left, in their order across the palm.
void nameTheRest(const Row& row, int thumb, std::vector<std::string>& names) {
  std::vector<std::string> left;
  if (thumb >= 0) left.assign(kFingerNames.begin(), kFingerNames.end());
  std::erase_if(left, [&](const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  });
  std::vector<int> nameless;
  for (const int finger : row.fingers)
    if (names[static_cast<std::size_t>(finger)].empty()) nameless.push_back(finger);
  int number = 0;
  for (std::size_t rank = 0; rank < nameless.size(); ++rank)
    names[static_cast<std::size_t>(nameless[rank])] =
        nameless.size() <= left.size() ? left[rank] : fmt::format("f{}", ++number);
}

/// Takes what the file's names say, where they say it once; returns the thumb that they name,
/// or -1.
int takeNamesOfFile(const std::vector<Digit>& digits, DigitNames& result) {
  std::map<std::string, int> hints;
  for (const Digit& digit : digits)
    ++hints[digit.hint];
  std::vector<std::string> twice;
  for (const auto& [hint, count] : hints)
    if (!hint.empty() && count > 1) twice.push_back(hint);
  int thumb = -1;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    const std::string& hint = digits[i].hint;
    if (hint.empty() || hints[hint] > 1) continue;
    result.names[i] = hint;
    result.from_file[i] = 1;
    if (hint == "thumb") thumb = static_cast<int>(i);
  }
  if (!twice.empty())
    result.notes.push_back(fmt::format("names of several digits say {}: their shape decides",
                                       fmt::join(twice, ", ")));
  return thumb;
}

/// Where names and shape disagree, names win.
void tellContradictions(const std::vector<Digit>& digits, int shape_thumb, DigitNames& result) {
  const std::vector<std::string> shape =
      namesByShape(orderFingers(digits, shape_thumb), shape_thumb, digits.size());
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (result.from_file[i] == 0 || shape[i] == result.names[i]) continue;
    const bool is_order = shape[i].starts_with('f');  // by number: nothing to contradict
    if (!is_order)
      result.notes.push_back(fmt::format("the names say {} where the shape has {}: names win",
                                         result.names[i], shape[i]));
  }
}

}  // namespace

DigitNames nameDigits(const std::vector<Digit>& digits) {
  DigitNames result;
  result.names.resize(digits.size());
  result.from_file.assign(digits.size(), 0);
  const int named_thumb = takeNamesOfFile(digits, result);
  const int shape_thumb = findThumb(digits);
  // `middle` alone, of the one that stands against the others, means where it stands.
  if (named_thumb < 0 && shape_thumb >= 0 && digits.size() >= 3 &&
      std::count(result.from_file.begin(), result.from_file.end(), 1) == 1 &&
      result.from_file[static_cast<std::size_t>(shape_thumb)] == 1) {
    const auto one = static_cast<std::size_t>(shape_thumb);
    result.notes.push_back(
        fmt::format("only one of its fingers is called {}, and it stands against the others: "
                    "the thumb, by its shape",
                    result.names[one]));
    result.names[one].clear();
    result.from_file[one] = 0;
  }

  // === The rest by shape, about the thumb that the names tell
  int thumb = named_thumb;
  if (thumb < 0 && shape_thumb >= 0 &&
      result.from_file[static_cast<std::size_t>(shape_thumb)] == 0) {
    thumb = shape_thumb;
    result.names[static_cast<std::size_t>(thumb)] = "thumb";
  }
  const Row row = orderFingers(digits, thumb);
  result.chirality = chiralityOf(row);
  nameTheRest(row, thumb, result.names);

  std::vector<std::string> by_shape;
  for (std::size_t i = 0; i < digits.size(); ++i)
    if (result.from_file[i] == 0) by_shape.push_back(result.names[i]);
  if (!by_shape.empty())
    result.notes.push_back(
        fmt::format("named by the hand's shape, since its names do not say which finger: {}",
                    fmt::join(by_shape, ", ")));

  if (shape_thumb >= 0 && digits.size() > kClawDigits)
    tellContradictions(digits, shape_thumb, result);
  return result;
}

}  // namespace handgraft::hand
