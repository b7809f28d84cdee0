#include "client/link/model_files.h"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <regex>
#include <system_error>
#include <utility>

#include <unistd.h>

#include "client/link/file_fence.h"
#include "core/base/content_hash.h"
#include "core/base/error.h"

namespace handgraft::client {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kShort = 8;  // digits of a hash in a name

constexpr std::uintmax_t kLargestFile = 512ULL << 20U;  // a mesh of 10 million triangles
constexpr std::string_view kPackageScheme = "package://";

void requireReadable(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) rejectInput("{}: no such file", quoted(path.string()));
  if (!fs::is_regular_file(status)) rejectInput("{}: not a file", quoted(path.string()));
  if (access(path.c_str(), R_OK) != 0) {
    rejectInput("{}: cannot be read ({})", quoted(path.string()),
                std::generic_category().message(errno));
  }
  const std::uintmax_t size = fs::file_size(path, error);
  if (error || size == 0) rejectInput("{}: the file is empty", quoted(path.string()));
  if (size > kLargestFile) {
    rejectInput("{}: {} bytes; a file may have up to {}", quoted(path.string()), size,
                kLargestFile);
  }
}

/// What shows contact goes along with the mesh that it lies on.
void requireNoPicture(const fs::path& contacts) {
  static const std::regex png(R"(\.png)", std::regex::icase);
  if (!std::regex_match(contacts.extension().string(), png)) return;
  rejectInput(
      "contacts {}: a picture is no contact map by itself; give the mesh that it lies on, "
      "and the picture as --picture FILE --colors SCALE",
      quoted(contacts.string()));
}

ModelFiles withMainFile(v1::ModelKind kind, const fs::path& path) {
  requireReadable(path);
  ModelFiles model;
  model.kind = kind;
  model.name = nameFromPath(path);
  model.main_uri = path.filename().string();
  model.files.push_back({model.main_uri, path});
  return model;
}

/// It goes into exported files, and must not pass for the hand of the file there.
std::string mirrorsName(const std::string& name) {
  constexpr std::string_view kSuffix = "_mirrored";
  return name.substr(0, kLongestModelName - kSuffix.size()) + std::string(kSuffix);
}

void add(ModelFiles& model, const std::string& uri, const fs::path& path) {
  const auto same = [&](const UploadFile& file) {
    return file.uri == uri;
  };
  if (std::any_of(model.files.begin(), model.files.end(), same)) return;
  requireReadable(path);
  model.files.push_back({uri, path});
}

// The folder that a package URI was looked up in: the file's path without what follows the
// name.
void notePackage(PackageMap& packages, const std::string& uri, const fs::path& file) {
  if (uri.compare(0, kPackageScheme.size(), kPackageScheme) != 0) return;
  const std::string rest = uri.substr(kPackageScheme.size());
  const std::size_t slash = rest.find('/');
  if (slash == std::string::npos) return;
  fs::path folder = fs::absolute(file);
  for ([[maybe_unused]] const fs::path& part : fs::path(rest.substr(slash + 1))) {
    folder = folder.parent_path();
  }
  packages.emplace(rest.substr(0, slash), folder);
}

// Packages of an installed workspace come last: what the user names or keeps beside the URDF is
// meant rather than what happens to be installed.
fs::path findMesh(const std::string& uri,
                  const fs::path& folder,
                  const PackageMap& given,
                  const fs::path& within) {
  if (!within.empty()) return resolveResourceWithin(within, uri, folder, given);
  try {
    return resolveResource(uri, folder, given);
  } catch (const InvalidInput&) {
    PackageMap all = given;
    all.merge(amentPackages());
    if (all.size() == given.size()) throw;
    return resolveResource(uri, folder, all);
  }
}

constexpr std::size_t kLongestUri = 4096;

/// The values of all fields "uri" in a glTF's text. By hand: a std::regex takes stack for every
/// character, and buffers that are written into the file have millions.
std::vector<std::string> urisInGltf(const std::string& text) {
  constexpr const char* kBlank = " \t\r\n";
  const std::string key = "\"uri\"";
  std::vector<std::string> uris;
  for (std::size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + 1)) {
    const std::size_t colon = text.find_first_not_of(kBlank, at + key.size());
    if (colon == std::string::npos || text[colon] != ':') continue;
    const std::size_t quote = text.find_first_not_of(kBlank, colon + 1);
    if (quote == std::string::npos || text[quote] != '"') continue;
    const std::size_t end = text.find('"', quote + 1);
    if (end == std::string::npos) break;
    uris.push_back(text.substr(quote + 1, end - quote - 1));
  }
  return uris;
}

FileFence fenceOf(const fs::path& model, const PackageMap& packages, const fs::path& within) {
  return within.empty() ? FileFence(model, packages) : FileFence::around(within);
}

