#include <algorithm>
#include <exception>

#include <assimp/DefaultIOSystem.h>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "core/base/error.h"
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

}  // namespace

FileMesh readScene(const std::filesystem::path& path) {
  Assimp::Importer importer;
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
