#include "client/cli/commands/grasp_session.h"

#include "client/cli/commands/input_files.h"
#include "client/link/wire_pose.h"
#include "core/base/error.h"
#include "idl/fields.h"

namespace handgraft::client {

namespace fs = std::filesystem;

GraspInputs collectInputs(const GraspOptions& options) {
  GraspInputs inputs;
  if (isPath(options.hand)) inputs.hand = handFiles(options.hand, options.hand_reading);
  if (isPath(options.object)) inputs.object = objectFiles(options.object, options.units);
  if (isPath(options.contacts)) {
    inputs.contacts =
        contactFiles(options.contacts, "", options.contact_reading, options.units);
  }
  return inputs;
}

std::vector<NamedFile> filesOf(const GraspInputs& inputs) {
  std::vector<NamedFile> read = inputsOf(inputs.hand, "--hand");
  for (const auto& more :
       {inputsOf(inputs.object, "--object"), inputsOf(inputs.contacts, "--contacts")}) {
    read.insert(read.end(), more.begin(), more.end());
  }
  return read;
}

v1::OpenSessionRequest sessionRequest(const GraspOptions& options) {
  v1::OpenSessionRequest request;
  if (options.place) request.X_WO().push_back(placeOf(*options.place, "--place"));
  if (options.weights) {
    v1::Weights weights;
    weights.distance((*options.weights)[0]);
    weights.normal((*options.weights)[1]);
    weights.prior((*options.weights)[2]);
    request.weights().push_back(weights);
  }
  if (!options.log_map.empty() || options.interior_rings > 0) {
    v1::TransferOptions transfer;
    transfer.method(v1::enumeratorFrom<v1::LogMapMethod>(options.log_map, "--log-map"));
    transfer.interior_rings(options.interior_rings);
    request.transfer().push_back(transfer);
  }
  return request;
}

v1::SolveOptions solvingOf(const GraspOptions& options) {
  v1::SolveOptions solving;
  solving.solver(v1::enumeratorFrom<v1::Solver>(options.solver, "--solver"));
  solving.starts(options.starts);
  solving.seed(options.seed);
  solving.max_evaluations(options.max_evaluations);
  solving.paper(options.paper);
  solving.normal_form(options.normal_form);
  if (options.touch_only) solving.penetration(v1::PENETRATION_REPORTED);
  return solving;
}

v1::SessionState openSession(Client& server,
                             ModelSender& sender,
                             const GraspOptions& options,
                             GraspInputs& inputs,
                             v1::OpenSessionRequest& request) {
  request.hand(nameOnServer(sender, options.hand, inputs.hand));
  request.object(nameOnServer(sender, options.object, inputs.object));
  if (inputs.contacts) {
    inputs.contacts->object = request.object();
    // A scan and its contact map come in the same units.
    if (inputs.object) inputs.contacts->units = inputs.object->units;
  }
  request.contacts(nameOnServer(sender, options.contacts, inputs.contacts));
  return server.openSession(request).get();
}

}  // namespace handgraft::client
