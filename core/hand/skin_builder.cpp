#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/hand/kinematics.h"
#include "core/hand/link_surfaces.h"
#include "core/hand/skin.h"
#include "core/hand/skin_report.h"
#include "core/hand/skin_wrap.h"
#include "core/hand/tunnel_plugs.h"

namespace handgraft::hand {

namespace {

/// Every rung bridges gaps half as wide again as the one before.
constexpr double kLadderStep = 1.5;
constexpr int kLadderRungs = 6;
/// A wrap that has less of its area within epsilon of a link or sheet hides the hand: better in
/// pieces.
constexpr double kCoveringShare = 0.8;
/// Smaller pieces are loose screws and stray triangles, and are dropped.
constexpr double kPieceShare = 0.03;
/// Rounds of shutting tunnels, each on a finer grid: alpha / 2, / 4, / 6.
constexpr int kTunnelRounds = 3;
/// Remeshing to shorter edges follows a thin place better.
constexpr double kEdgeShares[] = {1.0, 0.7, 0.5};
/// Sheets that are this share of the skin's area are worth a word.
constexpr double kNotableSheets = 0.05;
/// Sizes of a hand; outside them a mesh is in other units than its file says.
constexpr double kSmallestHand = 0.01;  // m
constexpr double kLargestHand = 2.0;    // m
constexpr double kLargestAlpha = 0.05;  // m
constexpr double kMostAlphas = 600.0;   // across a hand: a wrap then takes a gigabyte

class Stopwatch {
 public:
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

double areaOf(const geometry::TriangleMesh& mesh, int f) {
  const Eigen::Vector3i face = mesh.face(f);
  return 0.5 * (mesh.vertex(face[1]) - mesh.vertex(face[0]))
                   .cross(mesh.vertex(face[2]) - mesh.vertex(face[0]))
                   .norm();
}

/// The connected pieces of a surface that are worth keeping, in the order of their vertices.
std::vector<geometry::TriangleMesh> piecesOf(const geometry::TriangleMesh& mesh) {
  const auto [component, count] = mesh.components();
  if (count == 1) return {mesh};
  std::vector<double> area(static_cast<std::size_t>(count), 0.0);
  double total = 0.0;
  const auto component_of = [&component = component, &mesh](int f) {
    return static_cast<std::size_t>(component[static_cast<std::size_t>(mesh.face(f)[0])]);
  };
  for (int f = 0; f < mesh.faceCount(); ++f) {
    area[component_of(f)] += areaOf(mesh, f);
    total += areaOf(mesh, f);
  }
  std::vector<geometry::TriangleMesh> pieces;
  for (std::size_t kept = 0; kept < area.size(); ++kept) {
    if (area[kept] < kPieceShare * total) continue;
    std::vector<int> index(static_cast<std::size_t>(mesh.vertexCount()), -1);
    Eigen::Matrix3Xd vertices(3, mesh.vertexCount());
    int vertex_count = 0;
    for (int v = 0; v < mesh.vertexCount(); ++v) {
      if (static_cast<std::size_t>(component[static_cast<std::size_t>(v)]) != kept) continue;
      vertices.col(vertex_count) = mesh.vertex(v);
      index[static_cast<std::size_t>(v)] = vertex_count++;
    }
    Eigen::Matrix3Xi faces(3, mesh.faceCount());
    int face_count = 0;
    for (int f = 0; f < mesh.faceCount(); ++f) {
      if (component_of(f) != kept) continue;
      for (int c = 0; c < 3; ++c)
        faces(c, face_count) = index[static_cast<std::size_t>(mesh.face(f)[c])];
      ++face_count;
    }
    pieces.emplace_back(vertices.leftCols(vertex_count), faces.leftCols(face_count));
  }
  return pieces;
}

int genusOf(const std::vector<geometry::TriangleMesh>& pieces) {
  int genus = 0;
  for (const geometry::TriangleMesh& piece : pieces)
    genus += 1 - piece.eulerCharacteristic() / 2;
  return genus;
}

int vertexCountOf(const std::vector<geometry::TriangleMesh>& pieces) {
  int count = 0;
  for (const geometry::TriangleMesh& piece : pieces)
    count += piece.vertexCount();
  return count;
}

/// Share of the area whose faces' middles lie within epsilon of what was wrapped.
double coveringShareOf(const std::vector<geometry::TriangleMesh>& pieces,
                       const geometry::SurfaceLocator& wrapped,
                       double epsilon_m) {
  double near = 0.0;
  double total = 0.0;
  for (const geometry::TriangleMesh& piece : pieces) {
    for (int f = 0; f < piece.faceCount(); ++f) {
      const Eigen::Vector3i face = piece.face(f);
      const double area = areaOf(piece, f);
      total += area;
      const Eigen::Vector3d middle =
          (piece.vertex(face[0]) + piece.vertex(face[1]) + piece.vertex(face[2])) / 3.0;
      if (wrapped.nearest(middle, epsilon_m)) near += area;
    }
  }
  return total > 0.0 ? near / total : 0.0;
}

void validate(const SkinOptions& options) {
  const auto check = [](double value, const char* name, double low, double high) {
    if (!(value >= low && value <= high))
      rejectInput("skin: {} {} m lies outside {} to {} m", name, value, low, high);
  };
  check(options.alpha_m, "alpha", 5e-4, kLargestAlpha);
  check(options.offset_m, "offset", 5e-5, 0.01);
  check(options.edge_m, "edge", 5e-4, 0.05);
  check(options.epsilon_m, "epsilon", 1e-4, 0.1);
}

/// A wrap of the links, as pieces, and what it was made from.
struct Wrap {
  std::vector<geometry::TriangleMesh> pieces;
  geometry::TriangleMesh triangles;  ///< the links' and those of the sheets
  double alpha_m = 0.0;
};

class Builder {
 public:
  Builder(geometry::TriangleMesh links_S,
          const SkinOptions& options,
          const Progress& progress,
          SkinReport& report)
      : triangles_S_(std::move(links_S)),
        options_(options),
        progress_(progress),
        report_(report) {}

