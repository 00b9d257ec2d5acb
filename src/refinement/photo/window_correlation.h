#pragma once

#include <vector>

namespace lsmvs {

// Columns [begin, end).
struct ColumnSpan {
  int begin = 0, end = 0;
  bool Empty() const { return end <= begin; }
};

// Planes of a rectangle of pixels, row by row without padding: element (column, row) is plane[row *
// width + column].
struct CorrelationTile {
  int width = 0, height = 0;
  // Inputs.
  std::vector<float> reference;  // grey values of the reference view
  std::vector<float> warped;     // grey values of the other view, brought here through the surface;
                                 // any where not valid
  std::vector<float> valid;      // 1 where both views see the surface, else 0
  std::vector<float> weight;     // of the window centred here; 0: not judged
  // Of each row: the columns from the first to the last with a weight, and those that windows
  // around such pixels of any row reach. Inputs but the weights matter only there.
  std::vector<ColumnSpan> judged, reached;
  // Outputs.
  std::vector<float> error;  // mass * robust (1 - ZNCC)
  std::vector<float> mass;   // weight * texture; 0 where the window has too few valid pixels
  // Left alone by CorrelateWindows without derivatives:
  std::vector<float> derivative;  // of the sum of all errors with respect to `warped`
  std::vector<float> curvature;   // diagonal of its Gauss-Newton matrix, >= 0

  // Keeps memory that is large enough; contents are undefined afterwards.
  void Resize(int tile_width, int tile_height);
  // Finds `judged` and `reached` from the weights.
  void FindSpans(int radius);
};

struct CorrelationOptions {
  int radius = 3;            // windows are squares of 2 * radius + 1 pixels
  float noise_variance = 4;  // added to the variance of both windows
  // Errors h = 1 - ZNCC count as h s / (h + s): what disagrees altogether (highlights, shadows,
  // what an edge hides) hardly pulls.
  float robust_scale = 0.5f;
  float min_valid_fraction = 0.5f;  // of a full window's pixels, else the window is not judged
  bool derivatives = true;          // else only error and mass
};

// Rows that CorrelateWindows keeps; reuse it between calls.
struct CorrelationScratch {
  std::vector<float> rows;
};

// Zero-mean normalised cross-correlation of every window of a tile with its derivative:
//   ZNCC = cov(a, b) / sqrt((var a + noise) (var b + noise)),
// statistics over the valid pixels of the window only. Windows reach to the border of the tile;
// pixels beyond count as not valid. A window counts by its texture, var a / (var a + 4 noise). With
// h = 1 - ZNCC of the window around x and n its valid pixels,
//   dh/db(y) = -((a(y) - mean a) / (n sqrt(..)) - ZNCC (b(y) - mean b) / (n (var b + noise))),
// whose sum over the windows that hold y is three box filters. Errors and derivatives are exact for
// windows inside the tile. Outputs are 0 where no judged window reaches; the tile's spans must have
// been found. About 2 (2 radius + 1) * 6 additions a judged pixel, and * 4 a reached one for the
// derivatives, vectorised over columns for the instruction set at hand.
void CorrelateWindows(const CorrelationOptions& options, CorrelationScratch* scratch,
                      CorrelationTile* tile);

}  // namespace lsmvs
