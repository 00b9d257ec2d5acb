#pragma once

#include <vector>

#include "lsmvs/scene/scene.h"

namespace lsmvs {

// For each view the number of the place it was taken from: views whose centres lie within a
// ten-thousandth of the scene's spread (median distance of the centres from their median) share
// one, as crops of one panorama do. No depth comes from two views of one place. Numbers count from
// 0 in the order of the views. O(views x places).
std::vector<int> CenterGroups(const Scene& scene);

}  // namespace lsmvs