  geometry::TriangleMesh build() {
    shutTunnelsAhead();
    locator_.emplace(triangles_S_);
    Wrap wrap = wrapInOnePiece();
    shutTunnels(wrap);
    return evenOut(wrap);
  }

 private:
  /// Reports `stage`, from `begin` on by at most `width`.
  Wrap wrapOf(const geometry::TriangleMesh& triangles,
              double alpha_m,
              SkinStep& step,
              const char* stage,
              double begin,
              double width) {
    progress_.checkpoint();
    progress_.report(stage, begin);
    const Progress wrapping(progress_, [&](std::string_view, double share) {
      progress_.report(stage, begin + share * width);
    });
    const Stopwatch watch;
    Wrap wrap;
    wrap.pieces = piecesOf(wrapped(triangles, alpha_m, options_.offset_m, wrapping));
    wrap.triangles = triangles;
    wrap.alpha_m = alpha_m;
    step.alpha_m = alpha_m;
    step.offset_m = options_.offset_m;
    step.vertices = vertexCountOf(wrap.pieces);
    step.pieces = static_cast<int>(wrap.pieces.size());
    step.genus = genusOf(wrap.pieces);
    step.covering_share = coveringShareOf(wrap.pieces, *locator_, options_.epsilon_m);
    step.time_s += watch.seconds();
    return wrap;
  }

  /// Spans sheets over the through-holes that the first wrap would have.
  void shutTunnelsAhead() {
    progress_.checkpoint();
    progress_.report("looking for through-holes", 0.05);
    const Stopwatch watch;
    const TunnelPlugs plugs = findTunnelPlugsOfWrap(triangles_S_, options_.alpha_m,
                                                    options_.offset_m, 0.5 * options_.alpha_m);
    if (plugs.sheets_S.faceCount() == 0) return;
    SkinStep step;
    step.action = "span sheets";
    step.sheets = plugs.count;
    step.sheets_area_m2 = plugs.area_m2;
    step.time_s = watch.seconds();
    step.verdict = "spanned";
    report_.steps.push_back(step);
    triangles_S_ = geometry::merged({triangles_S_, plugs.sheets_S});
    sheets_ = plugs.count;
    sheets_area_m2_ = plugs.area_m2;
  }

