#include <algorithm>
#include <cctype>
#include <cstdint>
#include <exception>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>
#include <sstream>
#include <vector>

#include <assimp/BaseImporter.h>
#include <assimp/DefaultIOSystem.h>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "core/base/error.h"
#include "core/io/file_bytes.h"
#include "core/io/file_mesh.h"
#include "core/io/mesh_file.h"

namespace handgraft::io {

namespace {

/// Collects a scene's meshes, each where its first node puts it; a mesh that several nodes show
/// is repeated behind the others.
class SceneReader {
 public:
  SceneReader(const aiScene& scene, std::string file) : scene_(scene), file_(std::move(file)) {}

  FileMesh read() {
    addNode(*scene_.mRootNode, aiMatrix4x4());
    return std::move(mesh_);
  }

 private:
  void addNode(const aiNode& node, const aiMatrix4x4& parent) {
    const aiMatrix4x4 transform = parent * node.mTransformation;
    for (unsigned i = 0; i < node.mNumMeshes; ++i) {
      if (node.mMeshes[i] >= scene_.mNumMeshes) {
        rejectInput("{}: node {} shows mesh {}, the file has {}", file_,
                    handgraft::quoted(node.mName.C_Str()), node.mMeshes[i], scene_.mNumMeshes);
      }
      addMesh(*scene_.mMeshes[node.mMeshes[i]], transform);
    }
    for (unsigned i = 0; i < node.mNumChildren; ++i)
      addNode(*node.mChildren[i], transform);
  }

  void addMesh(const aiMesh& part, const aiMatrix4x4& transform) {
    const std::size_t first = mesh_.vertices.size();
    if (first + part.mNumVertices > static_cast<std::size_t>(kMostVertices)) {
      rejectInput("{}: has more than {} vertices", file_, kMostVertices);
    }
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      const aiVector3D p = transform * part.mVertices[v];
      mesh_.vertices.emplace_back(p.x, p.y, p.z);
    }
    addTextureCoordinates(part, first);
    const bool mirrored = transform.Determinant() < 0.0F;
    for (unsigned f = 0; f < part.mNumFaces; ++f, ++face_count_) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;  // points and lines have no surface
      std::array<int, 3> corners{};
      for (unsigned c = 0; c < 3; ++c) {
        if (face.mIndices[c] >= part.mNumVertices) {
          rejectInput("{}: face {} names vertex {}, its mesh has vertices 0 to {}", file_,
                      face_count_, face.mIndices[c], part.mNumVertices - 1);
        }
        corners[c] = static_cast<int>(first + face.mIndices[c]);
      }
      if (mirrored) std::swap(corners[1], corners[2]);
      mesh_.triangles.push_back(corners);
      mesh_.file_face.push_back(face_count_);
    }
  }

  /// assimp turns glTF's v, which runs downwards, upwards.
  void addTextureCoordinates(const aiMesh& part, std::size_t first) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    if (!part.HasTextureCoords(0) && mesh_.uv.empty()) return;
    mesh_.uv.resize(first + part.mNumVertices, {kNone, kNone});
    for (unsigned v = 0; v < part.mNumVertices && part.HasTextureCoords(0); ++v) {
      const aiVector3D& uv = part.mTextureCoords[0][v];
      mesh_.uv[first + v] = {uv.x, uv.y};
    }
  }

  const aiScene& scene_;
  std::string file_;
  FileMesh mesh_;
  int face_count_ = 0;
};

/// Lets a scene read what lies in its own folder or below, nothing else: a glTF from the
/// network may name any file of this machine as its buffer.
class OwnFolder : public Assimp::DefaultIOSystem {
 public:
  explicit OwnFolder(const std::filesystem::path& file)
      : folder_(std::filesystem::weakly_canonical(file).parent_path()) {}

  bool Exists(const char* file) const override {
    return isWithin(file) && DefaultIOSystem::Exists(file);
  }

  Assimp::IOStream* Open(const char* file, const char* mode) override {
    return isWithin(file) ? DefaultIOSystem::Open(file, mode) : nullptr;
  }

 private:
  [[nodiscard]] bool isWithin(const char* file) const {
    std::error_code error;
    const auto path = std::filesystem::weakly_canonical(file, error);
    if (error) return false;
    const auto [end, rest] =
        std::mismatch(folder_.begin(), folder_.end(), path.begin(), path.end());
    return end == folder_.end();
  }

