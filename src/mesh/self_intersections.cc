#include "lsmvs/mesh/self_intersections.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace lsmvs {

namespace {

constexpr size_t kBucketsPerBlock = 1 << 13, kFacesPerBlock = 1 << 13;
// If less than one of so many faces moved, each of them is looked up.
constexpr size_t kFewMoved = 4;
constexpr double kCellEdges = 2.0;
// Blocks of 2^kBlockBits cells along each axis.
constexpr int kBlockBits = 2;
constexpr size_t kCellsPerBlock = size_t{1} << 3 * kBlockBits;
// A face that touches more cells than this along an axis is entered in these many, so that one huge
// face does not fill the grid; it then meets others only there.
constexpr int kMaxCellsAlongAxis = 64;
// Boxes are rounded to float: wider by this part of the largest coordinate.
constexpr float kRounding = 2.5e-7f;

double Orientation(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                   const Eigen::Vector3d& d) {
  return (b - a).cross(c - a).dot(d - a);
}

bool EdgeCrosses(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& a,
                 const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  if (Orientation(a, b, c, p) * Orientation(a, b, c, q) >= 0) return false;
  const double ab = Orientation(p, q, a, b), bc = Orientation(p, q, b, c);
  if (ab * bc <= 0) return false;
  return ab * Orientation(p, q, c, a) > 0;
}

bool OnOneSide(std::span<const Eigen::Vector3d> vertices, const Eigen::Vector3i& plane,
               const Eigen::Vector3i& face) {
  const Eigen::Vector3d& a = vertices[static_cast<size_t>(plane[0])];
  const Eigen::Vector3d normal = (vertices[static_cast<size_t>(plane[1])] - a)
                                     .cross(vertices[static_cast<size_t>(plane[2])] - a);
  int num_above = 0, num_below = 0;
  for (const int v : face) {
    const double height = normal.dot(vertices[static_cast<size_t>(v)] - a);
    num_above += height > 0;
    num_below += height < 0;
  }
  return num_above == 0 || num_below == 0;
}

int NumShared(const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
  int count = 0;
  for (const int v : a) count += v == b[0] || v == b[1] || v == b[2];
  return count;
}

double MeanEdge(std::span<const Eigen::Vector3d> vertices, std::span<const Eigen::Vector3i> faces) {
  double sum = 0;
  for (const Eigen::Vector3i& f : faces) {
    sum += (vertices[static_cast<size_t>(f[1])] - vertices[static_cast<size_t>(f[0])]).norm();
  }
  return faces.empty() ? 1.0 : sum / static_cast<double>(faces.size());
}

Eigen::Array3i BlockOf(const Eigen::Array3i& cell) {
  return {cell[0] >> kBlockBits, cell[1] >> kBlockBits, cell[2] >> kBlockBits};
}

uint64_t Mixed(const Eigen::Array3i& cell) {
  const Eigen::Array<uint64_t, 3, 1> c = cell.cast<uint64_t>();
  const uint64_t mixed = (c[0] << 42 ^ c[1] << 21 ^ c[2]) * 0x9e3779b97f4a7c15u;
  return (mixed ^ mixed >> 32) * 0xd6e8feb86659fd93u;
}

}  // namespace

bool FacesCross(std::span<const Eigen::Vector3d> vertices, const Eigen::Vector3i& a,
                const Eigen::Vector3i& b) {
  if (OnOneSide(vertices, a, b) || OnOneSide(vertices, b, a)) return false;
  const auto at = [&](const Eigen::Vector3i& face, int k) -> const Eigen::Vector3d& {
    return vertices[static_cast<size_t>(face[k % 3])];
  };
  for (int k = 0; k < 3; ++k) {
    if (EdgeCrosses(at(a, k), at(a, k + 1), at(b, 0), at(b, 1), at(b, 2))) return true;
    if (EdgeCrosses(at(b, k), at(b, k + 1), at(a, 0), at(a, 1), at(a, 2))) return true;
  }
  return false;
}

FaceGrid::FaceGrid(std::span<const Eigen::Vector3d> vertices,
                   std::span<const Eigen::Vector3i> faces, std::span<const Eigen::Vector3d> before)
    : vertices_(vertices), before_(before), faces_(faces) {
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3d& x : vertices) bounds.extend(x);
  for (const Eigen::Vector3d& x : before) bounds.extend(x);
  if (faces.empty()) return;
  const double cell_size = kCellEdges * MeanEdge(vertices, faces);
  if (!(cell_size > 0) || !std::isfinite(cell_size)) return;
  origin_ = bounds.min();
  cells_per_length_ = static_cast<float>(1.0 / cell_size);
  boxes_.reserve(faces.size());
  for (const Eigen::Vector3i& face : faces) boxes_.push_back(BoxOf(face));
  for (const Box& box : boxes_) {
    const Cells cells = CellsOf(box);
    const Cell low = BlockOf(cells.low), high = BlockOf(cells.high);
    for (int32_t z = low[2]; z <= high[2]; ++z) {
      for (int32_t y = low[1]; y <= high[1]; ++y) {
        for (int32_t x = low[0]; x <= high[0]; ++x) blocks_.Add({x, y, z});
      }
    }
  }
  begins_.assign(blocks_.size() * kCellsPerBlock + 1, 0);
  for (const Box& box : boxes_) {
    ForBuckets(box, [&](size_t bucket) { ++begins_[bucket]; });
  }
  // Ends of the buckets, which become their begins as members are put in from the back.
  uint32_t end = 0;
  for (uint32_t& count : begins_) count = end += count;
  members_.resize(end);
  for (size_t f = boxes_.size(); f-- > 0;) {
    ForBuckets(boxes_[f],
               [&](size_t bucket) { members_[--begins_[bucket]] = static_cast<int32_t>(f); });
  }
}

