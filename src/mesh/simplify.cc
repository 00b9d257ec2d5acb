#include "lsmvs/mesh/simplify.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <queue>
#include <unordered_map>

#include "lsmvs/util/check.h"

namespace lsmvs {

namespace {

constexpr size_t kThinningFactor = 16;
constexpr double kBorderWeight = 20;
constexpr double kMinFlatness = 1e-3;     // twice the area of a face over its longest edge squared
constexpr double kMinNormalCosine = 0.2;  // between a face's normals before and after a collapse

// x^T A x + 2 b^T x + c: the weighted sum of squared distances to planes.
struct Quadric {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double c = 0;

  void AddPlane(const Eigen::Vector3d& normal, const Eigen::Vector3d& x, double weight) {
    const double offset = -normal.dot(x);
    a += weight * normal * normal.transpose();
    b += weight * offset * normal;
    c += weight * offset * offset;
  }
  Quadric& operator+=(const Quadric& other) {
    a += other.a;
    b += other.b;
    c += other.c;
    return *this;
  }
  double At(const Eigen::Vector3d& x) const {
    return std::max(0.0, x.dot(a * x) + 2 * b.dot(x) + c);
  }
};

bool IsProper(const TriangleMesh& mesh, const Eigen::Vector3i& face) {
  if (face[0] == face[1] || face[1] == face[2] || face[2] == face[0]) return false;
  for (int k = 0; k < 3; ++k) {
    if (!mesh.vertices[face[k]].allFinite()) return false;
  }
  return true;
}

// Vertices, faces and where the vertices come from; what both steps work on.
struct Surface {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> faces;
  std::vector<int> source;
};

Surface ProperPart(const TriangleMesh& mesh) {
  Surface surface;
  std::vector<int> new_index(mesh.vertices.size(), -1);
  for (const Eigen::Vector3i& face : mesh.faces) {
    if (!IsProper(mesh, face)) continue;
    Eigen::Vector3i renamed;
    for (int k = 0; k < 3; ++k) {
      int& index = new_index[face[k]];
      if (index < 0) {
        index = static_cast<int>(surface.vertices.size());
        surface.vertices.push_back(mesh.vertices[face[k]]);
        surface.source.push_back(face[k]);
      }
      renamed[k] = index;
    }
    surface.faces.push_back(renamed);
  }
  return surface;
}

double Area(const Surface& surface) {
  double sum = 0;
  for (const Eigen::Vector3i& f : surface.faces) {
    const Eigen::Vector3d& a = surface.vertices[f[0]];
    sum += 0.5 * (surface.vertices[f[1]] - a).cross(surface.vertices[f[2]] - a).norm();
  }
  return sum;
}

struct CellHash {
  size_t operator()(const Eigen::Vector3i& c) const {
    return static_cast<size_t>(c.x()) * 73856093u ^ static_cast<size_t>(c.y()) * 19349663u ^
           static_cast<size_t>(c.z()) * 83492791u;
  }
};

// One vertex a cell of a grid: the one that is nearest to the cell's mean.
Surface ThinOnGrid(const Surface& surface, double cell_size) {
  std::unordered_map<Eigen::Vector3i, int, CellHash> cells;
  std::vector<int> cell_of(surface.vertices.size());
  std::vector<Eigen::Vector3d> sums;
  std::vector<int> counts;
  for (size_t v = 0; v < surface.vertices.size(); ++v) {
    const Eigen::Vector3d place = (surface.vertices[v] - surface.vertices[0]) / cell_size;
    const Eigen::Vector3i key =
        place.cwiseMax(-1e9).cwiseMin(1e9).array().floor().matrix().cast<int>();
    const auto [entry, is_new] = cells.try_emplace(key, static_cast<int>(sums.size()));
    if (is_new) {
      sums.emplace_back(Eigen::Vector3d::Zero());
      counts.push_back(0);
    }
    cell_of[v] = entry->second;
    sums[cell_of[v]] += surface.vertices[v];
    ++counts[cell_of[v]];
  }
  std::vector<int> chosen(sums.size(), -1);
  std::vector<double> chosen_distance(sums.size());
  for (size_t v = 0; v < surface.vertices.size(); ++v) {
    const int cell = cell_of[v];
    const double distance = (surface.vertices[v] - sums[cell] / counts[cell]).squaredNorm();
    if (chosen[cell] >= 0 && distance >= chosen_distance[cell]) continue;
    chosen[cell] = static_cast<int>(v);
    chosen_distance[cell] = distance;
  }
  Surface thin;
  for (const int v : chosen) {
    thin.vertices.push_back(surface.vertices[v]);
    thin.source.push_back(surface.source[v]);
  }
  for (const Eigen::Vector3i& f : surface.faces) {
    Eigen::Vector3i renamed(cell_of[f[0]], cell_of[f[1]], cell_of[f[2]]);
    if (renamed[0] == renamed[1] || renamed[1] == renamed[2] || renamed[2] == renamed[0]) continue;
    while (renamed[0] > renamed[1] || renamed[0] > renamed[2]) {
      renamed = Eigen::Vector3i(renamed[1], renamed[2], renamed[0]);
    }
    thin.faces.push_back(renamed);
  }
  const auto key = [](const Eigen::Vector3i& f) { return std::tuple(f[0], f[1], f[2]); };
  std::sort(thin.faces.begin(), thin.faces.end(),
            [&](const auto& a, const auto& b) { return key(a) < key(b); });
  thin.faces.erase(std::unique(thin.faces.begin(), thin.faces.end()), thin.faces.end());
  return thin;
}

class Collapser {
 public:
  explicit Collapser(Surface* surface)
      : s_(*surface),
        quadrics_(s_.vertices.size()),
        faces_of_(s_.vertices.size()),
        stamps_(s_.vertices.size(), 0),
        alive_(s_.faces.size(), 1),
        num_faces_(s_.faces.size()) {
    for (size_t f = 0; f < s_.faces.size(); ++f) AddFace(static_cast<int>(f));
    for (size_t v = 0; v < s_.vertices.size(); ++v) HoldBorders(static_cast<int>(v));
    for (size_t v = 0; v < s_.vertices.size(); ++v) PushEdges(static_cast<int>(v), true);
  }

