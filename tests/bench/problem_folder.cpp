#include "tests/bench/problem_folder.h"

#include <fstream>

#include <nlohmann/json.hpp>

#include "core/base/error.h"

namespace handgraft::bench {

namespace fs = std::filesystem;

namespace {

nlohmann::json parse(const fs::path& path) {
  std::ifstream stream(path);
  if (!stream) rejectInput("{}: cannot be opened for reading", path.string());
  return nlohmann::json::parse(stream);
}

}  // namespace

std::map<std::string, double> readBestKnown(const fs::path& directory) {
  const fs::path path = directory / "reference.json";
  std::map<std::string, double> best_known;
  try {
    const nlohmann::json reference = parse(path);
    for (const auto& [name, entry] : reference.items()) {
      if (fs::exists(directory / (name + ".json"))) {
        best_known[name] = entry.at("best_known").get<double>();
      }
    }
  } catch (const nlohmann::json::exception& error) {
    rejectInput("{}: {}", path.string(), quoted(error.what()));
  }
  if (best_known.empty()) rejectInput("{}: names no problem beside it", path.string());
  return best_known;
}

fs::path urdfOf(const fs::path& problem_file) {
  try {
    const auto name = parse(problem_file).at("hand").at("urdf").get<std::string>();
    return problem_file.parent_path() / name;
  } catch (const nlohmann::json::exception& error) {
    rejectInput("{}: {}", problem_file.string(), quoted(error.what()));
  }
}

}  // namespace handgraft::bench
