#include "core/io/problem_file.h"

#include <cmath>
#include <fstream>
#include <limits>
#include <set>

#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/formats/json_keys.h"
#include "core/io/urdf_file.h"

namespace handgraft::io {

namespace {

using nlohmann::json;
using optimize::PoseProblem;

constexpr const char* kFormat = "handgraft-problem/1";
constexpr const char* kCosine = "cosine";
constexpr const char* kSum = "sum";
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::uintmax_t kMostBytes = 64U << 20U;
constexpr std::size_t kMostEntries = 200'000;  // of a list; a point pair takes 200 bytes

/// A value inside the file and the way to it, for messages.
class Field {
 public:
  Field(const json& value, std::string file, std::string path)
      : value_(value), file_(std::move(file)), path_(std::move(path)) {}

  template <class... Args>
  [[noreturn]] void reject(fmt::format_string<Args...> format, Args&&... args) const {
    rejectInput("{}: {}: {}", file_, path_.empty() ? "the whole" : quoted(path_),
                fmt::format(format, std::forward<Args>(args)...));
  }

  /// Errors: InvalidInput if it has other keys.
  void permitKeys(std::initializer_list<const char*> permitted) const {
    if (const auto fault = formats::unknownKeyIn(value_, permitted)) reject("{}", *fault);
  }

  [[nodiscard]] bool has(const char* key) const { return value_.contains(key); }

  [[nodiscard]] Field operator[](const char* key) const {
    if (!value_.is_object()) reject("is {}; it must be an object", value_.type_name());
    const auto found = value_.find(key);
    if (found == value_.end()) reject("has no field '{}'", key);
    return {*found, file_, path_.empty() ? key : path_ + "." + key};
  }

  [[nodiscard]] std::vector<Field> list() const {
    if (!value_.is_array()) reject("is {}; it must be a list", value_.type_name());
    if (value_.size() > kMostEntries)
      reject("has {} entries; permitted are {}", value_.size(), kMostEntries);
    std::vector<Field> fields;
    fields.reserve(value_.size());
    for (const json& entry : value_) {
      fields.emplace_back(entry, file_, fmt::format("{}[{}]", path_, fields.size()));
    }
    return fields;
  }

  [[nodiscard]] std::vector<Field> list(std::size_t size) const {
    if (value_.is_array() && value_.size() != size) {
      reject("has {} entries; it must have {}", value_.size(), size);
    }
    return list();
  }

  [[nodiscard]] std::string text() const {
    if (!value_.is_string()) reject("is {}; it must be a string", value_.type_name());
    return value_.get<std::string>();
  }

  [[nodiscard]] double number() const {
    if (!value_.is_number()) reject("is {}; it must be a number", value_.type_name());
    return value_.get<double>();
  }

  [[nodiscard]] double weight() const {
    const double value = number();
    if (value < 0.0) reject("is {}; it must be at least 0", value);
    return value;
  }

  /// A bound; null is none.
  [[nodiscard]] double numberOr(double none) const {
    return value_.is_null() ? none : number();
  }

  [[nodiscard]] Eigen::Vector3d vector3() const {
    const std::vector<Field> entries = list(3);
    return {entries[0].number(), entries[1].number(), entries[2].number()};
  }

  [[nodiscard]] Eigen::Vector3d unitVector3() const {
    constexpr double kTolerance = 1e-3;  // as optimize::validate has it
    Eigen::Vector3d n = vector3();
    const double norm = n.norm();
    if (!(std::abs(norm - 1.0) <= kTolerance)) {
      reject("has length {:.6g}; a normal's must be 1 within {}", norm, kTolerance);
    }
    return n;
  }

  [[nodiscard]] const json& raw() const { return value_; }

