#include "server/handlers/models.h"

#include <utility>

#include "core/base/error.h"
#include "core/io/contact_file.h"
#include "core/io/object_file.h"
#include "core/io/sites_file.h"
#include "core/io/urdf_file.h"
#include "server/convert.h"

namespace handgraft::server {

namespace {

constexpr const char* kSitesUri = "sites.yaml";
constexpr int kMostJoints = 512;  // the bound of joint_rad in sessions.idl

StoredHand readHand(const v1::LoadModelRequest& request, const UploadedFiles& files) {
  io::UrdfFile file =
      io::readUrdf(files.file(request.main_uri()), ResourceFinder([&](const std::string& uri) {
                     return files.file(uri);
                   }));
  auto model = std::make_shared<const hand::HandModel>(std::move(file.model));
  if (model->dofCount() > kMostJoints) {
    rejectInput("hand {}: {} joints; at most {} are supported",
                handgraft::quoted(request.name()), model->dofCount(), kMostJoints);
  }
  std::optional<std::vector<hand::ContactSite>> sites;
  if (files.has(kSitesUri)) sites = io::readSites(files.file(kSitesUri), *model);
  return {request.name(), Origin(), std::move(file.text), std::move(file.notes),
          std::make_shared<LazyHand>(std::move(model), std::move(sites))};
}

/// Sizes of what a hand can hold; outside them a mesh is in other units than metres.
constexpr double kSmallestObject_m = 0.001;
constexpr double kLargestObject_m = 10.0;

StoredObject readObject(const v1::LoadModelRequest& request,
                        const UploadedFiles& files,
                        const Progress& progress) {
  auto file = std::make_shared<const io::MeshFile>(
      io::readObject(files.file(request.main_uri()), progress));
  const double size = file->mesh.diagonal();
  if (!(size >= kSmallestObject_m && size <= kLargestObject_m)) {
    rejectInput("object {}: {:.4g} m across, outside {} to {} m; is its mesh in metres?",
                handgraft::quoted(request.name()), size, kSmallestObject_m, kLargestObject_m);
  }
  return {request.name(), Origin(), std::move(file)};
}

StoredContacts readContacts(const v1::LoadModelRequest& request,
                            const UploadedFiles& files,
                            const ModelStore& models) {
  const std::filesystem::path& path = files.file(request.main_uri());
  std::string object = request.object();
  if (object.empty()) object = io::objectNameIn(path);
  if (object.empty()) {
    rejectInput("contacts {}: neither the request nor the file says which object they lie on",
                handgraft::quoted(request.name()));
  }
  const auto mesh = models.object(object)->file;
  contact::ContactSet set = io::readContacts(path, *mesh);
  set.object = object;
  return {request.name(), Origin(), mesh, std::move(set)};
}

template <class Model>
v1::ModelList store(Model model, std::uint64_t fingerprint, ModelStore& models) {
  model.origin.fingerprint = fingerprint;
  v1::ModelList reply;
  reply.models().push_back(summaryOf(model));
  models.add(std::move(model));
  return reply;
}

}  // namespace

void putFile(const v1::PutFileRequest& request,
             const UploadStore::ClientId& client,
             Workshop& workshop) {
  workshop.uploads.put(client, request);
}

v1::ModelList loadModel(const v1::LoadModelRequest& request,
                        const UploadStore::ClientId& client,
                        Workshop& workshop,
                        const Progress& progress) {
  const auto files = workshop.uploads.finish(client, request.upload_id());
  validateName(request.name());
  try {
    progress.report("reading the model", 0.0);
    progress.checkpoint();
    std::uint64_t fingerprint = files->fingerprint();
    switch (request.kind()) {
      case v1::MODEL_HAND:
        return store(readHand(request, *files), fingerprint, workshop.models);
      case v1::MODEL_OBJECT:
        return store(readObject(request, *files, progress), fingerprint, workshop.models);
      case v1::MODEL_CONTACTS: {
        StoredContacts contacts = readContacts(request, *files, workshop.models);
        // The same marks on another object are other contacts.
        for (const char c : contacts.set.object) {
          fingerprint = fingerprint * 1099511628211ull ^ static_cast<unsigned char>(c);
        }
        return store(std::move(contacts), fingerprint, workshop.models);
      }
    }
  } catch (const InvalidInput& error) {
    throw InvalidInput(files->inClientsWords(error.what()));
  }
  rejectInput("model kind {} does not exist", static_cast<unsigned>(request.kind()));
}

v1::ModelList listModels(const Workshop& workshop) {
  v1::ModelList reply;
  reply.models(workshop.models.list());
  return reply;
}

v1::ModelDescription describeModel(const v1::DescribeModelRequest& request,
                                   const Workshop& workshop,
                                   const Progress& progress) {
  v1::ModelDescription reply;
  const std::string& name = request.model().name();
  switch (request.model().kind()) {
    case v1::MODEL_HAND: {
      const auto hand = workshop.models.hand(name);
      const auto ready = request.with_meshes() ? std::optional(hand->hand->get(progress))
                                               : hand->hand->ready();
      reply.hand(describe(*hand, ready, request.with_meshes()));
      return reply;
    }
    case v1::MODEL_OBJECT:
      reply.object(describe(*workshop.models.object(name), request.with_meshes()));
      return reply;
    case v1::MODEL_CONTACTS:
      reply.contacts(describe(*workshop.models.contacts(name)));
      return reply;
  }
  rejectInput("model kind {} does not exist", static_cast<unsigned>(request.model().kind()));
}

void unloadModel(const v1::ModelKey& key, Workshop& workshop) {
  workshop.models.remove(key.kind(), key.name());
}

}  // namespace handgraft::server
