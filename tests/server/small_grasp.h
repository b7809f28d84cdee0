#pragma once

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "idl/service.h"

#include "tests/support/shared_data.h"

/// Requests that make a small grasp problem: a hand of two boxes, whose skin takes a moment,
/// and the built-in lemon.
namespace handgraft::test {

inline const std::string clamp_urdf = R"(<robot name="clamp">
  <link name="palm"><visual><geometry><box size="0.02 0.06 0.06"/></geometry></visual></link>
  <link name="jaw"><visual><origin xyz="0 0 0.03"/><geometry><box size="0.015 0.02 0.06"/></geometry></visual></link>
  <joint name="hinge" type="revolute"><parent link="palm"/><child link="jaw"/>
    <origin xyz="0 0.05 0.035"/><axis xyz="0 1 0"/>
    <limit lower="-0.5" upper="1.2" effort="1" velocity="2"/></joint>
</robot>)";

inline const std::string clamp_sites = R"(format: handgraft-sites/1
sites:
  - {name: palm, link: palm, point_m: [0.01, 0, 0], normal: [1, 0, 0], direction: [0, 0, -1]}
  - {name: index, link: jaw, point_m: [0.0075, 0, 0.04], normal: [1, 0, 0], direction: [0, 0, -1]}
)";

inline v1::RequestBody putFile(std::uint64_t upload,
                               const std::string& uri,
                               const std::string& bytes) {
  v1::PutFileRequest file;
  file.upload_id(upload);
  file.uri(uri);
  file.total_bytes(bytes.size());
  file.bytes({bytes.begin(), bytes.end()});
  v1::RequestBody body;
  body.put_file(file);
  return body;
}

inline v1::RequestBody loadModel(std::uint64_t upload,
                                 v1::ModelKind kind,
                                 const std::string& name,
                                 const std::string& uri,
                                 const std::string& object = "") {
  v1::LoadModelRequest load;
  load.kind(kind);
  load.name(name);
  load.upload_id(upload);
  load.main_uri(uri);
  load.object(object);
  v1::RequestBody body;
  body.load_model(load);
  return body;
}

inline v1::RequestBody describeModel(v1::ModelKind kind,
                                     const std::string& name,
                                     bool with_meshes) {
  v1::DescribeModelRequest describe;
  v1::ModelKey key;
  key.kind(kind);
  key.name(name);
  describe.model(key);
  describe.with_meshes(with_meshes);
  v1::RequestBody body;
  body.describe_model(describe);
  return body;
}

inline v1::RequestBody unloadModel(v1::ModelKind kind, const std::string& name) {
  v1::ModelKey key;
  key.kind(kind);
  key.name(name);
  v1::RequestBody body;
  body.unload_model(key);
  return body;
}

inline v1::RequestBody plain(v1::Operation operation) {
  v1::RequestBody body;
  body.nothing(v1::Nothing());
  body._d(operation);
  return body;
}

inline v1::RequestBody openSession(const std::string& hand,
                                   const std::string& object,
                                   const std::string& contacts) {
  v1::OpenSessionRequest open;
  open.hand(hand);
  open.object(object);
  open.contacts(contacts);
  v1::RequestBody body;
  body.open_session(open);
  return body;
}

inline v1::RequestBody ofSession(v1::Operation operation, std::uint64_t session) {
  v1::SessionKey key;
  key.session_id(session);
  v1::RequestBody body;
  body.session(key);
  body._d(operation);
  return body;
}

inline v1::RequestBody optimize(std::uint64_t session,
                                v1::Solver solver = v1::SOLVER_DEFAULT,
                                unsigned starts = 0) {
  v1::OptimizeRequest request;
  request.session_id(session);
  v1::SolveOptions options;
  options.solver(solver);
  options.starts(starts);
  request.options().push_back(options);
  v1::RequestBody body;
  body.optimize(request);
  return body;
}

inline v1::RequestBody suggest(std::uint64_t session,
                               const std::string& patch,
                               double reach_m = 0.0,
                               unsigned count = 0) {
  v1::SuggestRequest request;
  request.session_id(session);
  request.patch(patch);
  request.reach_m(reach_m);
  request.count(count);
  v1::RequestBody body;
  body.suggest(request);
  return body;
}

inline v1::RequestBody exportProblem(std::uint64_t session) {
  v1::ExportRequest request;
  request.session_id(session);
  request.format(v1::EXPORT_PROBLEM);
  request.urdf_path("clamp.urdf");
  v1::RequestBody body;
  body.export_file(request);
  return body;
}

inline v1::RequestBody cancel(std::uint64_t request) {
  v1::CancelRequest cancel_request;
  cancel_request.request_id(request);
  v1::RequestBody body;
  body.cancel(cancel_request);
  return body;
}

inline std::string builtIn(const std::string& relative) {
  std::ifstream in(sourceDirectory() / "server" / "models" / relative, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// All that must be asked, in order, before a session on hand `clamp`, object `fruit` and
/// contacts `marks` can be opened.
inline std::vector<v1::RequestBody> smallGrasp() {
  return {putFile(1, "clamp.urdf", clamp_urdf),
          putFile(1, "sites.yaml", clamp_sites),
          loadModel(1, v1::MODEL_HAND, "clamp", "clamp.urdf"),
          putFile(2, "lemon.obj", builtIn("objects/lemon.obj")),
          loadModel(2, v1::MODEL_OBJECT, "fruit", "lemon.obj"),
          putFile(3, "lemon_6.json", builtIn("contacts/lemon_6.json")),
          loadModel(3, v1::MODEL_CONTACTS, "marks", "lemon_6.json", "fruit")};
}

}  // namespace handgraft::test