FaceGrid::Box FaceGrid::BoxOf(const Eigen::Vector3i& face) const {
  Eigen::AlignedBox3d box;
  for (const int v : face) {
    box.extend(vertices_[static_cast<size_t>(v)] - origin_);
    if (!before_.empty()) box.extend(before_[static_cast<size_t>(v)] - origin_);
  }
  const auto wider = [](const Eigen::Vector3d& x, float by) {
    const Eigen::Array3f rounded = x.cast<float>().array();
    return Eigen::Array3f(rounded + by * rounded.abs());
  };
  return {wider(box.min(), -kRounding), wider(box.max(), kRounding)};
}

FaceGrid::Cells FaceGrid::CellsOf(const Box& box) const {
  // Within what the type holds, also where one vertex lies very far out.
  const auto cell = [&](const Eigen::Array3f& x) -> Cell {
    return (x * cells_per_length_).max(0.0f).min(2e9f).cast<int32_t>();
  };
  Cells cells{cell(box.min), cell(box.max)};
  cells.high = cells.high.min(cells.low + kMaxCellsAlongAxis - 1);
  return cells;
}

template <class Visit>
void FaceGrid::ForBuckets(const Box& box, const Visit& visit) const {
  const Cells cells = CellsOf(box);
  for (int32_t z = cells.low[2]; z <= cells.high[2]; ++z) {
    for (int32_t y = cells.low[1]; y <= cells.high[1]; ++y) {
      for (int32_t x = cells.low[0]; x <= cells.high[0]; ++x) {
        visit(BucketOf({x, y, z}));
      }
    }
  }
}

// Cells of a block have buckets side by side, so that what is worked on together lies together.
size_t FaceGrid::BucketOf(const Cell& cell) const {
  const auto in_block = [&](int k) {
    return static_cast<size_t>(cell[k] & ((1 << kBlockBits) - 1));
  };
  const auto block = static_cast<size_t>(blocks_.Find(BlockOf(cell)));
  return block * kCellsPerBlock +
         (in_block(2) << 2 * kBlockBits | in_block(1) << kBlockBits | in_block(0));
}

uint32_t FaceGrid::BlockNumbers::Add(const Cell& block) {
  if (2 * static_cast<size_t>(size_) >= entries_.size()) Grow();
  Entry& entry = entries_[Place(block)];
  if (entry.number == kNone) entry = {block, size_++};
  return entry.number;
}

uint32_t FaceGrid::BlockNumbers::Find(const Cell& block) const {
  return entries_[Place(block)].number;
}

size_t FaceGrid::BlockNumbers::Place(const Cell& block) const {
  const size_t mask = entries_.size() - 1;
  size_t place = Mixed(block) & mask;
  while (entries_[place].number != kNone && (entries_[place].block != block).any()) {
    place = (place + 1) & mask;
  }
  return place;
}

void FaceGrid::BlockNumbers::Grow() {
  std::vector<Entry> before(std::max<size_t>(64, 2 * entries_.size()));
  before.swap(entries_);
  for (const Entry& entry : before) {
    if (entry.number != kNone) entries_[Place(entry.block)] = entry;
  }
}

bool FaceGrid::MayCross(int32_t a, int32_t b) const {
  const size_t i = static_cast<size_t>(a), j = static_cast<size_t>(b);
  if (!boxes_[i].Meets(boxes_[j]) || a == b) return false;
  return NumShared(faces_[i], faces_[j]) < 2;
}

size_t FaceGrid::FirstCommonBucket(int32_t a, int32_t b) const {
  const auto low = [&](int32_t f) { return CellsOf(boxes_[static_cast<size_t>(f)]).low; };
  return BucketOf(low(a).max(low(b)));
}

