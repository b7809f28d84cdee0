#include "client/cli/study/study_axis.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>

#include "core/base/error.h"
#include "core/base/length_unit.h"
#include "core/base/limit_note.h"

namespace handgraft::client {

namespace {

constexpr int kMostValues = 10'000;
constexpr double kDegree = std::numbers::pi / 180.0;
// What --vary and --set look like, each.
constexpr const char* kAxisForms =
    "it must be NAME.PROPERTY=FROM:TO:COUNT or NAME.PROPERTY=A,B,C, with PROPERTY lower, upper "
    "or range of a joint, length or size of a link, or hand.size";
constexpr const char* kChangeForm =
    "it must be NAME.PROPERTY=VALUE, with PROPERTY lower, upper or range of a joint, length or "
    "size of a link, or hand.size";

std::optional<v1::HandProperty> propertyNamed(const std::string& name) {
  if (name == "lower") return v1::PROPERTY_LOWER;
  if (name == "upper") return v1::PROPERTY_UPPER;
  if (name == "range") return v1::PROPERTY_RANGE;
  if (name == "length") return v1::PROPERTY_LENGTH;
  if (name == "size") return v1::PROPERTY_SIZE;
  return std::nullopt;
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  while (true) {
    const std::size_t end = text.find(separator, begin);
    parts.push_back(text.substr(begin, end - begin));
    if (end == std::string::npos) return parts;
    begin = end + 1;
  }
}

/// NAME.PROPERTY, and what follows `=`.
struct Named {
  std::string name;
  v1::HandProperty property{};
  std::string target;
  std::string values;
};

Named namedIn(const std::string& text, const char* forms) {
  const std::size_t equals = text.find('=');
  const std::size_t dot =
      equals == std::string::npos ? equals : text.rfind('.', equals);  // names may have dots
  if (dot == std::string::npos || dot == 0) rejectInput("{}: {}", quoted(text), forms);
  Named named;
  named.name = text.substr(0, equals);
  named.target = text.substr(0, dot);
  named.values = text.substr(equals + 1);
  const std::string property = text.substr(dot + 1, equals - dot - 1);
  const auto found = propertyNamed(property);
  if (!found) {
    rejectInput("{}: there is no property {}; there are lower, upper, range, length, size",
                quoted(text), quoted(property));
  }
  named.property = *found;
  if (named.property == v1::PROPERTY_SIZE && named.target == "hand") named.target.clear();
  return named;
}

/// A number as it stands, and whether `deg` follows.
struct Number {
  double value = 0.0;
  bool in_degrees = false;
};

Number numberIn(const std::string& word, const Named& named, const std::string& text) {
  Number number;
  std::string digits = word;
  if (digits.size() > 3 && digits.substr(digits.size() - 3) == "deg") {
    number.in_degrees = true;
    digits.resize(digits.size() - 3);
  }
  const char* end = digits.data() + digits.size();
  const auto [stop, fault] = std::from_chars(digits.data(), end, number.value);
  const bool is_number = fault == std::errc() && std::isfinite(number.value);
  const LengthUnit* unit =
      is_number ? lengthUnitCalled({stop, static_cast<std::size_t>(end - stop)}) : nullptr;
  if (unit != nullptr && !number.in_degrees) {
    // Whether the joint slides is not known here: 30mm of one that turns would be 0.03 rad.
    rejectInput(
        "{}: {}: limits of joints that slide are in metres here, without a unit; write {:g}",
        quoted(text), quoted(word), number.value * unit->metres);
  }
  if (!is_number || stop != end) rejectInput("{}: {} is no number", quoted(text), quoted(word));
  const bool is_limit =
      named.property == v1::PROPERTY_LOWER || named.property == v1::PROPERTY_UPPER;
  if (number.in_degrees && !is_limit)
    rejectInput("{}: {} is a factor and has no unit", quoted(text), quoted(word));
  return number;
}

/// Nought is nought in any unit: `0:45deg` is from 0deg.
void takeOneUnit(std::vector<Number>& numbers) {
  const bool any = std::any_of(numbers.begin(), numbers.end(), [](const Number& number) {
    return number.in_degrees;
  });
  for (Number& number : numbers)
    number.in_degrees = number.in_degrees || (any && number.value == 0.0);
}

double inRadians(const Number& number) {
  return number.in_degrees ? number.value * kDegree : number.value;
}

int countIn(const std::string& word, const std::string& text) {
  int count = 0;
  const char* end = word.data() + word.size();
  const auto [stop, fault] = std::from_chars(word.data(), end, count);
  if (fault != std::errc() || stop != end || count < 2 || count > kMostValues)
    rejectInput("{}: COUNT {} must be 2 to {}", quoted(text), quoted(word), kMostValues);
  return count;
}

}  // namespace

double StudyAxis::shown(double value) const {
  return in_degrees ? value / kDegree : value;
}

StudyAxis axisFrom(const std::string& text) {
  const Named named = namedIn(text, kAxisForms);
  StudyAxis axis;
  axis.name = named.name;
  axis.axis.property(named.property);
  axis.axis.target(named.target);
  std::vector<Number> numbers;
  if (named.values.find(':') != std::string::npos) {
    const std::vector<std::string> parts = split(named.values, ':');
    if (parts.size() != 3) rejectInput("{}: {}", quoted(text), kAxisForms);
    std::vector<Number> ends{numberIn(parts[0], named, text), numberIn(parts[1], named, text)};
    takeOneUnit(ends);
    const Number& from = ends[0];
    const Number& to = ends[1];
    if (from.in_degrees != to.in_degrees) {
      rejectInput("{}: FROM and TO have different units; write deg behind both or neither",
                  quoted(text));
    }
    const int count = countIn(parts[2], text);
    for (int i = 0; i < count; ++i) {
      // Ends exactly where the user said, and is finite where both ends are.
      const double share = static_cast<double>(i) / (count - 1);
      numbers.push_back({std::lerp(from.value, to.value, share), from.in_degrees});
    }
  } else {
    for (const std::string& word : split(named.values, ','))
      numbers.push_back(numberIn(word, named, text));
    takeOneUnit(numbers);
  }
  axis.in_degrees = numbers.front().in_degrees;
  for (const Number& number : numbers) {
    if (number.in_degrees != axis.in_degrees)
      rejectInput("{}: some values are in degrees, others are not", quoted(text));
    axis.axis.values().push_back(inRadians(number));
  }
  return axis;
}

v1::HandChange changeFrom(const std::string& text) {
  const Named named = namedIn(text, kChangeForm);
  if (named.values.find_first_of(":,") != std::string::npos) {
    rejectInput("{}: {} is no number: one hand has one value, several are for sweep --vary",
                quoted(text), quoted(named.values));
  }
  v1::HandChange change;
  change.property(named.property);
  change.target(named.target);
  change.value(inRadians(numberIn(named.values, named, text)));
  return change;
}

std::vector<std::string> notesOn(const std::vector<StudyAxis>& axes,
                                 const v1::HandDescription& hand) {
  std::vector<std::string> notes;
  for (const StudyAxis& axis : axes) {
    const bool is_upper = axis.axis.property() == v1::PROPERTY_UPPER;
    if (!is_upper && axis.axis.property() != v1::PROPERTY_LOWER) continue;
    const auto [least, most] =
        std::minmax_element(axis.axis.values().begin(), axis.axis.values().end());
    for (const v1::JointInfo& joint : hand.joints()) {
      if (joint.name() != axis.axis.target()) continue;
      const JointRange own{joint.lower(), joint.upper()};
      const JointRange limits{is_upper ? own.lower : *least, is_upper ? *most : own.upper};
      const bool slides = joint.kind() == v1::JOINT_PRISMATIC;
      const std::string note = limitNote(joint.name(), slides, limits, own);
      if (!note.empty()) notes.push_back(note);
    }
  }
  return notes;
}

}  // namespace handgraft::client
