#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

#include "lsmvs/mesh/simplification/edge_collapser.h"

namespace lsmvs::internal {

namespace {

constexpr size_t kStepsPerReport = 65536;
constexpr int32_t kVerticesPerBlock = 16384;

Eigen::Vector3d NormalTimesTwiceArea(const Triangle3& t) { return (t.b - t.a).cross(t.c - t.a); }

}  // namespace

EdgeCollapser::EdgeCollapser(const CollapseRules& rules, const std::vector<double>& tolerance,
                             VertexStars* stars, DeviationBound* bound)
    : rules_(rules),
      stars_(*stars),
      bound_(bound),
      quadrics_(stars->num_vertices()),
      finest_(tolerance),
      stamps_(stars->num_vertices(), 0),
      sources_(stars->num_vertices()),
      marks_(stars->num_vertices(), 0) {
  std::iota(sources_.begin(), sources_.end(), 0);
  const auto num_vertices = static_cast<int32_t>(stars_.num_vertices());
  for (int32_t f = 0; f < static_cast<int32_t>(stars_.num_all_faces()); ++f) AddFace(f);
  for (int32_t v = 0; v < num_vertices; ++v) HoldBorders(v);
}

void EdgeCollapser::Lock(const std::vector<uint8_t>& vertices) { is_locked_ = vertices; }

void EdgeCollapser::AddFace(int32_t f) {
  const Eigen::Vector3i& face = stars_.face(f);
  const Eigen::Vector3d normal = NormalTimesTwiceArea({At(face[0]), At(face[1]), At(face[2])});
  const double length = normal.norm();
  if (length == 0) return;
  for (const int v : face) {
    quadrics_[static_cast<size_t>(v)].AddPlane(normal / length, At(v), length);
  }
}

// Adds planes across the border edges from `v` to vertices behind it, to both ends.
void EdgeCollapser::HoldBorders(int32_t v) {
  stars_.ForFaces(v, [&](int32_t f, int k) {
    for (int step = 1; step < 3; ++step) {
      const int32_t w = stars_.face(f)[(k + step) % 3];
      if (w > v && CountShared(v, w) == 1) HoldBorder(f, v, w);
    }
  });
}

void EdgeCollapser::HoldBorder(int32_t f, int32_t v, int32_t w) {
  const Eigen::Vector3i& face = stars_.face(f);
  const Eigen::Vector3d edge = At(w) - At(v);
  const Eigen::Vector3d across =
      edge.cross(NormalTimesTwiceArea({At(face[0]), At(face[1]), At(face[2])}));
  if (across.norm() == 0) return;
  for (const int32_t end : {v, w}) {
    quadrics_[static_cast<size_t>(end)].AddPlane(across.normalized(), At(v),
                                                 rules_.border_weight * edge.squaredNorm());
  }
}

int EdgeCollapser::CountShared(int32_t a, int32_t b) const {
  int count = 0;
  stars_.ForFaces(a, [&](int32_t f, int) { count += stars_.Has(f, b); });
  return count;
}

void EdgeCollapser::Run(size_t min_faces, const RunContext& context) {
  // Where the order does not decide what is left, by blocks: their data stay in the cache.
  const auto num_vertices = static_cast<int32_t>(stars_.num_vertices());
  block_size_ = bound_ != nullptr && min_faces == 0 ? kVerticesPerBlock : std::max(num_vertices, 1);
  const size_t begin = stars_.num_faces();
  later_.clear();
  for (block_ = 0; block_ * block_size_ < num_vertices; ++block_) {
    const int32_t first = block_ * block_size_;
    queue_.clear();
    for (int32_t v = first; v < std::min(first + block_size_, num_vertices); ++v) {
      PushEdges(v, EdgesTo::kLower);
    }
    CollapseQueue(min_faces, [&] {
      context.Report(min_faces == 0 ? static_cast<double>(first) / num_vertices
                                    : static_cast<double>(begin - stars_.num_faces()) /
                                          static_cast<double>(begin - min_faces));
      context.ThrowIfCancelled();
    });
  }
  queue_.swap(later_);
  block_ = kAllBlocks;
  CollapseQueue(min_faces, [&] { context.ThrowIfCancelled(); });
}

template <class Poll>
void EdgeCollapser::CollapseQueue(size_t min_faces, const Poll& poll) {
  std::make_heap(queue_.begin(), queue_.end());
  for (size_t steps = 0; stars_.num_faces() > min_faces && !queue_.empty(); ++steps) {
    if (steps % kStepsPerReport == 0) poll();
    std::pop_heap(queue_.begin(), queue_.end());
    const Edge edge = queue_.back();
    queue_.pop_back();
    if (IsCurrent(edge) && TryCollapse(edge.a, edge.b)) {
      PushEdges(collapse_.keep, EdgesTo::kAll);
    }
  }
}

void EdgeCollapser::Repeat(const std::vector<CollapseStep>& steps, const RunContext& context) {
  std::vector<uint8_t> differs = is_locked_;
  std::vector<int32_t> around;
  for (size_t i = 0; i < steps.size(); ++i) {
    if (i % kStepsPerReport == 0) context.ThrowIfCancelled();
    const CollapseStep& step = steps[i];
    const auto keep = static_cast<size_t>(step.keep), drop = static_cast<size_t>(step.drop);
    if (!differs[keep] && !differs[drop]) {
      Prepare({step.place, step.keep, 0}, step.drop);
      bound_->Accept(collapse_);
      Apply();
      continue;
    }
    around.clear();
    FindAround(step.keep, &around);
    FindAround(step.drop, &around);
    const bool is_free = !is_locked_[keep] && !is_locked_[drop];
    if (is_free && TryCollapse(step.keep, step.drop) && steps_.back() == step) continue;
    for (const int32_t v : around) differs[static_cast<size_t>(v)] = 1;
  }
}

// Adds the vertices up to two edges away, each once or more often.
void EdgeCollapser::FindAround(int32_t v, std::vector<int32_t>* around) const {
  stars_.ForFaces(v, [&](int32_t f, int) {
    for (const int w : stars_.face(f)) {
      stars_.ForFaces(w, [&](int32_t g, int) {
        for (const int x : stars_.face(g)) around->push_back(x);
      });
    }
  });
}

bool EdgeCollapser::IsCurrent(const Edge& edge) const {
  return stamps_[static_cast<size_t>(edge.a)] + stamps_[static_cast<size_t>(edge.b)] == edge.stamps;
}

// Puts the edges at a vertex into the queue of their block: that of the end that comes later. Those
// of a block that is done wait for the end, those of one to come are found when it is their turn.
void EdgeCollapser::PushEdges(int32_t v, EdgesTo to) {
  if (!is_locked_.empty() && is_locked_[static_cast<size_t>(v)]) return;
  const uint32_t mark = ++mark_;
  stars_.ForFaces(v, [&](int32_t f, int k) {
    for (int step = 1; step < 3; ++step) {
      const int32_t w = stars_.face(f)[(k + step) % 3];
      if (marks_[static_cast<size_t>(w)] == mark || (to == EdgesTo::kLower && w > v)) continue;
      marks_[static_cast<size_t>(w)] = mark;
      if (!is_locked_.empty() && is_locked_[static_cast<size_t>(w)]) continue;
      const int32_t a = std::min(v, w), b = std::max(v, w);
      const int32_t block = block_ == kAllBlocks ? kAllBlocks : b / block_size_;
      if (block > block_) continue;
      const Edge edge = {static_cast<float>(PlacementOf(a, b).cost),
                         stamps_[static_cast<size_t>(a)] + stamps_[static_cast<size_t>(b)], a, b};
      std::vector<Edge>& queue = block == block_ ? queue_ : later_;
      queue.push_back(edge);
      if (to == EdgesTo::kAll && block == block_) std::push_heap(queue_.begin(), queue_.end());
    }
  });
}

EdgeCollapser::Placement EdgeCollapser::PlacementOf(int32_t a, int32_t b) const {
  Quadric sum = quadrics_[static_cast<size_t>(a)];
  sum += quadrics_[static_cast<size_t>(b)];
  const Eigen::Vector3d &xa = At(a), &xb = At(b);
  Placement result;
  if (IsPinned(a) || IsPinned(b)) {
    const bool keep_a = IsPinned(a) && (!IsPinned(b) || sum.At(xa) <= sum.At(xb));
    result.place = keep_a ? xa : xb;
  } else {
    result.place = BestPlace(sum, a, b);
  }
  result.keep = result.place == xb ? b : a;
  // Among edges that cost nothing, short ones first.
  result.cost = sum.At(result.place) + 1e-9 * sum.a.trace() * (xb - xa).squaredNorm();
  if (!finest_.empty()) {
    const double finest =
        std::min(finest_[static_cast<size_t>(a)], finest_[static_cast<size_t>(b)]);
    result.cost /= finest * finest;
  }
  return result;
}

Eigen::Vector3d EdgeCollapser::BestPlace(const Quadric& sum, int32_t a, int32_t b) const {
  const Eigen::Vector3d &xa = At(a), &xb = At(b);
  const Eigen::Vector3d middle = 0.5 * (xa + xb);
  // A little of "stay in the middle" makes flat regions well-posed and even.
  const double weight = 1e-7 * sum.a.trace() + 1e-300;
  const Eigen::Matrix3d system = sum.a + weight * Eigen::Matrix3d::Identity();
  Eigen::Vector3d best = system.llt().solve(weight * middle - sum.b);
  if (!best.allFinite() || (best - middle).squaredNorm() > 4 * (xb - xa).squaredNorm()) {
    best = middle;
  }
  double cost = sum.At(best);
  for (const Eigen::Vector3d& candidate : {xa, xb, middle}) {
    if (sum.At(candidate) >= cost) continue;
    cost = sum.At(candidate);
    best = candidate;
  }
  return best;
}

// Marks the neighbours of v; counts them, and those that have `mark` already.
int EdgeCollapser::CountNeighbors(int32_t v, uint32_t mark, int* num_marked) {
  const uint32_t own = ++mark_;
  int count = 0;
  stars_.ForFaces(v, [&](int32_t f, int k) {
    for (int step = 1; step < 3; ++step) {
      uint32_t& present = marks_[static_cast<size_t>(stars_.face(f)[(k + step) % 3])];
      if (present == own) continue;
      *num_marked += present == mark;
      present = own;
      ++count;
    }
  });
  return count;
}

// The link condition (Dey, Edelsbrunner, Guha, Nekhayev, 1999).
bool EdgeCollapser::KeepsTopology(int32_t a, int32_t b) {
  const int num_shared = CountShared(a, b);
  if (num_shared == 0) return false;
  int num_faces_a = 0, num_faces_b = 0, num_common = 0;
  stars_.ForFaces(a, [&](int32_t, int) { ++num_faces_a; });
  stars_.ForFaces(b, [&](int32_t, int) { ++num_faces_b; });
  int unused = 0;
  const int num_neighbors_a = CountNeighbors(a, 0, &unused);
  const int num_neighbors_b = CountNeighbors(b, mark_, &num_common);
  if (num_common != num_shared) return false;
  // An inner edge between two border vertices: collapsing it would pinch the surface there.
  const bool both_on_border = num_neighbors_a != num_faces_a && num_neighbors_b != num_faces_b;
  return !both_on_border || num_shared == 1;
}

bool EdgeCollapser::TryCollapse(int32_t a, int32_t b) {
  if (!KeepsTopology(a, b)) return false;
  const Placement placement = PlacementOf(a, b);
  if (!Prepare(placement, a + b - placement.keep)) return false;
  if (bound_ != nullptr && !bound_->Allows(collapse_)) return false;
  Apply();
  return true;
}

// Fills in collapse_; false if it turns or flattens a face.
bool EdgeCollapser::Prepare(const Placement& placement, int32_t drop) {
  collapse_.keep = placement.keep;
  collapse_.drop = drop;
  collapse_.place = placement.place;
  collapse_.faces.clear();
  collapse_.removed.clear();
  return AddNewFaces(drop, placement.keep) && AddNewFaces(placement.keep, drop) &&
         collapse_.faces.size() <= rules_.max_faces_of_vertex;
}

bool EdgeCollapser::AddNewFaces(int32_t v, int32_t other) {
  return !stars_.AnyFace(v, [&](int32_t f, int k) {
    if (stars_.Has(f, other)) {
      if (v == collapse_.drop) collapse_.removed.push_back(f);
      return false;
    }
    Eigen::Vector3i corners = stars_.face(f);
    corners[k] = collapse_.keep;
    Triangle3 triangle = {At(corners[0]), At(corners[1]), At(corners[2])};
    (k == 0 ? triangle.a : k == 1 ? triangle.b : triangle.c) = collapse_.place;
    collapse_.faces.push_back({f, corners, triangle});
    return !IsProper(collapse_.faces.back(), k);
  });
}

// Whether a face that gets its corner k from the collapse is neither turned over nor a sliver.
bool EdgeCollapser::IsProper(const Collapse::NewFace& face, int k) const {
  const Eigen::Vector3i& corners = stars_.face(face.face);
  const Eigen::Vector3d before =
      NormalTimesTwiceArea({At(corners[0]), At(corners[1]), At(corners[2])});
  const Eigen::Vector3d after = NormalTimesTwiceArea(face.triangle);
  const Eigen::Vector3d &next = At(corners[(k + 1) % 3]), &last = At(corners[(k + 2) % 3]);
  const double longest =
      std::max({(next - collapse_.place).squaredNorm(), (last - collapse_.place).squaredNorm(),
                (last - next).squaredNorm()});
  if (after.norm() < rules_.min_flatness * longest) return false;
  return before.dot(after) >= rules_.min_normal_cosine * before.norm() * after.norm();
}

void EdgeCollapser::Apply() {
  const size_t keep = static_cast<size_t>(collapse_.keep),
               drop = static_cast<size_t>(collapse_.drop);
  if (bound_ != nullptr) {
    bound_->Apply(collapse_);
    sources_[keep] = bound_->nearest();
    finest_[keep] = std::min(finest_[keep], finest_[drop]);
    steps_.push_back({collapse_.place, collapse_.keep, collapse_.drop, bound_->StateHash()});
  } else if ((At(collapse_.drop) - collapse_.place).squaredNorm() <
             (At(collapse_.keep) - collapse_.place).squaredNorm()) {
    sources_[keep] = sources_[drop];
  }
  stars_.Merge(collapse_.keep, collapse_.drop, collapse_.place);
  quadrics_[keep] += quadrics_[drop];
  ++stamps_[keep];
  ++stamps_[drop];
}

}  // namespace lsmvs::internal
