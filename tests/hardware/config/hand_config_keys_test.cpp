// Every key of every example: misspelt, without its value, cut off.
#include <random>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "hardware/config/hand_config_file.h"

#include "tests/hardware/config/config_texts.h"

namespace handgraft::config {
namespace {

using texts::contains;
using texts::example_configs;
using texts::exampleText;
using texts::objectionTo;

/// Applies `change` to one place of the tree after another, and tells each resulting text and
/// the path of the place.
template <class Change, class Judge>
void forEachPlace(const YAML::Node& node,
                  const std::string& path,
                  const YAML::Node& root,
                  const Change& change,
                  const Judge& judge) {
  if (node.IsMap()) {
    std::vector<std::string> keys;
    for (const auto& entry : node)
      keys.push_back(entry.first.Scalar());
    for (const std::string& key : keys) {
      YAML::Node map = node;  // nodes are handles: this changes the tree
      const std::string here = path.empty() ? key : path + "." + key;
      const YAML::Node kept = YAML::Clone(map[key]);
      if (change(map, key)) {
        std::ostringstream text;
        text << root;
        judge(here, text.str());
      }
      map.remove("misspelt");
      map[key] = kept;
      forEachPlace(map[key], here, root, change, judge);
    }
  } else if (node.IsSequence()) {
    // The first and the last stand for those between.
    for (std::size_t i = 0; i < node.size(); i += std::max<std::size_t>(1, node.size() - 1))
      forEachPlace(node[i], path + "[" + std::to_string(i) + "]", root, change, judge);
  }
}

TEST(HandConfig, NamesEveryMisspeltKey) {
  int tried = 0;
  for (const std::string& name : example_configs) {
    const YAML::Node root = YAML::Load(exampleText(name));
    forEachPlace(
        root, "", root,
        [](YAML::Node& map, const std::string& key) {
          map["misspelt"] = YAML::Clone(map[key]);
          map.remove(key);
          return true;
        },
        [&](const std::string& place, const std::string& text) {
          const std::string objection = objectionTo(text);
          const auto dot = place.rfind('.');
          const std::string where =
              (dot == std::string::npos ? "" : place.substr(0, dot + 1)) + "misspelt";
          EXPECT_TRUE(contains(objection, where + ": unknown key"))
              << name << " " << place << ": " << objection;
          ++tried;
        });
  }
  EXPECT_GT(tried, 150);
}

TEST(HandConfig, NamesEveryValueThatIsNone) {
  int tried = 0;
  for (const std::string& name : example_configs) {
    for (const char* const bad : {"1e99", ".nan", "[1, {a: b}]", "-.inf"}) {
      const YAML::Node root = YAML::Load(exampleText(name));
      forEachPlace(
          root, "", root,
          [&](YAML::Node& map, const std::string& key) {
            const bool may_be_any_text =
                (key == "name" || key == "hand" || key == "port") && bad[0] != '[';
            map[key] = YAML::Load(bad);
            return !may_be_any_text;
          },
          [&](const std::string& place, const std::string& text) {
            const std::string objection = objectionTo(text);
            EXPECT_TRUE(contains(objection, place))
                << name << " " << place << " = " << bad << ": " << objection;
            ++tried;
          });
    }
  }
  EXPECT_GT(tried, 500);
}

TEST(HandConfig, SurvivesEveryTruncation) {
  for (const std::string& name : example_configs) {
    const std::string text = exampleText(name);
    for (std::size_t length = 0; length < text.size(); length += 7) {
      try {
        parseHandConfig(text.substr(0, length));
      } catch (const InvalidInput&) {
        continue;
      }
    }
  }
}

}  // namespace
}  // namespace handgraft::config
