#include "hardware/config/yaml_section.h"

#include <algorithm>
#include <cmath>

namespace handgraft::config {

Section::Section(const YAML::Node& node, std::string path, Problems& problems)
    : node_(node), path_(std::move(path)), problems_(&problems) {
  if (node_.IsMap()) {
    std::set<std::string> seen;
    for (const auto& entry : node_) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
      // The library keeps both and gives the first.
      if (!seen.insert(key).second) problems_->push_back(pathOf(key) + ": is there twice");
    }
  } else {
    problems_->push_back((path_.empty() ? "the file" : path_) + " must be a map of keys");
    node_ = YAML::Node(YAML::NodeType::Map);
  }
}

Section Section::parse(const std::string& text, Problems& problems) {
  try {
    return {YAML::Load(text), "", problems};
  } catch (const YAML::Exception& error) {
    problems.push_back(
        fmt::format("line {}: {}", error.mark.line + 1, handgraft::quoted(error.msg)));
    return {YAML::Node(YAML::NodeType::Map), "", problems};
  }
}

std::string Section::pathOf(const std::string& key) const {
  const std::string name = quotedText(key);
  return path_.empty() ? name : path_ + "." + name;
}

// Keys come from the file: nothing unprintable, nothing endless.
std::string Section::quotedText(const std::string& text) {
  const std::string safe = handgraft::quoted(text);
  return safe.substr(1, safe.size() - 2);
}

void Section::object(const std::string& key, const std::string& what) {
  problems_->push_back(pathOf(key) + ": " + what);
}

bool Section::isWrong(const std::string& key) const {
  const std::string beginning = pathOf(key) + ": ";
  return std::any_of(problems_->begin(), problems_->end(),
                     [&beginning](const std::string& problem) {
                       return problem.compare(0, beginning.size(), beginning) == 0;
                     });
}

std::optional<YAML::Node> Section::find(const std::string& key, bool is_required) {
  asked_.insert(key);
  // A const node: the other operator[] would make the key.
  const YAML::Node& node = node_;
  const YAML::Node found = node[key];
  if (found.IsDefined()) return found;
  if (is_required) object(key, "is missing");
  return std::nullopt;
}

bool Section::has(const std::string& key) {
  return find(key, false).has_value();
}

std::optional<std::string> Section::scalar(const std::string& key, bool is_required) {
  const std::optional<YAML::Node> node = find(key, is_required);
  if (!node) return std::nullopt;
  if (node->IsScalar()) return node->Scalar();
  object(key, "must be one value");
  return std::nullopt;
}

double Section::number(const std::string& key,
                       double least,
                       double most,
                       std::optional<double> standard) {
  const std::optional<std::string> text = scalar(key, !standard.has_value());
  if (!text) return standard.value_or(least);
  double value = 0;
  if (!YAML::convert<double>::decode(YAML::Node(*text), value)) {
    object(key, fmt::format("{} is no number; permitted: {} to {}", handgraft::quoted(*text),
                            least, most));
  } else if (!(value >= least) || !(value <= most)) {
    object(key, fmt::format("{} is not in [{}, {}]", quotedText(*text), least, most));
  } else {
    return value;
  }
  return standard.value_or(least);
}

int Section::integer(const std::string& key, int least, int most, std::optional<int> standard) {
  const std::optional<std::string> text = scalar(key, !standard.has_value());
  if (!text) return standard.value_or(least);
  int value = 0;
  if (!YAML::convert<int>::decode(YAML::Node(*text), value)) {
    object(key, fmt::format("{} is no whole number; permitted: {} to {}",
                            handgraft::quoted(*text), least, most));
  } else if (value < least || value > most) {
    object(key, fmt::format("{} is not in [{}, {}]", value, least, most));
  } else {
    return value;
  }
  return standard.value_or(least);
}

std::string Section::text(const std::string& key, const std::optional<std::string>& standard) {
  const std::optional<std::string> found = scalar(key, !standard.has_value());
  if (!found) return standard.value_or("");
  if (found->empty() || found->size() > 200) object(key, "must be 1 to 200 characters");
  return *found;
}

bool Section::flag(const std::string& key, bool standard) {
  return choice<bool>(key, {{"true", true}, {"false", false}}, standard);
}

std::vector<double> Section::numbers(const std::string& key,
                                     std::size_t count,
                                     double least,
                                     double most) {
  const std::optional<YAML::Node> node = find(key, true);
  std::vector<double> values;
  if (!node) return values;
  if (!node->IsSequence() || (count != 0 && node->size() != count)) {
    object(key, count != 0 ? fmt::format("must be a list of {} numbers", count)
                           : std::string("must be a list of numbers"));
    return values;
  }
  for (std::size_t i = 0; i < node->size(); ++i) {
    double value = 0;
    const YAML::Node& list = *node;
    if (!YAML::convert<double>::decode(list[i], value) || !(value >= least) ||
        !(value <= most)) {
      object(fmt::format("{}[{}]", key, i),
             fmt::format("is no number in [{}, {}]", least, most));
      value = least;
    }
    values.push_back(value);
  }
  return values;
}

Section Section::section(const std::string& key, bool is_required) {
  const std::optional<YAML::Node> node = find(key, is_required);
  return {node ? *node : YAML::Node(YAML::NodeType::Map), pathOf(key), *problems_};
}

std::vector<Section> Section::list(const std::string& key,
                                   std::size_t least,
                                   std::size_t most) {
  const std::optional<YAML::Node> node = find(key, least > 0);
  std::vector<Section> sections;
  if (!node) return sections;
  if (!node->IsSequence() || node->size() < least || node->size() > most) {
    object(key, fmt::format("must be a list of {} to {} entries", least, most));
    return sections;
  }
  const YAML::Node& entries = *node;
  for (std::size_t i = 0; i < entries.size(); ++i)
    sections.emplace_back(entries[i], fmt::format("{}[{}]", pathOf(key), i), *problems_);
  return sections;
}

void Section::finish() {
  std::string known;
  for (const std::string& key : asked_)
    known += (known.empty() ? "" : ", ") + key;
  for (const auto& entry : node_) {
    const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
    if (asked_.count(key) == 0) object(key, "unknown key; there are " + known);
  }
}

}  // namespace handgraft::config
