#pragma once

#include "lsmvs/util/option_synonyms.h"

namespace lsmvs {

// COLMAP's names of options that have another name here, the keys that its project_generator writes
// for every command, and -1 where it means "found from the data".
const OptionSynonyms& ColmapSynonyms();

}  // namespace lsmvs
