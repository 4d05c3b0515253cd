#include "error_views.h"

#include <gpsrecon/io/io.h>
#include <gpsrecon/report/html_report.h>

namespace gpsrecon::cli {

void ErrorViews::bind(Arguments& arguments) {
  arguments.option("--heatmap", "FILE", heatmap_,
                   "the mesh coloured by error, with the error as a column (ply; off and obj hold the colours)", "",
                   "none");
  arguments.option("--heatmap-max", "X",
                   "error that has the last colour, in the unit of the coordinates; 0 = the 99th percentile", ">= 0",
                   "0", [this](const std::string& text) {
                     range_ = parse_double(text);
                     if (range_ < 0) throw OptionError("expected a number >= 0, got '" + text + "'");
                   });
  arguments.option("--html", "FILE", html_,
                   "the report as a page that opens from disk, with diagrams and the mesh in 3-D coloured by error", "",
                   "none");
}

void ErrorViews::plan(Outputs& outputs) const {
  outputs.plan(heatmap_, true);
  outputs.plan(html_);
}

void ErrorViews::stage(Outputs& outputs, const ErrorReport& report, const Mesh& mesh,
                       const std::function<ErrorMap(double range)>& map_of, const std::string& title,
                       const Console& console) const {
  if (!wanted()) return;
  const ErrorMap map = map_of(range_);
  console.info(map.is_signed ? "colours: signed distance, blue (inside) over white to red (outside), from -" +
                                   std::to_string(map.range) + " to " + std::to_string(map.range)
                             : "colours: distance, viridis, dark blue (0) to yellow (" + std::to_string(map.range) +
                                   " and more); grey where there are no points");
  if (!heatmap_.empty()) {
    const Mesh heatmap = colored(mesh, map);
    warn_of_losses(heatmap, heatmap_, console);
    outputs.stage(heatmap_, [&](const std::string& path) { write_mesh(heatmap, path); });
  }
  outputs.stage(html_, [&](const std::string& path) {
    HtmlOptions options;
    options.title = title;
    write_text(html_report(report, mesh, map, options), path);
  });
}

}  // namespace gpsrecon::cli