void addBuffersOfGltf(ModelFiles& model, const fs::path& mesh, const fs::path& within) {
  if (mesh.extension() != ".gltf") return;
  const FileFence fence = fenceOf(mesh, {}, within);
  const std::string text = readFile(mesh);
  for (const std::string& uri : urisInGltf(text)) {
    if (uri.empty() || uri.compare(0, 5, "data:") == 0) continue;
    if (uri.size() > kLongestUri) {
      rejectInput("{}: uri {} has {} bytes; permitted are {}", mesh.string(), quoted(uri),
                  uri.size(), kLongestUri);
    }
    // Textures are named in the same way, and nobody needs them here.
    static const std::regex picture(R"(.*\.(png|jpe?g|webp|ktx2?|dds)$)", std::regex::icase);
    if (std::regex_match(uri, picture)) continue;
    try {
      const fs::path folder = fs::absolute(mesh).parent_path();
      const fs::path buffer = within.empty() ? resolveResource(uri, folder, {})
                                             : resolveResourceWithin(within, uri, folder, {});
      fence.require(uri, buffer, FileFence::Kind::kBuffer);
      add(model, uri, buffer);
    } catch (const InvalidInput& error) {
      rejectInput("{}: {}", mesh.string(), error.what());
    }
  }
}

}  // namespace

bool isPath(const std::string& text) {
  std::error_code error;
  if (fs::is_regular_file(text, error) || text.find('/') != std::string::npos) return true;
  static const std::regex file_name(R"(.+\.[A-Za-z][A-Za-z0-9]{1,4})");
  return std::regex_match(text, file_name);
}

void checkModelName(const std::string& name, const std::string& option) {
  const bool allowed = !name.empty() && name.size() <= kLongestModelName && name[0] != '.' &&
                       name[0] != '-' &&
                       std::all_of(name.begin(), name.end(), isModelNameCharacter);
  if (!allowed) {
    rejectInput(
        "{} {}: a name has 1-{} letters, digits, '_', '-' or '.', and begins with none of "
        "the last two",
        option, quoted(name), kLongestModelName);
  }
}

ModelFiles handFiles(const fs::path& urdf,
                     const HandReading& reading,
                     const std::string& units) {
  ModelFiles model = withMainFile(v1::MODEL_HAND, urdf);
  if (reading.options.mirrored()) model.name = mirrorsName(model.name);
  model.units = units;
  const fs::path folder = fs::absolute(urdf).parent_path();
  const FileFence fence = fenceOf(urdf, reading.packages, reading.within);
  for (const auto& [name, directory] : reading.packages)
    model.packages[name] = fs::absolute(directory);
  for (const std::string& uri : meshUrisIn(readFile(urdf))) {
    if (uri.find("${") != std::string::npos || uri.find("$(") != std::string::npos) {
      rejectInput("{}: mesh {} is xacro, not URDF; expand it first: xacro {} > hand.urdf",
                  urdf.string(), quoted(uri), urdf.filename().string());
    }
    fs::path mesh;
    try {
      mesh = findMesh(uri, folder, reading.packages, reading.within);
      fence.require(uri, mesh, FileFence::Kind::kMesh);
      add(model, uri, mesh);
    } catch (const InvalidInput& error) {
      rejectInput("{}: {}", urdf.string(), error.what());
    }
    notePackage(model.packages, uri, mesh);
  }
  std::error_code error;
  // A file of the URDF's own name first: other URDFs of the folder have other links.
  const fs::path own_sites = fs::path(urdf).replace_extension(".sites.yaml");
  for (const fs::path& sites : {own_sites, folder / kSitesUri}) {
    if (!fs::is_regular_file(sites, error)) continue;
    fence.require(sites.filename().string(), sites, FileFence::Kind::kSites);
    add(model, kSitesUri, sites);
    break;
  }

  v1::HandOptions options = reading.options;
  fs::path srdf = reading.srdf;
  const fs::path beside = fs::path(urdf).replace_extension(".srdf");
  if (srdf.empty() && fs::is_regular_file(beside, error)) {
    fence.require(beside.filename().string(), beside, FileFence::Kind::kPoses);
    srdf = beside;
  }
  if (!srdf.empty()) {
    options.srdf_uri("srdf/" + srdf.filename().string());
    add(model, options.srdf_uri(), srdf);
  }
  if (options != v1::HandOptions()) model.hand_options = options;
  return model;
}

ModelFiles objectFiles(const fs::path& mesh, const std::string& units, const fs::path& within) {
  ModelFiles model = withMainFile(v1::MODEL_OBJECT, mesh);
  model.units = units;
  addBuffersOfGltf(model, mesh, within);
  return model;
}

ModelFiles contactFiles(const fs::path& path,
                        const std::string& object,
                        const ContactReading& reading,
                        const std::string& units) {
  requireNoPicture(path);
  ModelFiles model = withMainFile(v1::MODEL_CONTACTS, path);
  model.object = object;
  model.units = units;
  addBuffersOfGltf(model, path, reading.within);
  v1::ContactOptions options = reading.options;
  if (!reading.picture.empty()) {
    options.picture_uri("picture/" + reading.picture.filename().string());
    add(model, options.picture_uri(), reading.picture);
  }
  if (!reading.joints.empty()) {
    options.joints_uri("joints/" + reading.joints.filename().string());
    add(model, options.joints_uri(), reading.joints);
  }
  if (options != v1::ContactOptions()) model.contact_options = options;
  return model;
}

