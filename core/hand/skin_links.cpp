#include "core/hand/skin_links.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include "core/base/error.h"

namespace handgraft::hand {

namespace {

constexpr int kRounds = 10;
/// What a neighbour of another link counts, against the distance to a link.
constexpr double kDisagreement = 0.0003;  // m
/// A piece of a link's area that is smaller than both, and not its largest, is a splinter.
constexpr double kSplinter = 50e-6;  // m^2
constexpr double kSplinterShare = 0.1;

struct Choice {
  int link;
  double cost_m;
};

double areaOf(const geometry::TriangleMesh& mesh, int f) {
  const Eigen::Vector3i face = mesh.face(f);
  return 0.5 * (mesh.vertex(face[1]) - mesh.vertex(face[0]))
                   .cross(mesh.vertex(face[2]) - mesh.vertex(face[0]))
                   .norm();
}

/// The links within reach of each face's middle, and how well each suits it.
std::vector<std::vector<Choice>> choicesOf(const geometry::TriangleMesh& skin_S,
                                           const LinkLocators& links,
                                           double epsilon_m) {
  std::vector<std::vector<Choice>> choices(static_cast<std::size_t>(skin_S.faceCount()));
  for (int f = 0; f < skin_S.faceCount(); ++f) {
    const Eigen::Vector3i face = skin_S.face(f);
    const Eigen::Vector3d middle =
        (skin_S.vertex(face[0]) + skin_S.vertex(face[1]) + skin_S.vertex(face[2])) / 3.0;
    for (const LinkLocators::Hit& hit : links.within(middle, epsilon_m)) {
      choices[static_cast<std::size_t>(f)].push_back(
          {hit.link, misfit(hit, middle, skin_S.faceNormals().col(f))});
    }
  }
  return choices;
}

std::array<int, 3> neighboursOf(const geometry::TriangleMesh& mesh, int f) {
  std::array<int, 3> neighbours{};
  for (int c = 0; c < 3; ++c) {
    const int twin = mesh.twin(3 * f + c);
    neighbours[static_cast<std::size_t>(c)] =
        twin < 0 ? -1 : geometry::TriangleMesh::faceOf(twin);
  }
  return neighbours;
}

/// The link that suits a face best, of whose neighbours the labels are known.
int bestAmong(const std::vector<Choice>& options,
              const std::array<int, 3>& neighbours,
              const std::vector<int>& labels) {
  int best = -1;
  double best_cost = std::numeric_limits<double>::infinity();
  for (const Choice& choice : options) {
    double cost = choice.cost_m;
    for (const int other : neighbours)
      if (other >= 0 && labels[static_cast<std::size_t>(other)] != choice.link)
        cost += kDisagreement;
    if (cost < best_cost) {
      best_cost = cost;
      best = choice.link;
    }
  }
  return best;
}

/// Faces change to the link that suits them and their neighbours best, until none does.
void agree(const geometry::TriangleMesh& skin_S,
           const std::vector<std::vector<Choice>>& choices,
           std::vector<int>& labels) {
  bool has_changed = true;
  for (int round = 0; round < kRounds && has_changed; ++round) {
    has_changed = false;
    for (int f = 0; f < skin_S.faceCount(); ++f) {
      const auto& options = choices[static_cast<std::size_t>(f)];
      if (options.size() < 2) continue;
      const int best = bestAmong(options, neighboursOf(skin_S, f), labels);
      if (best == labels[static_cast<std::size_t>(f)]) continue;
      labels[static_cast<std::size_t>(f)] = best;
      has_changed = true;
    }
  }
}

struct Piece {
  int link = -1;
  double area_m2 = 0.0;
  std::vector<int> faces;
};

std::vector<Piece> piecesOf(const geometry::TriangleMesh& skin_S,
                            const std::vector<int>& labels) {
  std::vector<Piece> pieces;
  std::vector<bool> is_seen(labels.size(), false);
  for (int start = 0; start < skin_S.faceCount(); ++start) {
    if (is_seen[static_cast<std::size_t>(start)]) continue;
    Piece piece;
    piece.link = labels[static_cast<std::size_t>(start)];
    piece.faces.push_back(start);
    is_seen[static_cast<std::size_t>(start)] = true;
    for (std::size_t i = 0; i < piece.faces.size(); ++i) {
      piece.area_m2 += areaOf(skin_S, piece.faces[i]);
      for (const int other : neighboursOf(skin_S, piece.faces[i])) {
        if (other < 0 || is_seen[static_cast<std::size_t>(other)] ||
            labels[static_cast<std::size_t>(other)] != piece.link)
          continue;
        is_seen[static_cast<std::size_t>(other)] = true;
        piece.faces.push_back(other);
      }
    }
    pieces.push_back(std::move(piece));
  }
  return pieces;
}

/// The link that most of a piece's rim has, or -1.
int linkAround(const geometry::TriangleMesh& skin_S,
               const Piece& piece,
               const std::vector<int>& labels) {
  std::map<int, int> rim;
  for (const int f : piece.faces)
    for (const int other : neighboursOf(skin_S, f))
      if (other >= 0 && labels[static_cast<std::size_t>(other)] != piece.link)
        ++rim[labels[static_cast<std::size_t>(other)]];
  int around = -1;
  for (const auto& [link, count] : rim)
    if (link >= 0 && (around < 0 || count > rim[around])) around = link;
  return around;
}

/// Gives splinters to the link that most of their rim has, where that is within reach.
void absorbSplinters(const geometry::TriangleMesh& skin_S,
                     const std::vector<std::vector<Choice>>& choices,
                     std::vector<int>& labels) {
  const std::vector<Piece> pieces = piecesOf(skin_S, labels);
  std::map<int, double> largest;
  for (const Piece& piece : pieces)
    largest[piece.link] = std::max(largest[piece.link], piece.area_m2);
  for (const Piece& piece : pieces) {
    if (piece.link < 0 || piece.area_m2 >= kSplinter ||
        piece.area_m2 >= kSplinterShare * largest[piece.link])
      continue;
    const int around = linkAround(skin_S, piece, labels);
    if (around < 0) continue;
    for (const int f : piece.faces) {
      const auto& options = choices[static_cast<std::size_t>(f)];
      if (std::any_of(options.begin(), options.end(), [&](const Choice& choice) {
            return choice.link == around;
          }))
        labels[static_cast<std::size_t>(f)] = around;
    }
  }
}

}  // namespace

LinkLocators::LinkLocators(const LinkSurfaces& surfaces_S, int link_count)
    : boxes_S_(static_cast<std::size_t>(link_count)),
      locators_(static_cast<std::size_t>(link_count)) {
  const geometry::TriangleMesh& all = surfaces_S.mesh_A;
  std::vector<std::vector<int>> faces_of(static_cast<std::size_t>(link_count));
  for (int f = 0; f < all.faceCount(); ++f)
    faces_of[static_cast<std::size_t>(surfaces_S.face_links[static_cast<std::size_t>(f)])]
        .push_back(f);
  std::vector<int> index(static_cast<std::size_t>(all.vertexCount()), -1);
  for (std::size_t link = 0; link < faces_of.size(); ++link) {
    if (faces_of[link].empty()) continue;
    std::vector<int> used;
    Eigen::Matrix3Xi faces(3, static_cast<Eigen::Index>(faces_of[link].size()));
    for (std::size_t i = 0; i < faces_of[link].size(); ++i) {
      const Eigen::Vector3i face = all.face(faces_of[link][i]);
      for (int c = 0; c < 3; ++c) {
        int& vertex = index[static_cast<std::size_t>(face[c])];
        if (vertex < 0) {
          vertex = static_cast<int>(used.size());
          used.push_back(face[c]);
        }
        faces(c, static_cast<Eigen::Index>(i)) = vertex;
      }
    }
    Eigen::Matrix3Xd vertices(3, static_cast<Eigen::Index>(used.size()));
    for (std::size_t i = 0; i < used.size(); ++i) {
      vertices.col(static_cast<Eigen::Index>(i)) = all.vertex(used[i]);
      boxes_S_[link].extend(all.vertex(used[i]));
      index[static_cast<std::size_t>(used[i])] = -1;
    }
    locators_[link] = std::make_unique<geometry::SurfaceLocator>(
        geometry::TriangleMesh(std::move(vertices), std::move(faces)));
  }
}

const geometry::TriangleMesh* LinkLocators::surfaceOf(int link) const {
  const auto i = static_cast<std::size_t>(link);
  HANDGRAFT_REQUIRE(i < locators_.size());
  return locators_[i] ? &locators_[i]->mesh() : nullptr;
}

std::optional<LinkLocators::Hit> LinkLocators::nearestOf(int link,
                                                         const Eigen::Vector3d& p_S,
                                                         double reach_m) const {
  const auto i = static_cast<std::size_t>(link);
  HANDGRAFT_REQUIRE(i < locators_.size());
  if (!locators_[i] || !(boxes_S_[i].exteriorDistance(p_S) <= reach_m)) return std::nullopt;
  const auto hit = locators_[i]->nearest(p_S, reach_m);
  if (!hit) return std::nullopt;
  return Hit{link, hit->position, locators_[i]->mesh().faceNormals().col(hit->point.face),
             hit->distance};
}

std::optional<LinkLocators::Hit> LinkLocators::nearest(const Eigen::Vector3d& p_S,
                                                       double reach_m) const {
  std::optional<Hit> best;
  for (int link = 0; link < static_cast<int>(locators_.size()); ++link) {
    const auto hit = nearestOf(link, p_S, best ? best->distance_m : reach_m);
    if (hit && (!best || hit->distance_m < best->distance_m)) best = hit;
  }
  return best;
}

std::vector<LinkLocators::Hit> LinkLocators::within(const Eigen::Vector3d& p_S,
                                                    double reach_m) const {
  std::vector<Hit> hits;
  for (int link = 0; link < static_cast<int>(locators_.size()); ++link)
    if (const auto hit = nearestOf(link, p_S, reach_m)) hits.push_back(*hit);
  return hits;
}

double misfit(const LinkLocators::Hit& hit,
              const Eigen::Vector3d& p_S,
              const Eigen::Vector3d& n_S) {
  return 1.5 * hit.distance_m - 0.5 * (p_S - hit.position_S).dot(n_S);
}

std::vector<int> linksOfFaces(const geometry::TriangleMesh& skin_S,
                              const LinkLocators& links,
                              double epsilon_m) {
  const auto choices = choicesOf(skin_S, links, epsilon_m);
  std::vector<int> labels(choices.size(), -1);
  for (std::size_t f = 0; f < choices.size(); ++f) {
    const auto best = std::min_element(choices[f].begin(), choices[f].end(),
                                       [](const Choice& a, const Choice& b) {
                                         return a.cost_m < b.cost_m;
                                       });
    if (best != choices[f].end()) labels[f] = best->link;
  }
  agree(skin_S, choices, labels);
  absorbSplinters(skin_S, choices, labels);
  return labels;
}

}  // namespace handgraft::hand
