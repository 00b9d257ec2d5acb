#include "lsmvs/report/page/page_template.h"

#ifdef LSMVS_REPORT_PAGE
// The assembler puts the file's bytes into the program; the build system knows that this file
// depends on it.
__asm__(
    ".section .rodata\n"
    ".global lsmvs_report_page_begin\n"
    ".global lsmvs_report_page_end\n"
    "lsmvs_report_page_begin:\n"
    ".incbin \"" LSMVS_REPORT_PAGE
    "\"\n"
    "lsmvs_report_page_end:\n"
    ".byte 0\n"
    ".previous\n");

extern "C" const char lsmvs_report_page_begin[];
extern "C" const char lsmvs_report_page_end[];
#endif

namespace lsmvs {

std::string_view PageTemplate() {
#ifdef LSMVS_REPORT_PAGE
  return {lsmvs_report_page_begin,
          static_cast<size_t>(lsmvs_report_page_end - lsmvs_report_page_begin)};
#else
  return {};
#endif
}

}  // namespace lsmvs
