// The hazard tables name tests. Each of those names is looked up in the sources of the test
// programs: a table that names a test which is gone, or is not run, would claim what nobody
// proves.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/shared_data.h"

namespace handgraft::safety {
namespace {

namespace fs = std::filesystem;
using handgraft::test::sourceDirectory;  // there is safety::test, too

std::string textOf(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Whether the CMakeLists.txt next above `source` lists it: else it is in no program.
bool isBuilt(const fs::path& source) {
  static const std::regex comment_text(R"(#[^\n]*)");
  for (fs::path folder = source.parent_path(); folder.has_relative_path();
       folder = folder.parent_path()) {
    if (!fs::exists(folder / "CMakeLists.txt")) continue;
    const std::string list =
        std::regex_replace(textOf(folder / "CMakeLists.txt"), comment_text, "");
    const std::string name = source.lexically_relative(folder).generic_string();
    const std::regex listed("(^|[\\s(])" +
                            std::regex_replace(name, std::regex(R"(\.)"), "\\.") + "[\\s)]");
    return std::regex_search(list, listed);
  }
  return false;
}

/// "Suite.Name" of every test that is run.
std::vector<std::string> testsThatRun() {
  static const std::regex test_macro(R"(\nTEST(?:_F|_P)?\(\s*(\w+)\s*,\s*(\w+)\s*\))");
  std::vector<std::string> tests;
  constexpr auto kAlsoLinks = fs::directory_options::follow_directory_symlink;
  for (const auto& entry :
       fs::recursive_directory_iterator(sourceDirectory() / "tests", kAlsoLinks)) {
    if (entry.path().extension() != ".cpp" || !isBuilt(entry.path())) continue;
    const std::string text = textOf(entry.path());
    for (std::sregex_iterator found(text.begin(), text.end(), test_macro), end; found != end;
         ++found) {
      const bool is_run = (*found)[2].str().rfind("DISABLED_", 0) != 0;
      if (is_run) tests.push_back((*found)[1].str() + "." + (*found)[2].str());
    }
  }
  return tests;
}

struct Row {
  std::string hazard, mitigation, tests;
};

/// The rows of the table under "## Hazards".
std::vector<Row> hazardsOf(const fs::path& readme) {
  static const std::regex table_row(R"(\|([^|]*)\|([^|]*)\|([^|]*)\|)");
  const std::string text = textOf(readme);
  const std::size_t begin = text.find("\n## Hazards\n");
  if (begin == std::string::npos) return {};
  const std::string section = text.substr(begin, text.find("\n## ", begin + 4) - begin);
  std::vector<Row> rows;
  for (std::sregex_iterator found(section.begin(), section.end(), table_row), end; found != end;
       ++found)
    rows.push_back({(*found)[1], (*found)[2], (*found)[3]});
  if (rows.size() < 2) return {};
  return {rows.begin() + 2, rows.end()};  // without heading and rule
}

/// The patterns in a cell: `Suite.Name`, `.Name` of the suite before; `...` and `*` stand for
/// anything.
std::vector<std::regex> patternsIn(const std::string& cell) {
  static const std::regex quoted_name(R"(`([\w.*]*)`)");
  static const std::regex wildcard(R"(\.\.\.|\*)");
  std::vector<std::regex> patterns;
  std::string suite;
  for (std::sregex_iterator found(cell.begin(), cell.end(), quoted_name), end; found != end;
       ++found) {
    std::string name = (*found)[1];
    if (name.find_first_of(".*") == std::string::npos) continue;  // no test: a fuzz target
    if (name[0] == '.') name = suite + name;
    suite = name.substr(0, name.find('.'));
    std::string pattern;
    for (const char c : std::regex_replace(name, wildcard, "@"))
      pattern += c == '@' ? ".*" : c == '.' ? "\\." : std::string(1, c);
    patterns.emplace_back(pattern);
  }
  return patterns;
}

class HazardTable : public ::testing::TestWithParam<const char*> {};

TEST_P(HazardTable, NamesTestsThatAreRun) {
  const std::vector<std::string> tests = testsThatRun();
  const std::vector<Row> rows = hazardsOf(sourceDirectory() / GetParam());
  ASSERT_GT(rows.size(), 10u);
  for (const Row& row : rows) {
    const bool is_open = row.mitigation.find("**none**") != std::string::npos;
    const std::vector<std::regex> patterns = patternsIn(row.tests);
    EXPECT_EQ(patterns.empty(), is_open) << row.hazard << "|" << row.tests;
    for (std::size_t i = 0; i < patterns.size(); ++i) {
      EXPECT_TRUE(std::any_of(tests.begin(), tests.end(),
                              [&](const std::string& test) {
                                return std::regex_match(test, patterns[i]);
                              }))
          << "test " << i + 1 << " of" << row.tests;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Tables,
                         HazardTable,
                         ::testing::Values("hardware/HAZARDS.md", "hardware/safety/README.md"),
                         [](const auto& told) {
                           const bool is_of_governor =
                               std::string(told.param).find("safety") != std::string::npos;
                           return is_of_governor ? "safety" : "hardware";
                         });

}  // namespace
}  // namespace handgraft::safety
