#pragma once

#include <Eigen/Core>
#include <vector>

#include "lsmvs/texturing/labels/view_labels.h"
#include "lsmvs/texturing/levelling/label_nodes.h"

namespace lsmvs {

// Colours (grey levels) for the faces that no photo shows: at vertices beside seen faces their mean
// after levelling, inside the harmonic function between them (mean of the neighbours). Parts of the
// surface that touch no seen face are mid grey. #V; zero at vertices without unseen faces.
std::vector<Eigen::Vector3f> HarmonicFillColors(const LabelEnergy& energy,
                                                std::span<const int32_t> views,
                                                const LabelNodes& nodes,
                                                const std::vector<Eigen::Vector3f>& offsets);

}  // namespace lsmvs
