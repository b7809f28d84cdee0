#pragma once

#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include <fmt/format.h>
#include <unistd.h>

#include "core/hand/hand_model.h"
#include "core/io/urdf_file.h"

/// Small hands, written where they are tested.
namespace handgraft::test {

/// `links`: links and joints of a URDF.
inline hand::HandModel handOfText(const std::string& name, const std::string& links) {
  const auto path =
      std::filesystem::temp_directory_path() /
      fmt::format("{}_{}_{}.urdf", name, getpid(), std::hash<std::string>()(links));
  std::ofstream(path) << fmt::format("<robot name='{}'>{}</robot>", name, links);
  hand::HandModel model = io::readUrdf(path).model;
  std::filesystem::remove(path);
  return model;
}

/// A link that is a box of a size, its middle at a place, both "x y z".
inline std::string boxLink(const std::string& link,
                           const std::string& size,
                           const std::string& at) {
  return fmt::format(
      "<link name='{}'><visual><origin xyz='{}'/><geometry><box size='{}'/></geometry>"
      "</visual></link>",
      link, at, size);
}

}  // namespace handgraft::test