 private:
  const json& value_;
  std::string file_;
  std::string path_;
};

json parseFile(const std::filesystem::path& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    rejectInput("{}: is a directory; it must be a problem file", path.string());
  }
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (!error && size > kMostBytes)
    rejectInput("{}: {} bytes; permitted are {}", path.string(), size, kMostBytes);
  std::ifstream stream(path, std::ios::binary);
  if (!stream) rejectInput("{}: cannot be opened for reading", path.string());
  try {
    return json::parse(stream);
  } catch (const json::exception& failure) {
    rejectInput("{}: not JSON: {}", path.string(), quoted(failure.what()));
  }
}

/// The file's dofs as degrees of freedom of the problem; each exactly once.
std::vector<int> readOrder(const Field& field, const PoseProblem& problem) {
  std::vector<bool> seen(static_cast<std::size_t>(problem.dofCount()), false);
  std::vector<int> order;
  for (const Field& entry : field.list()) {
    const std::string name = entry.text();
    int dof = 0;
    while (dof < problem.dofCount() && dofName(problem, dof) != name)
      ++dof;
    if (dof == problem.dofCount()) {
      entry.reject(
          "{} is neither a root coordinate nor an independent joint of the hand; it has "
          "{}",
          quoted(name), quoted(fmt::format("{}", fmt::join(problem.model->dofNames(), " "))));
    }
    if (seen[static_cast<std::size_t>(dof)]) entry.reject("names {} twice", quoted(name));
    seen[static_cast<std::size_t>(dof)] = true;
    order.push_back(dof);
  }
  for (int dof = 0; dof < problem.dofCount(); ++dof) {
    if (!seen[static_cast<std::size_t>(dof)]) {
      field.reject("lacks {}", quoted(dofName(problem, dof)));
    }
  }
  return order;
}

/// One number per dof, from the file's order to the problem's.
Eigen::VectorXd readTheta(const Field& field, const std::vector<int>& order) {
  const std::vector<Field> entries = field.list(order.size());
  Eigen::VectorXd theta(static_cast<Eigen::Index>(order.size()));
  for (std::size_t i = 0; i < order.size(); ++i)
    theta[order[i]] = entries[i].number();
  return theta;
}

hand::HandPose poseOf(const Eigen::VectorXd& theta) {
  hand::HandPose pose;
  pose.X_WH.linear() = rotationFromVector(theta.head<3>());
  pose.X_WH.translation() = theta.segment<3>(3);
  pose.q = theta.tail(theta.size() - 6);
  return pose;
}

void readBounds(const Field& file, const std::vector<int>& order, PoseProblem& problem) {
  const std::vector<Field> lower = file["lower"].list(order.size());
  const std::vector<Field> upper = file["upper"].list(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const int dof = order[i];
    const double low = lower[i].numberOr(-kInfinity);
    const double high = upper[i].numberOr(kInfinity);
    if (dof >= 6) {
      problem.lower[dof - 6] = low;
      problem.upper[dof - 6] = high;
    } else if (dof >= 3) {
      problem.root_lower[dof - 3] = low;
      problem.root_upper[dof - 3] = high;
    } else if (low > -kInfinity) {
      lower[i].reject("is {}; the root's rotation takes no bounds, only null", low);
    } else if (high < kInfinity) {
      upper[i].reject("is {}; the root's rotation takes no bounds, only null", high);
    }
  }
}

/// Names of dofs, or one flag per dof.
std::vector<bool> readLocked(const Field& field,
                             const std::vector<int>& order,
                             const PoseProblem& problem) {
  std::vector<bool> locked(order.size(), false);
  const std::vector<Field> entries = field.list();
  if (!entries.empty() && entries.front().raw().is_boolean()) {
    const std::vector<Field> flags = field.list(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (!flags[i].raw().is_boolean())
        flags[i].reject("must be true or false like the others");
      locked[static_cast<std::size_t>(order[i])] = flags[i].raw().get<bool>();
    }
    return locked;
  }
  if (entries.size() > order.size())
    field.reject("has {} entries; the hand has {} dofs", entries.size(), order.size());
  for (const Field& entry : entries) {
    const std::string name = entry.text();
    int dof = 0;
    while (dof < problem.dofCount() && dofName(problem, dof) != name)
      ++dof;
    if (dof == problem.dofCount()) entry.reject("{} is not among the dofs", quoted(name));
    locked[static_cast<std::size_t>(dof)] = true;
  }
  return locked;
}

optimize::NormalForm readNormalForm(const Field& field) {
  const std::string name = field.text();
  if (name == kCosine) return optimize::NormalForm::kCosine;
  if (name == kSum) return optimize::NormalForm::kSum;
  field.reject("is {}; it must be '{}' or '{}'", quoted(name), kCosine, kSum);
}

optimize::PointPair readPair(const Field& field, const hand::HandModel& model) {
  field.permitKeys({"link", "p_hand", "n_hand", "p_object", "n_object", "weight"});
  optimize::PointPair pair;
  const Field link = field["link"];
  const std::string name = link.text();
  const std::optional<int> index = model.maybeLinkIndex(name);
  if (!index) link.reject("{} is not a link of hand {}", quoted(name), quoted(model.name()));
  pair.link = *index;
  pair.p_L = field["p_hand"].vector3();
  pair.p_W = field["p_object"].vector3();
  pair.has_normals = field.has("n_hand") || field.has("n_object");
  pair.n_L = pair.has_normals ? field["n_hand"].unitVector3() : Eigen::Vector3d::UnitZ();
  pair.n_W = pair.has_normals ? field["n_object"].unitVector3() : Eigen::Vector3d::UnitZ();
  if (field.has("weight")) pair.weight = field["weight"].weight();
  return pair;
}

std::shared_ptr<const hand::HandModel> readHand(const Field& field,
                                                const std::filesystem::path& folder) {
  field.permitKeys({"urdf", "packages"});
  const Field urdf = field["urdf"];
  const std::filesystem::path path = folder / urdf.text();
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    urdf.reject("there is no file {}", quoted(path.string()));
  }
  if (field.has("packages")) {
    const Field packages = field["packages"];
    if (!packages.raw().is_object()) packages.reject("must map names to directories");
  }
  return std::make_shared<const hand::HandModel>(readUrdfKinematics(path));
}

json vectorJson(const Eigen::Vector3d& v) {
  return json{v.x(), v.y(), v.z()};
}

