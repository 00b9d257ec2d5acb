#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "lsmvs/mesh/half_edges.h"
#include "lsmvs/mesh/simplification/deviation_bound.h"

namespace lsmvs::internal {

namespace {

// Faces that an input edge may pass in a star.
constexpr int kMaxSteps = 12;
// Faces that are looked at for an edge, a bit each.
constexpr size_t kMaxCandidates = 64, kMaxFacesAt = 16;
// Input vertices whose faces a point of the new surface is compared with.
constexpr size_t kNumNearest = 3;
// Between the points looked at, the square of the distance may be larger.
constexpr double kSampleMargin = 0.8;

Triangle3 TriangleOf(const std::vector<Eigen::Vector3d>& x, const Eigen::Vector3i& face) {
  return {x[static_cast<size_t>(face[0])], x[static_cast<size_t>(face[1])],
          x[static_cast<size_t>(face[2])]};
}

uint64_t FirstBits(size_t count) { return count >= 64 ? ~uint64_t{0} : (uint64_t{1} << count) - 1; }

}  // namespace

DeviationBound::DeviationBound(const std::vector<Eigen::Vector3d>& vertices,
                               const std::vector<Eigen::Vector3i>& faces,
                               const std::vector<double>& tolerance, const VertexStars& stars)
    : vertices_(vertices),
      input_faces_(faces),
      tolerance_(tolerance),
      stars_(stars),
      face_of_(vertices.size(), kInPlace),
      first_by_(faces.size(), kNone),
      next_by_(vertices.size(), kNone),
      input_next_(vertices.size(), kNone),
      previous_on_border_(vertices.size(), kNone),
      place_in_star_(vertices.size(), kNone),
      place_in_candidates_(faces.size(), kNone) {
  LinkNeighbors(faces);
  LinkBorders(faces);
}

void DeviationBound::LinkNeighbors(const std::vector<Eigen::Vector3i>& faces) {
  const size_t num_vertices = vertices_.size();
  const std::vector<HalfEdge> sides = SortedHalfEdges(faces, num_vertices);
  neighbors_begin_.assign(num_vertices + 1, 0);
  ForEdges(sides, [&](const HalfEdge* side, const HalfEdge*) {
    ++neighbors_begin_[static_cast<size_t>(side->low) + 1];
    ++neighbors_begin_[static_cast<size_t>(side->high) + 1];
  });
  for (size_t v = 0; v < num_vertices; ++v) neighbors_begin_[v + 1] += neighbors_begin_[v];
  neighbors_.resize(neighbors_begin_[num_vertices]);
  std::vector<uint32_t> place(neighbors_begin_.begin(), neighbors_begin_.end() - 1);
  ForEdges(sides, [&](const HalfEdge* side, const HalfEdge*) {
    neighbors_[place[static_cast<size_t>(side->low)]++] = side->high;
    neighbors_[place[static_cast<size_t>(side->high)]++] = side->low;
  });
  corners_of_ = CornersByVertex(num_vertices, faces);
}

void DeviationBound::LinkBorders(const std::vector<Eigen::Vector3i>& faces) {
  ForEdges(SortedHalfEdges(faces, vertices_.size()),
           [&](const HalfEdge* side, const HalfEdge* end) {
             if (end - side != 1) return;
             const Eigen::Vector3i& face = faces[static_cast<size_t>(side->face)];
             const int from = face[side->corner], to = face[(side->corner + 1) % 3];
             int32_t& next = input_next_[static_cast<size_t>(from)];
             next = next == kNone ? to : kBranches;
             previous_on_border_[static_cast<size_t>(to)] = from;
           });
  next_on_border_ = input_next_;
}

double DeviationBound::SquaredTolerance(int32_t v) const {
  const double tolerance = tolerance_[static_cast<size_t>(v)];
  return tolerance * tolerance;
}

bool DeviationBound::Allows(const Collapse& collapse) {
  Begin();
  return End(IsBorderNear(collapse) && CollectVertices(collapse) && IsPlaceNear(collapse) &&
             AreEdgesNear(collapse) && AreNewFacesNear(collapse));
}

void DeviationBound::Accept(const Collapse& collapse) {
  Begin();
  End(CollectVertices(collapse) && IsPlaceNear(collapse));
}

void DeviationBound::Begin() {
  ForgetCandidates(0);
  star_vertices_.clear();
  old_faces_.clear();
  near_faces_.clear();
}

bool DeviationBound::End(bool allowed) {
  for (const int32_t v : star_vertices_) place_in_star_[static_cast<size_t>(v)] = kNone;
  for (size_t i = 0; !allowed && i < star_vertices_.size(); ++i) {
    face_of_[static_cast<size_t>(star_vertices_[i])] = old_faces_[i];
  }
  return allowed;
}

// Finds the input vertices of the star and puts each by its nearest new face; false if that is too
// far. What is likely to fail comes first.
bool DeviationBound::CollectVertices(const Collapse& collapse) {
  for (const Collapse::NewFace& face : collapse.faces) {
    if (candidates_.size() < kMaxCandidates) AddCandidate(face.triangle);
  }
  const auto add = [&](int32_t v) { return AddVertex(collapse, v); };
  const auto add_all = [&](int32_t face) {
    for (int32_t v = first_by_[static_cast<size_t>(face)]; v != kNone;
         v = next_by_[static_cast<size_t>(v)]) {
      if (!add(v)) return false;
    }
    return true;
  };
  const bool moves = collapse.place != stars_.position(collapse.keep);
  if (IsInPlace(collapse.drop) && !add(collapse.drop)) return false;
  if (moves && IsInPlace(collapse.keep) && !add(collapse.keep)) return false;
  for (const int32_t face : collapse.removed) {
    if (!add_all(face)) return false;
  }
  for (const Collapse::NewFace& face : collapse.faces) {
    if (!add_all(face.face)) return false;
  }
  return true;
}

bool DeviationBound::AddVertex(const Collapse& collapse, int32_t v) {
  const Eigen::Vector3d& x = vertices_[static_cast<size_t>(v)];
  const double squared_tolerance = SquaredTolerance(v);
  uint64_t near = 0;
  size_t nearest = 0;
  double least = squared_tolerance;
  for (size_t k = 0; k < candidates_.size(); ++k) {
    const double distance = candidates_[k].SquaredDistance(x, squared_tolerance);
    if (distance > squared_tolerance) continue;
    near |= uint64_t{1} << k;
    if (distance >= least) continue;
    least = distance;
    nearest = k;
  }
  if (near == 0) return false;
  place_in_star_[static_cast<size_t>(v)] = static_cast<int32_t>(star_vertices_.size());
  star_vertices_.push_back(v);
  near_faces_.push_back(near);
  old_faces_.push_back(
      std::exchange(face_of_[static_cast<size_t>(v)], collapse.faces[nearest].face));
  return true;
}

// Judges by the input faces around the input vertex that is nearest to the new vertex.
bool DeviationBound::IsPlaceNear(const Collapse& collapse) {
  nearest_ = collapse.keep;
  const bool moves = collapse.place != stars_.position(collapse.keep);
  if (IsInPlace(collapse.keep) && !moves) return true;
  double nearest = std::numeric_limits<double>::infinity();
  for (const int32_t v : star_vertices_) {
    const double distance = (vertices_[static_cast<size_t>(v)] - collapse.place).squaredNorm();
    if (distance >= nearest) continue;
    nearest = distance;
    nearest_ = v;
  }
  const double squared_tolerance = SquaredTolerance(nearest_);
  if (nearest <= squared_tolerance) return true;
  return IsNearFacesAt(nearest_, collapse.place, squared_tolerance);
}

bool DeviationBound::AreEdgesNear(const Collapse& collapse) {
  for (size_t i = 0; i < star_vertices_.size(); ++i) {
    const int32_t v = star_vertices_[i];
    for (uint32_t k = neighbors_begin_[static_cast<size_t>(v)];
         k < neighbors_begin_[static_cast<size_t>(v) + 1]; ++k) {
      const int32_t w = neighbors_[k], j = place_in_star_[static_cast<size_t>(w)];
      if (j != kNone && w < v) continue;  // looked at from there
      if (j != kNone && (near_faces_[i] & near_faces_[static_cast<size_t>(j)]) != 0) continue;
      const double squared_tolerance = std::min(SquaredTolerance(v), SquaredTolerance(w));
      const bool covered =
          j != kNone ? IsWayInsideCovered(collapse, i, static_cast<size_t>(j), squared_tolerance)
                     : IsWayOutCovered(collapse, i, w, squared_tolerance);
      if (!covered) return false;
    }
  }
  return true;
}

// The edge between two vertices of the star: by the new faces, or else by those around, too.
bool DeviationBound::IsWayInsideCovered(const Collapse& collapse, size_t i, size_t j,
                                        double squared_tolerance) {
  const Point s = {vertices_[static_cast<size_t>(star_vertices_[i])], near_faces_[i]};
  const Point t = {vertices_[static_cast<size_t>(star_vertices_[j])], near_faces_[j], kAll};
  return IsCovered(s, t, NewFaces(collapse), squared_tolerance) ||
         IsWayCoveredAround(collapse, s, t, squared_tolerance);
}

// The edge from a vertex of the star to one outside: by the new faces, those at that one and those
// around the star.
bool DeviationBound::IsWayOutCovered(const Collapse& collapse, size_t star_vertex, int32_t w,
                                     double squared_tolerance) {
  Point s = {vertices_[static_cast<size_t>(star_vertices_[star_vertex])], near_faces_[star_vertex]};
  Point t = {vertices_[static_cast<size_t>(w)], 0};
  if (IsNearOneOf(s.near, squared_tolerance, &t)) return true;
  const uint64_t new_faces = NewFaces(collapse);
  if (candidates_.size() > kMaxCandidates - kMaxFacesAt) {
    ForgetCandidates(static_cast<size_t>(std::popcount(new_faces)));
  }
  const uint64_t at_w = FacesAt(collapse, w);
  return IsOneStepCovered(s, at_w, squared_tolerance, &t) ||
         IsWayCoveredAround(collapse, s, t, squared_tolerance);
}

// By all candidates, with the faces around the star.
bool DeviationBound::IsWayCoveredAround(const Collapse& collapse, const Point& s, const Point& t,
                                        double squared_tolerance) {
  if (!has_faces_around_) AddFacesAround(collapse);
  const uint64_t along =
      CandidatesAlong(s.x, t.x, FirstBits(candidates_.size()), squared_tolerance);
  if (IsCovered(s, t, along, squared_tolerance)) return true;
  const uint64_t others = NearFaces(s.x, along & ~s.near, squared_tolerance);
  return others != 0 && IsCovered({s.x, s.near | others}, t, along, squared_tolerance);
}

// Whether the way from s leaves a face that s is near where it is near one of some other faces that
// t is near: what IsCovered() finds out, too, for most of the edges.
bool DeviationBound::IsOneStepCovered(const Point& s, uint64_t faces_at_t, double squared_tolerance,
                                      Point* t) const {
  if (!IsNearOneOf(faces_at_t, squared_tolerance, t)) return false;
  for (uint64_t left = s.near; left != 0; left &= left - 1) {
    const double share =
        candidates_[static_cast<size_t>(std::countr_zero(left))].ExitShare(s.x, t->x);
    if (!(share > 0)) continue;
    Point exit = {s.x + share * (t->x - s.x), 0};
    if (IsNearOneOf(left & -left, squared_tolerance, &exit) &&
        IsNearOneOf(faces_at_t & t->near, squared_tolerance, &exit)) {
      return true;
    }
  }
  return false;
}

// The new faces among the candidates: the first ones.
uint64_t DeviationBound::NewFaces(const Collapse& collapse) const {
  return FirstBits(std::min(collapse.faces.size(), kMaxCandidates));
}

void DeviationBound::AddCandidate(const Triangle3& t) {
  candidates_.emplace_back(t);
  const Eigen::Vector3d center = (t.a + t.b + t.c) / 3;
  balls_.push_back(
      {center, std::sqrt(std::max({(t.a - center).squaredNorm(), (t.b - center).squaredNorm(),
                                   (t.c - center).squaredNorm()}))});
}

// The bit of a face outside the star, which becomes a candidate if it is none; 0 for faces of the
// star and where there are too many.
uint64_t DeviationBound::OuterCandidate(const Collapse& collapse, int32_t face) {
  int8_t& place = place_in_candidates_[static_cast<size_t>(face)];
  if (place != kNone) return uint64_t{1} << place;
  if (candidates_.size() == kMaxCandidates || stars_.Has(face, collapse.keep) ||
      stars_.Has(face, collapse.drop)) {
    return 0;
  }
  place = static_cast<int8_t>(candidates_.size());
  outer_faces_.push_back(face);
  AddCandidate(TriangleOf(stars_.positions(), stars_.face(face)));
  return uint64_t{1} << place;
}

// Leaves the first ones, which are the new faces.
void DeviationBound::ForgetCandidates(size_t num_left) {
  for (const int32_t face : outer_faces_) place_in_candidates_[static_cast<size_t>(face)] = kNone;
  outer_faces_.clear();
  has_faces_around_ = false;
  const auto left = static_cast<std::ptrdiff_t>(num_left);
  candidates_.erase(candidates_.begin() + left, candidates_.end());
  balls_.erase(balls_.begin() + left, balls_.end());
}

// Those of some candidates that may be within tolerance of a point between two.
uint64_t DeviationBound::CandidatesAlong(const Eigen::Vector3d& s, const Eigen::Vector3d& t,
                                         uint64_t candidates, double squared_tolerance) const {
  const Eigen::Vector3d middle = 0.5 * (s + t);
  const double reach = 0.5 * (t - s).norm() + std::sqrt(squared_tolerance);
  uint64_t along = 0;
  for (; candidates != 0; candidates &= candidates - 1) {
    const int k = std::countr_zero(candidates);
    const Ball& ball = balls_[static_cast<size_t>(k)];
    const double limit = ball.radius + reach;
    along |= uint64_t{(ball.center - middle).squaredNorm() <= limit * limit} << k;
  }
  return along;
}

// The faces outside the star by which an input vertex lies.
uint64_t DeviationBound::FacesAt(const Collapse& collapse, int32_t v) {
  if (!IsInPlace(v)) return OuterCandidate(collapse, face_of_[static_cast<size_t>(v)]);
  uint64_t faces = 0;
  stars_.ForFaces(v, [&](int32_t f, int) { faces |= OuterCandidate(collapse, f); });
  return faces;
}

// The faces outside the star that touch it.
void DeviationBound::AddFacesAround(const Collapse& collapse) {
  has_faces_around_ = true;
  for (const Collapse::NewFace& face : collapse.faces) {
    // Of the two other corners the one that follows: each corner of the star's rim comes once.
    int k = 0;
    while (face.corners[k] != collapse.keep) ++k;
    const int32_t v = face.corners[(k + 1) % 3];
    stars_.ForFaces(v, [&](int32_t f, int) { OuterCandidate(collapse, f); });
  }
}

// Those of some candidates that are within tolerance of a point, a bit each.
uint64_t DeviationBound::NearFaces(const Eigen::Vector3d& x, uint64_t candidates,
                                   double squared_tolerance) const {
  uint64_t near = 0;
  for (; candidates != 0; candidates &= candidates - 1) {
    const int k = std::countr_zero(candidates);
    const double distance =
        candidates_[static_cast<size_t>(k)].SquaredDistance(x, squared_tolerance);
    near |= uint64_t{distance <= squared_tolerance} << k;
  }
  return near;
}

// Whether a point is within tolerance of one of some candidates.
bool DeviationBound::IsNearOneOf(uint64_t candidates, double squared_tolerance, Point* t) const {
  const uint64_t unknown = candidates & ~t->known;
  t->near |= NearFaces(t->x, unknown, squared_tolerance);
  t->known |= unknown;
  return (candidates & t->near) != 0;
}

// Whether the way between two points lies within tolerance of the candidates. Walks from candidate
// to candidate: between two points within tolerance of one the way is, too.
bool DeviationBound::IsCovered(Point s, Point t, uint64_t candidates,
                               double squared_tolerance) const {
  for (int step = 0; step < kMaxSteps; ++step) {
    if (IsNearOneOf(s.near, squared_tolerance, &t)) return true;
    double exit = 0;
    uint64_t leaving = 0;
    for (uint64_t left = s.near; left != 0; left &= left - 1) {
      const int k = std::countr_zero(left);
      const double share = candidates_[static_cast<size_t>(k)].ExitShare(s.x, t.x);
      if (share <= exit) continue;
      exit = share;
      leaving = uint64_t{1} << k;
    }
    if (leaving == 0) return false;
    s.x += exit * (t.x - s.x);
    s.near = NearFaces(s.x, candidates, squared_tolerance);
    if ((s.near & leaving) == 0) return false;
  }
  return false;
}

// Whether points on the new edges and faces are within tolerance of the input.
bool DeviationBound::AreNewFacesNear(const Collapse& collapse) const {
  for (const Collapse::NewFace& face : collapse.faces) {
    const Triangle3& t = face.triangle;
    int k = 0;
    while (face.corners[k] != collapse.keep) ++k;
    const Eigen::Vector3d& rim = k == 0 ? t.b : k == 1 ? t.c : t.a;
    for (const Eigen::Vector3d& x : {Eigen::Vector3d((t.a + t.b + t.c) / 3),
                                     Eigen::Vector3d(0.67 * collapse.place + 0.33 * rim),
                                     Eigen::Vector3d(0.33 * collapse.place + 0.67 * rim)}) {
      if (!IsNearInput(collapse, face, x)) return false;
    }
  }
  return true;
}

// Judges by the input faces at the two nearest input vertices of the star.
bool DeviationBound::IsNearInput(const Collapse& collapse, const Collapse::NewFace& face,
                                 const Eigen::Vector3d& x) const {
  std::array<double, kNumNearest> distances;
  distances.fill(std::numeric_limits<double>::infinity());
  std::array<int32_t, kNumNearest> nearest;
  nearest.fill(kNone);
  const auto look_at = [&](int32_t v) {
    double distance = (vertices_[static_cast<size_t>(v)] - x).squaredNorm();
    if (distance >= distances.back()) return;
    for (size_t k = 0; k < kNumNearest; ++k) {
      if (distance >= distances[k]) continue;
      std::swap(distance, distances[k]);
      std::swap(v, nearest[k]);
    }
  };
  for (const int32_t v : star_vertices_) look_at(v);
  for (const int v : face.corners) {
    if (v != collapse.keep && IsInPlace(v)) look_at(v);
  }
  if (IsInPlace(collapse.keep) && collapse.place == stars_.position(collapse.keep)) {
    look_at(collapse.keep);
  }
  return std::any_of(nearest.begin(), nearest.end(), [&](int32_t v) {
    return v != kNone && IsNearFacesAt(v, x, kSampleMargin * SquaredTolerance(v));
  });
}

bool DeviationBound::IsNearFacesAt(int32_t v, const Eigen::Vector3d& x,
                                   double squared_tolerance) const {
  const auto corners = corners_of_.Of(static_cast<size_t>(v));
  return std::any_of(corners.begin(), corners.end(), [&](uint32_t corner) {
    const Triangle3 triangle = TriangleOf(vertices_, input_faces_[corner / 3]);
    return (ClosestOnTriangle(x, triangle) - x).squaredNorm() <= squared_tolerance;
  });
}

bool DeviationBound::IsBorderNear(const Collapse& collapse) const {
  if (!IsOnBorder(collapse.drop)) return true;
  const int32_t next = next_on_border_[static_cast<size_t>(collapse.drop)],
                previous = previous_on_border_[static_cast<size_t>(collapse.drop)];
  if (next < 0 || previous < 0) return false;
  return next == collapse.keep ? IsChainNear(previous, next) : IsChainNear(collapse.keep, next);
}

// Whether the input's border from one vertex to another lies by the edge between them.
bool DeviationBound::IsChainNear(int32_t from, int32_t to) const {
  const Eigen::Vector3d &a = vertices_[static_cast<size_t>(from)],
                        &b = vertices_[static_cast<size_t>(to)];
  for (int32_t v = input_next_[static_cast<size_t>(from)]; v != to;
       v = input_next_[static_cast<size_t>(v)]) {
    if (v < 0) return false;
    const Eigen::Vector3d& x = vertices_[static_cast<size_t>(v)];
    if ((ClosestOnSegment(x, a, b) - x).squaredNorm() > SquaredTolerance(v)) return false;
  }
  return true;
}

uint64_t DeviationBound::StateHash() const {
  uint64_t hash = 0;
  for (const int32_t v : star_vertices_) {
    const auto face = static_cast<uint64_t>(face_of_[static_cast<size_t>(v)]);
    uint64_t x = (static_cast<uint64_t>(v) << 32 | face) * 0x9e3779b97f4a7c15;
    x = (x ^ x >> 32) * 0xd6e8feb86659fd93;
    hash += x ^ x >> 32;  // in any order
  }
  return hash;
}

void DeviationBound::Apply(const Collapse& collapse) {
  for (const int32_t face : collapse.removed) first_by_[static_cast<size_t>(face)] = kNone;
  for (const Collapse::NewFace& face : collapse.faces) {
    first_by_[static_cast<size_t>(face.face)] = kNone;
  }
  for (const int32_t v : star_vertices_) {
    int32_t& first = first_by_[static_cast<size_t>(face_of_[static_cast<size_t>(v)])];
    next_by_[static_cast<size_t>(v)] = std::exchange(first, v);
  }
  if (!IsOnBorder(collapse.drop)) return;
  const int32_t next = std::exchange(next_on_border_[static_cast<size_t>(collapse.drop)], kNone);
  const int32_t previous = previous_on_border_[static_cast<size_t>(collapse.drop)];
  next_on_border_[static_cast<size_t>(previous)] = next;
  previous_on_border_[static_cast<size_t>(next)] = previous;
}

}  // namespace lsmvs::internal
