#include "core/base/model_name.h"

namespace handgraft {

bool isModelNameCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         c == '_' || c == '-' || c == '.';
}

std::string nameFromPath(const std::filesystem::path& path) {
  std::string name = path.stem().string().substr(0, kLongestModelName);
  for (char& c : name) {
    if (!isModelNameCharacter(c)) c = '_';
  }
  if (name.empty()) name = "model";
  if (name[0] == '.' || name[0] == '-') name[0] = '_';
  return name;
}

}  // namespace handgraft