  /// Climbs the ladder to the first wrap of one piece: the tightest keeps the most detail. Else
  /// the tightest of those with the fewest pieces that do not hide the hand.
  Wrap wrapInOnePiece() {
    std::optional<Wrap> best;
    std::size_t best_step = 0;
    double alpha = options_.alpha_m;
    for (int rung = 0; rung < kLadderRungs; ++rung, alpha *= kLadderStep) {
      SkinStep step;
      step.action = "wrap";
      Wrap wrap = wrapOf(triangles_S_, alpha, step,
                         rung == 0 ? "wrapping the skin" : "wrapping the skin more loosely",
                         0.1 + 0.4 * rung / kLadderRungs, 0.4 / kLadderRungs);
      const bool hides = step.covering_share < kCoveringShare;
      const bool is_better = !best || (!hides && wrap.pieces.size() < best->pieces.size());
      step.verdict = verdictOn(wrap, is_better, hides);
      report_.steps.push_back(step);
      if (is_better) {
        best = std::move(wrap);
        best_step = report_.steps.size() - 1;
      }
      if (best->pieces.size() == 1 || hides) break;
    }
    HANDGRAFT_REQUIRE(best && !best->pieces.empty());
    takeBackVerdictsBut(best_step);
    if (best->pieces.size() > 1)
      report_.notes.push_back(fmt::format(
          "the links cannot be joined: the skin has {} separate pieces, and no patch reaches "
          "from one to another",
          best->pieces.size()));
    return std::move(*best);
  }

  static std::string verdictOn(const Wrap& wrap, bool is_better, bool hides) {
    std::string verdict = !is_better ? "not kept"
                          : hides    ? "kept for want of a better one"
                                     : "kept";
    if (wrap.pieces.size() > 1) verdict += ": in pieces";
    if (hides) verdict += ": hides the links";
    return verdict;
  }

  /// Wraps that were kept until a better one came were not kept in the end.
  void takeBackVerdictsBut(std::size_t best_step) {
    for (std::size_t i = 0; i < report_.steps.size(); ++i)
      if (i != best_step && report_.steps[i].verdict.starts_with("kept"))
        report_.steps[i].verdict = "not kept" + report_.steps[i].verdict.substr(4);
  }

  /// Spans sheets over the through-holes that the wrap has all the same, until none is left.
  void shutTunnels(Wrap& wrap) {
    for (int round = 0; round < kTunnelRounds && genusOf(wrap.pieces) > 0; ++round) {
      const Stopwatch watch;
      SkinStep step;
      step.action = "shut tunnels";
      std::vector<geometry::TriangleMesh> triangles{wrap.triangles};
      for (const geometry::TriangleMesh& piece : wrap.pieces) {
        if (piece.eulerCharacteristic() == 2) continue;
        const TunnelPlugs plugs = findTunnelPlugs(piece, 0.5 * wrap.alpha_m / (1 + round));
        step.sheets += plugs.count;
        step.sheets_area_m2 += plugs.area_m2;
        if (plugs.sheets_S.faceCount() > 0) triangles.push_back(plugs.sheets_S);
      }
      step.time_s = watch.seconds();
      Wrap shut = wrapOf(geometry::merged(triangles), wrap.alpha_m, step,
                         "shutting through-holes", 0.5 + 0.1 * round, 0.1);
      const bool is_better =
          shut.pieces.size() <= wrap.pieces.size() && step.genus < genusOf(wrap.pieces);
      step.verdict = is_better ? "kept" : "not kept: no fewer handles";
      report_.steps.push_back(step);
      if (!is_better) continue;
      wrap = std::move(shut);
      sheets_ += step.sheets;
      sheets_area_m2_ += step.sheets_area_m2;
    }
    if (const int genus = genusOf(wrap.pieces); genus > 0)
      report_.notes.push_back(
          fmt::format("the skin keeps {} handle{}", genus, genus == 1 ? "" : "s"));
    double area_m2 = 0.0;
    for (const geometry::TriangleMesh& piece : wrap.pieces)
      area_m2 += piece.area();
    const double share = 2.0 * sheets_area_m2_ / area_m2;
    if (share > kNotableSheets)
      report_.notes.push_back(
          fmt::format("{} sheets shut through-holes; they are about {:.0f} % of the skin",
                      sheets_, 100.0 * share));
  }

