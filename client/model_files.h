#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/resource_uri.h"
#include "idl/models.h"

namespace handgraft::client {

struct UploadFile {
  std::string uri;  ///< as the main file spells it
  std::filesystem::path path;
};

/// Every file that the server needs to read one model.
struct ModelFiles {
  v1::ModelKind kind = v1::MODEL_HAND;
  std::string name;
  std::string object;  ///< contacts: what they lie on; may be empty
  std::string main_uri;
  std::vector<UploadFile> files;  ///< the main one first
  PackageMap packages;            ///< hands: each package that the URDF names, absolute
};

/// True if the user means a file: it exists as one, contains a `/`, or ends like a file name
/// (`lemon.obj`). Everything else is the name of a model on the server.
bool isPath(const std::string& text);

/// What the server may call a model: 1-64 letters, digits, `_`, `-` and `.`, not starting with
/// `.` or `-`. Throws InvalidInput; `option` names where the text came from.
void checkModelName(const std::string& name, const std::string& option);

/// The file's name without its extension; characters that a model name may not have become `_`.
std::string nameFromPath(const std::filesystem::path& path);

/// The URDF, all meshes that it names, and a `sites.yaml` beside it.
///
/// Errors: InvalidInput if a file is missing, unreadable or empty, naming the URI and the URDF.
ModelFiles handFiles(const std::filesystem::path& urdf, const PackageMap& packages);

/// A mesh; for glTF, the buffers beside it too. Errors as `handFiles`.
ModelFiles objectFiles(const std::filesystem::path& mesh);

/// A contact set (JSON) or a contact map (PLY). Errors as `handFiles`.
ModelFiles contactFiles(const std::filesystem::path& path, const std::string& object);

/// A hash of all bytes and URIs, for telling models of one name apart. Not cryptographic.
/// Errors: InvalidInput if a file cannot be read.
std::uint64_t contentHash(const ModelFiles& model);

/// The same of one text.
std::uint64_t textHash(const std::string& text);

/// The whole file. Errors: InvalidInput, naming the path and the reason; also above 512 MiB.
std::string readFile(const std::filesystem::path& path);

}  // namespace handgraft::client
