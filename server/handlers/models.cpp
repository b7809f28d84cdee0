#include "server/handlers/models.h"

#include <utility>

#include "core/base/error.h"
#include "server/descriptions.h"
#include "server/reading/read_model.h"

namespace handgraft::server {

namespace {

/// What is read of an upload, the same for all kinds.
ReadRequest readingOf(const v1::LoadModelRequest& request,
                      const UploadedFiles& files,
                      ReadKind kind) {
  ReadRequest reading;
  reading.kind = kind;
  reading.name = request.name();
  reading.main_uri = request.main_uri();
  reading.files = files.all();
  reading.units = request.units();
  return reading;
}

StoredHand readHand(const ReadRequest& reading, const Progress& progress) {
  return storedHand(reading.name, Origin(), std::get<ReadHand>(readModel(reading, progress)),
                    reading.hand);
}

StoredObject readObject(const ReadRequest& reading, const Progress& progress) {
  return storedObject(reading.name, Origin(),
                      std::get<io::MeshFile>(readModel(reading, progress)), reading.units);
}

StoredContacts readContacts(ReadRequest reading,
                            std::string object,
                            const ModelStore& models,
                            const Progress& progress) {
  if (object.empty()) {
    reading.kind = ReadKind::kObjectName;
    object = std::get<ObjectName>(readModel(reading, progress)).name;
    reading.kind = ReadKind::kContacts;
  }
  if (object.empty()) {
    rejectInput("contacts {}: neither the request nor the file says which object they lie on",
                handgraft::quoted(reading.name));
  }
  const auto stored = models.object(object);
  reading.contacts.object = stored->file;
  reading.contacts.object_units = stored->units;
  return storedContacts(reading.name, Origin(),
                        std::get<ReadContacts>(readModel(reading, progress)), stored->file,
                        std::move(object));
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
    std::uint64_t fingerprint = files->fingerprint();
    switch (request.kind()) {
      case v1::MODEL_HAND:
        return store(readHand(readingOf(request, *files, ReadKind::kHand), progress),
                     fingerprint, workshop.models);
      case v1::MODEL_OBJECT:
        return store(readObject(readingOf(request, *files, ReadKind::kObject), progress),
                     fingerprint, workshop.models);
      case v1::MODEL_CONTACTS: {
        StoredContacts contacts = readContacts(readingOf(request, *files, ReadKind::kContacts),
                                               request.object(), workshop.models, progress);
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
      std::optional<SkinnedHand> skinned;
      if (request.with_meshes())
        skinned = {hand->hand->get(progress), hand->hand->skinReport(progress)};
      reply.hand(describe(*hand, skinned));
      return reply;
    }
    case v1::MODEL_OBJECT:
      reply.object(describe(*workshop.models.object(name), request.with_meshes()));
      return reply;
    case v1::MODEL_CONTACTS:
      reply.contacts(describe(*workshop.models.contacts(name), request.with_meshes()));
      return reply;
  }
  rejectInput("model kind {} does not exist", static_cast<unsigned>(request.model().kind()));
}

void unloadModel(const v1::ModelKey& key, Workshop& workshop) {
  workshop.models.remove(key.kind(), key.name());
}

}  // namespace handgraft::server
