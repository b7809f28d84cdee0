#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/model_name.h"
#include "core/base/resource_uri.h"
#include "idl/models.h"

namespace handgraft::client {

/// What a hand's `sites.yaml` is called among its files.
inline constexpr const char* kSitesUri = "sites.yaml";

struct UploadFile {
  std::string uri;  ///< as the main file spells it
  std::filesystem::path path;
  std::optional<std::string>
      text{};  ///< what it holds, where there is no file: `path` is empty
};

/// How the files of a hand are to be read.
struct HandReading {
  PackageMap packages;
  /// Named poses; empty: the SRDF beside the URDF that has its name, if there is one.
  std::filesystem::path srdf;
  v1::HandOptions options;  ///< but for `srdf_uri`, which `handFiles` sets
  /// The folder that holds all files there are, and beyond which nothing is looked at: for
  /// strangers'. Empty: as `FileFence` permits.
  std::filesystem::path within = {};
};

/// How a contact map is to be read.
struct ContactReading {
  std::filesystem::path picture;      ///< empty: none; likewise the next
  std::filesystem::path joints;       ///< of the hand that touched
  v1::ContactOptions options;         ///< but for the URIs, which `contactFiles` sets
  std::filesystem::path within = {};  ///< as in HandReading
};

/// Every file that the server needs to read one model, and how it is to read them.
struct ModelFiles {
  v1::ModelKind kind = v1::MODEL_HAND;
  std::string name;
  std::string object;  ///< contacts and motions: what they lie on; may be empty
  std::string main_uri;
  std::string units;              ///< empty: metres unless the size says otherwise
  std::vector<UploadFile> files;  ///< the main one first
  PackageMap packages;            ///< hands: each package that the URDF names, absolute
  std::optional<v1::HandOptions> hand_options;  ///< nothing: defaults; likewise the next
  std::optional<v1::ContactOptions> contact_options;
};

/// True if the user means a file: it exists as one, contains a `/`, or ends like a file name
/// (`lemon.obj`). Everything else is the name of a model on the server.
bool isPath(const std::string& text);

/// What the server may call a model: 1-64 letters, digits, `_`, `-` and `.`, not starting with
/// `.` or `-`. Throws InvalidInput; `option` names where the text came from.
void checkModelName(const std::string& name, const std::string& option);

/// The URDF, all meshes that it names, and beside it an SRDF and sites of its name
/// (`NAME.sites.yaml`), or a `sites.yaml` for the folder.
///
/// Packages are looked up among those given, then in the folders above the URDF, then in
/// `AMENT_PREFIX_PATH`.
/// Errors: InvalidInput if a file is missing, unreadable or empty, naming the URI and the URDF;
/// or if it is none that a model may take along (FileFence).
ModelFiles handFiles(const std::filesystem::path& urdf,
                     const HandReading& reading,
                     const std::string& units = {});

/// A mesh; for glTF, the buffers beside it too. `within` as in HandReading. Errors as
/// `handFiles`.
ModelFiles objectFiles(const std::filesystem::path& mesh,
                       const std::string& units = {},
                       const std::filesystem::path& within = {});

/// A contact set (JSON) or a contact map (PLY, or glTF and the like with a picture). Errors as
/// `handFiles`, and InvalidInput for a picture (PNG) without its mesh.
ModelFiles contactFiles(const std::filesystem::path& path,
                        const std::string& object,
                        const ContactReading& reading = {},
                        const std::string& units = {});

/// A motion, or a recording of contacts. Errors as `handFiles`.
ModelFiles motionFiles(const std::filesystem::path& path, const std::string& object);

/// A motion that is made of other files, as `plan` says (handgraft-motion-plan/1), which names
/// them by their URIs. Errors as `handFiles`.
ModelFiles plannedMotion(const std::string& name,
                         std::string plan,
                         std::vector<UploadFile> files);

/// A server's complaint about the model with the files' paths as they were given in place of
/// the URIs under which they were sent, and without a main file that nobody gave.
std::string byGivenPaths(std::string complaint, const ModelFiles& model);

/// A name that tells the model apart from others of its name: that, and a hash of all bytes,
/// URIs, units and options. Errors: InvalidInput if a file cannot be read.
std::string nameApart(const ModelFiles& model);

/// What people call a model that has such a name: without its digits. Other names as they are.
std::string nameCalled(const std::string& name);

/// The packages that a URDF names, as folders of those there are below `within`: where the
/// first mesh lies that the URDF looks for in it, rather a folder of its name than another one.
PackageMap packagesWithin(const std::filesystem::path& within,
                          const std::filesystem::path& urdf);

/// The options as text, the same for equal ones.
std::string textOf(const v1::HandOptions& options);
std::string textOf(const v1::ContactOptions& options);

/// The first 8 digits of a text's ContentHash, for names.
std::string shortHash(const std::string& text);

/// The whole file. Errors: InvalidInput, naming the path and the reason; also above 512 MiB.
std::string readFile(const std::filesystem::path& path);

}  // namespace handgraft::client
