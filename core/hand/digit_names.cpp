#include <algorithm>
#include <array>
#include <limits>
#include <set>

#include <fmt/format.h>

#include "core/hand/digits.h"

namespace handgraft::hand {

namespace {

constexpr std::array<const char*, 4> kFingerNames{"index", "middle", "ring", "little"};
/// What a thumb must differ from the other digits to be called one (0 alike, 2 opposed).
constexpr double kThumbContrast = 0.1;

/// The digit that opposes the others: without it, the rest closes most alike, and it closes
/// least like them. -1 if none stands out.
int findThumb(const std::vector<Digit>& digits) {
  for (std::size_t i = 0; i < digits.size(); ++i)
    if (digits[i].hint == "thumb") return static_cast<int>(i);
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

/// The other digits, from the one next to the thumb across the palm.
std::vector<int> orderFingers(const std::vector<Digit>& digits, int thumb) {
  std::vector<int> fingers;
  for (int i = 0; i < static_cast<int>(digits.size()); ++i)
    if (i != thumb) fingers.push_back(i);
  const auto baseOf = [&](int i) {
    return digits[static_cast<std::size_t>(i)].base;
  };

  Eigen::Vector3d across = Eigen::Vector3d::Zero();
  for (const int a : fingers)
    for (const int b : fingers)
      if ((baseOf(b) - baseOf(a)).norm() > across.norm() + 1e-9) across = baseOf(b) - baseOf(a);
  if (thumb >= 0) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const int i : fingers)
      centre += baseOf(i) / static_cast<double>(fingers.size());
    if ((baseOf(thumb) - centre).dot(across) > 1e-6 * across.norm()) across = -across;
  }
  std::stable_sort(fingers.begin(), fingers.end(), [&](int a, int b) {
    return baseOf(a).dot(across) < baseOf(b).dot(across) - 1e-12;
  });
  return fingers;
}

}  // namespace

std::vector<std::string> nameDigits(const std::vector<Digit>& digits) {
  std::vector<std::string> names(digits.size());
  // Names that the file gives count when every digit has its own.
  std::set<std::string> hints;
  for (const Digit& digit : digits)
    hints.insert(digit.hint);
  if (hints.size() == digits.size() && !hints.contains("")) {
    for (std::size_t i = 0; i < digits.size(); ++i)
      names[i] = digits[i].hint;
    return names;
  }
  const int thumb = findThumb(digits);
  const std::vector<int> fingers = orderFingers(digits, thumb);
  const bool usual = thumb >= 0 && fingers.size() <= kFingerNames.size();
  for (std::size_t rank = 0; rank < fingers.size(); ++rank)
    names[static_cast<std::size_t>(fingers[rank])] =
        usual ? std::string(kFingerNames[rank]) : fmt::format("f{}", rank + 1);
  if (thumb >= 0) names[static_cast<std::size_t>(thumb)] = "thumb";
  return names;
}

}  // namespace handgraft::hand