  void Run(size_t max_faces, const RunContext& context) {
    const size_t begin = num_faces_;
    size_t steps = 0;
    while (num_faces_ > max_faces && !queue_.empty()) {
      if (++steps % 65536 == 0) {
        context.ThrowIfCancelled();
        context.Report(static_cast<double>(begin - num_faces_) /
                       static_cast<double>(begin - max_faces));
      }
      const Edge edge = queue_.top();
      queue_.pop();
      if (stamps_[edge.a] != edge.stamp_a || stamps_[edge.b] != edge.stamp_b) continue;
      if (MayCollapse(edge)) Collapse(edge);
    }
  }

  // Faces that are left.
  std::vector<Eigen::Vector3i> Faces() const {
    std::vector<Eigen::Vector3i> faces;
    for (size_t f = 0; f < alive_.size(); ++f) {
      if (alive_[f]) faces.push_back(s_.faces[f]);
    }
    return faces;
  }

 private:
  struct Edge {
    double cost;
    int a, b;
    int stamp_a, stamp_b;
    Eigen::Vector3f shift;                     // from the middle of the edge to the new vertex
    bool operator<(const Edge& other) const {  // the cheapest comes first; ties by position
      if (cost != other.cost) return cost > other.cost;
      return a != other.a ? a > other.a : b > other.b;
    }
  };

  Eigen::Vector3d NormalTimesTwiceArea(const Eigen::Vector3i& f) const {
    const Eigen::Vector3d& a = s_.vertices[f[0]];
    return (s_.vertices[f[1]] - a).cross(s_.vertices[f[2]] - a);
  }

  void AddFace(int f) {
    const Eigen::Vector3i& face = s_.faces[f];
    const Eigen::Vector3d normal = NormalTimesTwiceArea(face);
    const double length = normal.norm();
    for (int k = 0; k < 3; ++k) {
      faces_of_[face[k]].push_back(f);
      if (length > 0) {
        quadrics_[face[k]].AddPlane(normal / length, s_.vertices[face[k]], length);
      }
    }
  }