json thetaJson(const Eigen::VectorXd& theta) {
  return json(std::vector<double>(theta.data(), theta.data() + theta.size()));
}

json boundsJson(const Eigen::Vector3d& root, const Eigen::VectorXd& joints) {
  json bounds = json::array({nullptr, nullptr, nullptr});
  const auto add = [&bounds](double value) {
    bounds.push_back(std::isinf(value) ? json(nullptr) : json(value));
  };
  for (const double value : root)
    add(value);
  for (const double value : joints)
    add(value);
  return bounds;
}

}  // namespace

ProblemFile readProblemFile(const std::filesystem::path& path) {
  const json document = parseFile(path);
  const Field file(document, path.string(), "");
  const Field format = file["format"];
  if (format.text() != kFormat) {
    format.reject("is {}; it must be '{}'", quoted(format.text()), kFormat);
  }

  file.permitKeys({"format", "hand", "dofs", "start", "prior", "lower", "upper", "weights",
                   "normal_form", "prior_weights", "locked", "correspondences", "notes"});
  if (file.has("notes")) {
    for (const Field& note : file["notes"].list())
      static_cast<void>(note.text());
  }

  ProblemFile result;
  PoseProblem& problem = result.problem;
  problem = optimize::makeProblem(readHand(file["hand"], path.parent_path()));
  result.order = readOrder(file["dofs"], problem);
  problem.start = poseOf(readTheta(file["start"], result.order));
  problem.prior = poseOf(readTheta(file["prior"], result.order));
  readBounds(file, result.order, problem);
  const Field weights = file["weights"];
  weights.permitKeys({"distance", "normal", "prior"});
  problem.weights.distance = weights["distance"].weight();
  problem.weights.normal = weights["normal"].weight();
  problem.weights.prior = weights["prior"].weight();
  if (file.has("normal_form")) problem.normal_form = readNormalForm(file["normal_form"]);
  if (file.has("prior_weights")) {
    problem.prior_weights = readTheta(file["prior_weights"], result.order);
  }
  if (file.has("locked")) {
    problem.locked = readLocked(file["locked"], result.order, problem);
  }
  for (const Field& entry : file["correspondences"].list()) {
    problem.pairs.push_back(readPair(entry, *problem.model));
  }
  try {
    validate(problem);
  } catch (const InvalidInput& fault) {
    rejectInput("{}: {}", path.string(), fault.what());
  }
  return result;
}

PoseProblem readProblem(const std::filesystem::path& path) {
  return readProblemFile(path).problem;
}

std::string problemText(const PoseProblem& problem,
                        const std::string& urdf_path,
                        const std::vector<std::pair<std::string, std::string>>& packages,
                        const std::vector<std::string>& notes) {
  validate(problem);
  nlohmann::ordered_json file;
  file["format"] = kFormat;
  if (!notes.empty()) file["notes"] = notes;
  file["hand"]["urdf"] = urdf_path;
  file["hand"]["packages"] = json::object();
  for (const auto& [name, directory] : packages)
    file["hand"]["packages"][name] = directory;
  file["dofs"] = json::array();
  for (int dof = 0; dof < problem.dofCount(); ++dof)
    file["dofs"].push_back(dofName(problem, dof));
  file["start"] = thetaJson(thetaOf(problem.start));
  file["prior"] = thetaJson(thetaOf(problem.prior));
  file["lower"] = boundsJson(problem.root_lower, problem.lower);
  file["upper"] = boundsJson(problem.root_upper, problem.upper);
  file["weights"]["distance"] = problem.weights.distance;
  file["weights"]["normal"] = problem.weights.normal;
  file["weights"]["prior"] = problem.weights.prior;
  if (problem.normal_form == optimize::NormalForm::kSum) file["normal_form"] = kSum;
  if (problem.prior_weights.size() != 0) {
    file["prior_weights"] = thetaJson(problem.prior_weights);
  }
  if (!problem.locked.empty()) {
    file["locked"] = json::array();
    for (int dof = 0; dof < problem.dofCount(); ++dof) {
      if (problem.locked[static_cast<std::size_t>(dof)]) {
        file["locked"].push_back(dofName(problem, dof));
      }
    }
  }
  file["correspondences"] = json::array();
  for (const optimize::PointPair& pair : problem.pairs) {
    nlohmann::ordered_json entry;
    entry["link"] = problem.model->links()[static_cast<std::size_t>(pair.link)].name;
    entry["p_hand"] = vectorJson(pair.p_L);
    if (pair.has_normals) entry["n_hand"] = vectorJson(pair.n_L);
    entry["p_object"] = vectorJson(pair.p_W);
    if (pair.has_normals) entry["n_object"] = vectorJson(pair.n_W);
    if (pair.weight != 1.0) entry["weight"] = pair.weight;
    file["correspondences"].push_back(std::move(entry));
  }
  return file.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

Eigen::VectorXd thetaOf(const hand::HandPose& pose) {
  Eigen::VectorXd theta(6 + pose.q.size());
  theta << vectorFromRotation(pose.X_WH.linear()), pose.X_WH.translation(), pose.q;
  return theta;
}

}  // namespace handgraft::io
