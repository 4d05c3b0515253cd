#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/options.h>
#include <gpsrecon/report/heatmap.h>
#include <gpsrecon/report/report.h>
#include <string>

namespace gpsrecon {

struct HtmlOptions {
  std::string title = {};  ///< of the page; plain text
  std::size_t max_faces = 700000;

  static OptionTable fields() {
    return {
        field<&HtmlOptions::max_faces>("html-faces", ">= 100",
                                       "faces (as triangles) the 3-D view shows, at most: larger meshes are thinned "
                                       "by merging vertices within the cells of a grid, and the page says so")
            .only_in_library()};
  }
  /// Throws OptionError naming option, range and value.
  void check() const { check_fields(*this); }
};

/// The report as one HTML page that needs nothing else and opens from disk: its numbers, the distribution of the
/// distances as histogram and as curve (inline SVG), what was left out, open loops, options; and the mesh coloured by
/// error, to be turned in 3-D where the browser can (WebGL, by three.js, which the page contains), as a picture
/// otherwise. Text from outside is escaped. About 0.6 MB plus 22 bytes per face shown. `mesh` and `map` belong
/// together. Throws OptionError.
std::string html_report(const ErrorReport& report, const Mesh& mesh, const ErrorMap& map,
                        const HtmlOptions& options = {});

/// `text` as it has to be written in HTML, between tags or in quotes.
std::string html_escaped(const std::string& text);

}  // namespace gpsrecon