  std::filesystem::path folder_;
};

// === What assimp gets to see

std::string lowerExtension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) {
    return static_cast<char>(std::tolower(c));
  });
  return extension;
}

std::string firstBytes(const std::filesystem::path& path, std::size_t most) {
  std::string bytes(most, '\0');
  std::ifstream stream(path, std::ios::binary);
  stream.read(bytes.data(), static_cast<std::streamsize>(most));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  return bytes;
}

/// Magic, version and length, which open a GLB, then length and type of its first chunk, the
/// JSON: five little-endian words.
void requireGlb(const std::string& start, std::uintmax_t file_size) {
  constexpr std::size_t kHeaderBytes = 12;
  constexpr std::size_t kChunkStart = 20;
  if (start.size() < kHeaderBytes)
    rejectInput("has {} bytes, a GLB at least {}", start.size(), kHeaderBytes);
  if (!start.starts_with("glTF"))
    rejectInput("is no GLB: it begins with {}, not 'glTF'",
                handgraft::quoted(start.substr(0, 4)));
  const auto word = [&start](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 4; i-- > 0;)
      value = value << 8U | static_cast<unsigned char>(start[at + i]);
    return value;
  };
  if (word(4) != 2) rejectInput("is GLB version {}, permitted is 2", word(4));
  if (word(8) != file_size) {
    rejectInput("its header says {} bytes, the file has {} (truncated?)", word(8), file_size);
  }
  if (start.size() < kChunkStart || start.compare(16, 4, "JSON") != 0)
    rejectInput("is no GLB: its first chunk is not JSON");
  if (word(12) > file_size - kChunkStart) {
    rejectInput("its JSON says {} bytes, the file has {} left", word(12),
                file_size - kChunkStart);
  }
}

/// Refuses what cannot be of the format that the extension says: assimp would try all that it
/// knows, some of them for many seconds.
void requireFormat(const std::filesystem::path& path, const std::string& extension) {
  constexpr std::size_t kStart = 4096;
  const std::uintmax_t size = requireFile(path);
  const std::string start = firstBytes(path, kStart);
  if (extension == ".glb") requireGlb(start, size);
  if (extension == ".gltf") {
    const std::size_t mark = start.starts_with("\xEF\xBB\xBF") ? 3 : 0;
    const std::size_t first = start.find_first_not_of(" \t\r\n", mark);
    if (first == std::string::npos || start[first] != '{')
      rejectInput("is no glTF: its text does not begin with '{{'");
  }
  if (extension == ".dae" && start.find("<COLLADA") == std::string::npos)
    rejectInput("is no COLLADA: no '<COLLADA' in its first {} bytes", kStart);
}

/// Takes away the loaders of all other extensions, so that none of them is tried.
void keepLoadersOf(const std::string& extension, Assimp::Importer& importer) {
  const std::string wanted = extension.substr(1);
  for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {
    std::istringstream known(importer.GetImporterInfo(i)->mFileExtensions);
    const std::istream_iterator<std::string> begin(known), end;
    if (std::find(begin, end, wanted) != end) continue;
    const std::unique_ptr<Assimp::BaseImporter> loader(importer.GetImporter(i));
    importer.UnregisterLoader(loader.get());  // from here on it is ours
  }
}

}  // namespace

FileMesh readScene(const std::filesystem::path& path) {
  const std::string extension = lowerExtension(path);
  try {
    requireFormat(path, extension);
  } catch (const InvalidInput& error) {
    rejectInput("{}: {}", handgraft::quoted(path.string()), error.what());
  }
  Assimp::Importer importer;
  keepLoadersOf(extension, importer);
  importer.SetIOHandler(new OwnFolder(path));  // the importer owns and deletes it
  // Frames stay as the file has them; its unit is applied.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene = nullptr;
  std::string reason;
  try {
    scene = importer.ReadFile(path.string(), aiProcess_Triangulate);
    reason = importer.GetErrorString();
  } catch (const std::exception& error) {
    reason = error.what();
  }
  if (!scene || !scene->mRootNode) {
    rejectInput("{}: cannot be read as a mesh: {}", handgraft::quoted(path.string()),
                handgraft::quoted(reason));
  }
  return SceneReader(*scene, handgraft::quoted(path.string())).read();
}

}  // namespace handgraft::io
