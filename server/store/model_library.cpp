#include "server/store/model_library.h"

#include <algorithm>
#include <functional>
#include <future>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel_for.h"
#include "core/base/progress.h"
#include "core/base/resource_uri.h"
#include "core/hand/kept_solid.h"
#include "core/hand/skin_cache.h"
#include "core/io/contact_file.h"
#include "core/io/file_bytes.h"
#include "server/base/rejection.h"
#include "server/log/log.h"
#include "server/reading/read_model.h"

namespace handgraft::server {

namespace fs = std::filesystem;

namespace {

const Origin built_in_origin{true};

std::vector<fs::path> entriesOf(const fs::path& folder) {
  std::vector<fs::path> entries;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    entries.push_back(at->path());
  }
  std::sort(entries.begin(), entries.end());
  return entries;
}

/// The meshes that a URDF names, where it would find them; those it would not are left out.
std::map<std::string, fs::path> meshesOf(const fs::path& urdf) {
  std::map<std::string, fs::path> files;
  for (const std::string& uri : meshUrisIn(io::readFileBytes(urdf))) {
    try {
      files.emplace(uri, resolveResource(uri, urdf.parent_path(), {}));
    } catch (const InvalidInput&) {
      // A comment may name what nobody has; what is needed is missed when the hand is read.
    }
  }
  return files;
}

StoredHand readHand(const fs::path& folder) {
  ReadRequest reading;
  reading.kind = ReadKind::kHand;
  reading.name = folder.filename().string();
  const fs::path urdf = folder / (reading.name + ".urdf");
  reading.main_uri = urdf.string();
  reading.files = meshesOf(urdf);
  reading.files[reading.main_uri] = urdf;
  if (fs::exists(folder / kSitesUri)) reading.files[kSitesUri] = folder / kSitesUri;
  return storedHand(reading.name, built_in_origin,
                    std::get<ReadHand>(readModel(reading, Progress())), reading.hand);
}

StoredObject readObject(const fs::path& path) {
  ReadRequest reading;
  reading.kind = ReadKind::kObject;
  reading.name = path.stem().string();
  reading.main_uri = path.string();
  reading.files[reading.main_uri] = path;
  return storedObject(reading.name, built_in_origin,
                      std::get<io::MeshFile>(readModel(reading, Progress())), "");
}

/// The object whose name begins `name`, the longest one; empty if there is none.
std::string objectOf(const std::string& name, const ModelStore& store) {
  std::string best;
  for (const v1::ModelSummary& one : store.list()) {
    if (one.kind() != v1::MODEL_OBJECT || one.name().size() <= best.size()) continue;
    if (name.compare(0, one.name().size() + 1, one.name() + "_") == 0) best = one.name();
  }
  return best;
}

StoredContacts readContacts(const fs::path& path, const ModelStore& store) {
  ReadRequest reading;
  reading.kind = ReadKind::kContacts;
  reading.name = path.stem().string();
  reading.main_uri = path.string();
  reading.files[reading.main_uri] = path;
  std::string object = io::objectNameIn(path);
  if (object.empty()) object = objectOf(reading.name, store);
  if (object.empty()) rejectInput("{}: does not say which object it lies on", path.string());
  const auto file = store.object(object)->file;
  reading.contacts.object = file;
  return storedContacts(reading.name, built_in_origin,
                        std::get<ReadContacts>(readModel(reading, Progress())), file,
                        std::move(object));
}

/// 1 if the model had to be left out.
int attempt(const char* kind, const fs::path& path, const std::function<void()>& read) {
  try {
    read();
    return 0;
  } catch (const std::exception& error) {
    log::warn("event=model_left_out kind={} path={} reason={}", kind, path.string(),
              handgraft::quoted(error.what()));
    return 1;
  }
}

/// Reads all of a kind side by side, and enters them one after another: of two of one name the
/// later stays, as ever. How many had to be left out.
template <class Read>
int enterAll(const char* kind,
             const std::vector<fs::path>& paths,
             const Read& read,
             ModelStore& store) {
  std::vector<std::optional<decltype(read(fs::path()))>> models(paths.size());
  std::vector<int> left_out(paths.size(), 0);
  parallelFor(static_cast<int>(paths.size()), [&](int k) {
    const auto i = static_cast<std::size_t>(k);
    left_out[i] = attempt(kind, paths[i], [&] {
      models[i] = read(paths[i]);
    });
  });
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (!models[i]) continue;
    left_out[i] = attempt(kind, paths[i], [&] {
      store.replace(std::move(*models[i]));
    });
  }
  return std::accumulate(left_out.begin(), left_out.end(), 0);
}

}  // namespace

int readLibrary(const fs::path& folder, ModelStore& store) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    rejectInput("models: {} is not a folder", handgraft::quoted(folder.string()));
  }
  static const std::set<std::string> mesh_extensions = {".obj", ".stl",  ".ply",
                                                        ".glb", ".gltf", ".dae"};
  static const std::set<std::string> contact_extensions = {".json", ".ply"};
  const auto those_of = [&](const char* subfolder, const auto& are_so) {
    std::vector<fs::path> paths = entriesOf(folder / subfolder);
    std::erase_if(paths, [&](const fs::path& path) {
      return !are_so(path);
    });
    return paths;
  };
  const auto hands = those_of("hands", [&](const fs::path& path) {
    return fs::is_directory(path, error);
  });
  const auto objects = those_of("objects", [&](const fs::path& path) {
    return mesh_extensions.count(path.extension().string()) > 0;
  });
  const auto contacts = those_of("contacts", [&](const fs::path& path) {
    return contact_extensions.count(path.extension().string()) > 0;
  });
  const auto contacts_from = [&store](const fs::path& path) {
    return readContacts(path, store);
  };
  int left_out = enterAll("hand", hands, readHand, store);
  left_out += enterAll("object", objects, readObject, store);
  return left_out + enterAll("contacts", contacts, contacts_from, store);  // on those objects
}

fs::path builtInLibrary() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) {
    fs::path installed = program.parent_path().parent_path() / "share" / "handgraft" / "models";
    if (fs::is_directory(installed, error)) return installed;
  }
  return HANDGRAFT_SOURCE_MODELS;
}

fs::path builtInSkins() {
  const fs::path library = builtInLibrary();
  return library == HANDGRAFT_SOURCE_MODELS ? fs::path(HANDGRAFT_BUILT_SKINS)
                                            : library.parent_path() / "skins";
}

void makeSkins(const fs::path& folder) {
  ModelStore store;
  if (readLibrary(builtInLibrary(), store) > 0)
    rejectInput("models: a built-in one cannot be read");
  const hand::SkinCache skins(folder);
  // Each takes seconds: side by side.
  std::vector<std::future<void>> made;
  for (const v1::ModelSummary& one : store.list()) {
    if (one.kind() != v1::MODEL_HAND) continue;
    made.push_back(std::async(std::launch::async, [&skins, held = store.hand(one.name())] {
      const hand::HandModel& model = held->hand->model();
      const hand::Skin skin = skins.get(model, HandReading().skin, Progress());
      static_cast<void>(hand::keptSolid(model, skin, Progress()));
    }));
  }
  for (std::future<void>& one : made)
    one.get();
}

}  // namespace handgraft::server