  // Adds planes across the border edges from `v` to vertices behind it, to both ends.
  void HoldBorders(int v) {
    for (const int f : faces_of_[v]) {
      const Eigen::Vector3i face = s_.faces[f];
      for (int k = 0; k < 3; ++k) {
        const int a = face[k], b = face[(k + 1) % 3];
        if (std::min(a, b) != v || CountShared(a, b) != 1) continue;
        const Eigen::Vector3d along = s_.vertices[b] - s_.vertices[a];
        const Eigen::Vector3d across = along.cross(NormalTimesTwiceArea(face));
        if (across.norm() == 0) continue;
        for (const int end : {a, b}) {
          quadrics_[end].AddPlane(across.normalized(), s_.vertices[a],
                                  kBorderWeight * along.squaredNorm());
        }
      }
    }
  }

  int CountShared(int a, int b) const {
    int count = 0;
    for (const int f : faces_of_[a]) count += (s_.faces[f].array() == b).any();
    return count;
  }

  void Neighbors(int v, std::vector<int>* neighbors) const {
    neighbors->clear();
    for (const int f : faces_of_[v]) {
      for (int k = 0; k < 3; ++k) {
        if (s_.faces[f][k] != v) neighbors->push_back(s_.faces[f][k]);
      }
    }
    std::sort(neighbors->begin(), neighbors->end());
    neighbors->erase(std::unique(neighbors->begin(), neighbors->end()), neighbors->end());
  }

  void PushEdges(int v, bool only_larger) {
    Neighbors(v, &scratch_a_);
    for (const int other : scratch_a_) {
      if (!only_larger || other > v) queue_.push(MakeEdge(std::min(v, other), std::max(v, other)));
    }
  }

  Edge MakeEdge(int a, int b) const {
    Quadric sum = quadrics_[a];
    sum += quadrics_[b];
    const Eigen::Vector3d &xa = s_.vertices[a], &xb = s_.vertices[b];
    const Eigen::Vector3d middle = 0.5 * (xa + xb);
    const double length = (xb - xa).norm();
    // A little of "stay in the middle" makes flat regions well-posed and even.
    const double weight = 1e-7 * sum.a.trace() + 1e-300;
    Eigen::Matrix3d system = sum.a + weight * Eigen::Matrix3d::Identity();
    Eigen::Vector3d best = system.ldlt().solve(weight * middle - sum.b);
    if (!best.allFinite() || (best - middle).norm() > 2 * length) best = middle;
    double cost = sum.At(best);
    for (const Eigen::Vector3d& candidate : {xa, xb, middle}) {
      if (sum.At(candidate) >= cost) continue;
      cost = sum.At(candidate);
      best = candidate;
    }
    // Among edges that cost nothing, short ones first.
    cost += 1e-9 * sum.a.trace() * length * length;
    return {cost, a, b, stamps_[a], stamps_[b], (best - middle).cast<float>()};
  }

  Eigen::Vector3d Place(const Edge& edge) const {
    return 0.5 * (s_.vertices[edge.a] + s_.vertices[edge.b]) + edge.shift.cast<double>();
  }

  bool MayCollapse(const Edge& edge) {
    const int num_shared = CountShared(edge.a, edge.b);
    if (num_shared == 0) return false;
    Neighbors(edge.a, &scratch_a_);
    Neighbors(edge.b, &scratch_b_);
    scratch_both_.clear();
    std::set_intersection(scratch_a_.begin(), scratch_a_.end(), scratch_b_.begin(),
                          scratch_b_.end(), std::back_inserter(scratch_both_));
    if (static_cast<int>(scratch_both_.size()) != num_shared) return false;
    // An inner edge between two border vertices: collapsing it would pinch the surface there.
    const bool both_on_border = scratch_a_.size() != faces_of_[edge.a].size() &&
                                scratch_b_.size() != faces_of_[edge.b].size();
    if (both_on_border && num_shared != 1) return false;
    const Eigen::Vector3d place = Place(edge);
    return !TurnsOver(edge.a, edge.b, place) && !TurnsOver(edge.b, edge.a, place);
  }

