#include <gpsrecon/report/html_resources.h>

// The files go into the object as they are: as string literals they would be longer than compilers have to accept.
#define EMBED(name, file)                                                                \
  asm(".pushsection .rodata\n"                                                           \
      ".global gpsrecon_" #name "\n.global gpsrecon_" #name                              \
      "_end\n"                                                                           \
      "gpsrecon_" #name ":\n.incbin \"" GPSRECON_HTML_DIR "/" file "\"\ngpsrecon_" #name \
      "_end:\n.byte 0\n"                                                                 \
      ".popsection\n");                                                                  \
  extern "C" const char gpsrecon_##name[];                                               \
  extern "C" const char gpsrecon_##name##_end[]

EMBED(html_page, "report.html");
EMBED(html_viewer, "viewer.min.js");

namespace gpsrecon::internal {

std::string_view html_page() {
  return {gpsrecon_html_page, gpsrecon_html_page_end};
}

std::string_view html_viewer() {
  return {gpsrecon_html_viewer, gpsrecon_html_viewer_end};
}

}  // namespace gpsrecon::internal
