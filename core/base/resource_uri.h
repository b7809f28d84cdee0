#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace handgraft {

/// Where `package://NAME/...` leads: package name to directory.
using PackageMap = std::map<std::string, std::filesystem::path>;

/// The packages of a ROS 2 workspace: every folder of `share` in the prefixes that
/// `AMENT_PREFIX_PATH` lists, the first of a name. Empty where the variable is not set;
/// prefixes that do not exist count for nothing.
PackageMap amentPackages();

/// Finds the file that a URI written in a model file means.
///
/// Accepted: `package://NAME/rest`, `file:///absolute`, absolute paths, and paths relative to
/// `base_directory` (the folder of the file that wrote the URI). A package that is not in
/// `packages` is searched for upwards from `base_directory`: a folder called NAME, as ROS
/// checkouts have it. Percent escapes are decoded.
///
/// Errors: InvalidInput, naming the URI and the places looked at, if there is no such file.
std::filesystem::path resolveResource(const std::string& uri,
                                      const std::filesystem::path& base_directory,
                                      const PackageMap& packages);

/// The same among the files below the folder `within`, for URIs of strangers: nothing else of
/// this machine is looked at, and no message tells what is there. Packages are those of
/// `packages`.
///
/// Errors: InvalidInput, naming the URI, if it is absolute, leads out of the folder, or if
/// there is no such file.
std::filesystem::path resolveResourceWithin(const std::filesystem::path& within,
                                            const std::string& uri,
                                            const std::filesystem::path& base_directory,
                                            const PackageMap& packages);

/// Another way to find the file that a URI means: a server maps URIs to files it was sent, and
/// opens no other. Errors: InvalidInput naming the URI if there is none.
using ResourceFinder = std::function<std::filesystem::path(const std::string& uri)>;

/// The URIs of all mesh files that a URDF text names, each once, in order of appearance. A scan
/// of
/// `<mesh filename="...">`, no full parse: what is malformed is found when the model is read.
std::vector<std::string> meshUrisIn(const std::string& urdf_text);

}  // namespace handgraft