ModelFiles motionFiles(const fs::path& path, const std::string& object) {
  ModelFiles model = withMainFile(v1::MODEL_MOTION, path);
  model.object = object;
  return model;
}

ModelFiles plannedMotion(const std::string& name,
                         std::string plan,
                         std::vector<UploadFile> files) {
  ModelFiles model;
  model.kind = v1::MODEL_MOTION;
  model.name = name;
  model.main_uri = "plan.json";
  model.files.push_back({model.main_uri, {}, std::move(plan)});
  for (UploadFile& file : files) {
    if (!file.text) requireReadable(file.path);
    model.files.push_back(std::move(file));
  }
  return model;
}

std::string byGivenPaths(std::string complaint, const ModelFiles& model) {
  const auto replace = [&](const std::string& text, const std::string& by) {
    for (std::size_t at = complaint.find(text); at != std::string::npos;
         at = complaint.find(text, at + by.size()))
      complaint.replace(at, text.size(), by);
  };
  for (const UploadFile& file : model.files) {
    const bool is_spelt_by_a_file = file.uri.find("://") != std::string::npos;
    if (is_spelt_by_a_file || file.uri == file.path.filename()) continue;
    if (!file.text)
      replace(quoted(file.uri), quoted(file.path.string()));
    else if (file.uri == model.main_uri)
      replace(quoted(file.uri) + ": ", "");
  }
  return complaint;
}

std::string nameApart(const ModelFiles& model) {
  ContentHash hash;
  hash.addText(model.object);
  hash.addText(model.units);
  if (model.hand_options) hash.addText(textOf(*model.hand_options));
  if (model.contact_options) hash.addText(textOf(*model.contact_options));
  for (const UploadFile& file : model.files) {
    hash.addText(file.uri);
    hash.addText(file.text ? *file.text : readFile(file.path));
  }
  return model.name.substr(0, 55) + "-" + hash.finish().substr(0, kShort);
}

std::string nameCalled(const std::string& name) {
  const std::size_t dash = name.rfind('-');
  if (dash == std::string::npos || dash == 0 || name.size() - dash - 1 != kShort) return name;
  return name.find_first_not_of("0123456789abcdef", dash + 1) == std::string::npos
             ? name.substr(0, dash)
             : name;
}

PackageMap packagesWithin(const fs::path& within, const fs::path& urdf) {
  std::vector<fs::path> folders = {within};
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(within))
    if (entry.is_directory()) folders.push_back(entry.path());
  std::sort(folders.begin(), folders.end());  // what holds another one comes before it
  PackageMap packages;
  for (const std::string& uri : meshUrisIn(readFile(urdf))) {
    if (uri.compare(0, kPackageScheme.size(), kPackageScheme) != 0) continue;
    const std::string rest = uri.substr(kPackageScheme.size());
    const std::size_t slash = rest.find('/');
    if (slash == std::string::npos || packages.count(rest.substr(0, slash)) != 0) continue;
    const std::string name = rest.substr(0, slash);
    const fs::path file = fs::path(rest.substr(slash + 1)).lexically_normal();
    if (file.empty() || file.is_absolute() || *file.begin() == "..") continue;
    const auto holds = [&](const fs::path& one) {
      return fs::is_regular_file(one / file);
    };
    const auto is_named = [&](const fs::path& one) {
      return one != within && one.filename() == name;
    };
    auto found = std::find_if(folders.begin(), folders.end(), [&](const fs::path& one) {
      return is_named(one) && holds(one);
    });
    if (found == folders.end()) found = std::find_if(folders.begin(), folders.end(), holds);
    if (found == folders.end()) found = std::find_if(folders.begin(), folders.end(), is_named);
    if (found != folders.end()) packages.emplace(name, *found);
  }
  return packages;
}

std::string textOf(const v1::HandOptions& o) {
  return fmt::format("hand {} {} {} {} {} {} {}", o.mirrored(), quoted(o.srdf_uri()),
                     quoted(o.rest_pose()), quoted(o.skin().surfaces()), o.skin().alpha_m(),
                     o.skin().offset_m(), o.skin().edge_m());
}

std::string textOf(const v1::ContactOptions& o) {
  const auto first = [](const auto& values) {
    return values.empty() ? std::string("-") : fmt::format("{}", values.front());
  };
  return fmt::format("contacts {} {} {} {} {} {} {} {} {} {} {} {} {}",
                     quoted(o.value_property()), quoted(o.label_property()),
                     quoted(o.color_scale()), quoted(o.picture_uri()), quoted(o.joints_uri()),
                     first(o.joints_hand()), first(o.threshold()), o.otsu(),
                     first(o.low_share()), first(o.outline_share()), o.smoothing_steps(),
                     first(o.minimum_area_m2()), o.interpolation_count());
}

std::string shortHash(const std::string& text) {
  ContentHash hash;
  hash.add(text);
  return hash.finish().substr(0, kShort);
}

std::string readFile(const fs::path& path) {
  requireReadable(path);
  std::ifstream file(path, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (!file) rejectInput("{}: cannot be read", quoted(path.string()));
  return text;
}

}  // namespace handgraft::client
