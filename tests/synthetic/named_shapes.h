#pragma once

#include "lsmvs/synthetic/shape.h"

namespace lsmvs {

// Shapes of about unit size around the origin, z up. `gsd` (one pixel on the surface) sets the size
// of the small parts.
enum class ShapeName {
  kSphere,          // radius 1
  kBox,             // [-1,1] x [-0.8,0.8] x [-0.6,0.6]
  kTorus,           // radii 1 and 0.4
  kStep,            // slab [-1.5,1.5]^2 whose top is at z = 0 for x < 0 and at z = 0.3 for x > 0
  kThinWalls,       // two upright walls, 2 wide, 1 high, 3 gsd thick and 5 gsd apart, on a slab
  kPole,            // a pole of 6 gsd diameter and height 1 on a slab
  kSphereOnGround,  // radius 0.7, standing on a slab
  kTerrain,         // hills with eight buildings, [-2,2]^2
  kRelief,          // a wall in the plane y = 0 seen from y < 0: pilasters, niches, cornice, domes,
                    // columns, with a floor
  kTown,            // six by six lots of Town; in a scene as many as the photos overfly
};

ShapePtr MakeShape(ShapeName name, double gsd);

}  // namespace lsmvs
