#include "client/python/model_functions.h"

#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <pybind11/stl.h>

#include "client/link/hand_point.h"
#include "client/link/model_files.h"
#include "client/link/surface_pick.h"
#include "client/python/awaiting.h"
#include "client/python/python_message.h"

namespace handgraft::python {

namespace py = pybind11;
using client::Client;
using py::literals::operator""_a;

namespace {

v1::ModelKind kindFrom(const std::string& name) {
  return static_cast<v1::ModelKind>(
      idl::requireValue(idl::typeOf<v1::ModelKind>(), name, "kind"));
}

/// Sends a model. Where the server has another one of that name, this one is told apart by a
/// hash of its content.
py::object send(client::Client& server, client::ModelFiles model, bool replace_name) {
  try {
    return awaitDict(server.load(model));
  } catch (const client::Refused& refused) {
    if (refused.code() != v1::ERROR_CONFLICT || !replace_name) throw;
  }
  model.name = client::nameApart(model);
  return awaitDict(server.load(std::move(model)));
}

/// The place nearest to a point on a hand's skin or an object's mesh, and its distance, m.
py::dict nearest(client::Client& server,
                 const std::string& side,
                 const std::string& name,
                 const std::array<double, 3>& point) {
  const v1::ModelDescription model = await(server.describe(kindFrom(side), name, true));
  const v1::Mesh& mesh = side == "object" ? model.object().mesh_O() : model.hand().skin_S();
  const Eigen::Vector3d p(point[0], point[1], point[2]);
  v1::SurfacePoint root = client::nearestPoint(mesh, p);
  return py::dict("root"_a = dictOf(root),
                  "distance_m"_a = (client::positionOf(mesh, root) - p).norm());
}

/// What a name means on a hand, its palm's where it is empty: a point that moves with a link.
py::dict handPoint(client::Client& server, const std::string& name, const std::string& point) {
  const v1::ModelDescription bare = await(server.describe(v1::MODEL_HAND, name, false));
  v1::ModelDescription whole;
  const auto with_meshes = [&]() -> const v1::HandDescription& {
    whole = await(server.describe(v1::MODEL_HAND, name, true));
    return whole.hand();
  };
  const client::HandPoint found = point.empty()
                                      ? client::palmPointOf(bare.hand())
                                      : client::handPointNamed(bare.hand(), point, with_meshes);
  return py::dict("link"_a = found.link,
                  "p_L_m"_a = std::array{found.p_L.x(), found.p_L.y(), found.p_L.z()});
}

}  // namespace

void defineModels(ClientClass& type) {
  type.def("list_models",
           [](Client& server) {
             return awaitDict(server.listModels());
           })
      .def(
          "describe",
          [](Client& server, const std::string& kind, const std::string& name, bool meshes) {
            return awaitDict(server.describe(kindFrom(kind), name, meshes));
          },
          "kind"_a, "name"_a, "meshes"_a)
      .def(
          "load_hand",
          [](Client& server, const std::string& path, const std::string& name,
             const std::string& units, const std::map<std::string, std::string>& packages,
             const py::dict& options) {
            client::HandReading reading;
            for (const auto& [package, folder] : packages)
              reading.packages[package] = folder;
            reading.options = messageOf<v1::HandOptions>(options);
            client::ModelFiles model = client::handFiles(path, reading, units);
            if (!name.empty()) model.name = name;
            return send(server, std::move(model), name.empty());
          },
          "path"_a, "name"_a, "units"_a, "packages"_a, "options"_a)
      .def(
          "load_object",
          [](Client& server, const std::string& path, const std::string& name,
             const std::string& units) {
            client::ModelFiles model = client::objectFiles(path, units);
            if (!name.empty()) model.name = name;
            return send(server, std::move(model), name.empty());
          },
          "path"_a, "name"_a, "units"_a)
      .def(
          "load_contacts",
          [](Client& server, const std::string& path, const std::string& object,
             const std::string& name, const std::string& units, const std::string& picture,
             const std::string& joints, const py::dict& options) {
            client::ContactReading reading;
            reading.picture = picture;
            reading.joints = joints;
            reading.options = messageOf<v1::ContactOptions>(options);
            client::ModelFiles model = client::contactFiles(path, object, reading, units);
            if (!name.empty()) model.name = name;
            return send(server, std::move(model), name.empty());
          },
          "path"_a, "object"_a, "name"_a, "units"_a, "picture"_a, "joints"_a, "options"_a)
      .def(
          "load_motion",
          [](Client& server, const std::string& path, const std::string& object,
             const std::string& name) {
            client::ModelFiles model = client::motionFiles(path, object);
            if (!name.empty()) model.name = name;
            return send(server, std::move(model), name.empty());
          },
          "path"_a, "object"_a, "name"_a)
      .def(
          "load_planned_motion",
          [](Client& server, const std::string& name, const std::string& object,
             const std::string& plan, const std::map<std::string, std::string>& texts) {
            std::vector<client::UploadFile> files;
            files.reserve(texts.size());
            for (const auto& [uri, text] : texts)
              files.push_back({uri, {}, text});
            client::ModelFiles model = client::plannedMotion(name, plan, std::move(files));
            model.object = object;
            return send(server, std::move(model), false);
          },
          "name"_a, "object"_a, "plan"_a, "texts"_a)
      .def("nearest", &nearest, "side"_a, "name"_a, "point"_a)
      .def("hand_point", &handPoint, "name"_a, "point"_a)
      .def(
          "unload",
          [](Client& server, const std::string& kind, const std::string& name) {
            await(server.unload(kindFrom(kind), name));
          },
          "kind"_a, "name"_a);
}

}  // namespace handgraft::python
