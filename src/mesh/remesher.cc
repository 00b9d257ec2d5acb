#include "lsmvs/mesh/remesher.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

#include "lsmvs/mesh/half_edges.h"

namespace lsmvs {

namespace {

constexpr int kMaxFan = 64;
// Faces may turn by this cosine when an edge is collapsed.
constexpr double kMinTurnCosine = 0.9;
// Edges are worked on by blocks of so many faces that follow each other: of a mesh that is larger
// than memory, a part is needed at a time.
constexpr size_t kFacesPerBlock = 1 << 16;
// Of an edge, by which its middle may be moved to a number that a file holds.
constexpr double kMaxRoundingPart = 1e-4;

double Cotangent(const Eigen::Vector3d& at, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d u = a - at, v = b - at;
  return u.dot(v) / std::max(u.cross(v).norm(), 1e-300);
}

}  // namespace

Remesher::Remesher(const TriangleMesh& mesh, std::vector<Eigen::Vector3d> rest,
                   std::vector<float> density)
    : positions_(mesh.vertices), rest_(std::move(rest)) {
  faces_.reserve(mesh.faces.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f) {
    const Eigen::Vector3i& v = mesh.faces[f];
    faces_.push_back({{v[0], v[1], v[2]}, {kBorder, kBorder, kBorder}, density[f]});
  }
  origins_.resize(positions_.size());
  std::iota(origins_.begin(), origins_.end(), 0);
  LinkFaces(mesh);
  LockIrregularVertices();
}

void Remesher::Lock(const std::vector<int32_t>& vertices) {
  for (const int32_t v : vertices) locked_[v] = 1;
}

void Remesher::LinkFaces(const TriangleMesh& mesh) {
  locked_.assign(positions_.size(), 0);
  on_border_.assign(positions_.size(), 0);
  face_of_.assign(positions_.size(), kBorder);
  for (size_t f = 0; f < faces_.size(); ++f) {
    for (const int32_t v : faces_[f].v) face_of_[v] = static_cast<int32_t>(f);
  }
  ForEdges(SortedHalfEdges(mesh.faces, positions_.size()),
           [&](const HalfEdge* a, const HalfEdge* end) {
             const HalfEdge* b = end - 1;
             const bool opposite = faces_[a->face].v[a->corner] != faces_[b->face].v[b->corner];
             if (end - a == 2 && opposite) {
               faces_[a->face].across[a->corner] = b->face;
               faces_[b->face].across[b->corner] = a->face;
               return;
             }
             on_border_[a->low] = on_border_[a->high] = 1;
             if (end - a > 1) locked_[a->low] = locked_[a->high] = 1;
           });
}

void Remesher::LockIrregularVertices() {
  std::vector<int> counts(positions_.size(), 0);
  for (const Face& face : faces_) {
    for (const int32_t v : face.v) ++counts[v];
  }
  std::vector<int32_t> fan;
  for (size_t v = 0; v < positions_.size(); ++v) {
    if (locked_[v] || counts[v] == 0) continue;
    const int32_t vertex = static_cast<int32_t>(v);
    if (!on_border_[v]) {
      locked_[v] = !Fan(vertex, &fan) || static_cast<int>(fan.size()) != counts[v];
      continue;
    }
    // An ordinary border vertex has one border edge that leaves it; two fans have two.
    locked_[v] = 0;
  }
  std::vector<int> num_border_edges(positions_.size(), 0);
  for (const Face& face : faces_) {
    for (int k = 0; k < 3; ++k) {
      if (face.across[k] == kBorder) ++num_border_edges[face.v[k]];
    }
  }
  for (size_t v = 0; v < positions_.size(); ++v) {
    if (num_border_edges[v] > 1) locked_[v] = 1;
  }
}

int Remesher::CornerOf(int32_t face, int32_t vertex) const {
  const auto& v = faces_[face].v;
  return v[0] == vertex ? 0 : (v[1] == vertex ? 1 : 2);
}

void Remesher::SetAcross(int32_t face, int32_t start, int32_t to) {
  if (face != kBorder) faces_[face].across[CornerOf(face, start)] = to;
}

double Remesher::Area(const Face& face) const {
  const Eigen::Vector3d& a = positions_[face.v[0]];
  return 0.5 * (positions_[face.v[1]] - a).cross(positions_[face.v[2]] - a).norm();
}

double Remesher::EdgeLength(const Face& face, int edge) const {
  return (positions_[face.v[(edge + 1) % 3]] - positions_[face.v[edge]]).norm();
}

int Remesher::LongestEdge(const Face& face) const {
  int longest = 0;
  for (int k = 1; k < 3; ++k) {
    if (EdgeLength(face, k) > EdgeLength(face, longest)) longest = k;
  }
  return longest;
}

bool Remesher::IsLocked(const Face& face, int edge) const {
  const int32_t n = face.across[edge], b = face.v[(edge + 1) % 3];
  if (locked_[face.v[edge]] && locked_[b]) return true;
  if (n == kBorder) return false;
  // Two faces back to back on the same three corners: the edges from a new vertex to the third
  // corner would coincide.
  return faces_[n].v[(CornerOf(n, b) + 2) % 3] == face.v[(edge + 2) % 3];
}

template <class Work>
void Remesher::ForBlocks(const Work& work) {
  const size_t count = faces_.size();  // before any work
  for (size_t begin = 0; begin < count; begin += kFacesPerBlock) {
    work(begin, std::min(count, begin + kFacesPerBlock));
  }
}

size_t Remesher::SplitLargeFaces(double max_area, int max_passes) {
  size_t count = 0;
  for (int pass = 0; pass < max_passes; ++pass) {
    const size_t before = count;
    ForBlocks([&](size_t begin, size_t end) { count += SplitInBlock(begin, end, max_area); });
    if (count == before) break;
  }
  return count;
}

// Of the faces [begin, end), the largest first.
size_t Remesher::SplitInBlock(size_t begin, size_t end, double max_area) {
  std::vector<std::pair<double, int32_t>> large;
  for (size_t f = begin; f < end; ++f) {
    if (faces_[f].deleted) continue;
    const double area = faces_[f].density * Area(faces_[f]);
    if (area > max_area) large.emplace_back(-area, static_cast<int32_t>(f));
  }
  std::sort(large.begin(), large.end());
  size_t count = 0;
  for (const auto& [negative_area, f] : large) {
    if (faces_[f].density * Area(faces_[f]) <= max_area) continue;
    const int edge = LongestEdge(faces_[f]);
    if (IsLocked(faces_[f], edge)) continue;
    SplitEdge(f, edge);
    ++count;
  }
  return count;
}

void Remesher::SplitEdge(int32_t f, int k) {
  const int32_t a = faces_[f].v[k], b = faces_[f].v[(k + 1) % 3], c = faces_[f].v[(k + 2) % 3];
  const int32_t n = faces_[f].across[k];
  const int32_t m = static_cast<int32_t>(positions_.size());
  const auto middle = [](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
    return RoundToFile(0.5 * (p + q), kMaxRoundingPart * (p - q).norm());
  };
  positions_.push_back(middle(positions_[a], positions_[b]));
  rest_.push_back(middle(rest_[a], rest_[b]));
  origins_.push_back(origins_[a]);
  locked_.push_back(0);
  on_border_.push_back(n == kBorder);
  face_of_.push_back(f);
  const int32_t g = static_cast<int32_t>(faces_.size());
  const int32_t h = n == kBorder ? kBorder : g + 1;
  const int32_t across_bc = faces_[f].across[(k + 1) % 3];
  faces_.push_back({{m, b, c}, {h, across_bc, f}, faces_[f].density});
  SetAcross(across_bc, c, g);
  faces_[f].v[(k + 1) % 3] = m;
  faces_[f].across[(k + 1) % 3] = g;
  face_of_[b] = g;
  if (n == kBorder) return;
  const int j = CornerOf(n, b);
  const int32_t d = faces_[n].v[(j + 2) % 3];
  const int32_t across_db = faces_[n].across[(j + 2) % 3];
  faces_.push_back({{b, m, d}, {g, n, across_db}, faces_[n].density});
  SetAcross(across_db, b, h);
  faces_[n].v[j] = m;
  faces_[n].across[(j + 2) % 3] = h;
}

size_t Remesher::FlipToDelaunay(double max_deviation, int max_passes) {
  size_t count = 0;
  for (int pass = 0; pass < max_passes; ++pass) {
    const size_t before = count;
    for (size_t i = 0; i < faces_.size(); ++i) {
      const int32_t f = static_cast<int32_t>(i);
      for (int k = 0; k < 3 && !faces_[f].deleted; ++k) {
        // Each edge once.
        if (faces_[f].across[k] <= f || !WantsFlip(f, k, max_deviation)) continue;
        FlipEdge(f, k);
        ++count;
      }
    }
    if (count == before) break;
  }
  return count;
}

bool Remesher::WantsFlip(int32_t f, int k, double max_deviation) const {
  const int32_t n = faces_[f].across[k];
  const int32_t a = faces_[f].v[k], b = faces_[f].v[(k + 1) % 3];
  const int j = CornerOf(n, b);
  const int32_t c = faces_[f].v[(k + 2) % 3], d = faces_[n].v[(j + 2) % 3];
  if (c == d || locked_[a] || locked_[b] || locked_[c] || locked_[d]) return false;
  const Eigen::Vector3d &pa = positions_[a], &pb = positions_[b], &pc = positions_[c],
                        &pd = positions_[d];
  // The sum of the angles opposite of the edge exceeds 180 degrees.
  if (Cotangent(pc, pa, pb) + Cotangent(pd, pb, pa) >= -1e-9) return false;
  const Eigen::Vector3d across = (pb - pa).cross(pd - pc);
  const double height = std::abs((pc - pa).dot(across)) / std::max(across.norm(), 1e-300);
  const double density = std::sqrt(std::min(faces_[f].density, faces_[n].density));
  if (density == 0 ? height > 1e-9 * (pb - pa).norm() : height * density > max_deviation) {
    return false;
  }
  const Eigen::Vector3d old_f = (pb - pa).cross(pc - pa), old_n = (pa - pb).cross(pd - pb);
  const Eigen::Vector3d new_f = (pd - pa).cross(pc - pa), new_n = (pb - pd).cross(pc - pd);
  const Eigen::Vector3d mean = old_f + old_n;
  if (new_f.dot(mean) <= 0.5 * new_f.norm() * mean.norm()) return false;
  if (new_n.dot(mean) <= 0.5 * new_n.norm() * mean.norm()) return false;
  std::vector<int32_t> fan;
  for (const int32_t end : {a, b}) {
    if (!Fan(end, &fan) || fan.size() < 4) return false;
  }
  if (!Fan(c, &fan)) return false;
  for (const int32_t face : fan) {
    const auto& v = faces_[face].v;
    if (v[0] == d || v[1] == d || v[2] == d) return false;
  }
  return true;
}

Remesher::EdgeSides Remesher::SidesOf(int32_t f, int k) const {
  const int32_t n = faces_[f].across[k];
  const auto &v = faces_[f].v, &w = faces_[n].v;
  const int j = CornerOf(n, v[(k + 1) % 3]);
  return {n,
          v[k],
          v[(k + 1) % 3],
          v[(k + 2) % 3],
          w[(j + 2) % 3],
          faces_[f].across[(k + 1) % 3],
          faces_[f].across[(k + 2) % 3],
          faces_[n].across[(j + 1) % 3],
          faces_[n].across[(j + 2) % 3]};
}

void Remesher::FlipEdge(int32_t f, int k) {
  const auto [n, a, b, c, d, across_bc, across_ca, across_ad, across_db] = SidesOf(f, k);
  const float density = std::min(faces_[f].density, faces_[n].density);
  faces_[f] = {{a, d, c}, {across_ad, n, across_ca}, density};
  faces_[n] = {{d, b, c}, {across_db, across_bc, f}, density};
  SetAcross(across_ad, d, f);
  SetAcross(across_bc, c, n);
  face_of_[a] = face_of_[c] = face_of_[d] = f;
  face_of_[b] = n;
}

bool Remesher::Fan(int32_t vertex, std::vector<int32_t>* faces) const {
  faces->clear();
  const int32_t first = face_of_[vertex];
  if (first == kBorder || locked_[vertex] || on_border_[vertex]) return false;
  for (int32_t face = first; static_cast<int>(faces->size()) < kMaxFan;) {
    faces->push_back(face);
    face = faces_[face].across[(CornerOf(face, vertex) + 2) % 3];
    if (face == kBorder) return false;
    if (face == first) return true;
  }
  return false;
}

size_t Remesher::CollapseShortEdges(double min_length, double max_deviation) {
  size_t count = 0;
  ForBlocks([&](size_t begin, size_t end) {
    count += CollapseInBlock(begin, end, min_length, max_deviation);
  });
  return count;
}

// Of the faces [begin, end), the shortest first.
size_t Remesher::CollapseInBlock(size_t begin, size_t end, double min_length,
                                 double max_deviation) {
  std::vector<std::tuple<double, int32_t, int>> edges;
  for (size_t f = begin; f < end; ++f) {
    const Face& face = faces_[f];
    for (int k = 0; k < 3 && !face.deleted && face.density > 0; ++k) {
      const double length = EdgeLength(face, k) * std::sqrt(face.density);
      if (length < min_length) edges.emplace_back(length, static_cast<int32_t>(f), k);
    }
  }
  std::sort(edges.begin(), edges.end());
  size_t count = 0;
  for (const auto& [length, f, k] : edges) {
    if (!MayCollapse(f, k, min_length, max_deviation)) continue;
    CollapseEdge(f, k);
    ++count;
  }
  return count;
}

// Whether v[k + 1] of the face may move onto v[k]; fills fan_b_ with the faces around it.
bool Remesher::MayCollapse(int32_t f, int k, double min_length, double max_deviation) {
  const Face& face = faces_[f];
  if (face.deleted || face.across[k] == kBorder) return false;
  const int32_t n = face.across[k];
  const double scale = std::sqrt(std::min(face.density, faces_[n].density));
  if (scale == 0 || EdgeLength(face, k) * scale >= min_length) return false;
  const int32_t a = face.v[k], b = face.v[(k + 1) % 3], c = face.v[(k + 2) % 3];
  const int32_t d = faces_[n].v[(CornerOf(n, b) + 2) % 3];
  for (const int32_t side : {c, d}) {
    if (!Fan(side, &fan_a_) || fan_a_.size() < 4) return false;
  }
  if (!Fan(a, &fan_a_) || !Fan(b, &fan_b_)) return false;
  // The only common neighbours are c and d.
  int num_common = 0;
  for (const int32_t face_a : fan_a_) {
    const int32_t u = faces_[face_a].v[(CornerOf(face_a, a) + 1) % 3];
    for (const int32_t face_b : fan_b_) {
      num_common += faces_[face_b].v[(CornerOf(face_b, b) + 1) % 3] == u;
    }
  }
  if (num_common != 2) return false;
  return KeepsShape(b, a, positions_[a], fan_b_, 2 * min_length / scale, max_deviation / scale);
}

// Whether moving a vertex onto `other` changes the faces around it little.
bool Remesher::KeepsShape(int32_t moved, int32_t other, const Eigen::Vector3d& to,
                          const std::vector<int32_t>& fan, double max_length,
                          double max_deviation) const {
  for (const int32_t f : fan) {
    const int corner = CornerOf(f, moved);
    const int32_t u = faces_[f].v[(corner + 1) % 3], w = faces_[f].v[(corner + 2) % 3];
    if (u == other || w == other) continue;
    const Eigen::Vector3d &pu = positions_[u], &pw = positions_[w];
    if ((pu - to).norm() > max_length) return false;
    const Eigen::Vector3d before = (pu - positions_[moved]).cross(pw - positions_[moved]);
    const Eigen::Vector3d after = (pu - to).cross(pw - to);
    if (!(after.dot(before) > kMinTurnCosine * after.norm() * before.norm())) return false;
    if (std::abs(after.dot(positions_[moved] - to)) > max_deviation * after.norm()) return false;
  }
  return true;
}

void Remesher::CollapseEdge(int32_t f, int k) {
  const auto [n, a, b, c, d, across_bc, across_ca, across_ad, across_db] = SidesOf(f, k);
  for (const int32_t face : fan_b_) faces_[face].v[CornerOf(face, b)] = a;
  faces_[f].deleted = faces_[n].deleted = true;
  SetAcross(across_bc, c, across_ca);
  SetAcross(across_ca, a, across_bc);
  SetAcross(across_ad, d, across_db);
  SetAcross(across_db, a, across_ad);
  face_of_[a] = face_of_[c] = across_bc;
  face_of_[d] = across_db;
  face_of_[b] = kBorder;
}

std::vector<uint8_t> Remesher::UsedVertices() const {
  std::vector<uint8_t> used(positions_.size(), 0);
  for (const Face& face : faces_) {
    for (const int32_t v : face.v) used[v] |= !face.deleted;
  }
  return used;
}

TriangleMesh Remesher::Mesh() const {
  TriangleMesh mesh;
  const std::vector<uint8_t> used = UsedVertices();
  std::vector<int32_t> index(positions_.size(), -1);
  for (size_t v = 0; v < index.size(); ++v) {
    if (!used[v]) continue;
    index[v] = static_cast<int32_t>(mesh.vertices.size());
    mesh.vertices.push_back(positions_[v]);
  }
  for (const Face& face : faces_) {
    if (!face.deleted) mesh.faces.push_back({index[face.v[0]], index[face.v[1]], index[face.v[2]]});
  }
  return mesh;
}

std::vector<Eigen::Vector3d> Remesher::Rest() const {
  const std::vector<uint8_t> used = UsedVertices();
  std::vector<Eigen::Vector3d> rest;
  for (size_t v = 0; v < used.size(); ++v) {
    if (used[v]) rest.push_back(rest_[v]);
  }
  return rest;
}

std::vector<int32_t> Remesher::Origins() const {
  const std::vector<uint8_t> used = UsedVertices();
  std::vector<int32_t> origins;
  for (size_t v = 0; v < used.size(); ++v) {
    if (used[v]) origins.push_back(origins_[v]);
  }
  return origins;
}

}  // namespace lsmvs
