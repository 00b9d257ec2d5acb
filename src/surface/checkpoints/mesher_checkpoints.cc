#include <array>
#include <type_traits>
#include <utility>

#include "lsmvs/surface/checkpoints/mesher_checkpoints.h"

namespace lsmvs::internal {

namespace {

// A sight in six bytes where there are few enough views.
#pragma pack(push, 1)
struct ShortSight {
  uint16_t view_idx;
  float support;
};
#pragma pack(pop)
constexpr uint32_t kMaxShortViews = 1 << 16;

template <class T>
void Free(std::vector<T>* values) {
  std::vector<T>().swap(*values);
}

bool AreShort(const std::vector<Sight>& sights) {
  for (const Sight& sight : sights) {
    if (sight.view_idx >= kMaxShortViews) return false;
  }
  return true;
}

}  // namespace

void MesherCheckpoints::WriteCounters(const char* step,
                                      const VisibilityMesherCounters& counters) const {
  static_assert(std::is_trivially_copyable_v<VisibilityMesherCounters>);
  folder_.Write(std::string(step) + "_counters", std::vector(1, counters));
  folder_.FinishStep(step);
}

void MesherCheckpoints::ReadCounters(const char* step, VisibilityMesherCounters* counters) const {
  std::vector<VisibilityMesherCounters> read;
  folder_.Read(std::string(step) + "_counters", &read);
  const size_t num_steps_found = counters->num_steps_found + 1;
  *counters = read.at(0);
  counters->num_steps_found = num_steps_found;
}

void MesherCheckpoints::WriteMerged(const VisibilityMesherCounters& counters,
                                    MergedCloud* cloud) const {
  if (!folder_.is_on()) return;
  folder_.Write("frame", std::vector(1, cloud->frame));
  folder_.Write("positions", cloud->positions);
  folder_.Write("normals", cloud->normals);
  folder_.Write("colors", cloud->colors);
  folder_.Write("vertex_of_point", cloud->vertex_of_point);
  std::vector<uint32_t> num_sights(cloud->positions.size());
  for (size_t v = 0; v < num_sights.size(); ++v) {
    num_sights[v] = static_cast<uint32_t>(cloud->sight_begin[v + 1] - cloud->sight_begin[v]);
  }
  folder_.Write("num_sights", num_sights);
  if (AreShort(cloud->sights)) {
    std::vector<ShortSight> sights(cloud->sights.size());
    for (size_t i = 0; i < sights.size(); ++i) {
      sights[i] = {static_cast<uint16_t>(cloud->sights[i].view_idx), cloud->sights[i].support};
    }
    folder_.Write("sights_short", sights);
  } else {
    folder_.Write("sights", cloud->sights);
  }
  WriteCounters(kMerged, counters);
  Free(&cloud->normals);
  Free(&cloud->colors);
  Free(&cloud->vertex_of_point);
  DropSights(cloud);
}

void MesherCheckpoints::ReadMerged(VisibilityMesherCounters* counters, MergedCloud* cloud) const {
  std::vector<CanonicalFrame> frame;
  folder_.Read("frame", &frame);
  cloud->frame = frame.at(0);
  folder_.Read("positions", &cloud->positions);
  ReadCounters(kMerged, counters);
  cloud->num_filtered_vertices = counters->num_filtered_vertices;
}

void MesherCheckpoints::LoadSights(MergedCloud* cloud) const {
  if (!folder_.is_on() || !cloud->sight_begin.empty()) return;
  std::vector<uint32_t> num_sights;
  folder_.Read("num_sights", &num_sights);
  cloud->sight_begin.reserve(num_sights.size() + 1);
  cloud->sight_begin.push_back(0);
  for (const uint32_t count : num_sights) {
    cloud->sight_begin.push_back(cloud->sight_begin.back() + count);
  }
  Free(&num_sights);
  if (!folder_.Has("sights_short")) {
    folder_.Read("sights", &cloud->sights);
    return;
  }
  std::vector<ShortSight> sights;
  folder_.Read("sights_short", &sights);
  cloud->sights.reserve(sights.size());
  for (const ShortSight& sight : sights) cloud->sights.push_back({sight.view_idx, sight.support});
}

void MesherCheckpoints::DropSights(MergedCloud* cloud) const {
  if (!folder_.is_on()) return;
  Free(&cloud->sight_begin);
  Free(&cloud->sights);
}

void MesherCheckpoints::LoadVertexOfPoint(MergedCloud* cloud) const {
  if (folder_.is_on()) folder_.Read("vertex_of_point", &cloud->vertex_of_point);
}

void MesherCheckpoints::LoadLooks(MergedCloud* cloud) const {
  if (!folder_.is_on()) return;
  folder_.Read("normals", &cloud->normals);
  folder_.Read("colors", &cloud->colors);
}

void MesherCheckpoints::WriteLabels(const VisibilityMesherCounters& counters,
                                    const Tetrahedralization& complex) const {
  if (!folder_.is_on()) return;
  std::vector<uint8_t> bits((complex.cells.size() + 7) / 8, 0);
  for (size_t c = 0; c < complex.cells.size(); ++c) {
    if (complex.cells[c].OnSourceSide()) bits[c / 8] |= static_cast<uint8_t>(1 << (c % 8));
  }
  folder_.Write("cell_labels", bits);
  WriteCounters(kLabels, counters);
}

void MesherCheckpoints::ReadLabels(VisibilityMesherCounters* counters,
                                   Tetrahedralization* complex) const {
  std::vector<uint8_t> bits;
  folder_.Read("cell_labels", &bits);
  for (size_t c = 0; c < complex->cells.size(); ++c) {
    complex->cells[c].distance = (bits.at(c / 8) >> (c % 8)) & 1;
  }
  ReadCounters(kLabels, counters);
}

void MesherCheckpoints::WriteSurface(const VisibilityMesherCounters& counters,
                                     const ExtractedSurface& surface,
                                     const std::vector<uint8_t>& point_is_free) const {
  if (!folder_.is_on()) return;
  folder_.Write("mesh_vertices", surface.mesh.vertices);
  folder_.Write("mesh_faces", surface.mesh.faces);
  folder_.Write("vertex_point", surface.vertex_point);
  folder_.Write("point_is_free", point_is_free);
  WriteCounters(kSurface, counters);
}

void MesherCheckpoints::ReadSurface(VisibilityMesherCounters* counters, ExtractedSurface* surface,
                                    std::vector<uint8_t>* point_is_free) const {
  folder_.Read("mesh_vertices", &surface->mesh.vertices);
  folder_.Read("mesh_faces", &surface->mesh.faces);
  folder_.Read("vertex_point", &surface->vertex_point);
  folder_.Read("point_is_free", point_is_free);
  ReadCounters(kSurface, counters);
}

}  // namespace lsmvs::internal
