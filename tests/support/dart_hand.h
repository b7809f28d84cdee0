#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <dart/dart.hpp>
#include <dart/utils/urdf/urdf.hpp>

namespace handgraft::test {

/// A URDF's text without the shapes of its links: DART cannot leave meshes out by itself.
inline std::string withoutShapes(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  std::string xml = text.str();
  for (const std::string tag : {"visual", "collision"}) {
    for (std::size_t at = xml.find("<" + tag); at != std::string::npos;
         at = xml.find("<" + tag, at)) {
      const std::size_t end = xml.find("</" + tag + ">", at);
      if (end == std::string::npos) break;
      xml.erase(at, end + tag.size() + 3 - at);
    }
  }
  return xml;
}

/// A hand's joints and links as DART reads them, by code that shares nothing with ours but
/// urdfdom; null if it does not. Followers are joints of their own: DART 6.12 does not move
/// them.
inline dart::dynamics::SkeletonPtr dartHand(const std::filesystem::path& path) {
  dart::utils::DartLoader loader;
  return loader.parseSkeletonString(withoutShapes(path),
                                    dart::common::Uri::createFromPath(path.string()));
}

}  // namespace handgraft::test
