#include "server/handlers/load_model.h"

#include <string>
#include <utility>

#include "core/base/content_hash.h"
#include "core/base/error.h"
#include "server/base/rejection.h"
#include "server/handlers/enter_model.h"
#include "server/handlers/hand_trajectory.h"
#include "server/messages/load_messages.h"
#include "server/reading/packed.h"
#include "server/reading/units.h"

namespace handgraft::server {

namespace {

/// Of the files, of how they are read, and of the object's name: the same marks on another
/// object are other contacts.
std::string contentOf(ReadRequest reading,
                      const std::string& object,
                      const std::string& of_files) {
  reading.files.clear();
  reading.contacts.object.reset();
  ContentHash hash;
  hash.addText(of_files);
  hash.addText(pack(reading));
  hash.addText(object);
  return hash.finish();
}

/// Of files that mean something with a hand alone.
std::string contentOfBoth(const std::string& of_files, const std::string& of_hand) {
  ContentHash hash;
  hash.addText(of_files);
  hash.addText(of_hand);
  return hash.finish();
}

class Loading {
 public:
  Loading(ReadRequest reading,
          std::string of_files,
          HandlerContext& context,
          const RequestKey& by,
          const Progress& progress)
      : reading_(std::move(reading)),
        of_files_(std::move(of_files)),
        context_(context),
        by_(by),
        progress_(progress) {}

  v1::ModelList load(const std::string& object) {
    switch (reading_.kind) {
      case ReadKind::kHand:
        return enter(
            storedHand(reading_.name, origin(), read<ReadHand>(reading_), reading_.hand));
      case ReadKind::kObject:
        return enter(storedObject(reading_.name, origin(), read<io::MeshFile>(reading_),
                                  reading_.units));
      case ReadKind::kMotion:
        return loadMotion(object.empty() ? objectInFile() : object);
      default:
        return loadContacts(object.empty() ? objectInFile() : object);
    }
  }

 private:
  template <class Model>
  Model read(const ReadRequest& reading) {
    ReadModel model = context_.reader.read(reading, progress_);
    read_bytes_ = pack(model);
    return std::get<Model>(std::move(model));
  }

  template <class Model>
  v1::ModelList enter(Model model, const StoredObject* object = nullptr) {
    const auto recipe = [&] {
      ReadRequest how = reading_;
      how.files.clear();
      how.contacts.object.reset();
      ModelRecipe of{readForm(), pack(how), std::move(read_bytes_)};
      if (object != nullptr) {
        of.base_row = object->origin.row;
        of.base_name = object->name;
      }
      return of;
    };
    return enterModel(std::move(model), context_, by_, "load_model", recipe);
  }

  std::string objectInFile() {
    ReadRequest name = reading_;
    name.kind = ReadKind::kObjectName;
    std::string object = read<ObjectName>(name).name;
    if (object.empty()) {
      rejectInput("{} {}: neither the request nor the file says which object they lie on",
                  reading_.kind == ReadKind::kMotion ? "contacts of motion" : "contacts",
                  handgraft::quoted(reading_.name));
    }
    return object;
  }

  v1::ModelList loadContacts(std::string object) {
    const auto stored = context_.models.object(object);
    reading_.contacts.object = stored->file;
    reading_.contacts.object_units = stored->units;
    auto read_contacts = read<ReadContacts>(reading_);
    const Origin from = origin(object);
    return enter(storedContacts(reading_.name, from, std::move(read_contacts), stored->file,
                                std::move(object)),
                 stored.get());
  }

  v1::ModelList loadMotion(std::string object) {
    const auto stored = context_.models.object(object);
    reading_.contacts.object = stored->file;
    ReadModel model = context_.reader.read(reading_, progress_);
    Origin from = origin(object);
    if (const auto* what = std::get_if<ReadHandTrajectory>(&model)) {
      const auto hand = context_.models.hand(what->plan.hand);
      from.content = contentOfBoth(from.content, hand->origin.content);
      // Cutting contacts takes minutes: not under a name that stands for something else.
      static_cast<void>(context_.models.lacks(v1::MODEL_MOTION, reading_.name, from.content));
      model = ReadMotion{
          motionOfTrajectory(what->plan, *hand, object, stored->file->mesh, progress_)};
    }
    read_bytes_ = pack(model);
    auto read_motion = std::get<ReadMotion>(std::move(model));
    return enter(storedMotion(reading_.name, from, std::move(read_motion), stored->file,
                              std::move(object)),
                 stored.get());
  }

  [[nodiscard]] Origin origin(const std::string& object = "") const {
    return {false, contentOf(reading_, object, of_files_)};
  }

  ReadRequest reading_;
  std::string of_files_;
  HandlerContext& context_;
  const RequestKey& by_;
  const Progress& progress_;
  std::string read_bytes_;  ///< what the reader gave last
};

}  // namespace

v1::ModelList loadModel(const v1::LoadModelRequest& request,
                        const UploadStore::ClientId& client,
                        HandlerContext& context,
                        const RequestKey& by,
                        const Progress& progress) {
  const auto files = context.uploads.finish(client, request.upload_id());
  validateName(request.name());
  try {
    progress.report("reading the model", 0.0);
    return Loading(readRequestFrom(request, *files), files->contentHash(), context, by,
                   progress)
        .load(request.object());
  } catch (const UnitsInDoubt& doubt) {
    throw Rejection(v1::ERROR_UNITS, files->inClientsWords(doubt.what()));
  } catch (const InvalidInput& error) {
    throw InvalidInput(files->inClientsWords(error.what()));
  }
}

}  // namespace handgraft::server