std::vector<std::pair<int32_t, int32_t>> FaceGrid::CrossingPairs(const std::vector<uint8_t>& moved,
                                                                 const RunContext& context) const {
  if (members_.empty()) return {};
  const auto num_moved = std::count_if(moved.begin(), moved.end(), [](uint8_t m) { return m; });
  const bool few = static_cast<size_t>(num_moved) < moved.size() / kFewMoved;
  Pairs pairs = few ? PairsOfFaces(moved, context) : PairsOfBuckets(moved, context);
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

bool FaceGrid::Cross(int32_t a, int32_t b) const {
  return FacesCross(vertices_, faces_[static_cast<size_t>(a)], faces_[static_cast<size_t>(b)]);
}

// The boxes of a bucket's members side by side, so that one is compared with all behind it at once.
struct FaceGrid::BucketBoxes {
  std::array<std::vector<float>, 3> min, max;
  std::vector<Cell> low;  // the first cell that each touches
  std::vector<int32_t> meets;

  void Resize(size_t size) {
    if (meets.size() >= size) return;
    for (auto& values : min) values.resize(size);
    for (auto& values : max) values.resize(size);
    low.resize(size);
    meets.resize(size);
  }
  void Set(size_t i, const Box& box, const Cell& low_cell) {
    for (size_t k = 0; k < 3; ++k) {
      min[k][i] = box.min[static_cast<int>(k)];
      max[k][i] = box.max[static_cast<int>(k)];
    }
    low[i] = low_cell;
  }
  // Sets meets[k] for k of (i, end).
  void Compare(size_t i, size_t end) {
    const float* const min_x = min[0].data();
    const float* const min_y = min[1].data();
    const float* const min_z = min[2].data();
    const float* const max_x = max[0].data();
    const float* const max_y = max[1].data();
    const float* const max_z = max[2].data();
    const float x0 = min_x[i], x1 = max_x[i], y0 = min_y[i], y1 = max_y[i], z0 = min_z[i],
                z1 = max_z[i];
    int32_t* const out = meets.data();
    for (size_t k = i + 1; k < end; ++k) {
      out[k] = (min_x[k] <= x1) & (x0 <= max_x[k]) & (min_y[k] <= y1) & (y0 <= max_y[k]) &
               (min_z[k] <= z1) & (z0 <= max_z[k]);
    }
  }
};

void FaceGrid::FindInBucket(size_t bucket, const std::vector<uint8_t>& moved, BucketBoxes* boxes,
                            Pairs* found) const {
  const int32_t* members = members_.data() + begins_[bucket];
  const size_t count = begins_[bucket + 1] - begins_[bucket];
  boxes->Resize(count);
  for (size_t i = 0; i < count; ++i) {
    const Box& box = boxes_[static_cast<size_t>(members[i])];
    boxes->Set(i, box, CellsOf(box).low);
  }
  for (size_t i = 0; i + 1 < count; ++i) {
    const int32_t a = members[i];
    const bool a_moved = moved[static_cast<size_t>(a)] != 0;
    boxes->Compare(i, count);
    for (size_t k = i + 1; k < count; ++k) {
      const int32_t b = members[k];
      if (!boxes->meets[k] || a == b || !(a_moved || moved[static_cast<size_t>(b)])) continue;
      if (NumShared(faces_[static_cast<size_t>(a)], faces_[static_cast<size_t>(b)]) >= 2) continue;
      if (BucketOf(boxes->low[i].max(boxes->low[k])) != bucket || !Cross(a, b)) continue;
      found->emplace_back(a, b);
    }
  }
}

FaceGrid::Pairs FaceGrid::PairsOfBuckets(const std::vector<uint8_t>& moved,
                                         const RunContext& context) const {
  const size_t num_buckets = begins_.size() - 1;
  std::vector<Pairs> found((num_buckets + kBucketsPerBlock - 1) / kBucketsPerBlock);
  ParallelBlocks(context, num_buckets, kBucketsPerBlock, [&](size_t begin, size_t end) {
    BucketBoxes boxes;
    for (size_t bucket = begin; bucket < end; ++bucket) {
      FindInBucket(bucket, moved, &boxes, &found[begin / kBucketsPerBlock]);
    }
  });
  return Joined(found);
}

FaceGrid::Pairs FaceGrid::PairsOfFaces(const std::vector<uint8_t>& moved,
                                       const RunContext& context) const {
  std::vector<Pairs> found((moved.size() + kFacesPerBlock - 1) / kFacesPerBlock);
  ParallelFor(context, moved.size(), kFacesPerBlock, [&](size_t f) {
    if (!moved[f]) return;
    const int32_t a = static_cast<int32_t>(f);
    ForBuckets(boxes_[f], [&](size_t bucket) {
      for (uint32_t k = begins_[bucket]; k < begins_[bucket + 1]; ++k) {
        const int32_t b = members_[k];
        if (!MayCross(a, b) || FirstCommonBucket(a, b) != bucket || !Cross(a, b)) continue;
        found[f / kFacesPerBlock].push_back(std::minmax(a, b));
      }
    });
  });
  return Joined(found);
}

FaceGrid::Pairs FaceGrid::Joined(const std::vector<Pairs>& blocks) {
  Pairs pairs;
  for (const Pairs& block : blocks) pairs.insert(pairs.end(), block.begin(), block.end());
  return pairs;
}

}  // namespace lsmvs