  /// Even triangles, which log maps are the better for; the wrap's own where they would cross.
  geometry::TriangleMesh evenOut(const Wrap& wrap) {
    progress_.report("evening out triangles", 0.8);
    geometry::TriangleMesh raw = geometry::merged(wrap.pieces);
    for (const double share : kEdgeShares) {
      progress_.checkpoint();
      const Stopwatch watch;
      SkinStep step;
      step.action = "even out triangles";
      step.alpha_m = wrap.alpha_m;
      step.offset_m = options_.offset_m;
      step.edge_m = share * options_.edge_m;
      geometry::TriangleMesh mesh = remeshed(raw, step.edge_m);
      step.vertices = mesh.vertexCount();
      step.pieces = mesh.components().second;
      step.genus = step.pieces - mesh.eulerCharacteristic() / 2;
      const bool is_sound = mesh.isClosed() &&
                            step.pieces == static_cast<int>(wrap.pieces.size()) &&
                            step.genus == genusOf(wrap.pieces);
      if (is_sound) step.crossing_faces = static_cast<int>(selfIntersectingFaces(mesh).size());
      step.time_s = watch.seconds();
      step.verdict = !is_sound                 ? "not kept: another topology"
                     : step.crossing_faces > 0 ? "not kept: it crosses itself"
                                               : "kept";
      report_.steps.push_back(step);
      if (is_sound && step.crossing_faces == 0) return mesh;
    }
    report_.notes.emplace_back("the skin's triangles are as the wrap left them");
    return raw;
  }

  geometry::TriangleMesh triangles_S_;  ///< what is wrapped: the links' and those of sheets
  std::optional<geometry::SurfaceLocator> locator_;  ///< of these
  int sheets_ = 0;
  double sheets_area_m2_ = 0.0;
  const SkinOptions& options_;
  const Progress& progress_;
  SkinReport& report_;
};

}  // namespace

Skin buildSkin(const HandModel& model,
               const SkinOptions& options,
               const Progress& progress,
               SkinReport* report) {
  validate(options);
  const Stopwatch watch;
  progress.report("opening the hand", 0.0);
  Eigen::VectorXd q = skinReferencePose(model);
  LinkPoses X_SL;
  forwardKinematics(model, Pose::Identity(), q, X_SL);
  LinkSurfaces links = linkSurfaces(model, X_SL, options.source);
  if (!(links.mesh_A.area() > 0.0))
    rejectInput("hand {}: none of its links has a surface", quoted(model.name()));
  const double size = links.mesh_A.diagonal();
  if (!(size >= kSmallestHand && size <= kLargestHand))
    rejectInput("hand {}: {} m across, outside {} to {} m; are its meshes in another unit?",
                quoted(model.name()), size, kSmallestHand, kLargestHand);
  if (options.alpha_m < size / kMostAlphas)
    rejectInput("skin: alpha {} m is too fine for hand {}, {} m across; permitted are {} to {}",
                options.alpha_m, quoted(model.name()), size, size / kMostAlphas, kLargestAlpha);

  SkinReport steps;
  geometry::TriangleMesh mesh =
      Builder(std::move(links.mesh_A), options, progress, steps).build();
  progress.report("relating skin and links", 0.95);
  Skin skin(model, std::move(mesh), std::move(q), options.epsilon_m, options.source);
  if (report != nullptr) {
    steps.time_s = watch.seconds();
    *report = std::move(steps);
  }
  return skin;
}

}  // namespace handgraft::hand