  // Whether moving `v` to `place` turns or flattens a face that survives the collapse with `other`.
  bool TurnsOver(int v, int other, const Eigen::Vector3d& place) const {
    for (const int f : faces_of_[v]) {
      const Eigen::Vector3i& face = s_.faces[f];
      if ((face.array() == other).any()) continue;
      const int k = face[0] == v ? 0 : face[1] == v ? 1 : 2;
      const Eigen::Vector3d &next = s_.vertices[face[(k + 1) % 3]],
                            &last = s_.vertices[face[(k + 2) % 3]];
      const Eigen::Vector3d before = (next - s_.vertices[v]).cross(last - s_.vertices[v]);
      const Eigen::Vector3d after = (next - place).cross(last - place);
      const double longest = std::max((next - place).squaredNorm(), (last - place).squaredNorm());
      if (after.norm() < kMinFlatness * longest) return true;
      if (before.dot(after) < kMinNormalCosine * before.norm() * after.norm()) return true;
    }
    return false;
  }

  void Collapse(const Edge& edge) {
    const int a = edge.a, b = edge.b;
    const Eigen::Vector3d place = Place(edge);
    if ((s_.vertices[b] - place).squaredNorm() < (s_.vertices[a] - place).squaredNorm()) {
      s_.source[a] = s_.source[b];
    }
    s_.vertices[a] = place;
    quadrics_[a] += quadrics_[b];
    for (const int f : faces_of_[b]) {
      Eigen::Vector3i& face = s_.faces[f];
      if ((face.array() == a).any()) {
        Remove(f, b);
        continue;
      }
      for (int k = 0; k < 3; ++k) {
        if (face[k] == b) face[k] = a;
      }
      faces_of_[a].push_back(f);
    }
    faces_of_[b] = {};
    ++stamps_[a];
    ++stamps_[b];
    PushEdges(a, false);
  }

  // Removes a face from all its vertices but `except`.
  void Remove(int f, int except) {
    alive_[f] = 0;
    --num_faces_;
    for (int k = 0; k < 3; ++k) {
      const int v = s_.faces[f][k];
      if (v != except) std::erase(faces_of_[v], f);
    }
  }

  Surface& s_;
  std::vector<Quadric> quadrics_;
  std::vector<std::vector<int>> faces_of_;
  std::vector<int> stamps_;
  std::vector<char> alive_;
  size_t num_faces_;
  std::priority_queue<Edge> queue_;
  std::vector<int> scratch_a_, scratch_b_, scratch_both_;
};

SimplifiedMesh Finish(const TriangleMesh& input, const Surface& surface) {
  SimplifiedMesh result;
  std::vector<int> new_index(surface.vertices.size(), -1);
  for (const Eigen::Vector3i& face : surface.faces) {
    Eigen::Vector3i renamed;
    for (int k = 0; k < 3; ++k) {
      int& index = new_index[face[k]];
      if (index < 0) {
        index = static_cast<int>(result.mesh.vertices.size());
        result.mesh.vertices.push_back(surface.vertices[face[k]]);
        result.source_vertex.push_back(surface.source[face[k]]);
      }
      renamed[k] = index;
    }
    result.mesh.faces.push_back(renamed);
  }
  if (!input.vertex_colors.empty()) {
    for (const int v : result.source_vertex) {
      result.mesh.vertex_colors.push_back(input.vertex_colors[v]);
    }
  }
  return result;
}

}  // namespace

SimplifiedMesh SimplifyMesh(const TriangleMesh& mesh, size_t max_faces, const RunContext& context) {
  LSMVS_CHECK_GE(max_faces, size_t{4});
  Surface surface = ProperPart(mesh);
  // Quadrics lose digits far from the origin.
  const Eigen::Vector3d origin =
      surface.vertices.empty() ? Eigen::Vector3d::Zero() : surface.vertices[0];
  for (Eigen::Vector3d& x : surface.vertices) x -= origin;
  double cell = std::sqrt(2 * Area(surface) / static_cast<double>(kThinningFactor * max_faces));
  for (; surface.faces.size() > kThinningFactor * max_faces && cell > 0; cell *= 1.3) {
    Surface thin = ThinOnGrid(surface, cell);
    if (thin.faces.size() < max_faces) break;
    surface = std::move(thin);
  }
  if (surface.faces.size() > max_faces) {
    Collapser collapser(&surface);
    collapser.Run(max_faces, context);
    surface.faces = collapser.Faces();
  }
  SimplifiedMesh result = Finish(mesh, surface);
  for (Eigen::Vector3d& x : result.mesh.vertices) x += origin;
  return result;
}

}  // namespace lsmvs
