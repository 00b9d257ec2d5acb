#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lsmvs/pipeline/reconstruction.h"
#include "lsmvs/util/option_set.h"

namespace lsmvs {

// Adds the files of the model, and of hand-made lists of sources; of the photos (and masks that are
// there) of some or all views; of depth maps.
void AddModelInputs(const Reconstruction& reconstruction, Task* task);
void AddPhotoInputs(const Reconstruction& reconstruction, int view_idx, Task* task);
void AddAllPhotoInputs(const Reconstruction& reconstruction, Task* task);
void AddDepthMapInputs(const Reconstruction& reconstruction, int view_idx, DepthMapKind kind,
                       Task* task);

// Options as a task records them: those of the structs, and what all stages share (image size,
// seed).
template <class... Options>
std::string TaskOptionsText(const Reconstruction& reconstruction, const Options&... options);

// "x0 y0 z0 x1 y1 z1", or empty.
std::string BoxText(const Eigen::AlignedBox3d& box);

// Throws InputError if no view has a neighbour to be matched with.
void CheckAnyNeighbors(const Reconstruction& reconstruction);

// What to check when no point was found; names the masks and the box if there are any.
std::string EmptyCloudRemedy(const Reconstruction& reconstruction);

namespace internal {
std::string SharedOptionsText(const Reconstruction& reconstruction);
template <class Options>
std::string OptionsText(Options options) {
  OptionSet set;
  options.Describe(&set);
  return set.ToText();
}
}  // namespace internal

template <class... Options>
std::string TaskOptionsText(const Reconstruction& reconstruction, const Options&... options) {
  return (internal::SharedOptionsText(reconstruction) + ... + internal::OptionsText(options));
}

}  // namespace lsmvs
