#include "client/cli/options/grasp_flags.h"

#include <algorithm>

#include <CLI/CLI.hpp>

#include "client/cli/options/option_checks.h"
#include "core/base/error.h"
#include "idl/check.h"

namespace handgraft::client {

namespace {

v1::NormalForm normalFormOf(const std::string& name) {
  if (name == "cosine") return v1::NORMAL_COSINE;
  if (name == "sum") return v1::NORMAL_SUM;
  rejectInput("--normal-form {}: it must be cosine or sum", quoted(name));
}

// What the server would refuse, too (idl/sessions.idl), but only once it has all models.
void requireSolving(const GraspOptions& grasp) {
  const auto require = [](std::uint32_t value, const char* field, const char* option) {
    idl::checkNumber(value, *idl::fieldOf(idl::typeOf<v1::SolveOptions>(), field), option);
  };
  require(grasp.starts, "starts", "--starts");
  require(grasp.max_evaluations, "max_evaluations", "--max-evaluations");
  if (grasp.paper && !grasp.solver.empty()) {
    rejectInput("--solver {}: --paper has its own, mma", quoted(grasp.solver));
  }
  if (grasp.paper && grasp.starts > 0) {
    rejectInput("--starts {}: --paper has one start", grasp.starts);
  }
}

}  // namespace

void GraspFlags::addTo(CLI::App& command) {
  models_ = {command.add_option("--hand", grasp_.hand, "Model name, or path of a URDF"),
             command.add_option("--object", grasp_.object, "Model name, or path of a mesh"),
             command.add_option("--contacts", grasp_.contacts,
                                "Model name, or path of a JSON or PLY file")};
  options_ = {
      command
          .add_option("--place", place_,
                      "The object's pose in the world: x y z (m) qw qx qy qz")
          ->expected(7),
      command
          .add_option("--solver", grasp_.solver,
                      "lm (default), mma, ccsaq, slsqp, lbfgs, tnewton, var2; all races them")
          ->check(objectionToSolver),
      command
          .add_option("--starts", grasp_.starts, "Number of starts; 0: the server's default")
          ->check(objectionToSmallCount),
      command.add_option("--seed", grasp_.seed, "Seed of the starts after the first")
          ->check(objectionToSmallCount),
      command
          .add_option("--max-evaluations", grasp_.max_evaluations,
                      "Of the objective, a start; 0: the server's default")
          ->check(objectionToSmallCount),
      command.add_flag("--paper", grasp_.paper,
                       "The paper's own way: one start, the prior, by mma; nothing refined"),
      command.add_option("--normal-form", normal_form_,
                         "What the normals' term sums: cosine (the paper's) or sum"),
      command.add_flag(
          "--touch-only", grasp_.touch_only,
          "Do not keep the hand out of the object and itself: the paper's own terms"),
      command.add_option("--log-map", grasp_.log_map,
                         "How patches are laid out: fast, exact, auto, smooth, heat"),
      command
          .add_option("--interior", grasp_.interior_rings,
                      "Rings of points inside each patch that count, too: 0 (default) to 16")
          ->check(objectionToSmallCount),
      command.add_option("--weights", weights_, "Of distance (1/m^2), normal and prior")
          ->expected(3)};
  addUnits(command, grasp_.units, "the object and the contacts");
  hand_.addTo(command);
  contacts_.addSourceTo(command);
  contacts_.addSegmentationTo(command);
}

bool GraspFlags::named() const {
  return std::any_of(models_.begin(), models_.end(), [](const CLI::Option* option) {
    return option->count() > 0;
  });
}

GraspOptions GraspFlags::grasp() const {
  GraspOptions grasp = grasp_;
  for (const CLI::Option* model : models_) {
    if (model->count() == 0) rejectInput("{} is required", model->get_name());
  }
  requireModel(grasp.hand, "--hand");
  requireModel(grasp.object, "--object");
  requireModel(grasp.contacts, "--contacts");
  if (!grasp.units.empty() && !isPath(grasp.object) && !isPath(grasp.contacts)) {
    rejectInput("--units {}: neither --object nor --contacts is a file", grasp.units);
  }
  grasp.hand_reading = hand_.reading();
  grasp.contact_reading = contacts_.reading();
  hand_.requirePath(grasp.hand, "--hand");
  contacts_.requirePath(grasp.contacts, "--contacts");
  grasp.place = placeOf(place_);
  if (!normal_form_.empty()) grasp.normal_form = normalFormOf(normal_form_);
  requireSolving(grasp);
  requireFinite(weights_, "--weights", 0.0);
  const auto is_zero = [](double weight) {
    return weight == 0.0;
  };
  if (!weights_.empty()) {
    if (std::all_of(weights_.begin(), weights_.end(), is_zero)) {
      rejectInput("--weights 0 0 0: at least one of them must be positive");
    }
    std::copy_n(weights_.begin(), 3, grasp.weights.emplace().begin());
  }
  return grasp;
}

void GraspFlags::requireUnused(const char* whom) const {
  for (const CLI::Option* option : options_) {
    if (option->count() > 0) rejectInput("{}: it is for {} alone", option->get_name(), whom);
  }
  if (!grasp_.units.empty()) rejectInput("--units: it is for {} alone", whom);
  hand_.requireUnused(whom);
  contacts_.requireUnused(whom);
}

}  // namespace handgraft::client
