#include "lsmvs/graph/minimum_cut.h"

#include "lsmvs/graph/minimum_cut-inl.h"

namespace lsmvs {

template int64_t MaximizeFlow(std::vector<CutNode>*, const RunContext&, size_t);

}  // namespace lsmvs
