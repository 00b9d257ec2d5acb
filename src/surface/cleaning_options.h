#pragma once

#include <cstddef>

namespace lsmvs {

// How much of the surface stays that no point supports.
enum class Completeness {
  kClosed,  // all that the cut closed inside of the surface; open only towards the scene's end, sky
  kSeen,    // gaps and webs inside go, too, where the evidence against them outweighs their border
  kStrict,  // every facet that spans what nobody measured goes
};

// What is done to a surface after the cut.
struct SurfaceCleaningOptions {
  // What becomes of facets that span what nobody measured.
  Completeness completeness = Completeness::kClosed;
  // Gaps up to about this wide stay closed, and borders are smooth at that scale: as a share of the
  // photos' longer side, so that the same photos at another size give the same surface. It is twice
  // the price of a pixel of border in square pixels of facets that go beyond what is believed by a
  // factor e. Raising it keeps more and gives shorter borders. Not used by kStrict.
  double max_gap_share = 0.04;
  // Facets with an edge longer than this times the surface's edge length (the percentile below, in
  // pixels at that place) span what nobody measured. 0: no limit.
  double max_side_length_factor = 200.0;
  // Webs, which span what nobody measured between a foreground and what lies behind it, around what
  // was seen, or to false points, are dropped: facets that are long, reach far along the line of
  // sight of every view that sees one of their corners from the front, turn away from the normals
  // that the points at their corners had, and hang on a corner that few views saw. With L the
  // longest edge and D the least reach along lines of sight (both over the percentile below, in
  // pixels at that place), c the least cosine to the normals and t the trust in the corner that the
  // fewest views saw (0 to 1; see visibility_sigma; the less the more of the cloud's points the cut
  // found false): (L + 8 D) sqrt(1 - c) > max_web_factor t. Raising it closes more of what nobody
  // saw. 0 keeps all.
  double max_web_factor = 600.0;
  // Facets with an edge longer than this times the same percentile (less where few views saw a
  // corner, the more so the more of the cloud's points the cut found false) and more than
  // max_normal_angle_deg away from the normals at a corner are webs at any rate. Raising either
  // closes more of what nobody saw. 0 keeps all.
  double normal_check_factor = 32.0;
  double max_normal_angle_deg = 70.0;
  // Percentile of the surface's longest facet edges that counts as its edge length.
  double max_side_length_percentile = 50.0;
  // Components with less than this fraction of the largest one's faces, or with fewer faces than
  // min_component_faces, are dropped; the largest stays.
  double min_component_fraction = 0.002;
  int min_component_faces = 50;
  // Holes with at most this many edges are closed. 0 closes none.
  int max_hole_edges = 40;
  // A vertex that stands out alone, all its edges longer than this times the surface's edge length
  // (the percentile above), is a false point that the cut took along, and sinks to its neighbours
  // (SinkSpikes). Raising it keeps more of them. 0 keeps all.
  double min_spike_factor = 2.0;
  // Steps of volume-preserving smoothing after the cut. 0 returns the vertices where they were
  // measured, but for spikes.
  int smoothing_iterations = 0;
};

struct SurfaceCleaningCounters {
  size_t num_dropped_webs = 0;  // facets that spanned what nobody measured
  size_t num_components = 0;    // of the result
  size_t num_dropped_components = 0, num_dropped_component_faces = 0;
  size_t num_closed_holes = 0;
  size_t num_sunk_spikes = 0;
};

}  // namespace lsmvs
