#include "server/model_library.h"

#include <algorithm>
#include <functional>
#include <set>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>

#include "core/base/error.h"
#include "core/io/contact_file.h"
#include "core/io/object_file.h"
#include "core/io/sites_file.h"
#include "core/io/urdf_file.h"
#include "server/rejection.h"

namespace handgraft::server {

namespace fs = std::filesystem;

namespace {

constexpr Origin kBuiltIn{true, 0};

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

void readHand(const fs::path& folder, ModelStore& store) {
  const std::string name = folder.filename().string();
  io::UrdfFile file = io::readUrdf(folder / (name + ".urdf"));
  auto model = std::make_shared<const hand::HandModel>(std::move(file.model));
  std::optional<std::vector<hand::ContactSite>> sites;
  if (fs::exists(folder / "sites.yaml")) {
    sites = io::readSites(folder / "sites.yaml", *model);
  }
  store.replace(StoredHand{name, kBuiltIn, std::move(file.text), std::move(file.notes),
                           std::make_shared<LazyHand>(std::move(model), std::move(sites))});
}

void readObject(const fs::path& path, ModelStore& store) {
  store.replace(StoredObject{path.stem().string(), kBuiltIn,
                             std::make_shared<const io::MeshFile>(io::readObject(path))});
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

void readContacts(const fs::path& path, ModelStore& store) {
  const std::string name = path.stem().string();
  std::string object = io::objectNameIn(path);
  if (object.empty()) object = objectOf(name, store);
  if (object.empty()) rejectInput("{}: does not say which object it lies on", path.string());
  const auto mesh = store.object(object)->file;
  contact::ContactSet set = io::readContacts(path, *mesh);
  set.object = object;
  store.replace(StoredContacts{name, kBuiltIn, mesh, std::move(set)});
}

/// 1 if the model had to be left out.
int attempt(const char* kind, const fs::path& path, const std::function<void()>& read) {
  try {
    read();
    return 0;
  } catch (const std::exception& error) {
    spdlog::warn("event=model_left_out kind={} path={} reason={}", kind, path.string(),
                 handgraft::quoted(error.what()));
    return 1;
  }
}

}  // namespace

int readLibrary(const fs::path& folder, ModelStore& store) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    rejectInput("models: {} is not a folder", handgraft::quoted(folder.string()));
  }
  static const std::set<std::string> kMeshes = {".obj", ".stl",  ".ply",
                                                ".glb", ".gltf", ".dae"};
  static const std::set<std::string> kContacts = {".json", ".ply"};
  int left_out = 0;
  for (const fs::path& entry : entriesOf(folder / "hands")) {
    if (!fs::is_directory(entry, error)) continue;
    left_out += attempt("hand", entry, [&] {
      readHand(entry, store);
    });
  }
  for (const fs::path& entry : entriesOf(folder / "objects")) {
    if (kMeshes.count(entry.extension().string()) == 0) continue;
    left_out += attempt("object", entry, [&] {
      readObject(entry, store);
    });
  }
  for (const fs::path& entry : entriesOf(folder / "contacts")) {
    if (kContacts.count(entry.extension().string()) == 0) continue;
    left_out += attempt("contacts", entry, [&] {
      readContacts(entry, store);
    });
  }
  return left_out;
}

fs::path builtInLibrary() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) {
    const fs::path installed =
        program.parent_path().parent_path() / "share" / "handgraft" / "models";
    if (fs::is_directory(installed, error)) return installed;
  }
  return HANDGRAFT_SOURCE_MODELS;
}

}  // namespace handgraft::server
